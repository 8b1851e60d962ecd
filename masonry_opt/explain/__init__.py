"""Why there is no answer, and every sentence a user reads."""

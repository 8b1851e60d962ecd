"""The limit analysis problem as matrices, and the residuals of an answer to it."""

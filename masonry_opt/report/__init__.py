"""What a person reads: tables and the command line's words."""

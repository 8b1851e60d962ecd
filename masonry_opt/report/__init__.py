"""What a person reads: tables and the command line's words, and the files of programs."""

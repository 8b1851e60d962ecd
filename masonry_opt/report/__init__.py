"""What a person sees: pictures, tables and the command line's words."""

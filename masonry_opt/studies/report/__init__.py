"""``report``: answers as one page for the file."""

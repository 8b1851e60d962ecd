"""What a page says of a result."""

"""A result as one interactive page, and as what a notebook shows."""

"""What an answer is, and when it is good enough."""

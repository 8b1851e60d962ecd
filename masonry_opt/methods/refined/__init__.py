"""Method "refined": the lowest exact state that passes and a search lead to."""

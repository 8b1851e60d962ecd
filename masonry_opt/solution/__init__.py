"""Answers of an analysis, their certificates, and the limits within which an answer is accepted."""

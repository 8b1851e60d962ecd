"""Exact states of Coulomb friction: the two linear programs, and the search that they make possible."""

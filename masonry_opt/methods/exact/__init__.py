"""Exact states of Coulomb friction: two linear programs that find them, and the search for lower states."""

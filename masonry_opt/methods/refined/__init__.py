"""Exact states of Coulomb friction by linear programs."""

"""Uncertain input: numbers of a scene drawn from distributions, and what that makes of its load factor."""

"""Axles that cross a bridge: the load factor by position, and the worst position."""

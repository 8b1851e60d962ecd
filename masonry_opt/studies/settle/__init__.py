"""Supports that settle: the reactions with which a scene stands."""

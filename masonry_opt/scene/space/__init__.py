"""Rigid polyhedral blocks in space: their shapes, and where they touch."""

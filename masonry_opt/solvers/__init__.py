"""Interfaces to solvers: one registry, and one file for each interface, without models and methods."""

"""Generators in space: walls along a plan, barrel vaults, domes, shafts of drums."""

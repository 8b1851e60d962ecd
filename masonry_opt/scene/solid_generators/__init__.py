"""Generators in space: walls along a plan, barrel and groin vaults, domes, shafts of drums."""

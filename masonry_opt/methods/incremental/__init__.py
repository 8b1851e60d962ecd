"""Incremental analysis: the live load is raised in steps until equilibrium is lost."""

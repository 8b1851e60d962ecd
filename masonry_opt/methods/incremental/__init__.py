"""Incremental analysis: the load factor at which equilibrium is lost as the live load is raised by steps."""

"""Files for other programs: optimisation programs for other solvers, and solids with their mechanism."""

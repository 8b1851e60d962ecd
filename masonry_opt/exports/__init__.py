"""Programs of a scene as files for other solvers."""

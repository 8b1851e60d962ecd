"""The benchmark: scenes × methods × models × solvers × tolerances, timed and judged."""

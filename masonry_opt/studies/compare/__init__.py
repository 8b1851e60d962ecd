"""Benchmark of scenes × methods × models × solvers × tolerances: runs are timed and judged."""

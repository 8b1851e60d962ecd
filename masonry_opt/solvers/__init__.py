"""Solvers: which there are, and how each modelling language drives them."""

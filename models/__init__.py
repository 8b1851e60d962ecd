"""Optimisation models: each file declares one formulation of the paper in one modelling language.

A model is declared for a :class:`~masonry_opt.problem.problem.Problem`. It consists of the terms of its
language (``cvxpy_terms``, ``pyomo_terms``): statics with the slacks z of the yield conditions, and mechanisms
with their rates p. Solvers, scenes and methods are not part of this folder.
"""

"""The mathematics: each file declares a formulation in one modelling language, to be read beside the paper.

Every model is declared on a :class:`~masonry_opt.problem.problem.Problem` from the terms of its language
(``cvxpy_terms``, ``pyomo_terms``). These are statics with the slacks z of the yield conditions, and
mechanisms with their rates p. Solvers, scenes and methods are not part of this folder.
"""

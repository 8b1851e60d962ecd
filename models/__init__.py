"""The mathematics: close formulations in one modelling language a file, to be read beside the paper.

Every model is declared on a :class:`~masonry_opt.problem.problem.Problem` from the terms of its language
(``cvxpy_terms``, ``pyomo_terms``): statics with the slacks z of the faces, and mechanisms with their rates p.
"""

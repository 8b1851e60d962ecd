"""The mathematics: one formulation in one modelling language a file, to be read beside the paper.

Every model is declared on a :class:`~masonry_opt.problem.problem.Problem`, owns its shear limits as
parameters, and reads a solver's answer back as a :class:`~masonry_opt.problem.state.State`.
"""

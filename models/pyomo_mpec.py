"""The least Coulomb load factor in Pyomo: a mathematical program with equilibrium constraints."""

from __future__ import annotations

import pyomo.environ as pyo

from masonry_opt.models.pyomo_mcp import PyomoMcp
from masonry_opt.problem.problem import Problem


class PyomoMpec(PyomoMcp):
    """The least load factor:

        min  λ Σ|f_L|    over the states of :class:`PyomoMcp`

    The objective is scaled by Σ|f_L|, as the velocities are.
    """

    def __init__(self, problem: Problem) -> None:
        super().__init__(problem)
        model = self.program
        model.objective = pyo.Objective(expr=problem.live_norm * model.load_factor)

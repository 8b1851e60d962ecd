"""Statics with chosen faces at yield, in CVXPY.

Of the states that hold the faces of a mechanism at the true yield condition, eq. (4), and keep all
others within it, the one whose λ is nearest to a given value. With that mechanism it satisfies
complementarity, eq. (8).
"""

from __future__ import annotations

import cvxpy as cp
import numpy as np

from masonry_opt.models.cvxpy_terms import Statics
from masonry_opt.problem.problem import Problem


class CvxpyAtYield:
    """Minimise |λ − ``near``| subject to equilibrium, yield, and z = 0 on the faces ``at_yield``.

    Parameters
    ----------
    at_yield: which faces slide (+, −) and rock (+, −), shape (4, c).
    near: the load factor to stay near.
    """

    def __init__(self, problem: Problem, at_yield: np.ndarray, near: float) -> None:
        self.problem = problem
        k, statics = problem.sliding, Statics(problem)
        rows = [statics.equilibrium]
        chosen_faces = [at_yield[0, k], at_yield[1, k], at_yield[2], at_yield[3]]
        for slack, held in zip(statics.slacks, chosen_faces, strict=True):
            for chosen, hold in ((np.flatnonzero(held), True), (np.flatnonzero(~held), False)):
                if len(chosen):
                    rows.append(slack[chosen] == 0 if hold else slack[chosen] >= 0)
        self.program = cp.Problem(cp.Minimize(cp.abs(statics.load_factor - near)), rows)
        self._statics = statics

    def read(self) -> tuple[float, np.ndarray]:
        """λ and joint forces n, s, m in turn, shape (3c,), at the optimum."""
        return self._statics.read()

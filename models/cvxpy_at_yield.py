"""Statics with the faces of a mechanism at yield, in CVXPY."""

from __future__ import annotations

import cvxpy as cp
import numpy as np

from masonry_opt.models.cvxpy_terms import Statics
from masonry_opt.problem.problem import Problem, ShearLimits


class CvxpyAtYield:
    """Of the states that hold the faces of a mechanism at the true yield condition, and so satisfy
    complementarity with it, eq. (8), the one whose λ is nearest to a given value:

        min  |λ − near|    s.t.    B q + λ f_L + f_D = 0,    z = 0 on the faces at yield,    z ≥ 0 elsewhere

    Parameters
    ----------
    at_yield: which faces take part in the mechanism, shape (faces,).
    near: the load factor to stay near.
    """

    def __init__(self, problem: Problem, at_yield: np.ndarray, near: float) -> None:
        self.statics = Statics(problem, ShearLimits.true(problem))
        z = self.statics.slacks
        rows = [self.statics.equilibrium, z[at_yield] == 0, z[~at_yield] >= 0]
        self.program = cp.Problem(cp.Minimize(cp.abs(self.statics.load_factor - near)), rows)

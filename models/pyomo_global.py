"""Complementarity with a binary for each face, in Pyomo."""

from __future__ import annotations

import numpy as np
import pyomo.environ as pyo

from masonry_opt.models.pyomo_arrays import dot
from masonry_opt.models.pyomo_mcp import with_slack_variables
from masonry_opt.models.pyomo_mpec import PyomoMpec
from masonry_opt.problem.problem import Problem


class PyomoGlobal(PyomoMpec):
    """The MPEC with 0 ≤ λ ≤ Λ, where each face is at yield (y = 1) or at rest:

        p ≤ P y,    z ≤ Z (1 − y),    −f_D·d ≤ Λ Σ|f_L|

    Exact as long as the bounds P and Z cut nothing off. The last row bounds rates and cuts nothing off:
    sliding dissipates, so what the live load does covers at least the raising of the blocks.

    Parameters
    ----------
    most_slack, most_rate: Z and P, shape (faces,).
    highest: Λ, an upper bound of λ ≥ 0, such as the associative load factor.
    """

    def __init__(
        self, problem: Problem, most_slack: np.ndarray, most_rate: np.ndarray, highest: float
    ) -> None:
        super().__init__(problem)
        model, faces = self.program, range(problem.faces)
        z = with_slack_variables(self, "mpec.standard_form")
        Z, P = most_slack.tolist(), most_rate.tolist()
        model.load_factor.setlb(0.0)
        model.load_factor.setub(highest)
        model.y = pyo.Var(faces, domain=pyo.Binary)
        model.at_rest = pyo.Constraint(faces, rule=lambda m, face: m.p[face] <= P[face] * m.y[face])
        model.at_yield = pyo.Constraint(faces, rule=lambda m, face: z[face] <= Z[face] * (1 - m.y[face]))
        raising = dot(-problem.dead, list(model.d.values()))
        model.raising = pyo.Constraint(expr=raising <= highest * problem.live_norm)

"""The MPEC in Pyomo: complementarity, eq. (8), as products of slacks and rates."""

from __future__ import annotations

from typing import Any

import numpy as np
import pyomo.environ as pyo

from masonry_opt.models.pyomo_arrays import values
from masonry_opt.models.pyomo_states import PyomoStates
from masonry_opt.problem.problem import Problem


class PyomoMpec(PyomoStates):
    """The states of :class:`PyomoStates`, with Scholtes' relaxation of complementarity:

        z p ≤ ε    for each face

    At ε = 0 every feasible point is a state under the joints' own flow rule.
    """

    def __init__(self, problem: Problem) -> None:
        super().__init__(problem)
        self.program.epsilon = pyo.Param(mutable=True, initialize=1.0)
        self.program.complementarity = pyo.Constraint(
            range(problem.faces), rule=lambda m, face: m.z[face] * m.p[face] <= m.epsilon
        )

    def products(self) -> np.ndarray:
        """z p of every face, shape (faces,)."""
        return values(self.program.z) * values(self.program.p)

    @property
    def complementarity_rows(self) -> list[Any]:
        """The rows z p ≤ ε, whose bound is all that changes between solves."""
        return list(self.program.complementarity.values())

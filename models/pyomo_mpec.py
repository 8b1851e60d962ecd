"""The MPEC in Pyomo: complementarity, eq. (8), as products of yield slacks and rates.

The products are bounded by ε (Scholtes' relaxation). At ε = 0 every feasible point is a state under
the joints' own flow rule; the least λ is what is looked for.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import pyomo.environ as pyo

from masonry_opt.models.pyomo_states import PyomoBothSides
from masonry_opt.models.pyomo_terms import SENSES, values
from masonry_opt.problem.problem import Problem


class PyomoMpec(PyomoBothSides):
    """Minimise λ (or, ``minimise=False``, find any state: the MCP) subject to statics, kinematics and
    z p ≤ ε for each yield condition."""

    def __init__(self, problem: Problem, minimise: bool = True) -> None:
        super().__init__(problem, minimise)
        model = self.program

        def slide_product(m: Any, sense: str, i: int) -> Any:
            return m.slide_slack[sense, i] * m.slide[sense, i] <= m.epsilon

        def rock_product(m: Any, sense: str, i: int) -> Any:
            return m.rock_slack[sense, i] * m.rock[sense, i] <= m.epsilon

        model.epsilon = pyo.Param(mutable=True, initialize=1.0)
        model.slide_complementarity = pyo.Constraint(SENSES, model.sliding, rule=slide_product)
        model.rock_complementarity = pyo.Constraint(SENSES, model.joints, rule=rock_product)

    def products(self) -> np.ndarray:
        """z p of every yield condition."""
        model = self.program
        return np.concatenate(
            [
                values(model.slide_slack) * values(model.slide),
                values(model.rock_slack) * values(model.rock),
            ]
        )

    @property
    def complementarity_rows(self) -> list[Any]:
        """The rows z p ≤ ε, whose bound is all that changes between solves."""
        model = self.program
        return [*model.slide_complementarity.values(), *model.rock_complementarity.values()]

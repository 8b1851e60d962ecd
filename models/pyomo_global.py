"""Statics, kinematics and complementarity with a binary for each yield condition, in Pyomo.

Either a face is at yield (z = 0) or its rate is zero (p = 0): z ≤ Z (1 - y), p ≤ P y. Exact as long
as the bounds Z and P cut nothing off.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import pyomo.environ as pyo

from masonry_opt.models.pyomo_states import PyomoBothSides
from masonry_opt.models.pyomo_terms import SENSES
from masonry_opt.problem.problem import Problem


class PyomoGlobal(PyomoBothSides):
    """Minimise λ subject to statics, kinematics and, for each face, z = 0 or p = 0.

    Parameters
    ----------
    slack_bound, rate_bound: Z and P of each face, as (4, c): sliding (+, −), rocking (+, −).
    highest: an upper bound of λ ≥ 0, such as the associative load factor.
    """

    def __init__(
        self,
        problem: Problem,
        slack_bound: np.ndarray,
        rate_bound: np.ndarray,
        highest: float,
    ) -> None:
        super().__init__(problem)
        model = self.program
        model.load_factor.setlb(0.0)
        model.load_factor.setub(highest)
        model.slide_at_yield = pyo.Var(SENSES, model.sliding, domain=pyo.Binary)
        model.rock_at_yield = pyo.Var(SENSES, model.joints, domain=pyo.Binary)
        row = {"+": 0, "-": 1}

        def no_slide(m: Any, sense: str, i: int) -> Any:
            bound = float(rate_bound[row[sense], i])
            return m.slide[sense, i] <= bound * m.slide_at_yield[sense, i]

        def slide_yields(m: Any, sense: str, i: int) -> Any:
            bound = float(slack_bound[row[sense], i])
            return m.slide_slack[sense, i] <= bound * (1 - m.slide_at_yield[sense, i])

        def no_rock(m: Any, sense: str, i: int) -> Any:
            bound = float(rate_bound[2 + row[sense], i])
            return m.rock[sense, i] <= bound * m.rock_at_yield[sense, i]

        def rock_yields(m: Any, sense: str, i: int) -> Any:
            bound = float(slack_bound[2 + row[sense], i])
            return m.rock_slack[sense, i] <= bound * (1 - m.rock_at_yield[sense, i])

        model.no_slide = pyo.Constraint(SENSES, model.sliding, rule=no_slide)
        model.slide_yields = pyo.Constraint(SENSES, model.sliding, rule=slide_yields)
        model.no_rock = pyo.Constraint(SENSES, model.joints, rule=no_rock)
        model.rock_yields = pyo.Constraint(SENSES, model.joints, rule=rock_yields)
        # Sliding dissipates: what the live load does covers at least the raising of the blocks.
        # (f_D·d ≥ -λ f_L·d, linear with an upper bound of λ.) It bounds rates, and cuts nothing off.
        raising = -sum(weight * model.d[j] for j, weight in enumerate(problem.dead.tolist()) if weight)
        model.raising = pyo.Constraint(expr=raising <= highest * problem.live_norm)

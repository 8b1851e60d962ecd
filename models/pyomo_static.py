"""Static formulation, eq. (9), in Pyomo."""

from __future__ import annotations

from typing import Any

import pyomo.environ as pyo

from masonry_opt.models.pyomo_terms import SENSES, ShearLimited, add_forces, duals, values
from masonry_opt.problem.problem import Problem, ShearLimits
from masonry_opt.problem.state import State, gather_state


class PyomoStatic(ShearLimited):
    """Maximise λ subject to equilibrium and yield.

    n ≥ 0 is no row of its own: the two rocking rows imply it.
    """

    def __init__(self, problem: Problem, limits: ShearLimits) -> None:
        super().__init__(problem, limits)
        model, half = self.program, problem.half_length.tolist()
        add_forces(model, problem)

        def slide(m: Any, sense: str, i: int) -> Any:
            return (m.s[i] if sense == "+" else -m.s[i]) <= self.limit(i, m.n[i])

        def rock(m: Any, sense: str, i: int) -> Any:
            return (m.m[i] if sense == "+" else -m.m[i]) <= half[i] * m.n[i]

        model.slide = pyo.Constraint(SENSES, model.sliding, rule=slide)
        model.rock = pyo.Constraint(SENSES, model.joints, rule=rock)
        # Written as a minimisation: of a maximisation HiGHS's interior point, without crossover,
        # finds the optimum and then calls it unknown.
        model.objective = pyo.Objective(expr=-problem.live_norm * model.load_factor)

    def read(self) -> State:
        """The state at the optimum: velocities and rates are the duals of equilibrium and yield
        (of a minimisation: negative)."""
        model = self.program
        return gather_state(
            self.problem,
            load_factor=model.load_factor.value,
            forces=[values(force) for force in (model.n, model.s, model.m)],
            d=-duals(model.equilibrium),
            slide=list(-duals(model.slide).reshape(2, -1)),
            rock=list(-duals(model.rock).reshape(2, -1)),
        )

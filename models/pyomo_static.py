"""Static formulation, eq. (9), in Pyomo."""

from __future__ import annotations

from typing import Any

import pyomo.environ as pyo
from masonry_opt.models.interface import State, gather_state
from masonry_opt.models.pyomo_terms import ShearLimited, duals, products, values

from masonry_opt.problem.problem import Problem, ShearLimits


class PyomoStatic(ShearLimited):
    """Maximise λ subject to equilibrium and yield.

    n ≥ 0 is no row of its own: the two rocking rows imply it.
    """

    def __init__(self, problem: Problem, limits: ShearLimits) -> None:
        super().__init__(problem, limits)
        model = self.program
        model.load_factor = pyo.Var()
        model.n, model.s, model.m = (pyo.Var(model.joints) for _ in range(3))
        q = [force for i in model.joints for force in (model.n[i], model.s[i], model.m[i])]
        internal = list(products(problem.B, q))
        live, dead = problem.live.tolist(), problem.dead.tolist()
        half = problem.half_length.tolist()

        def equilibrium(m: Any, row: int) -> Any:
            external = live[row] * m.load_factor if live[row] else 0.0
            return internal[row] + external == -dead[row]

        def slide(m: Any, sense: str, i: int) -> Any:
            return (m.s[i] if sense == "+" else -m.s[i]) <= self.limit(i, m.n[i])

        def rock(m: Any, sense: str, i: int) -> Any:
            return (m.m[i] if sense == "+" else -m.m[i]) <= half[i] * m.n[i]

        senses = ("+", "-")
        model.equilibrium = pyo.Constraint(range(3 * problem.blocks), rule=equilibrium)
        model.slide = pyo.Constraint(senses, model.sliding, rule=slide)
        model.rock = pyo.Constraint(senses, model.joints, rule=rock)
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

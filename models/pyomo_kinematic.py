"""Kinematic formulation, eq. (10), in Pyomo."""

from __future__ import annotations

import pyomo.environ as pyo

from masonry_opt.models.pyomo_terms import ShearLimited, add_mechanism, dot, duals, values
from masonry_opt.problem.problem import Problem, ShearLimits
from masonry_opt.problem.state import State, gather_state


class PyomoKinematic(ShearLimited):
    """Minimise the work against dead load and cohesion over the mechanisms on which the live load
    does the work Σ|f_L| (eq. (10) scaled, so that velocities come out near 1)."""

    def __init__(self, problem: Problem, limits: ShearLimits) -> None:
        super().__init__(problem, limits)
        model = self.program
        add_mechanism(model, problem, slope=lambda i: model.slope[i])
        d = list(model.d.values())
        model.live_work = pyo.Constraint(expr=dot(problem.live, d) == problem.live_norm)
        work = dot(-problem.dead, d)
        if self._cohesive:
            work += sum(
                model.cohesion[i] * (model.slide["+", i] + model.slide["-", i]) for i in model.sliding
            )
        model.objective = pyo.Objective(expr=work, sense=pyo.minimize)

    def read(self) -> State:
        """The state at the optimum: forces and load factor are the duals of compatibility and of
        the live work."""
        model = self.program
        return gather_state(
            self.problem,
            load_factor=model.dual[model.live_work],
            forces=[duals(rows) for rows in (model.opening, model.slip, model.rotation)],
            d=values(model.d),
            slide=list(values(model.slide).reshape(2, -1)),
            rock=list(values(model.rock).reshape(2, -1)),
        )

"""Static formulation, eq. (9), in CVXPY."""

from __future__ import annotations

import cvxpy as cp

from masonry_opt.models.cvxpy_terms import ShearLimited
from masonry_opt.problem.problem import Problem, ShearLimits
from masonry_opt.problem.state import State, gather_state


class CvxpyStatic(ShearLimited):
    """Maximise λ subject to equilibrium and yield.

    With no live load there is no load factor: that a state exists says that the scene stands.
    n ≥ 0 is no row of its own: the two rocking rows imply it.
    """

    def __init__(self, problem: Problem, limits: ShearLimits) -> None:
        super().__init__(problem, limits)
        c, k = problem.K.shape
        n, s, m = (cp.Variable(c, name=name) for name in "nsm")
        load_factor = cp.Variable(name="load_factor") if problem.live_norm else cp.Constant(0.0)

        internal = problem.B_n @ n + problem.B_s @ s + problem.B_m @ m
        equilibrium = internal + load_factor * problem.live + problem.dead == 0

        limit = cp.multiply(self.slope, problem.K.T @ n)
        if self.cohesion is not None:
            limit = self.cohesion + limit
        slide = [problem.K.T @ s <= limit, -problem.K.T @ s <= limit] if k else []

        rocking = cp.multiply(problem.half_length, n)
        rock = [m <= rocking, -m <= rocking]

        objective = cp.Maximize(problem.live_norm * load_factor)
        self.program = cp.Problem(objective, [equilibrium, *slide, *rock])
        self._load_factor, self._forces = load_factor, [n, s, m]
        self._equilibrium, self._slide, self._rock = equilibrium, slide, rock

    def read(self) -> State:
        """The state at the optimum: velocities and rates are the duals of equilibrium and yield."""
        return gather_state(
            self.problem,
            load_factor=self._load_factor.value,
            forces=[force.value for force in self._forces],
            d=self._equilibrium.dual_value,
            slide=[row.dual_value for row in self._slide],
            rock=[row.dual_value for row in self._rock],
        )

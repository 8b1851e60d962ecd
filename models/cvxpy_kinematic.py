"""Kinematic formulation, eq. (10), in CVXPY."""

from __future__ import annotations

import cvxpy as cp

from masonry_opt.models.cvxpy_terms import Mechanism, ShearLimited
from masonry_opt.problem.problem import Problem, ShearLimits
from masonry_opt.problem.state import State, gather_state


class CvxpyKinematic(ShearLimited):
    """Minimise the work against dead load and cohesion over the mechanisms on which the live load
    does the work Σ|f_L| (eq. (10) scaled, so that velocities come out near 1)."""

    def __init__(self, problem: Problem, limits: ShearLimits) -> None:
        super().__init__(problem, limits)
        mechanism = Mechanism(problem)
        compatibility = mechanism.compatibility(self.slope)
        live_work = problem.live @ mechanism.d == problem.live_norm

        work = -problem.dead @ mechanism.d + mechanism.dissipation(self.cohesion)
        self.program = cp.Problem(cp.Minimize(work), [*compatibility, live_work])
        self._mechanism, self._compatibility, self._live_work = mechanism, compatibility, live_work

    def read(self) -> State:
        """The state at the optimum: forces and load factor are the duals of compatibility and of
        the live work (CVXPY's sign of an equality's dual turned)."""
        return gather_state(
            self.problem,
            load_factor=-self._live_work.dual_value,
            forces=[-row.dual_value for row in self._compatibility],
            d=self._mechanism.d.value,
            slide=[rate.value for rate in self._mechanism.slide],
            rock=[rate.value for rate in self._mechanism.rock],
        )

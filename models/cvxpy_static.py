"""Static formulation, eq. (9), in CVXPY."""

from __future__ import annotations

import cvxpy as cp

from masonry_opt.models.cvxpy_terms import ShearParameters, Statics
from masonry_opt.problem.problem import Problem, ShearLimits, State


class CvxpyStatic:
    """Eq. (9):

        max  λ Σ|f_L|    s.t.    B q + λ f_L + f_D = 0,    z = C(slope) q + c ≥ 0

    n ≥ 0 is no row of its own: the two rocking faces of a joint imply it.
    """

    def __init__(self, problem: Problem, limits: ShearLimits) -> None:
        self.limits = ShearParameters(limits)
        self.statics = Statics(problem, self.limits)
        self.within_yield = self.statics.slacks >= 0
        objective = cp.Maximize(problem.live_norm * self.statics.load_factor)
        self.program = cp.Problem(objective, [self.statics.equilibrium, self.within_yield])

    def read(self) -> State:
        """The state at the optimum: velocities and rates are the duals of equilibrium and yield."""
        d, p = self.statics.equilibrium.dual_value, self.within_yield.dual_value
        return State(*self.statics.forces(), d, p)

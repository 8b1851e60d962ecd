"""Static formulation, eq. (9), in CVXPY."""

import cvxpy as cp

from masonry_opt.models.cvxpy_cone import ConeStatics
from masonry_opt.models.cvxpy_terms import CvxpyShearParameters, CvxpyStatics
from masonry_opt.problem.problem import Problem, ShearLimits, State


class CvxpyStatic:
    """Static program, eq. (9): maximise λ over forces that satisfy equilibrium and the yield conditions.

        max  λ Σ|f_L|    s.t.    B q + λ f_L + f_D = 0,    z = C(slope) q + c ≥ 0

    The condition n ≥ 0 is not a row, because the two rocking faces of a joint imply it. With friction cones,
    the conditions n ≥ 0 and |(s, t)| ≤ c + slope · n replace z ≥ 0.
    """

    def __init__(self, problem: Problem, limits: ShearLimits) -> None:
        self.limits = CvxpyShearParameters(limits)
        terms = ConeStatics if problem.by_friction.conic else CvxpyStatics
        statics = self.statics = terms(problem, self.limits)
        objective = cp.Maximize(problem.live_norm * statics.load_factor)
        self.program = cp.Problem(objective, [statics.equilibrium, *statics.within_yield])

    def read(self) -> State:
        """Return the state at the optimum of the program.

        Velocities and rates are the dual values of equilibrium and yield.
        """
        d = self.statics.equilibrium.dual_value
        return State(*self.statics.forces(), d, self.statics.rates(d, self.limits.slope.value))

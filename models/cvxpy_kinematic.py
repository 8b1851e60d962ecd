"""Kinematic formulation, eq. (10), in CVXPY."""

import cvxpy as cp

from masonry_opt.models.cvxpy_cone import ConeMechanism
from masonry_opt.models.cvxpy_terms import CvxpyMechanism, CvxpyShearParameters
from masonry_opt.problem.problem import Problem, ShearLimits, State


class CvxpyKinematic:
    """Kinematic program, eq. (10), scaled such that velocities are of the order of 1.

        min  −f_D·d + c·p    s.t.    Bᵀ d = D(slope) p,    f_L·d = Σ|f_L|,    p ≥ 0

    With friction cones the unknowns are slips w, their speeds γ, openings u and rates v of limited forces:

        min  −f_D·d + c·γ + l·v
        s.t.    Bᵀ d = (u + slope γ, w) + Lᵀ v,    γ ≥ |w|,    u ≥ 0,    v ≥ 0,    f_L·d = Σ|f_L|
    """

    def __init__(self, problem: Problem, limits: ShearLimits) -> None:
        self.limits = CvxpyShearParameters(limits)
        terms = ConeMechanism if problem.by_friction.conic else CvxpyMechanism
        mechanism = self.mechanism = terms(problem, self.limits.slope)
        self.compatibility = mechanism.compatibility
        work = -mechanism.power(self.limits.cohesion)
        self.program = cp.Problem(cp.Minimize(work), [*mechanism.rows, mechanism.live_work])

    def read(self) -> State:
        """Return the state at the optimum of the program.

        Forces and λ are the negative of CVXPY's dual values of compatibility and of the live work.
        """
        mechanism = self.mechanism
        load_factor, q = -mechanism.live_work.dual_value, -self.compatibility.dual_value
        return State(float(load_factor), q, mechanism.d.value, mechanism.rates(self.limits.slope.value))

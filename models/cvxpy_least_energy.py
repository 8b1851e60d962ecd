"""The two halves of complementarity, eq. (8), in CVXPY: given one side of a state, the other side that
leaves least energy z·p in faces that move without being at yield.

Where both leave nothing, forces and mechanism are a collapse state.
"""

from __future__ import annotations

import cvxpy as cp
import numpy as np

from masonry_opt.models.cvxpy_terms import Mechanism, Statics
from masonry_opt.problem.problem import Problem, ShearLimits


class CvxpyForcesFor:
    """Forces for given rates p:

        min  λ Σ|f_L| + weight z·p    s.t.    B q + λ f_L + f_D = 0,    z = C(μ) q + c ≥ 0

    With a large weight λ decides only among states that leave nearly the same energy. Bounded below where the
    rates are those of a mechanism that the live load drives and the weight is above one.

    Parameters
    ----------
    p: rates, shape (faces,).
    """

    def __init__(self, problem: Problem, p: np.ndarray, weight: float) -> None:
        statics = self.statics = Statics(problem, ShearLimits.true(problem))
        cost = problem.live_norm * statics.load_factor + weight * (p @ statics.slacks)
        self.program = cp.Problem(cp.Minimize(cost), [statics.equilibrium, statics.slacks >= 0])


class CvxpyMotionFor:
    """Motion for given slacks z:

        min  z·p    s.t.    Bᵀ d = D(slope) p,    f_L·d = Σ|f_L|,    p ≥ 0

    Parameters
    ----------
    z: slacks ≥ 0, shape (faces,).
    slope: opening per unit slip, shape (k,).
    """

    def __init__(self, problem: Problem, z: np.ndarray, slope: np.ndarray) -> None:
        mechanism = self.mechanism = Mechanism(problem, slope)
        rows = [mechanism.compatibility, mechanism.live_work]
        self.program = cp.Problem(cp.Minimize(z @ mechanism.p), rows)

"""The two programs that make a state exact, in CVXPY: forces for a given mechanism, a mechanism for given
forces.

Each leaves the least energy z·p in faces that move without being at yield. Where nothing is left, forces and
mechanism satisfy complementarity, eq. (8): they are a collapse state.
"""

from __future__ import annotations

import cvxpy as cp
import numpy as np

from masonry_opt.models.cvxpy_terms import Mechanism, Statics
from masonry_opt.problem.problem import Problem, ShearLimits


class CvxpyForces:
    """Forces on a mechanism:

        min  a λ + b·q    s.t.    B q + λ f_L + f_D = 0,    0 ≤ z = C(μ) q + c ≤ room,    λ within an interval

    ``room`` is infinite here. A solver that stays loaded is given other costs a and b, and room 0 on the
    faces that are held at yield.

    Parameters
    ----------
    costs: a, and b of shape (3c,); zeros by default.
    within: the interval.
    """

    def __init__(
        self,
        problem: Problem,
        costs: tuple[float, np.ndarray] | None = None,
        within: tuple[float, float] | None = None,
    ) -> None:
        load_factor = cp.Variable(bounds=list(within), name="load_factor") if within else None
        statics = self.statics = Statics(problem, ShearLimits.true(problem), load_factor)
        self.within_yield = cp.multiply(1 / problem.steep, statics.slacks) >= 0
        a, b = costs or (0.0, np.zeros(problem.B.shape[1]))
        cost = b @ statics.q + a * statics.load_factor
        self.program = cp.Problem(cp.Minimize(cost), [statics.equilibrium, self.within_yield])


class CvxpyMotion:
    """A mechanism for given forces:

        min  cost·p    s.t.    Bᵀ d = D(slope) p,    f_L·d = Σ|f_L|,    0 ≤ p ≤ most,    −f_D·d ≤ raising

    ``most`` is infinite here. A solver that stays loaded is given other costs, and most 0 on the faces that
    must not move.

    Parameters
    ----------
    cost: such as the slacks z ≥ 0 of a state, shape (faces,); zeros by default.
    slope: opening per unit slip, shape (k,); the joints' own by default.
    raising: largest work against the dead load.
    """

    def __init__(
        self,
        problem: Problem,
        cost: np.ndarray | None = None,
        slope: np.ndarray | None = None,
        raising: float | None = None,
    ) -> None:
        mechanism = self.mechanism = Mechanism(problem, problem.dilatancy if slope is None else slope)
        rows = [mechanism.compatibility, mechanism.live_work]
        if raising is not None:
            rows.append(-problem.dead @ mechanism.d <= raising)
        cost = np.zeros(problem.faces) if cost is None else cost
        self.program = cp.Problem(cp.Minimize(cost @ mechanism.p), rows)


def energy_costs(problem: Problem, p: np.ndarray, weight: float) -> tuple[float, np.ndarray]:
    """Costs a and b of λ Σ|f_L| + weight z·p for rates p, shape (faces,), without the constant weight c·p.

    Energy is counted as the certificate counts it. With a large weight λ decides only among forces that leave
    nearly the same energy. The cost is bounded below where the live load drives the mechanism and the weight
    is above one.
    """
    return problem.live_norm, weight * (problem.true_yield.T @ (p / problem.steep))

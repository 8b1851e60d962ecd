"""The two halves of complementarity, eq. (8), in CVXPY: given one side of a state, the other side that
leaves least energy z·p in faces that move without being at yield.

Both always have an answer where there is a state and a mechanism at all. Where both leave nothing, forces
and mechanism are a collapse state.
"""

from __future__ import annotations

import cvxpy as cp
import numpy as np

from masonry_opt.models.cvxpy_terms import Mechanism
from masonry_opt.problem.problem import Problem


class CvxpyForcesFor:
    """Minimise λ Σ|f_L| + ``weight`` z·p subject to equilibrium and yield, eq. (4), for given rates p.

    A large weight leaves λ the choice among states that leave the same energy.

    Parameters
    ----------
    rates: of sliding (+, −) and rocking (+, −), shape (4, c).
    """

    def __init__(self, problem: Problem, rates: np.ndarray, weight: float) -> None:
        c, k = problem.joints, problem.sliding
        n, s, m = (cp.Variable(c, name=name) for name in "nsm")
        load_factor = cp.Variable(name="load_factor")
        internal = problem.B_n @ n + problem.B_s @ s + problem.B_m @ m
        equilibrium = internal + load_factor * problem.live + problem.dead == 0

        limit = problem.cohesion[k] + cp.multiply(problem.friction[k], n[k])
        rocking = cp.multiply(problem.half_length, n)
        slacks = [limit - s[k], limit + s[k], rocking - m, rocking + m]
        moving = [rates[0, k], rates[1, k], rates[2], rates[3]]
        energy = sum(rate @ slack for rate, slack in zip(moving, slacks, strict=True))

        objective = cp.Minimize(problem.live_norm * load_factor + weight * energy)
        self.program = cp.Problem(objective, [equilibrium, *(slack >= 0 for slack in slacks if slack.size)])
        self._load_factor, self._forces = load_factor, [n, s, m]

    def read(self) -> tuple[float, np.ndarray]:
        """λ and joint forces n, s, m in turn, shape (3c,), at the optimum."""
        forces = np.stack([force.value for force in self._forces], axis=1).ravel()
        return float(self._load_factor.value), forces


class CvxpyMotionFor:
    """Minimise z·p over the mechanisms on which the live load does the work Σ|f_L|, for given slacks z.

    Parameters
    ----------
    slacks: of sliding (+, −) and rocking (+, −), ≥ 0, shape (4, c).
    slope: opening per unit slip of each joint that can slide, shape (k,).
    """

    def __init__(self, problem: Problem, slacks: np.ndarray, slope: np.ndarray) -> None:
        k = problem.sliding
        mechanism = Mechanism(problem)
        rates = [*mechanism.slide, *mechanism.rock]
        costs = [*([slacks[0, k], slacks[1, k]] if len(k) else []), slacks[2], slacks[3]]
        energy = sum(slack @ rate for slack, rate in zip(costs, rates, strict=True))
        rows = [*mechanism.compatibility(slope), problem.live @ mechanism.d == problem.live_norm]
        self.program = cp.Problem(cp.Minimize(energy), rows)
        self._mechanism = mechanism

    def read(self) -> np.ndarray:
        """Block velocities at the optimum, shape (3b,)."""
        return np.asarray(self._mechanism.d.value)

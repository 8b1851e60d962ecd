"""The two halves of complementarity, eq. (8), in CVXPY: given one side of a state, the other side that
leaves least energy z·p in faces that move without being at yield.

Where both leave nothing, forces and mechanism are a collapse state. For an interior point, which large
scenes need; `masonry_opt/analysis/refinement.py` solves the like by simplex, from basis to basis.
"""

from __future__ import annotations

import cvxpy as cp
import numpy as np

from masonry_opt.models.cvxpy_terms import Mechanism, Statics
from masonry_opt.problem.problem import Problem


class CvxpyForcesFor:
    """Minimise λ Σ|f_L| + ``weight`` z·p subject to equilibrium and yield, eq. (4), for given rates p.

    With a large weight λ decides only among states that leave nearly the same energy. Bounded below where the
    rates are those of a mechanism that the live load drives and the weight is above one.

    Parameters
    ----------
    rates: of sliding (+, −) and rocking (+, −), shape (4, c).
    """

    def __init__(self, problem: Problem, rates: np.ndarray, weight: float) -> None:
        k, statics = problem.sliding, Statics(problem)
        moving = [rates[0, k], rates[1, k], rates[2], rates[3]]
        energy = sum(rate @ slack for rate, slack in zip(moving, statics.slacks, strict=True))
        within_yield = [slack >= 0 for slack in statics.slacks if slack.size]
        objective = cp.Minimize(problem.live_norm * statics.load_factor + weight * energy)
        self.program = cp.Problem(objective, [statics.equilibrium, *within_yield])
        self._statics = statics

    def read(self) -> tuple[float, np.ndarray]:
        """λ and joint forces n, s, m in turn, shape (3c,), at the optimum."""
        return self._statics.read()


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

"""Check that forces carry the dead load, from the matrices alone."""

import numpy as np

from masonry_opt.problem.problem import Problem
from masonry_opt.solution.thresholds import DRIVES

#: Name in a result's ``solvers`` for the check that a scene is stable under its dead load.
DEAD_LOAD = "dead load"


def carries(problem: Problem, q: np.ndarray, most: float = DRIVES) -> bool:
    """Return True if joint forces q, shape (3c + t,), carry the dead load.

    The sum of the unbalanced forces, and the largest violation of yield, may be up to ``most``. The default
    is the least power of a mechanism that the dead load drives. By duality, the largest power of a mechanism
    equals the smallest sum of unbalanced forces.
    """
    beyond = -float(problem.by_cone.slacks(q).min(initial=0.0))
    return max(float(np.abs(problem.unbalanced(0.0, q)).sum()), beyond) <= most

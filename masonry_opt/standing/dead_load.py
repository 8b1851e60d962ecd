"""Check that forces carry the dead load, from the matrices alone."""

import numpy as np

from masonry_opt.answer.thresholds import DRIVES
from masonry_opt.problem.problem import Problem

DEAD_LOAD = "dead load"  #: Name of the solver's use for the check that a scene stands under its dead load.


def carries(problem: Problem, q: np.ndarray, most: float = DRIVES) -> bool:
    """Return True if joint forces q, shape (3c + t,), carry the dead load.

    The sum of the forces out of balance, and the largest violation of yield, may be up to ``most``. By
    default this is the least power that a mechanism needs to count as driven by the dead load: by duality,
    the greatest power is the least sum of forces out of balance.
    """
    beyond = -float(problem.by_cone.slacks(q).min(initial=0.0))
    return max(float(np.abs(problem.unbalanced(0.0, q)).sum()), beyond) <= most

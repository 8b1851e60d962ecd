"""Check from the matrices alone that joint forces carry the dead load."""

from dataclasses import replace

import numpy as np

from masonry_opt.problem.problem import Problem
from masonry_opt.solution.thresholds import DRIVING_POWER

#: Key of ``result.solvers`` for the solver that decides if a scene is stable under its dead load.
DEAD_LOAD = "dead load"


def carries(problem: Problem, q: np.ndarray, most: float = DRIVING_POWER) -> bool:
    """Return True if joint forces q, shape (3c + t,), carry the dead load within a tolerance.

    The sum of the unbalanced forces, and the largest violation of a yield condition, may be up to ``most``.
    The default is the power above which a mechanism counts as driven by the dead load. The same limit applies
    to both, because by duality the largest power of a mechanism equals the smallest sum of unbalanced forces.
    """
    beyond = -float(problem.by_cone.slacks(q).min(initial=0.0))
    return max(float(np.abs(problem.unbalanced(0.0, q)).sum()), beyond) <= most


def with_pressure_removed(problem: Problem) -> Problem:
    """Return a problem whose live load, at λ = 1, reduces the normal force of every joint by one unit.

    The live load is B e, where e is 1 for every normal force and 0 for shears. The associative load factor of
    this problem is the margin of stability: the largest amount by which the normal forces of all joints can
    exceed the normal forces that their shears and moments require. It is negative if the scene is unstable.
    """
    return replace(problem, live=problem.B @ unit_pressure(problem))


def unit_pressure(problem: Problem) -> np.ndarray:
    """Return joint forces, shape (3c + t,), with a normal force of 1 in each joint and without shear."""
    normal = np.zeros(problem.B.shape[1])
    problem.at_points(normal)[:] = 1 / problem.layout.points
    return normal

"""Compute the safety margins of a stable scene: how much friction, and how much of its joints, it can lose.

Both margins are computed by bisection. In each step forces or a mechanism are verified from the matrices
alone, see :mod:`~masonry_opt.stability.diagnosis`.
"""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import scipy.sparse as sp

from masonry_opt.effort import Effort
from masonry_opt.problem.assembly import Assembly
from masonry_opt.problem.problem import Problem
from masonry_opt.solvers.driver import ProgramCache
from masonry_opt.solvers.registry import Solver
from masonry_opt.stability.diagnosis import FACTOR_UP_TO, DeadLoadUndecided, falling_mechanism

#: The bisection for a safety margin varies a multiplier, from 0 to 1, of the friction or of the size of the
#: joints. It ends if the largest unstable and the smallest stable multiplier differ by at most this fraction
#: of the stable multiplier. A smaller tolerance requires more linear programs.
_BISECTION_TOLERANCE = 2e-4

#: The bisection for a safety margin ends early if the scene is stable with a multiplier up to this limit,
#: because such a small multiplier is negligible. A smaller limit requires more linear programs.
_NEGLIGIBLE_VALUE = 1e-4

#: Largest number of joints of a scene for which the geometric margin is computed. Each step of its bisection
#: builds a new linear program, which takes about a second for a scene of this size.
_MARGIN_UP_TO = 600


def least_friction_factor(problem: Problem, solver: Solver, effort: Effort) -> float | None:
    """Return the smallest common multiplier of all friction coefficients with which a scene is stable.

    A scene counts as stable if forces carry its dead load. None is returned if no joint can slide, if the
    scene is large, or if the solver cannot decide.
    """
    if not len(problem.sliding) or problem.joints > FACTOR_UP_TO:
        return None
    cache = ProgramCache(keeps=True)

    def is_stable(factor: float) -> bool:
        """Return True if the scene is stable after all friction coefficients are multiplied by a factor."""
        weaker = replace(problem, law=replace(problem.law, friction=factor * problem.friction))
        return falling_mechanism(weaker, solver, effort, cache) is None

    return _least_stable(is_stable)


def geometric_margin(assembly: Assembly, solver: Solver, effort: Effort) -> float | None:
    """Return the largest fraction by which all joints can shrink while the scene stays stable.

    Each joint shrinks towards its middle.

    The result is None in these cases: some joint has a limited strength, so that its limits depend on its
    length; no joint has a length (in space, an area); the scene is large; or the solver cannot decide.
    """
    problem = assembly.problem
    has_extent = bool((assembly.joints.extent > 0).any())
    if len(problem.crushing) or not has_extent or problem.joints > _MARGIN_UP_TO:
        return None

    def is_stable(share_left: float) -> bool:
        """Return True if the scene is stable after all joints have shrunk to a fraction of their size."""
        return falling_mechanism(_with_shrunk_joints(assembly, share_left), solver, effort) is None

    share = _least_stable(is_stable)
    return None if share is None else 1.0 - share


def _least_stable(is_stable: Callable[[float], bool]) -> float | None:
    """Find the smallest value between 0 and 1 for which ``is_stable`` is True, by bisection.

    ``is_stable`` must be True for 1, and for all values above a value for which it is True.

    The result is None if the solver cannot decide.
    """
    fails, holds = 0.0, 1.0
    try:
        if is_stable(0.0):
            return 0.0
        while holds > _NEGLIGIBLE_VALUE and holds - fails > _BISECTION_TOLERANCE * holds:
            value = (fails + holds) / 2
            if is_stable(value):
                holds = value
            else:
                fails = value
    except DeadLoadUndecided:
        return None
    return holds


def _with_shrunk_joints(assembly: Assembly, share: float) -> Problem:
    """Return a problem in which all contact points are moved towards the middles of their joints.

    ``share`` is the remaining distance of a point from the middle, divided by its original distance. The
    force on a moved point is replaced by an equivalent combination of forces on the original points of the
    joint.
    """
    problem = assembly.problem
    points = problem.layout.points
    if points == 2:
        near, far = (1 + share) / 2, (1 - share) / 2
        mixed = sp.kron([[near, far], [far, near]], sp.eye_array(problem.joints))
        moved = [mixed, sp.eye_array(problem.joints)]
    else:
        joint = assembly.joint
        of_joint = sp.csr_array((np.ones(len(joint)), (joint, np.arange(len(joint)))))
        mean = of_joint.T @ sp.diags_array(1 / np.asarray(of_joint.sum(axis=1)).ravel()) @ of_joint
        mixed = share * sp.eye_array(len(joint)) + (1 - share) * mean
        moved = [mixed, mixed, mixed]
    moved.append(sp.eye_array(problem.matrices.limited))
    matrices = replace(problem.matrices, B=(problem.B @ sp.block_diag(moved)).tocsr())
    return replace(problem, matrices=matrices)

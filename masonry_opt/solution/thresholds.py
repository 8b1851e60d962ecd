"""Thresholds above which motions and differences are reported in messages, plots and tables.

The limits that decide if an answer is accepted are in :mod:`~masonry_opt.solution.acceptance`.
"""

from masonry_opt.problem.problem import Problem
from masonry_opt.solution.acceptance import SMALLEST

#: A block counts as at rest if its fastest corner is slower than this fraction of the largest speed in the
#: scene. The loop computes 1.0e-3 for a block at rest (``closed_forms/pulled_stone``). A hand calculation
#: shows 5e-3 for the slowest moving block (``closed_forms/two_leaves``).
MOVES = 2e-3

#: A joint counts as sliding if it slips faster than this fraction of the largest speed in the scene. In
#: inexact answers of the loop of linear programs, the slip speed of joints between blocks at rest is up to
#: 0.002 μ times the largest speed.
SLIDES = MOVES

#: A joint counts as hinging if rotation opens one of its edges faster than this fraction of the speed of the
#: fastest corner.
HINGES = MOVES

#: A joint counts as separating if it opens at all of its contact points, faster than this fraction of the
#: speed of the fastest corner.
SEPARATES = MOVES

#: A joint of limited strength counts as crushing if one of its edges closes faster than this fraction of the
#: speed of the fastest corner.
CRUSHES = MOVES

#: A limited force (such as a tie force) counts as yielding if it exceeds this fraction of its upper limit,
#: and if the mechanism lengthens the tie or shortens the prop.
AT_HIGHEST = 1 - MOVES

#: Power of the loads, in median block weights, below which the loads do not drive the mechanism. Solvers
#: return up to 1e-9 for a power of zero.
DRIVING_POWER = 1e-7

#: A force, slip or rotation counts as zero below this fraction of the largest value in the scene. For
#: example, a joint counts as free of force if its normal force is below this fraction of the largest one.
NEGLIGIBLE_SHARE = 1e-6

#: Messages about locking list the joints whose departure from associative flow exceeds this fraction of the
#: largest departure. Messages about self-stress list the joints whose normal force exceeds this fraction of
#: the largest normal force.
LISTED_JOINT_SHARE = 1e-2

#: Relative difference below which two load factors count as equal. On the case files, methods differ by up to
#: 2e-8 for one state, and different states differ by at least 8e-4.
EQUALITY_TOLERANCE = 1e-6

#: Relative size of rounding errors in load factors, resultants and margins. A load factor counts as lower
#: than another only if the relative difference is larger. The value is the residual limit of exact states.
RELATIVE_ROUNDING = 1e-8

#: Magnitude below which a load factor counts as zero, if the live load does not exceed the dead load. For
#: larger live loads see :func:`zero_limit`.
ZERO = 1e-6

#: If the lowest, the incremental and the associative load factor agree after fewer starts, a message says
#: that a collapse state with a lower load factor may exist.
FEW_STARTS = 8

#: A message states that the mechanism moves against the live load if the live load's work is negative and
#: large enough. Its magnitude must exceed this fraction of the dead load's work.
LEAST_OPPOSING_WORK = 1e-2

#: Smallest change of the load factor in a narrow interval of a varied parameter that counts as a jump,
#: relative to the largest load factor.
JUMP = 1e-3


def zero_limit(problem: Problem) -> float:
    """Return the magnitude below which a load factor of a problem counts as zero.

    The limit is ``ZERO``, or less if the live load exceeds the dead load: load factors are then small too.
    """
    return ZERO * load_ratio(problem)


def load_ratio(problem: Problem) -> float:
    """Return the ratio of the dead load to the live load if it is less than 1; otherwise return 1.

    All thresholds of load factors are multiplied by this ratio.
    """
    dead = float(problem.force_sizes(problem.dead).sum())
    return min(1.0, dead / problem.live_norm) if dead and problem.live_norm else 1.0


def same(first: float, second: float, ratio: float = 1.0) -> bool:
    """Return True if two load factors are equal up to the relative difference ``EQUALITY_TOLERANCE``.

    ``ratio`` is the :func:`load_ratio` of their problem.
    """
    return abs(first - second) <= EQUALITY_TOLERANCE * max(abs(first), abs(second), SMALLEST * ratio)


def is_lower(load_factor: float, than: float, ratio: float = 1.0) -> bool:
    """Return True if a load factor is lower than another by more than rounding.

    ``ratio`` is the :func:`load_ratio` of their problem.
    """
    return load_factor < than - RELATIVE_ROUNDING * max(abs(than), SMALLEST * ratio)

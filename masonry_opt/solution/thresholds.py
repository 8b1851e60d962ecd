"""Thresholds above which motions and differences count, for words, pictures and tables.

No threshold decides if an answer is accepted: those limits are in :mod:`~masonry_opt.solution.acceptance`.
"""

from masonry_opt.solution.acceptance import SMALLEST

#: Speed of a block's fastest corner, over that of the scene's fastest corner, below which the block is at
#: rest. Answers of the loop contain 1.0e-3 for a block at rest (``closed_forms/pulled_stone``). The slowest
#: block that is known by hand to move has 5e-3 (``closed_forms/two_leaves``).
MOVES = 2e-3

#: Slip of a joint, over the speed of the fastest corner, above which the joint slides. A joint between blocks
#: at rest slips by 2e-3 μ in answers of the loop.
SLIDES = MOVES

#: Opening of an edge by rotation, over the speed of the fastest corner, above which the joint hinges.
HINGES = MOVES

#: Opening of a joint's edge that opens less than the other, over the speed of the fastest corner, above which
#: the joint separates.
SEPARATES = MOVES

#: Closing of an edge, over the speed of the fastest corner, above which a joint of limited strength crushes.
CRUSHES = MOVES

#: Share of its highest value above which a limited force (such as the force of a tie) yields, if its end
#: points move apart, or together, in the mechanism.
AT_HIGHEST = 1 - MOVES

#: Power of the loads at velocities of bounded size, in median block weights, below which no load drives the
#: velocities. Solvers return up to 1e-9 for a power of zero.
DRIVES = 1e-7

#: Share of the scene's largest normal force below which a joint carries no force.
IDLE = 1e-6

#: Share of the largest value above which a joint is named in a message. The value is the departure from
#: associative flow for joints that lock, and the normal force for joints that clamp.
LISTED_JOINT_SHARE = 1e-2

#: Relative difference below which two load factors are equal. Answers of different methods to one state
#: differ by up to 2e-8 on the case files; different states differ by 8e-4 and more.
SAME = 1e-6

#: Relative difference above which one load factor is lower than another. The value is the residual limit of
#: exact states.
LOWER = 1e-8

#: Size up to which a load factor counts as zero.
ZERO = 1e-6

#: Number of starts below which equal load factors are reported as little evidence.
FEW_STARTS = 8

#: Work of the live load over that of the dead load above which a mechanism is reported to move against the
#: live load.
APART = 1e-2

#: Smallest jump of the load factor within a narrow interval, as a share of the largest load factor. A smaller
#: difference between the ends of the interval does not count as a jump.
JUMP = 1e-3


def same(one: float, other: float) -> bool:
    """Return True if two load factors are equal up to ``SAME``."""
    return abs(one - other) <= SAME * max(abs(one), abs(other), SMALLEST)


def is_lower(load_factor: float, than: float) -> bool:
    """Return True if a load factor is lower than another by more than rounding."""
    return load_factor < than - LOWER * max(abs(than), SMALLEST)

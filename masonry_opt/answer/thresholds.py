"""Thresholds from which on something moves, slides, is idle or differs, for words, pictures and tables. None
decides whether an answer is accepted: those limits stand in ``acceptance``."""

from masonry_opt.answer.acceptance import SMALLEST

#: Speed of a block's fastest corner, over that of the scene's fastest, below which the block is at rest.
#: The loop's answers give 1.0e-3 to a block that rests (``closed_forms/pulled_stone``); the slowest block
#: known by hand to move has 5e-3 (``closed_forms/two_leaves``).
MOVES = 2e-3

#: The same share, of a joint's rates: its slip, the opening of an edge by turning, the opening of the edge
#: that opens less, the closing of an edge. A joint of blocks at rest in the loop's answers has twice 10⁻³ μ.
SLIDES = HINGES = SEPARATES = CRUSHES = MOVES

#: Share of its highest value from which a limited force that goes further yields: below, contacts give.
AT_HIGHEST = 1 - MOVES

#: Power of bounded velocities, in median block weights, below which no load drives them. (Solvers leave 1e-9
#: of a zero.)
DRIVES = 1e-7

IDLE = 1e-6  #: Share of the scene's largest normal force below which a joint carries nothing.
NAMED = 1e-2  #: Share of the largest from which a joint is named among those that lock, or clamp.

#: Relative difference below which two load factors are one. Answers of different methods to one state differ
#: by up to 2e-8 on the case files; different states by 8e-4 and more.
SAME = 1e-6

#: Relative difference from which a load factor is lower, or a load missed: the residual of exact states.
LOWER = 1e-8

ZERO = 1e-6  #: Load factors up to this, of either sign, are zero.
APART = 1e-2  #: Relative difference from which on different states are reported.

#: Share of the largest load factor by which the two ends of a narrow interval differ where there is a jump.
JUMP = 1e-3


def same(one: float, other: float) -> bool:
    """Whether two load factors are one."""
    return abs(one - other) <= SAME * max(abs(one), abs(other), SMALLEST)


def is_lower(load_factor: float, than: float) -> bool:
    """Whether a load factor is lower than another by more than rounding."""
    return load_factor < than - LOWER * max(abs(than), SMALLEST)

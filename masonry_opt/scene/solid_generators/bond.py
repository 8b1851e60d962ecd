"""Where the stones of a course end: joints of a bond, and what is done with pieces too short or too long."""

import math
from collections.abc import Iterable, Sequence
from itertools import pairwise

CLOSER = 0.25  #: Of a stone: pieces may be as short, and stones as much longer instead of a shorter piece.
_ROUNDING = 1e-9  #: Of a stone, what is rounding.


def cut(
    start: float, end: float, joints: Iterable[float], length: float, spare: Sequence[float] = ()
) -> list[tuple[float, float]]:
    """The stones of some length from one end of a run to the other.

    The bond has joints there, rising, of which those nearer than a closer to an end are left out. What is
    more than a closer longer than a stone is cut in two or more, as long as each other, at spare places first
    where these are half a stone or more from joints.
    """

    def within(places: Iterable[float], low: float, high: float, least: float) -> list[float]:
        least *= length * (1 - _ROUNDING)
        return [place for place in places if low + least < place < high - least]

    def too_long(low: float, high: float) -> bool:
        return high - low > length * (1 + CLOSER + _ROUNDING)

    ends = [start, *within(joints, start, end, CLOSER), end]
    spares = [place for run in pairwise(ends) if too_long(*run) for place in within(spare, *run, 0.5)]
    stones: list[tuple[float, float]] = []
    for low, high in pairwise(sorted([*ends, *spares])):
        count = math.ceil((high - low) / length - CLOSER - _ROUNDING) if too_long(low, high) else 1
        between = [low + (high - low) * number / count for number in range(1, count)]
        stones += pairwise([low, *between, high])
    return stones


def every(length: float, start: float, end: float) -> list[float]:
    """Joints a stone apart, the first at ``start``, up to ``end``."""
    return [start + number * length for number in range(math.floor((end - start) / length + _ROUNDING) + 1)]

"""Ranges and rings of numbers one after another, and combinations, so many at a time as memory holds."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

#: Combinations held in memory at a time.
_MOST_AT_ONCE = 2_000_000


def ranges(first: np.ndarray, count: np.ndarray) -> np.ndarray:
    """So many numbers from each first one upwards, one range after another."""
    return np.arange(count.sum()) + np.repeat(first - np.cumsum(count) + count, count)


def following(count: np.ndarray) -> np.ndarray:
    """The number that follows each in rings of so many numbers, one after the other."""
    ends = np.cumsum(count)
    after = np.arange(1, count.sum() + 1)
    after[ends[count > 0] - 1] = (ends - count)[count > 0]
    return after


def combine(
    first1: np.ndarray, count1: np.ndarray, first2: np.ndarray, count2: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """All pairs of one from each range of numbers and one from the range beside it: which ranges, and the two
    numbers; the second runs fastest."""
    size = count1 * count2
    number = np.repeat(np.arange(len(size)), size)
    step = ranges(np.zeros_like(size), size)
    return number, first1[number] + step // count2[number], first2[number] + step % count2[number]


def chunks(sizes: np.ndarray) -> Iterator[slice]:
    """Slices of so many combinations each that memory holds them."""
    total = np.cumsum(sizes)
    first = 0
    while first < len(sizes):
        before = total[first] - sizes[first]
        end = max(first + 1, int(np.searchsorted(total, before + _MOST_AT_ONCE, side="right")))
        yield slice(first, end)
        first = end

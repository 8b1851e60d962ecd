"""Tables of arrays with as many rows each, what is found row by row, and combinations of rows."""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, fields
from itertools import pairwise, starmap
from typing import Self

import numpy as np
import scipy.sparse as sp
from scipy.sparse.csgraph import connected_components

_MOST_AT_ONCE = 2_000_000  #: Combinations held in memory at a time.


@dataclass(frozen=True)
class Rows:
    """Columns with as many rows each, arrays or such tables again."""

    def where(self, chosen: np.ndarray) -> Self:
        """The rows of a mask, or with these numbers in this order."""
        columns = (getattr(self, column.name) for column in fields(self))
        return type(self)(*(one.where(chosen) if isinstance(one, Rows) else one[chosen] for one in columns))

    def then(self, *more: Self) -> Self:
        """These rows, then more."""
        every = ([getattr(one, column.name) for one in (self, *more)] for column in fields(self))
        new = (own[0].then(*own[1:]) if isinstance(own[0], Rows) else np.concatenate(own) for own in every)
        return type(self)(*new)


def dots(one: np.ndarray, other: np.ndarray) -> np.ndarray:
    """Scalar products of the rows, shape (rows,)."""
    return np.einsum("ij,ij->i", one, other)


def lengths(vectors: np.ndarray) -> np.ndarray:
    """Lengths of the rows, shape (rows,)."""
    return np.sqrt(dots(vectors, vectors))


def sums(owner: np.ndarray, values: np.ndarray, count: int) -> np.ndarray:
    """Sums of the rows of values, shape (rows, k), by owner, shape (count, k)."""
    return np.column_stack([np.bincount(owner, column, count) for column in values.T])


def bounds(owner: np.ndarray, values: np.ndarray, count: int) -> tuple[np.ndarray, np.ndarray]:
    """Least and largest of the rows of values by owner, rising, each of which has some, shape (count, k)."""
    first = np.searchsorted(owner, np.arange(count))
    return np.minimum.reduceat(values, first), np.maximum.reduceat(values, first)


def first_alike(rows: np.ndarray) -> np.ndarray:
    """Of each row the first one with the same numbers."""
    _, first, own = np.unique(rows, axis=0, return_index=True, return_inverse=True)
    return first[own.reshape(-1)]


def linked(count: int, one: np.ndarray, other: np.ndarray) -> np.ndarray:
    """Number of the group of each of so many rows, which pairs of rows link, shape (count,)."""
    links = sp.coo_array((np.ones(len(one)), (one, other)), shape=(count, count))
    return connected_components(links, directed=False)[1]


def turned(count: int, one: np.ndarray, other: np.ndarray, alike: np.ndarray) -> tuple[np.ndarray, ...]:
    """Which of so many faces to turn round, given pairs that share an edge, and whether they run along it the
    same way, which none shall; and which cannot be turned so. Shape (count,) each."""
    # Two nodes a face, as it is and turned round; edges say which of two faces' go together.
    together = np.where(alike, other + count, other), np.where(alike, other, other + count)
    group = linked(2 * count, np.append(one, one + count), np.append(*together))
    return group[:count] > group[count:], group[:count] == group[count:]


def ranges(first: np.ndarray, count: np.ndarray) -> np.ndarray:
    """So many numbers from each first one upwards, one range after another."""
    return np.arange(count.sum()) + np.repeat(first - np.cumsum(count) + count, count)


def following(count: np.ndarray) -> np.ndarray:
    """The number that follows each in rings of so many numbers, one after the other."""
    ends = np.cumsum(count)
    after = np.arange(1, count.sum() + 1)
    after[ends[count > 0] - 1] = (ends - count)[count > 0]
    return after


def steps_round(ring: Sequence[int]) -> Iterator[tuple[int, int]]:
    """Each number of a ring and the next one."""
    return zip(ring, [*ring[1:], ring[0]], strict=True)


def combine(
    first1: np.ndarray, count1: np.ndarray, first2: np.ndarray, count2: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """All pairs from ranges of numbers side by side: which ranges, and the two; the second runs fastest."""
    size = count1 * count2
    number = np.repeat(np.arange(len(size)), size)
    step = ranges(np.zeros_like(size), size)
    return number, first1[number] + step // count2[number], first2[number] + step % count2[number]


def chunks(sizes: np.ndarray) -> Iterator[slice]:
    """Slices of so many combinations each that memory holds them."""
    ends = np.flatnonzero(np.diff(np.cumsum(sizes) // _MOST_AT_ONCE)) + 1
    return starmap(slice, pairwise([0, *ends.tolist(), len(sizes)]))


def spaces(
    start: float, end: float, gaps: Iterable[Sequence[float]], least: float = 0.0
) -> list[tuple[float, float]]:
    """What gaps, in any order, leave of the length from one place to another, in pieces longer than so."""
    left, at = [], start
    for low, high in [*sorted(map(tuple, gaps)), (end, end)]:
        if min(low, end) - at > least:
            left.append((at, float(min(low, end))))
        at = max(at, high)
    return left

"""Provide tables of arrays with equal numbers of rows, functions of rows, and combinations of rows."""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, fields
from itertools import pairwise, starmap
from typing import Self

import numpy as np
import scipy.sparse as sp
from scipy.sparse.csgraph import connected_components

#: Approximate largest number of combinations, such as pairs of block sides, that are computed at once. A
#: larger value needs more memory.
_CHUNK_SIZE = 2_000_000


@dataclass(frozen=True)
class Rows:
    """Table whose columns have equal numbers of rows; each column is an array or another table."""

    def where(self, chosen: np.ndarray) -> Self:
        """Return the rows that a mask selects, or the rows with the given indices."""
        columns = (getattr(self, field.name) for field in fields(self))
        return type(self)(
            *(column.where(chosen) if isinstance(column, Rows) else column[chosen] for column in columns)
        )

    def then(self, *more: Self) -> Self:
        """Return the rows of this table, followed by the rows of other tables."""
        columns = ([getattr(table, field.name) for table in (self, *more)] for field in fields(self))
        return type(self)(
            *(
                parts[0].then(*parts[1:]) if isinstance(parts[0], Rows) else np.concatenate(parts)
                for parts in columns
            )
        )


def dots(first: np.ndarray, second: np.ndarray) -> np.ndarray:
    """Return the scalar products of corresponding rows of two arrays, shape (rows,)."""
    return np.einsum("ij,ij->i", first, second)


def lengths(vectors: np.ndarray) -> np.ndarray:
    """Return the Euclidean lengths of the rows of an array, shape (rows,)."""
    return np.sqrt(dots(vectors, vectors))


def sums(owner: np.ndarray, values: np.ndarray, count: int) -> np.ndarray:
    """Return the sum of the rows of ``values`` in each group, shape (count, columns).

    ``values`` has shape (rows, columns). ``owner`` has, for each row, the index of the group to which the row
    belongs, less than ``count``.
    """
    return np.column_stack([np.bincount(owner, column, count) for column in values.T])


def bounds(owner: np.ndarray, values: np.ndarray, count: int) -> tuple[np.ndarray, np.ndarray]:
    """Return the minimum and maximum of each column in each group of rows, shape (count, columns) each.

    ``values`` has shape (rows, columns). ``owner`` has, for each row, the index of the group to which the row
    belongs, in ascending order. Each group has at least one row.
    """
    first = np.searchsorted(owner, np.arange(count))
    return np.minimum.reduceat(values, first), np.maximum.reduceat(values, first)


def first_alike(rows: np.ndarray) -> np.ndarray:
    """Return, for each row, the index of the first row that is equal to it."""
    _, first, group = np.unique(rows, axis=0, return_index=True, return_inverse=True)
    return first[group.reshape(-1)]


def linked(count: int, first: np.ndarray, second: np.ndarray) -> np.ndarray:
    """Return, for each node of a graph, the index of its connected component, shape (nodes,).

    The graph has ``count`` nodes. Its edges connect each node of ``first`` to the node at the same place of
    ``second``.
    """
    links = sp.coo_array((np.ones(len(first)), (first, second)), shape=(count, count))
    return connected_components(links, directed=False)[1]


def turned(count: int, first: np.ndarray, second: np.ndarray, alike: np.ndarray) -> tuple[np.ndarray, ...]:
    """Return the faces of a surface that must be reversed so that all faces have the same orientation.

    Parameters
    ----------
    count : int
        Number of faces.
    first, second : ndarray
        Pairs of faces that share an edge.
    alike : ndarray
        True if both faces of a pair traverse their shared edge in the same direction. Faces of equal
        orientation traverse it in opposite directions.

    Returns
    -------
    turn, contradictory : ndarray, shape (count,)
        Masks of the faces to turn, and of the faces for which no choice is consistent.
    """
    # The graph has two nodes for each face, one for each orientation. Its edges connect consistent
    # orientations of neighbouring faces.
    targets = np.where(alike, second + count, second), np.where(alike, second, second + count)
    group = linked(2 * count, np.append(first, first + count), np.append(*targets))
    return group[:count] > group[count:], group[:count] == group[count:]


def ranges(first: np.ndarray, count: np.ndarray) -> np.ndarray:
    """Concatenate ranges of integers that are given by their first integers and lengths."""
    return np.arange(count.sum()) + np.repeat(first - np.cumsum(count) + count, count)


def following(count: np.ndarray) -> np.ndarray:
    """Return, for each entry of several rings, the index of the following entry of the same ring.

    The rings have the sizes ``count``, and their entries are numbered consecutively over all rings. The entry
    that follows the last entry of a ring is its first entry.
    """
    ends = np.cumsum(count)
    next_entry = np.arange(1, count.sum() + 1)
    next_entry[ends[count > 0] - 1] = (ends - count)[count > 0]
    return next_entry


def steps_round(ring: Sequence[int]) -> Iterator[tuple[int, int]]:
    """Return the pairs of successive entries of a ring; the last entry is paired with the first."""
    return zip(ring, [*ring[1:], ring[0]], strict=True)


def combine(
    first1: np.ndarray, count1: np.ndarray, first2: np.ndarray, count2: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return all pairs of an integer of range k of one list and an integer of range k of another, for all k.

    Range k of the first list has ``count1[k]`` integers and begins with ``first1[k]``. Range k of the second
    list has ``count2[k]`` integers and begins with ``first2[k]``. A pair consists of an integer i from range
    k of the first list and an integer j from range k of the second list. The results are the numbers k, i and
    j of each pair, as three arrays of shape (pairs,). The number j varies fastest, and k varies slowest.
    """
    size = count1 * count2
    number = np.repeat(np.arange(len(size)), size)
    step = ranges(np.zeros_like(size), size)
    return number, first1[number] + step // count2[number], first2[number] + step % count2[number]


def chunks(sizes: np.ndarray) -> Iterator[slice]:
    """Divide the array ``sizes`` into slices whose entries sum to at most about ``_CHUNK_SIZE``.

    The entries of ``sizes`` are numbers of combinations, so the combinations of one slice fit into memory.
    """
    ends = np.flatnonzero(np.diff(np.cumsum(sizes) // _CHUNK_SIZE)) + 1
    return starmap(slice, pairwise([0, *ends.tolist(), len(sizes)]))


def spaces(
    start: float, end: float, gaps: Iterable[Sequence[float]], least: float = 0.0
) -> list[tuple[float, float]]:
    """Return the parts of the interval from ``start`` to ``end`` that are outside all ``gaps``.

    Each gap is a pair of its lower and its upper end. The gaps can be in any order, and may overlap. Parts
    that are not longer than ``least`` are left out.
    """
    pieces = []
    position = start
    for low, high in [*sorted(map(tuple, gaps)), (end, end)]:
        if min(low, end) - position > least:
            pieces.append((position, float(min(low, end))))
        position = max(position, high)
    return pieces

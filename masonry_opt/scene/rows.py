"""Tables of arrays with as many rows each, and what is found row by row."""

from __future__ import annotations

from dataclasses import dataclass, fields
from typing import Self

import numpy as np
import scipy.sparse as sp
from scipy.sparse.csgraph import connected_components


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
        return type(self)(
            *(own[0].then(*own[1:]) if isinstance(own[0], Rows) else np.concatenate(own) for own in every)
        )


def dots(one: np.ndarray, other: np.ndarray) -> np.ndarray:
    """Scalar products of the rows, shape (rows,)."""
    return np.einsum("ij,ij->i", one, other)


def lengths(vectors: np.ndarray) -> np.ndarray:
    """Lengths of the rows, shape (rows,)."""
    return np.sqrt(dots(vectors, vectors))


def sums(owner: np.ndarray, values: np.ndarray, count: int) -> np.ndarray:
    """Sums of the rows of values, shape (rows, k), by owner, shape (count, k)."""
    return np.column_stack([np.bincount(owner, column, count) for column in values.T])


def first_alike(rows: np.ndarray) -> np.ndarray:
    """Of each row the first one with the same numbers."""
    order = np.lexsort(rows.T)
    new = np.ones(len(order), dtype=bool)
    new[1:] = (np.diff(rows[order], axis=0) != 0).any(axis=1)
    first = np.empty_like(order)
    first[order] = order[new][np.cumsum(new) - 1]
    return first


def linked(count: int, one: np.ndarray, other: np.ndarray) -> np.ndarray:
    """Number of the group of each of so many rows, which pairs of rows link, shape (count,)."""
    links = sp.coo_array((np.ones(len(one)), (one, other)), shape=(count, count))
    return connected_components(links, directed=False)[1]

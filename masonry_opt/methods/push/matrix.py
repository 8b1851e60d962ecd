"""The matrix of the blocks under stiffnesses of contacts, bordered by a load, and its factors."""

from __future__ import annotations

from collections.abc import Callable
from functools import cached_property
from typing import Any

import numpy as np
import scipy.sparse as sp
from scipy.linalg import lapack
from scipy.sparse.linalg import splu

from masonry_opt.methods.push.law import Rounded
from masonry_opt.problem.problem import Problem

#: Unknowns up to which matrices are full: LAPACK has little overhead.
_FULL_UP_TO = 250

#: Stiffness that is added to contacts, over the largest, where some motion finds none: it chooses among many
#: mechanisms one in which joints move about alike. And that of blocks, over it, for those that move no joint.
_REGULARISATION, _OF_BLOCKS = 1e-15, 0.01


class BlockMatrix:
    """[[S, -f], [c, 0]] with S = B J k Bᵀ, for a load f and a row c, shape (3b,) each; else [[S, 0], [0, 1]].

    Attributes
    ----------
    B: by slider, shape (3b, 3m), and its transpose ``Bt``.
    """

    def __init__(self, problem: Problem, law: Rounded) -> None:
        B, m = problem.B.tocoo(), law.count
        column = np.flatnonzero(law.of_sliders(np.ones(B.shape[1])))[B.col]
        self.B = sp.csr_array((B.data, (B.row, column)), shape=(B.shape[0], 3 * m))
        self.Bt, self.size = self.B.T.tocsr(), B.shape[0] + 1
        # Every two entries of B in columns of one slider, and the entry of S that they add to.
        order = np.argsort(column % m, kind="stable")
        row, kind, slider, value = B.row[order], column[order] // m, column[order] % m, B.data[order]
        count = np.bincount(slider, minlength=m)[slider]
        one = np.repeat(np.arange(len(row)), count)
        start = np.searchsorted(slider, slider) - np.cumsum(count) + count
        other = np.arange(len(one)) + np.repeat(start, count)
        last, diagonal = self.size - 1, (self.size + 1) * np.arange(self.size)
        border = self.size * np.arange(last) + last, self.size * last + np.arange(last)
        at = [row[other] * self.size + row[one], diagonal, *border]
        self._places, place = np.unique(np.concatenate(at), return_inverse=True)
        place, self._diagonal, self._below, self._right = np.split(
            place, np.cumsum([len(of) for of in at[:-1]])
        )
        entry = (3 * kind[one] + kind[other]) * m + slider[one]
        self._of_stiffness = sp.csr_array(
            (value[one] * value[other], (place, entry)), shape=(len(self._places), 9 * m)
        )
        springs = np.broadcast_to(np.eye(3)[:, :, None], (3, 3, m))
        self._of_springs = self._of_stiffness @ springs.ravel()
        self._of_springs[self._diagonal[:-1]] += _OF_BLOCKS
        self._rows = (self._places % self.size).astype(np.int32)
        ends = np.arange(self.size + 1) * self.size
        self._starts = np.searchsorted(self._places, ends).astype(np.int32)

    def factors(
        self, stiffness: np.ndarray, load: np.ndarray | None = None, row: np.ndarray | None = None
    ) -> BlockFactors:
        """Factors of the matrix under sliders' stiffnesses, shape (3, 3, m)."""
        values = self._of_stiffness @ stiffness.ravel()
        values += _REGULARISATION * np.abs(stiffness).max() * self._of_springs
        if load is None:
            values[self._diagonal[-1]] = 1.0
        else:
            values[self._below], values[self._right] = row, -load
        shape = (self.size, self.size)
        if self.size > _FULL_UP_TO:
            return BlockFactors(sp.csc_matrix((values, self._rows, self._starts), shape=shape))
        full = np.zeros(self.size**2)
        full[self._places] = values
        return BlockFactors(full.reshape(shape).T)


class BlockFactors:
    """Factors of a matrix of the blocks.

    Attributes
    ----------
    solve: what solves for a right-hand side.
    """

    solve: Callable[[np.ndarray], np.ndarray]

    def __init__(self, matrix: sp.csc_matrix | np.ndarray) -> None:
        if isinstance(matrix, np.ndarray):
            lu, pivots, _ = lapack.dgetrf(matrix, overwrite_a=True)
            self._lu: Any = (lu, pivots)
            self.solve = lambda right: lapack.dgetrs(lu, pivots, right)[0]
        else:
            options = {"SymmetricMode": True}
            self._lu = splu(matrix, permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.01, options=options)
            self.solve = self._lu.solve

    @cached_property
    def sign(self) -> int:
        """Sign of the determinant."""
        if isinstance(self._lu, tuple):
            lu, pivots = self._lu
            diagonal, swapped = np.diagonal(lu), int((pivots != np.arange(len(pivots))).sum())
        else:
            diagonal = self._lu.U.diagonal()
            swapped = _swapped(self._lu.perm_r) + _swapped(self._lu.perm_c)
        return 1 if (np.count_nonzero(diagonal < 0) + swapped) % 2 == 0 else -1


def _swapped(order: np.ndarray) -> int:
    """How many entries are to be swapped to come to an order."""
    ahead, swapped = order.tolist(), 0
    for place in range(len(ahead)):
        while ahead[place] != place:
            other = ahead[place]
            ahead[place], ahead[other] = ahead[other], other
            swapped += 1
    return swapped

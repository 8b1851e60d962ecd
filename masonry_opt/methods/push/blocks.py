"""The matrix of the blocks of a cell, bordered by a live load, its factors, and changes of single sliders."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import scipy.sparse as sp
from scipy.linalg import lapack
from scipy.sparse.linalg import splu

from masonry_opt.methods.push.laws import Law
from masonry_opt.problem.problem import Problem

#: Unknowns up to which matrices are full: LAPACK has little overhead.
_FULL_UP_TO = 250

#: Added to the diagonal of S, over its largest stiffness, for cells in which a block hangs on nothing.
_REGULARISATION = 1e-15

#: Sliders whose change is added to factors, before these are made anew; from so many unknowns on.
_ADDED, _ADDED_FROM = 20, 100


class Blocks:
    """The matrix of the blocks, bordered by a live load: [[S, -f], [fᵀ, 0]]; without one [[S, 0], [0, 1]].

    Attributes
    ----------
    B: by slider, shape (3b, 3m), and its transpose ``Bt``.
    """

    def __init__(self, problem: Problem, law: Law, live: np.ndarray | None) -> None:
        B, m = problem.B.tocoo(), len(law.friction)
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
        place, diagonal, below, right = np.split(place, np.cumsum([len(of) for of in at[:-1]]))
        self._diagonal = diagonal[:-1]
        self._fixed = np.zeros(len(self._places))
        if live is None:
            self._fixed[diagonal[-1]] = 1.0
        else:
            self._fixed[below], self._fixed[right] = live, -live
        entry = (3 * kind[one] + kind[other]) * m + slider[one]
        self._of_stiffness = sp.csr_array(
            (value[one] * value[other], (place, entry)), shape=(len(self._places), 9 * m)
        )
        self._rows = (self._places % self.size).astype(np.int32)
        ends = np.arange(self.size + 1) * self.size
        self._starts = np.searchsorted(self._places, ends).astype(np.int32)

    def columns(self, slider: int) -> np.ndarray:
        """Columns of B of a slider, shape (3, 3b + 1)."""
        columns, m = np.zeros((3, self.size)), self.B.shape[1] // 3
        for kind in range(3):
            row = slice(*self.Bt.indptr[kind * m + slider :][:2])
            columns[kind, self.Bt.indices[row]] = self.Bt.data[row]
        return columns

    def factors(self, stiffness: np.ndarray) -> Callable[[np.ndarray], np.ndarray]:
        """What solves for a right-hand side, of sliders' stiffnesses, shape (3, 3, m)."""
        values = self._of_stiffness @ stiffness.ravel() + self._fixed
        values[self._diagonal] += _REGULARISATION * np.abs(stiffness).max()
        shape = (self.size, self.size)
        if self.size > _FULL_UP_TO:
            return splu(sp.csc_matrix((values, self._rows, self._starts), shape=shape)).solve
        full = np.zeros(self.size**2)
        full[self._places] = values
        lu, pivots, _ = lapack.dgetrf(full.reshape(shape).T, overwrite_a=True)
        return lambda right: lapack.dgetrs(lu, pivots, right)[0]


class Factors:
    """Factors of the blocks' matrix, and changes of single sliders since, (M + L D Lᵀ)⁻¹ by M⁻¹ L."""

    def __init__(self, blocks: Blocks, stiffness: np.ndarray) -> None:
        self._blocks, self._stiffness = blocks, stiffness.copy()
        self._base = blocks.factors(stiffness)
        self._sliders: list[int] = []
        # L and M⁻¹ L, three columns a slider; D; and 1 + D Lᵀ M⁻¹ L.
        self._columns, self._solved = np.zeros((2, 3 * _ADDED, blocks.size))
        self._change, self._matrix = np.zeros((0, 3, 3)), np.zeros((0, 0))

    @property
    def fresh(self) -> bool:
        """Whether nothing was added."""
        return not self._sliders

    def add(self, slider: int, stiffness: np.ndarray) -> bool:
        """Whether stiffnesses (3, 3, m), which differ from those before in a slider, are taken."""
        if slider not in self._sliders:
            if np.array_equal(stiffness[..., slider], self._stiffness[..., slider]):
                return True
            if self._blocks.size < _ADDED_FROM or len(self._sliders) == _ADDED:
                return False
            new = slice(3 * len(self._sliders), 3 * len(self._sliders) + 3)
            self._columns[new] = self._blocks.columns(slider)
            self._solved[new] = self._base(self._columns[new].T).T
            self._sliders.append(slider)
        of = self._sliders
        self._change = (stiffness[..., of] - self._stiffness[..., of]).transpose(2, 0, 1)
        meets = self._columns[: 3 * len(of)] @ self._solved[: 3 * len(of)].T
        self._matrix = np.eye(3 * len(of)) + self._changed(meets)
        return True

    def _changed(self, of: np.ndarray) -> np.ndarray:
        return (self._change @ of.reshape(len(self._change), 3, -1)).reshape(of.shape)

    def solve(self, right: np.ndarray) -> np.ndarray:
        """The solution for a right-hand side."""
        solution = self._base(right)
        if self._sliders:
            new = slice(3 * len(self._sliders))
            moved = self._changed(self._columns[new] @ solution)
            solution = solution - np.linalg.solve(self._matrix, moved) @ self._solved[new]
        return solution

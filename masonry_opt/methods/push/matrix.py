"""The matrix of the blocks under stiffnesses of contacts, bordered by a load, and its factors."""

from functools import cached_property

import numpy as np
import scipy.sparse as sp
from scipy.linalg import lapack
from scipy.sparse.csgraph import connected_components, reverse_cuthill_mckee
from scipy.sparse.linalg import splu

from masonry_opt.methods.push.law import Rounded
from masonry_opt.problem.problem import Problem

#: Share of the unknowns up to which a band is narrow, as in the plane: LAPACK takes a half to a fifth of the
#: time of sparse factors then, in space up to ten times as long. And unknowns up to which any band is.
_NARROW, _FEW = 0.25, 60

#: Stiffness that is added to contacts, over the largest, where some motion finds none: it chooses among many
#: mechanisms one in which joints move about alike. And that of blocks, over it, for those that move no joint.
_REGULARISATION, _OF_BLOCKS = 1e-15, 0.01


class BlockMatrix:
    """[[S, -f], [c, 0]] with S = B J k Bᵀ, for a load f and a row c, shape (3b,) each; else [[S, 0], [0, 1]].
    B is by slider, shape (3b, 3m)."""

    def __init__(self, problem: Problem, law: Rounded) -> None:
        B, m = problem.B.tocoo(), law.count
        column = np.flatnonzero(law.of_sliders(np.ones(B.shape[1])))[B.col]
        self.B = sp.csr_array((B.data, (B.row, column)), shape=(B.shape[0], 3 * m))
        self.Bt, self.size = self.B.T.tocsr(), B.shape[0] + 1
        # Every two entries of B in columns of one slider, and the entry of S that they add to.
        kind, slider = np.divmod(column, m)
        of_sliders = sp.csr_array((np.ones(B.nnz), (np.arange(B.nnz), slider)), shape=(B.nnz, m))
        one, other = (of_sliders @ of_sliders.T).nonzero()
        last, diagonal = self.size - 1, (self.size + 1) * np.arange(self.size)
        border = self.size * np.arange(last) + last, self.size * last + np.arange(last)
        at = [B.row[other] * self.size + B.row[one], diagonal, *border]
        self._places = np.unique(np.concatenate(at))
        place, self._diagonal, self._below, self._right = (np.searchsorted(self._places, of) for of in at)
        entry = (3 * kind[one] + kind[other]) * m + slider[one]
        shape, value = (len(self._places), 9 * m), B.data[one] * B.data[other]
        self._of_stiffness = sp.csr_array((value, (place, entry)), shape=shape)
        springs = np.broadcast_to(np.eye(3)[:, :, None], (3, 3, m))
        self._of_springs = self._of_stiffness @ springs.ravel()
        self._of_springs[self._diagonal[:-1]] += _OF_BLOCKS
        self._rows = (self._places % self.size).astype(np.int32)
        starts = np.arange(self.size + 1) * self.size
        self._starts = np.searchsorted(self._places, starts).astype(np.int32)
        band = Band(self._matrix(np.ones(len(self._places))))
        self._band = band if band.width <= max(_NARROW * self.size, _FEW) else None

    def _matrix(self, values: np.ndarray) -> sp.csc_matrix:
        return sp.csc_matrix((values, self._rows, self._starts), shape=(self.size, self.size))

    def factors(
        self, stiffness: np.ndarray, load: np.ndarray, row: np.ndarray | None
    ) -> "SparseFactors | BandFactors":
        """Factors of the matrix under sliders' stiffnesses, shape (3, 3, m); without a row, of the other."""
        values = self._of_stiffness @ stiffness.ravel()
        values += _REGULARISATION * np.abs(stiffness).max() * self._of_springs
        if row is None:
            load = row = np.zeros(self.size - 1)
            values[self._diagonal[-1]] = 1.0
        values[self._below], values[self._right] = row, -load
        matrix = self._matrix(values)
        if self._band is not None:
            return BandFactors(self._band, matrix, load, row)
        return SparseFactors(matrix)


class SparseFactors:
    """Factors by minimum degree: solutions of right-hand sides, and the sign of the determinant."""

    def __init__(self, matrix: sp.csc_matrix) -> None:
        # These matrices have few entries a row. SuperLU's default relax and panel_size group columns for
        # dense BLAS operations, and the factors take longer.
        self._lu = splu(
            matrix,
            permc_spec="MMD_AT_PLUS_A",
            diag_pivot_thresh=0.01,
            relax=1,
            panel_size=1,
            options={"SymmetricMode": True},
        )

    def solve(self, right: np.ndarray) -> np.ndarray:
        found: np.ndarray = self._lu.solve(right)
        return found

    @cached_property
    def sign(self) -> int:
        odd = np.count_nonzero(self._lu.U.diagonal() < 0)
        odd += _swapped(self._lu.perm_r) + _swapped(self._lu.perm_c)
        return 1 if odd % 2 == 0 else -1


class Band:
    """Order of the unknowns in which a matrix without its border, the last row and column, has a narrow band.

    Attributes
    ----------
    order: the unknowns in this order, shape (n + 1,); the border stays the last.
    width: diagonals of the band on either side of the main diagonal.
    inside: the entries of the matrix that do not belong to the border, as a mask over all entries.
    at: the place of each entry inside in the array that LAPACK's ``dgbtrf`` factors, stored by columns.
    """

    def __init__(self, pattern: sp.csc_matrix) -> None:
        n = pattern.shape[0] - 1
        order = reverse_cuthill_mckee(pattern[:-1, :-1].tocsr(), symmetric_mode=True)
        self.order = np.append(order, n)
        place = np.argsort(self.order)
        row, column = place[pattern.indices], place[np.repeat(np.arange(n + 1), np.diff(pattern.indptr))]
        self.inside = (row < n) & (column < n)
        row, column = row[self.inside], column[self.inside]
        self.width = int(np.abs(row - column).max())
        # LAPACK keeps the first ``width`` rows of its array free for entries that pivoting adds.
        self.at = column * (3 * self.width + 1) + 2 * self.width + row - column


class BandFactors:
    """LU factors of a bordered band matrix: the band by LAPACK, the border by block elimination.

    Block elimination loses digits near a fold, where the band alone is almost singular. One step of iterative
    refinement restores these digits (Govaerts and Pryce, 1993).
    """

    def __init__(self, band: Band, matrix: sp.csc_matrix, load: np.ndarray, row: np.ndarray) -> None:
        n, width = len(load), band.width
        self._band, self._matrix = band, matrix
        room = np.zeros((n, 3 * width + 1)).T
        room.T.ravel()[band.at] = matrix.data[band.inside]
        self._lu, self._pivots, _ = lapack.dgbtrf(room, width, width, overwrite_ab=True)
        self._diagonal = self._lu[2 * width]
        # At a fold, to the last digit.
        self._diagonal[self._diagonal == 0] = _REGULARISATION * np.abs(self._diagonal).max()
        self._load, self._row = load[band.order[:-1]], row[band.order[:-1]]
        self._along = self._solved(self._load)
        self._corner = matrix.data[-1] + self._row @ self._along
        if self._corner == 0:
            # The border is singular. As in the band its pivot is tiny, and the step too long to be taken.
            self._corner = _REGULARISATION * (np.abs(self._row) @ np.abs(self._along)) or 1.0

    def solve(self, right: np.ndarray) -> np.ndarray:
        """Return the solution for a right-hand side, shape (n + 1,), after one step of refinement."""
        solution = self._placed(right)
        # A sparse product takes one thread. BLAS splits a band product among threads, which costs more
        # processor time than the product itself.
        solution += self._placed(right - self._matrix @ solution)
        return solution

    def _placed(self, right: np.ndarray) -> np.ndarray:
        """Return the solution by block elimination in the order of the matrix."""
        placed = np.empty_like(right)
        placed[self._band.order] = self._by_border(right[self._band.order])
        return placed

    def _by_border(self, right: np.ndarray) -> np.ndarray:
        found = self._solved(right[:-1])
        last = (right[-1] - self._row @ found) / self._corner
        return np.append(found + last * self._along, last)

    def _solved(self, right: np.ndarray) -> np.ndarray:
        width = self._band.width
        found: np.ndarray = lapack.dgbtrs(self._lu, width, width, right, self._pivots)[0]
        return found

    @property
    def sign(self) -> int:
        swapped = np.count_nonzero(self._pivots != np.arange(len(self._pivots)))
        odd = np.count_nonzero(self._diagonal < 0) + swapped + (self._corner < 0)
        return 1 if odd % 2 == 0 else -1


def _swapped(order: np.ndarray) -> int:
    """How many entries are to be swapped to come to an order: of each of its cycles all but one."""
    n = len(order)
    to = sp.coo_array((np.ones(n), (np.arange(n), order)), shape=(n, n))
    return n - int(connected_components(to, return_labels=False))

"""The stiffness matrix of the blocks, S = B J k Bᵀ, and its factors.

J is the tangent of the contact law and k the elastic stiffness. The entries of S are a fixed linear
function of the entries of J k, so that each assembly is one sparse product. The order of the unknowns is
computed only once.
"""

from typing import Protocol

import numpy as np
import scipy.sparse as sp
from scipy.linalg import lapack
from scipy.sparse.csgraph import reverse_cuthill_mckee
from scipy.sparse.linalg import splu

from masonry_opt.methods.incremental.contact_law import ContactLaw, by_joint
from masonry_opt.methods.incremental.settings import IncrementalSettings
from masonry_opt.problem.problem import Problem


class Factors(Protocol):
    """Factors of a stiffness matrix, with which systems of equations with this matrix are solved."""

    def solve(self, right: np.ndarray) -> np.ndarray:
        """Solve the system for right-hand sides of shape (3b,) or (3b, count)."""


class StiffnessMatrix:
    """Stiffness matrix S = B J k Bᵀ + η B k Bᵀ, with contact stiffness k, contact tangent J and damping η."""

    def __init__(
        self, problem: Problem, law: ContactLaw, settings: IncrementalSettings | None = None
    ) -> None:
        settings = settings or IncrementalSettings()
        self._source, self._stiffness = problem.B, law.stiffness
        B, m = problem.B.tocoo(), law.count
        column = np.flatnonzero(by_joint(np.ones(B.shape[1]), law.joints))[B.col]
        #: Equilibrium matrix and its transpose. The matrix has shape (3b, 3m), with columns in the order of
        #: the contact law.
        self.B = sp.csr_array((B.data, (B.row, column)), shape=(B.shape[0], 3 * m))
        self.Bt = self.B.T.tocsr()
        self.size = B.shape[0]
        # In S = B J k Bᵀ, two entries of B that belong to one joint contribute their product to one entry of
        # S. Find all pairs of such entries.
        kind, joint = np.divmod(column, m)
        of_joints = sp.csr_array((np.ones(B.nnz), (np.arange(B.nnz), joint)), shape=(B.nnz, m))
        first, second = (of_joints @ of_joints.T).nonzero()
        diagonal = (self.size + 1) * np.arange(self.size)
        places = B.row[second] * self.size + B.row[first]
        self._places = np.unique(np.append(places, diagonal))
        entry = np.searchsorted(self._places, places)
        tangent_entry = (3 * kind[first] + kind[second]) * m + joint[first]
        shape = (len(self._places), 9 * m)
        stiffness = law.stiffness[kind[second], joint[second]]
        values = B.data[first] * B.data[second] * stiffness
        self._assembly = sp.csr_array((values, (entry, tangent_entry)), shape=shape)
        self._elastic = self._assembly @ np.broadcast_to(np.eye(3)[:, :, None], (3, 3, m)).ravel()
        largest = float(np.abs(self._elastic).max(initial=0.0)) or 1.0
        self._regularisation = settings.regularisation * self._elastic
        self._regularisation[np.searchsorted(self._places, diagonal)] += settings.regularisation * largest
        rows, columns = self._places % self.size, self._places // self.size
        band = Band(rows, columns, self.size)
        is_narrow = band.width <= settings.narrow_band
        self._order: Band | SparseOrder = band if is_narrow else SparseOrder(rows, columns, self.size)

    def suits(self, problem: Problem, law: ContactLaw) -> bool:
        """Return True if a problem has the joints and elastic stiffness for which this matrix was built."""
        return self._source is problem.B and np.array_equal(self._stiffness, law.stiffness)

    def factorise(self, tangent: np.ndarray, damping: float) -> Factors:
        """Factorise the matrix for a given tangent of the contact law, shape (3, 3, m), and damping η."""
        stiffness = self._assembly @ tangent.ravel()
        stiffness += damping * self._elastic
        stiffness += self._regularisation
        return self._order.factorise(stiffness)


class Band:
    """Banded factorisation by LAPACK, with the unknowns in reverse Cuthill-McKee order."""

    def __init__(self, rows: np.ndarray, columns: np.ndarray, size: int) -> None:
        pattern = sp.csr_array((np.ones(len(rows)), (rows, columns)), shape=(size, size))
        self._permutation = reverse_cuthill_mckee(pattern, symmetric_mode=True)
        place = np.argsort(self._permutation)
        row, column = place[rows], place[columns]
        self.width = int(np.abs(row - column).max(initial=0))
        self._size = size
        # Position of each entry in LAPACK's band storage: column by column, with additional rows for
        # pivoting.
        self._at = column * (3 * self.width + 1) + 2 * self.width + row - column

    def factorise(self, values: np.ndarray) -> "BandFactors":
        """Factorise the matrix with the given nonzero entries, and return its factors."""
        storage = np.zeros((self._size, 3 * self.width + 1))
        storage.ravel()[self._at] = values
        factors, pivots, _ = lapack.dgbtrf(storage.T, self.width, self.width, overwrite_ab=True)
        return BandFactors(factors, pivots, self.width, self._permutation)


class BandFactors:
    """Factors of a banded matrix."""

    def __init__(self, factors: np.ndarray, pivots: np.ndarray, width: int, permutation: np.ndarray) -> None:
        self._factors, self._pivots, self._width = factors, pivots, width
        self._permutation = permutation

    def solve(self, right: np.ndarray) -> np.ndarray:
        """Solve the system for right-hand sides of shape (3b,) or (3b, count)."""
        width, order = self._width, self._permutation
        permuted = lapack.dgbtrs(self._factors, width, width, right[order], self._pivots)[0]
        solution = np.empty_like(permuted)
        solution[order] = permuted
        return solution


class SparseOrder:
    """Sparse factorisation by SuperLU, with the unknowns in minimum-degree order, which limits fill-in."""

    def __init__(self, rows: np.ndarray, columns: np.ndarray, size: int) -> None:
        pattern = sp.csc_matrix((np.ones(len(rows)), (rows, columns)), shape=(size, size))
        dominant = (pattern + size * sp.eye(size)).tocsc()
        self._permutation = self._factors(dominant, "MMD_AT_PLUS_A").perm_c.argsort()
        place = np.argsort(self._permutation)
        numbered = sp.csc_matrix((np.arange(1.0, len(rows) + 1), (place[rows], place[columns])), (size, size))
        numbered.sort_indices()
        self._entry = numbered.data.astype(np.intp) - 1
        self._indices, self._starts, self._shape = numbered.indices, numbered.indptr, (size, size)

    def factorise(self, values: np.ndarray) -> "SparseFactors":
        """Factorise the matrix with the given nonzero entries, and return its factors."""
        matrix = sp.csc_matrix((values[self._entry], self._indices, self._starts), shape=self._shape)
        return SparseFactors(self._factors(matrix, "NATURAL"), self._permutation)

    @staticmethod
    def _factors(matrix: sp.csc_matrix, order: str) -> "sp.linalg.SuperLU":
        options = {"SymmetricMode": True}
        # With supernodes and panels of one column, SuperLU is 1.2 to 2.6 times as fast on stiffness matrices
        # as with its defaults.
        return splu(matrix, order, diag_pivot_thresh=0.01, relax=1, panel_size=1, options=options)


class SparseFactors:
    """Factors of a sparse matrix."""

    def __init__(self, factors: "sp.linalg.SuperLU", permutation: np.ndarray) -> None:
        self._factors, self._permutation = factors, permutation

    def solve(self, right: np.ndarray) -> np.ndarray:
        """Solve the system for right-hand sides of shape (3b,) or (3b, count)."""
        solution = np.empty_like(right)
        solution[self._permutation] = self._factors.solve(right[self._permutation])
        return solution

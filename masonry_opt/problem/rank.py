"""Test whether the columns of an equilibrium matrix are independent, and solve for the forces if they are.

Equilibrium alone determines all forces if the columns are independent.
"""

from collections.abc import Iterator

import numpy as np
import scipy.linalg as la
import scipy.sparse as sp
from scipy.sparse.csgraph import connected_components, structural_rank

#: The columns of a scaled matrix count as independent if the smallest singular value of the matrix exceeds
#: this fraction of the largest. The ratio of the two is 6e-6 for a stack of 500 cubes. It is 1e-16 for the
#: prism on a knife edge of ``tests/unit/problem/test_rank.py``, whose columns are dependent. If the value is
#: larger, fewer scenes count as statically determinate.
_LEAST_SINGULAR_VALUE = 1e-9

#: Largest number of columns of a connected component for which singular values are computed. The computation
#: takes up to a second. The columns of larger components count as dependent.
_MOST_COLUMNS_OF_COMPONENT = 1500

#: Number of rounds of Ruiz scaling. Each round brings the lengths of rows and columns closer to one. With
#: fewer rounds, their lengths remain very different.
_SCALING_ROUNDS = 5


def has_independent_columns(matrix: sp.csr_array) -> bool:
    """Return True if the columns of a matrix are provably linearly independent.

    Most matrices with dependent columns already have a deficient structural rank, an upper bound on the rank
    for any values of the nonzero entries. A full structural rank is not sufficient: two contact points on one
    edge transmit two shears along one line, which the positions of the nonzero entries do not reveal. The
    function then computes the singular values of each connected component, after scaling rows and columns.
    """
    if structural_rank(matrix) < matrix.shape[1]:
        return False
    parts = (matrix[rows][:, columns] for rows, columns in _components(matrix))
    return all(_component_is_independent(component) for component in parts)


def solve_independent(matrix: sp.csr_array, right: np.ndarray) -> np.ndarray:
    """Solve linear systems whose matrix has independent columns, by least squares.

    ``right`` has one right side in each column, and the result has one solution in each column.
    """
    solution = np.zeros((matrix.shape[1], right.shape[1]))
    for rows, columns in _components(matrix):
        component = matrix[rows][:, columns].toarray()
        orthogonal, triangular = la.qr(component, mode="economic")
        solution[columns] = la.solve_triangular(triangular, orthogonal.T @ right[rows])
    return solution


def _components(matrix: sp.csr_array) -> Iterator[tuple[np.ndarray, np.ndarray]]:
    """Iterate over the connected components of a sparse matrix, as row indices and column indices.

    Components share no row and no column. A component without columns is left out.
    """
    rows = matrix.shape[0]
    graph = sp.block_array([[None, matrix], [matrix.T, None]], format="csr")
    count, label = connected_components(graph, directed=False)
    for component in range(count):
        members = np.flatnonzero(label == component)
        columns = members[members >= rows] - rows
        if len(columns):
            yield members[members < rows], columns


def _component_is_independent(component: sp.csr_array) -> bool:
    if component.shape[1] > _MOST_COLUMNS_OF_COMPONENT:
        return False
    singular = la.svdvals(_scaled(component.toarray()))
    return bool(singular[-1] > _LEAST_SINGULAR_VALUE * singular[0])


def _scaled(matrix: np.ndarray) -> np.ndarray:
    """Return a matrix with rows and columns of about unit length, by Ruiz scaling."""
    for _ in range(_SCALING_ROUNDS):
        for axis in (0, 1):
            length = np.sqrt(np.linalg.norm(matrix, axis=axis, keepdims=True))
            matrix = matrix / np.where(length > 0, length, 1.0)
    return matrix

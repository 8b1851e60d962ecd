"""Arrays into Pyomo's expressions, parameters and variables, and out of them."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np
import pyomo.environ as pyo
import scipy.sparse as sp
from pyomo.core.expr import LinearExpression


def rows(matrix: sp.csr_array, variables: Sequence[Any], together: int = 0) -> Iterator[Any]:
    """Each row of ``matrix @ variables`` as a linear expression.

    Parameters
    ----------
    together: number of joints, to write the terms n, s, m of a joint next to each other. The order of the
        terms is that of HiGHS's columns, and decides which of many optimal vertices its simplex ends in.
    """
    for row in range(matrix.shape[0]):
        span = slice(matrix.indptr[row], matrix.indptr[row + 1])
        columns, entries = matrix.indices[span], matrix.data[span]
        if together:
            order = np.lexsort((columns, columns % together))
            columns, entries = columns[order], entries[order]
        yield LinearExpression(
            linear_coefs=entries.tolist(), linear_vars=[variables[column] for column in columns]
        )


def dot(coefficients: np.ndarray, variables: Sequence[Any]) -> Any:
    """``coefficients · variables`` as a linear expression, zeros left out."""
    return next(rows(sp.csr_array(coefficients[None, :]), variables))


def values(variable: pyo.Var) -> np.ndarray:
    """The loaded values of an indexed variable, in order."""
    return np.array([data.value for data in variable.values()])


def duals(constraint: pyo.Constraint) -> np.ndarray:
    """The loaded duals of an indexed constraint, in order."""
    dual = constraint.model().dual
    return np.array([dual[data] for data in constraint.values()])


def put(variable: pyo.Var, numbers: np.ndarray) -> None:
    """Give an indexed variable these values, in order."""
    for data, number in zip(variable.values(), numbers.tolist(), strict=True):
        data.set_value(number, skip_validation=True)


def store(parameter: pyo.Param, numbers: np.ndarray) -> None:
    """Give an indexed mutable parameter these values, in order."""
    parameter.store_values(dict(enumerate(numbers.tolist())))

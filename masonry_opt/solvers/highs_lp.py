"""A declared Pyomo program as arrays, for HiGHS and for bounds computed from the arrays alone."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import highspy
import numpy as np
import pyomo.environ as pyo
import scipy.sparse as sp
from pyomo.repn.plugins.standard_form import LinearStandardFormCompiler

from masonry_opt.solvers.lp import LpSize

#: Rounding of one addition or product in double precision.
_UNIT_ROUNDOFF = 2.0**-53


@dataclass(frozen=True)
class LinearProgram:
    """min cost·x with lower ≤ A x ≤ upper of the rows and low ≤ x ≤ high of the columns.

    Attributes
    ----------
    cost, low, high: shape (columns,).
    matrix: A, shape (rows, columns).
    row_lower, row_upper: shape (rows,).
    column: number of each variable's column, by the identity of the variable.
    row: number of each constraint's row (of the last of two), by the identity of the constraint.
    """

    cost: np.ndarray
    matrix: sp.csc_array
    row_lower: np.ndarray
    row_upper: np.ndarray
    low: np.ndarray
    high: np.ndarray
    column: dict[int, int]
    row: dict[int, int]

    @classmethod
    def of(cls, program: pyo.ConcreteModel) -> LinearProgram:
        """The program as Pyomo compiles it. A bound that is infinite at first makes no row of its own."""
        form: Any = LinearStandardFormCompiler().write(program, mixed_form=True, set_sense=None)
        bounded = np.flatnonzero(np.isfinite(form.rhs))
        kind = np.array([form.rows[old].bound_type for old in bounded])
        rhs = np.asarray(form.rhs, dtype=float)[bounded]
        bounds = [variable.bounds for variable in form.columns]
        return cls(
            cost=np.asarray(form.c.toarray(), dtype=float)[0],
            matrix=sp.csc_array(sp.csr_array(form.A)[bounded]),
            row_lower=np.where(kind == 1, -np.inf, rhs),
            row_upper=np.where(kind == -1, np.inf, rhs),
            low=np.array([-np.inf if low is None else low for low, _ in bounds], dtype=float),
            high=np.array([np.inf if high is None else high for _, high in bounds], dtype=float),
            column={id(variable): index for index, variable in enumerate(form.columns)},
            row={id(form.rows[old].constraint): new for new, old in enumerate(bounded)},
        )

    def changed(
        self, rows: Sequence[Any], variables: Sequence[Any], entries: np.ndarray, upper: np.ndarray
    ) -> LinearProgram:
        """The same program with another entry, and another upper bound, in each of these rows.

        Parameters
        ----------
        rows, variables: constraints, and the variable of each whose entry changes.
        entries, upper: of each row. An entry that is zero now cannot be changed.
        """
        row = np.array([self.row[id(data)] for data in rows], dtype=np.int64)
        column = np.array([self.column[id(data)] for data in variables], dtype=np.int64)
        height, width = self.matrix.shape
        places = np.repeat(np.arange(width), np.diff(self.matrix.indptr)) * height + self.matrix.indices
        order = np.argsort(places)
        at = order[np.searchsorted(places, column * height + row, sorter=order)]
        data, row_upper = self.matrix.data.copy(), self.row_upper.copy()
        data[at], row_upper[row] = entries, upper
        matrix = sp.csc_array((data, self.matrix.indices, self.matrix.indptr), shape=self.matrix.shape)
        return replace(self, matrix=matrix, row_upper=row_upper)

    @property
    def size(self) -> LpSize:
        """Rows, columns and non-zeros."""
        rows, columns = self.matrix.shape
        return LpSize(rows, columns, self.matrix.nnz)

    def highs(self, cost: np.ndarray | None = None) -> highspy.HighsLp:
        """The same for HiGHS, with other costs if any are given."""
        lp = highspy.HighsLp()
        lp.num_row_, lp.num_col_ = self.matrix.shape
        lp.col_cost_ = self.cost if cost is None else cost
        lp.col_lower_, lp.col_upper_ = self.low, self.high
        lp.row_lower_, lp.row_upper_ = self.row_lower, self.row_upper
        lp.a_matrix_.format_ = highspy.MatrixFormat.kColwise
        lp.a_matrix_.start_, lp.a_matrix_.index_ = self.matrix.indptr, self.matrix.indices
        lp.a_matrix_.value_ = self.matrix.data
        return lp

    def least(self, multipliers: np.ndarray) -> tuple[float, np.ndarray]:
        """What any multipliers of the rows, shape (rows,), prove of the least cost, whoever found them:
        ``cost·x ≥ value − short·|x|`` for every x that meets rows and bounds.

        ``short``, shape (columns,), is what reduced costs lack where a column has no bound to pay it with,
        and a bound of the rounding of the reduced costs themselves.
        """
        y = np.where(np.isfinite(self.row_lower), np.maximum(multipliers, 0.0), 0.0)
        y += np.where(np.isfinite(self.row_upper), np.minimum(multipliers, 0.0), 0.0)
        at_rows = np.where(y > 0, self.row_lower, self.row_upper)
        terms = np.where(y == 0.0, 0.0, y * np.where(y == 0.0, 0.0, at_rows))
        reduced = self.cost - self.matrix.T @ y
        longest = int(np.diff(self.matrix.indptr).max(initial=0)) + 3
        rounding = longest * _UNIT_ROUNDOFF * (np.abs(self.cost) + abs(self.matrix).T @ np.abs(y))
        at_columns = np.where(reduced > 0, self.low, self.high)
        paid = np.isfinite(at_columns)
        of_columns = np.where(paid, reduced, 0.0) * np.where(paid, at_columns, 0.0)
        value = float(terms.sum() + of_columns.sum())
        value -= (
            (len(terms) + len(of_columns))
            * _UNIT_ROUNDOFF
            * float(np.abs(terms).sum() + np.abs(of_columns).sum())
        )
        return value, np.where(paid, 0.0, np.abs(reduced)) + rounding

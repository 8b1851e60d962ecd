"""A declared linear program as arrays, and the bounds that multipliers prove of it."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import cvxpy as cp
import numpy as np
import scipy.sparse as sp

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
    columns, rows: of each variable, and of each constraint in CVXPY, in order, by its identity.
    """

    cost: np.ndarray
    matrix: sp.csc_array
    row_lower: np.ndarray
    row_upper: np.ndarray
    low: np.ndarray
    high: np.ndarray
    columns: dict[int, np.ndarray]
    rows: dict[int, np.ndarray]

    @classmethod
    def of(cls, program: Any) -> LinearProgram:
        """The program as its modelling language compiles it, CVXPY or Pyomo."""
        if type(program).__module__.startswith("cvxpy"):
            return cls._of_cvxpy(program)
        return cls._of_pyomo(program)

    @classmethod
    def _of_cvxpy(cls, program: Any) -> LinearProgram:
        data = program.get_problem_data("HIGHS", ignore_dpp=True)[0]
        rhs, equations = np.asarray(data["b"], dtype=float), data["dims"].zero
        width, offset = len(data["c"]), data["param_prob"].var_id_to_col
        low, high = (
            np.full(width, default) if data[name] is None else np.asarray(data[name], dtype=float)
            for name, default in (("lower_bounds", -np.inf), ("upper_bounds", np.inf))
        )
        # Equations come first, in the order of their declaration.
        declared = sorted(program.constraints, key=lambda row: not isinstance(row, cp.constraints.Zero))
        ends = np.cumsum([0, *(row.size for row in declared)])
        assert ends[-1] == len(rhs)
        return cls(
            cost=np.asarray(data["c"], dtype=float),
            matrix=sp.csc_array(data["A"]),
            row_lower=np.where(np.arange(len(rhs)) < equations, rhs, -np.inf),
            row_upper=rhs,
            low=low,
            high=high,
            columns={
                id(variable): offset[variable.id] + np.arange(variable.size, dtype=np.int32)
                for variable in program.variables()
            },
            rows={
                id(row): np.arange(start, end, dtype=np.int32)
                for row, start, end in zip(declared, ends, ends[1:], strict=False)
            },
        )

    @classmethod
    def _of_pyomo(cls, program: Any) -> LinearProgram:
        from pyomo.environ import Var
        from pyomo.repn.plugins.standard_form import LinearStandardFormCompiler

        # A row without a finite bound is left out.
        form: Any = LinearStandardFormCompiler().write(program, mixed_form=True, set_sense=None)
        bounded = np.flatnonzero(np.isfinite(form.rhs))
        kind = np.array([form.rows[old].bound_type for old in bounded])
        rhs = np.asarray(form.rhs, dtype=float)[bounded]
        bounds = [variable.bounds for variable in form.columns]
        column = {id(variable): index for index, variable in enumerate(form.columns)}
        return cls(
            cost=np.asarray(form.c.toarray(), dtype=float)[0],
            matrix=sp.csc_array(sp.csr_array(form.A)[bounded]),
            row_lower=np.where(kind == 1, -np.inf, rhs),
            row_upper=np.where(kind == -1, np.inf, rhs),
            low=np.array([-np.inf if low is None else low for low, _ in bounds], dtype=float),
            high=np.array([np.inf if high is None else high for _, high in bounds], dtype=float),
            columns={
                id(variable): np.array([column[id(data)] for data in variable.values()], dtype=np.int32)
                for variable in program.component_objects(Var)
            },
            rows={},
        )

    def changed(
        self, row: np.ndarray, column: np.ndarray, entries: np.ndarray, upper: np.ndarray
    ) -> LinearProgram:
        """The same program with new ``entries`` at these rows and columns, and new upper bounds of the rows.
        An entry that is zero now cannot change."""
        height, width = self.matrix.shape
        places = np.repeat(np.arange(width), np.diff(self.matrix.indptr)) * height + self.matrix.indices
        order = np.argsort(places)
        at = order[np.searchsorted(places, column.astype(np.int64) * height + row, sorter=order)]
        data, row_upper = self.matrix.data.copy(), self.row_upper.copy()
        data[at], row_upper[row] = entries, upper
        matrix = sp.csc_array((data, self.matrix.indices, self.matrix.indptr), shape=self.matrix.shape)
        return replace(self, matrix=matrix, row_upper=row_upper)

    @property
    def size(self) -> LpSize:
        """Rows, columns and non-zeros."""
        rows, columns = self.matrix.shape
        return LpSize(rows, columns, self.matrix.nnz)

    def least(self, multipliers: np.ndarray) -> tuple[float, np.ndarray]:
        """Lower bound of the cost from any multipliers of the rows, shape (rows,): value and short, shape
        (columns,), with ``cost·x ≥ value − short·|x|`` for every x within rows and bounds. ``short`` is the
        reduced cost of columns without the bound that it needs, and a bound of all rounding."""
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
        terms = np.concatenate([terms, of_columns])
        value = float(terms.sum() - len(terms) * _UNIT_ROUNDOFF * np.abs(terms).sum())
        return value, np.where(paid, 0.0, np.abs(reduced)) + rounding

"""A declared Pyomo model in a HiGHS that stays loaded while only bounds and costs change."""

from __future__ import annotations

import highspy
import numpy as np
import pyomo.environ as pyo
import scipy.sparse as sp
from pyomo.repn.plugins.standard_form import LinearStandardFormCompiler

#: HiGHS's feasibility tolerances.
_FEASIBILITY = 1e-10


class HighsSession:
    """Simplex with warm starts: after a change of bounds or costs the last basis is where it begins.

    Attributes
    ----------
    solves: linear programs solved.
    iterations: simplex iterations, summed.
    seconds: HiGHS's own time, summed.
    """

    def __init__(self, program: pyo.ConcreteModel) -> None:
        form = LinearStandardFormCompiler().write(program, mixed_form=True, set_sense=None)
        self._column = {id(variable): index for index, variable in enumerate(form.columns)}
        self._row = {id(row.constraint): index for index, row in enumerate(form.rows)}
        kind = np.array([row.bound_type for row in form.rows])
        matrix = sp.csc_array(form.A)
        lp = highspy.HighsLp()
        lp.num_row_, lp.num_col_ = matrix.shape
        lp.col_cost_ = np.zeros(len(form.columns))
        bounds = [variable.bounds for variable in form.columns]
        lp.col_lower_ = np.array([-np.inf if low is None else low for low, _ in bounds], dtype=float)
        lp.col_upper_ = np.array([np.inf if high is None else high for _, high in bounds], dtype=float)
        lp.row_lower_ = np.where(kind == 1, -np.inf, form.rhs)
        lp.row_upper_ = np.where(kind == -1, np.inf, form.rhs)
        lp.a_matrix_.format_ = highspy.MatrixFormat.kColwise
        lp.a_matrix_.start_, lp.a_matrix_.index_ = matrix.indptr, matrix.indices
        lp.a_matrix_.value_ = matrix.data
        self.matrix, self.rhs = sp.csr_array(form.A), np.asarray(form.rhs, dtype=float)
        self._highs = highspy.Highs()
        self._highs.silent()
        for name in ("primal_feasibility_tolerance", "dual_feasibility_tolerance"):
            self._highs.setOptionValue(name, _FEASIBILITY)
        self._highs.setOptionValue("solver", "simplex")
        self._highs.passModel(lp)
        self.solves, self.iterations, self.seconds = 0, 0, 0.0

    def columns(self, *variables: pyo.Var) -> np.ndarray:
        """Columns of indexed variables, in order."""
        return np.array([self._column[id(d)] for v in variables for d in v.values()], dtype=np.int32)

    def rows(self, *constraints: pyo.Constraint) -> np.ndarray:
        """Rows of indexed constraints, in order."""
        return np.array([self._row[id(d)] for c in constraints for d in c.values()], dtype=np.int32)

    def set_costs(self, columns: np.ndarray, costs: np.ndarray) -> None:
        """Minimise these costs of these columns."""
        self._highs.changeColsCost(len(columns), columns, np.asarray(costs, dtype=float))

    def set_column_bounds(self, columns: np.ndarray, lower: np.ndarray, upper: np.ndarray) -> None:
        """Bound these columns."""
        self._highs.changeColsBounds(len(columns), columns, lower, upper)

    def set_row_bounds(self, rows: np.ndarray, lower: np.ndarray, upper: np.ndarray) -> None:
        """Bound these rows."""
        self._highs.changeRowsBounds(len(rows), rows, lower, upper)

    def add_row(self, columns: np.ndarray, coefficients: np.ndarray, upper: float) -> None:
        """Demand coefficients · columns ≤ upper as a last row."""
        self._highs.addRow(-np.inf, upper, len(columns), columns, np.asarray(coefficients, dtype=float))

    def drop_last_row(self) -> None:
        """Take the last row away."""
        last = self._highs.getNumRow() - 1
        self._highs.deleteRows(1, np.array([last], dtype=np.int32))

    def solve(self) -> bool:
        """Whether there is an optimum."""
        self._run()
        if not (self._optimal or self.infeasible):
            # A warm start may leave HiGHS undecided: once more, from the beginning.
            self._highs.clearSolver()
            self._run()
        self.solves += 1
        return self._optimal

    def _run(self) -> None:
        start = self._highs.getRunTime()
        self._highs.run()
        self.seconds += self._highs.getRunTime() - start
        self.iterations += max(self._highs.getInfo().simplex_iteration_count, 0)

    @property
    def _optimal(self) -> bool:
        return bool(self._highs.getModelStatus() == highspy.HighsModelStatus.kOptimal)

    @property
    def empty(self) -> bool:
        """Whether the last program was found to have no feasible point, for certain."""
        return bool(self._highs.getModelStatus() == highspy.HighsModelStatus.kInfeasible)

    @property
    def infeasible(self) -> bool:
        """Whether the last program was found to have no feasible point, or no bound."""
        status = highspy.HighsModelStatus
        return self._highs.getModelStatus() in (
            status.kInfeasible,
            status.kUnboundedOrInfeasible,
            status.kUnbounded,
        )

    @property
    def values(self) -> np.ndarray:
        """Values of the columns at the last optimum."""
        return np.array(self._highs.getSolution().col_value)

    @property
    def row_duals(self) -> np.ndarray:
        """Duals of the rows at the last optimum: change of the optimum per unit of right-hand side."""
        return np.array(self._highs.getSolution().row_dual)

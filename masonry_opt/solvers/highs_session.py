"""The driver of HiGHS: a linear program that stays loaded while its costs and bounds change."""

from __future__ import annotations

import time
from dataclasses import replace
from math import inf
from typing import Any

import highspy
import numpy as np

from masonry_opt.effort import Effort
from masonry_opt.solvers.highs_lp import LinearProgram
from masonry_opt.solvers.lp import Verdict
from masonry_opt.solvers.registry import Solver, find_solver

_STATUS = highspy.HighsModelStatus
_VERDICTS = {
    _STATUS.kOptimal: Verdict.OPTIMAL,
    _STATUS.kInfeasible: Verdict.INFEASIBLE,
    _STATUS.kUnbounded: Verdict.UNBOUNDED,
    _STATUS.kUnboundedOrInfeasible: Verdict.INFEASIBLE_OR_UNBOUNDED,
}


class HighsSession:
    """A linear program in HiGHS, as declared or compiled before. After a change of costs or bounds simplex
    starts from the last basis.

    Parameters
    ----------
    purpose: what it is solved for, under which the effort records the solver.
    solver: one of HiGHS's; simplex by default.
    options: of HiGHS, beside the solver's own.
    """

    def __init__(
        self, program: Any, effort: Effort, purpose: str, solver: Solver | None = None, **options: Any
    ) -> None:
        self.effort = effort
        solver = solver or find_solver("cvxpy", "highs", tolerance=1e-10)
        effort.uses(solver.name, purpose)
        self.lp = lp = program if isinstance(program, LinearProgram) else LinearProgram.of(program)
        self.size = lp.size
        self._highs = highspy.Highs()
        self._highs.silent()
        # Simplex may go round in circles for ever: runs that end take fewer iterations than rows and columns.
        most = {"simplex_iteration_limit": 10 * sum(lp.matrix.shape)}
        for name, value in {**most, **solver.options, **options}.items():
            self._highs.setOptionValue(name, value)
        self._highs.passModel(_loaded(lp))

    def set_costs(self, variable: Any, costs: np.ndarray) -> None:
        """Costs of a variable, in order."""
        columns = self.columns(variable)
        self._highs.changeColsCost(len(columns), columns, np.asarray(costs, dtype=float))

    def set_most(self, variable: Any, most: np.ndarray) -> None:
        """Upper bounds of a variable, in order."""
        columns = self.columns(variable)
        self._highs.changeColsBounds(len(columns), columns, self.lp.low[columns], most)

    def set_room(self, constraint: Any, room: np.ndarray) -> None:
        """Lower bounds of rows, in order: so far below their upper bounds."""
        rows = self.lp.rows[id(constraint)]
        upper = self.lp.row_upper[rows]
        self._highs.changeRowsBounds(len(rows), rows, upper - room, upper)

    def set_column(self, variable: Any, constraint: Any, entries: np.ndarray) -> None:
        """Entries of a variable of one column in the rows of a constraint, in order. Bounds by multipliers
        (``least``, ``contradiction``) are those of the program as it was declared."""
        column, rows = int(self.columns(variable)[0]), self.lp.rows[id(constraint)]
        _, held, values = self._highs.getColEntries(column)
        now = np.zeros(self.lp.matrix.shape[0])
        now[held] = values
        for index in np.flatnonzero(now[rows] != entries):
            self._highs.changeCoeff(int(rows[index]), column, float(entries[index]))

    def columns(self, variable: Any) -> np.ndarray:
        """Columns of a variable, in order."""
        return self.lp.columns[id(variable)]

    def solve(self, seconds: float = inf) -> Verdict:
        """Solve with the present parameters, within so many seconds."""
        ends = time.perf_counter() + seconds
        verdict = self.run(seconds)
        if verdict is Verdict.FAILED:
            # A warm start may leave HiGHS undecided: once more, from the beginning.
            self._highs.clearSolver()
            left = ends - time.perf_counter()
            verdict = self.run(left) if left > 0 else verdict
        self.effort.lp_solves += 1
        return verdict

    def stop_if_iterations_restart(self) -> None:
        """Interrupt runs whose count of iterations falls. HiGHS restarts a HiPO run that stalls by the older
        interior point, and drops the multipliers of both if that fails; interrupted, it keeps HiPO's."""
        furthest = 0

        def look(_kind: Any, _message: str, out: Any, into: Any, _data: Any) -> None:
            nonlocal furthest
            into.user_interrupt = out.ipm_iteration_count < furthest
            furthest = max(furthest, out.ipm_iteration_count)

        self._highs.setCallback(look, None)
        self._highs.startCallback(highspy.cb.HighsCallbackType.kCallbackIpmInterrupt)

    def run(self, seconds: float) -> Verdict:
        """One run within so many seconds, without a second try."""
        start = self._highs.getRunTime()
        # The limit is of all runs.
        self._highs.setOptionValue("time_limit", start + seconds)
        self._highs.run()
        self.effort.add("solve", self._highs.getRunTime() - start)
        info = self._highs.getInfo()
        self.effort.iterations += max(info.simplex_iteration_count, 0) + max(info.ipm_iteration_count, 0)
        return _VERDICTS.get(self._highs.getModelStatus(), Verdict.FAILED)

    def values(self, variable: Any) -> np.ndarray:
        """Values of a variable at the last optimum."""
        return self.point()[self.columns(variable)]

    def point(self) -> np.ndarray:
        """Values of all columns after the last run, shape (columns,); empty if there are none."""
        return np.array(self._highs.getSolution().col_value)

    def duals(self, constraint: Any) -> np.ndarray:
        """Duals of rows at the last optimum: change of the optimum per unit of bound."""
        return self.multipliers()[self.lp.rows[id(constraint)]]

    def multipliers(self) -> np.ndarray:
        """Duals of all rows after the last run, shape (rows,); empty if there are none."""
        return np.array(self._highs.getSolution().row_dual)

    def least(self) -> tuple[float, np.ndarray]:
        """Lower bound of the cost by the last multipliers, see :meth:`LinearProgram.least`."""
        return self._as_it_stands().least(self.multipliers())

    def contradiction(self) -> tuple[float, np.ndarray]:
        """Proof by a dual ray that the last program is infeasible: value and short, shape (columns,), with
        ``short·|x| ≥ value`` for every x within rows and bounds. Value 0 proves nothing."""
        nothing = np.zeros(len(self.lp.cost))
        _, found, ray = self._highs.getDualRay()
        return replace(self._as_it_stands(), cost=nothing).least(np.array(ray)) if found else (0.0, nothing)

    def _as_it_stands(self) -> LinearProgram:
        """The program with the costs and bounds that it has in HiGHS now."""
        lp = self._highs.getLp()
        return replace(
            self.lp,
            cost=np.array(lp.col_cost_),
            row_lower=np.array(lp.row_lower_),
            row_upper=np.array(lp.row_upper_),
            low=np.array(lp.col_lower_),
            high=np.array(lp.col_upper_),
        )


def _loaded(program: LinearProgram) -> highspy.HighsLp:
    lp = highspy.HighsLp()
    lp.num_row_, lp.num_col_ = program.matrix.shape
    lp.col_cost_, lp.col_lower_, lp.col_upper_ = program.cost, program.low, program.high
    lp.row_lower_, lp.row_upper_ = program.row_lower, program.row_upper
    lp.a_matrix_.format_ = highspy.MatrixFormat.kColwise
    lp.a_matrix_.start_, lp.a_matrix_.index_ = program.matrix.indptr, program.matrix.indices
    lp.a_matrix_.value_ = program.matrix.data
    return lp

"""Linear programs as arrays, what multipliers prove of them, and HiGHS, in which they stay loaded."""

import time
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from math import inf
from typing import Any

import cvxpy as cp
import highspy
import numpy as np
import scipy.sparse as sp

from masonry_opt.effort import Effort
from masonry_opt.solvers.registry import LpSize, Solver, Verdict, find_solver, iterations_of

_UNIT_ROUNDOFF = 2.0**-53  #: Rounding of one addition or product in double precision.


@dataclass(frozen=True)
class LinearProgram:
    """min cost·x with lower ≤ A x ≤ upper of the rows and low ≤ x ≤ high of the columns."""

    cost: np.ndarray  #: shape (columns,)
    matrix: sp.csc_array  #: A, shape (rows, columns)
    row_lower: np.ndarray  #: shape (rows,)
    row_upper: np.ndarray
    low: np.ndarray  #: shape (columns,)
    high: np.ndarray
    #: Those of each variable, and of each constraint in CVXPY, in order, by its identity, or by name.
    columns: Mapping[int | str, np.ndarray] = field(default_factory=dict)
    rows: Mapping[int | str, np.ndarray] = field(default_factory=dict)

    @classmethod
    def of(cls, program: cp.Problem) -> "LinearProgram":
        """The program as CVXPY compiles it."""
        data = program.get_problem_data("HIGHS", ignore_dpp=True)[0]
        rhs, equations = np.asarray(data["b"], dtype=float), data["dims"].zero
        width, offset = len(data["c"]), data["param_prob"].var_id_to_col
        low, high = (
            np.full(width, default) if data[name] is None else np.asarray(data[name], dtype=float)
            for name, default in (("lower_bounds", -np.inf), ("upper_bounds", np.inf))
        )
        # Equations come first, in the order of their declaration.
        declared = sorted(program.constraints, key=lambda row: not isinstance(row, cp.constraints.Zero))
        *ends, last = np.cumsum([row.size for row in declared])
        assert last == len(rhs)
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
            rows=dict(zip(map(id, declared), np.split(np.arange(last, dtype=np.int32), ends), strict=True)),
        )

    @classmethod
    def of_pyomo(cls, program: Any) -> "LinearProgram":
        """The program as Pyomo compiles it."""
        from pyomo.environ import Var
        from pyomo.repn.plugins.standard_form import LinearStandardFormCompiler

        form: Any = LinearStandardFormCompiler().write(program, mixed_form=True, set_sense=None)
        kind = np.array([row.bound_type for row in form.rows])
        rhs = np.asarray(form.rhs, dtype=float)
        bounds = [variable.bounds for variable in form.columns]
        column = {id(variable): index for index, variable in enumerate(form.columns)}
        return cls(
            cost=np.asarray(form.c.toarray(), dtype=float)[0],
            matrix=sp.csc_array(form.A),
            row_lower=np.where(kind == 1, -np.inf, rhs),
            row_upper=np.where(kind == -1, np.inf, rhs),
            low=np.array([-np.inf if low is None else low for low, _ in bounds], dtype=float),
            high=np.array([np.inf if high is None else high for _, high in bounds], dtype=float),
            columns={
                id(variable): np.array([column[id(data)] for data in variable.values()], dtype=np.int32)
                for variable in program.component_objects(Var)
            },
        )

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


_STATUS = highspy.HighsModelStatus
_VERDICTS = {
    _STATUS.kOptimal: Verdict.OPTIMAL,
    _STATUS.kInfeasible: Verdict.INFEASIBLE,
    _STATUS.kUnbounded: Verdict.UNBOUNDED,
    _STATUS.kUnboundedOrInfeasible: Verdict.INFEASIBLE_OR_UNBOUNDED,
}


class HighsSession:
    """A linear program in HiGHS, as declared in CVXPY or compiled before, and one of its solvers, simplex by
    default, with options beside its own. After a change simplex starts from the last basis."""

    def __init__(
        self, program: Any, effort: Effort, purpose: str, solver: Solver | None = None, **options: Any
    ) -> None:
        self.effort = effort
        solver = solver or find_solver("cvxpy", "highs", tolerance=1e-10)
        effort.uses(solver.name, purpose)
        self.lp = lp = program if isinstance(program, LinearProgram) else LinearProgram.of(program)
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

    def set_bounds(self, variable: Any, low: float, high: float) -> None:
        """Set the bounds of all columns of a variable."""
        self.set_bounds_of_columns(self.columns(variable), low, np.full(len(self.columns(variable)), high))

    def set_bounds_of_columns(self, columns: np.ndarray, low: float, high: np.ndarray) -> None:
        """Set one lower bound, and the upper bounds in order, of these columns."""
        self._highs.changeColsBounds(len(columns), columns, np.full(len(columns), low), high)

    def set_room(self, constraint: Any, room: np.ndarray) -> None:
        """Lower bounds of rows, in order: so far below their upper bounds."""
        rows = self.rows(constraint)
        upper = self.lp.row_upper[rows]
        self._highs.changeRowsBounds(len(rows), rows, upper - room, upper)

    def set_column(self, variable: Any, constraint: Any, entries: np.ndarray) -> None:
        """Entries of a variable of one column in the rows of a constraint, in order (``least`` and
        ``contradiction`` do not know them)."""
        column = int(self.columns(variable)[0])
        for row, entry in zip(self.rows(constraint).tolist(), entries.tolist(), strict=True):
            self._highs.changeCoeff(row, column, entry)

    def columns(self, variable: Any) -> np.ndarray:
        """Columns of a variable, in order."""
        return self.lp.columns[variable if isinstance(variable, str) else id(variable)]

    def rows(self, constraint: Any) -> np.ndarray:
        """Rows of a constraint, in order."""
        return self.lp.rows[constraint if isinstance(constraint, str) else id(constraint)]

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
        """Interrupt runs whose count of iterations falls: HiGHS restarts a HiPO run that stalls by the older
        interior point, and, not interrupted, drops the multipliers of both if that fails."""
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
        self._highs.setOptionValue("time_limit", start + seconds)  # of all runs
        self._highs.run()
        self.effort.add("solve", self._highs.getRunTime() - start)
        self.effort.iterations += iterations_of(self._highs.getInfo())
        return _VERDICTS.get(self._highs.getModelStatus(), Verdict.FAILED)

    def values(self, variable: Any) -> np.ndarray:
        """Values of a variable at the last optimum."""
        return self.point()[self.columns(variable)]

    def point(self) -> np.ndarray:
        """Values of all columns after the last run, shape (columns,); empty if there are none."""
        return np.array(self._highs.getSolution().col_value)

    def duals(self, constraint: Any) -> np.ndarray:
        """Duals of rows at the last optimum: change of the optimum per unit of bound."""
        return self.multipliers()[self.rows(constraint)]

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

    def dual_ray(self) -> np.ndarray | None:
        """Return row multipliers that refute the last program, shape (rows,); None if HiGHS has none.

        A positive multiplier belongs to the lower bound of its row, a negative one to the upper bound.
        """
        _, exists, ray = self._highs.getDualRay()
        return np.array(ray) if exists else None

    def accept_rays_up_to(self, residual: float) -> None:
        """Let HiGHS call a program infeasible although its dual ray leaves residuals up to a value.

        HiGHS takes the value from ``small_matrix_value``, which it reads again when it checks a ray. With the
        default of 1e-9, which the matrix needs, small programs end as "Unknown" although they are infeasible.
        """
        self._highs.setOptionValue("small_matrix_value", residual)

    def set_upper_bound_of_row(self, constraint: Any, bound: float) -> None:
        """Set the upper bound of the one row of a constraint."""
        rows = self.rows(constraint)
        self._highs.changeRowsBounds(1, rows, self.lp.row_lower[rows], np.array([bound]))

    def _as_it_stands(self) -> LinearProgram:
        """The program with the costs and bounds that it has in HiGHS now."""
        lp = self._highs.getLp()
        low, high, lower, upper = map(np.array, (lp.col_lower_, lp.col_upper_, lp.row_lower_, lp.row_upper_))
        cost = np.array(lp.col_cost_)
        return replace(self.lp, cost=cost, low=low, high=high, row_lower=lower, row_upper=upper)


def _loaded(program: LinearProgram) -> highspy.HighsLp:
    lp = highspy.HighsLp()
    lp.num_row_, lp.num_col_ = program.matrix.shape
    lp.col_cost_, lp.col_lower_, lp.col_upper_ = program.cost, program.low, program.high
    lp.row_lower_, lp.row_upper_ = program.row_lower, program.row_upper
    lp.a_matrix_.format_ = highspy.MatrixFormat.kColwise
    lp.a_matrix_.start_, lp.a_matrix_.index_ = program.matrix.indptr, program.matrix.indices
    lp.a_matrix_.value_ = program.matrix.data
    return lp

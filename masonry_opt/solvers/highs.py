"""Linear programs as arrays, rigorous bounds from dual values, and a HiGHS instance that stays loaded."""

import time
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from math import inf
from typing import TYPE_CHECKING, Any

import highspy
import numpy as np
import scipy.sparse as sp
from scipy.sparse.linalg import SuperLU, splu

from masonry_opt.deadline import SAME_TIME, check_time, seconds_left
from masonry_opt.effort import Effort
from masonry_opt.solvers.registry import LpSize, Solver, Verdict, find_solver, iterations_of

if TYPE_CHECKING:
    import cvxpy as cp

#: HiGHS ignores matrix coefficients below this magnitude (option ``small_matrix_value``). The default of
#: HiGHS, 1e-9, would ignore coefficients of nearly parallel joints, which are as small as 1e-10.
SMALLEST_COEFFICIENT = 1e-12

_UNIT_ROUNDOFF = 2.0**-53  #: Largest relative rounding error of one addition or product in double precision.


@dataclass(frozen=True)
class LinearProgram:
    """Linear program: min cost·x subject to row_lower ≤ A x ≤ row_upper and low ≤ x ≤ high."""

    cost: np.ndarray  #: shape (columns,)
    matrix: sp.csc_array  #: A, shape (rows, columns)
    row_lower: np.ndarray  #: lower bounds of the rows, shape (rows,)
    row_upper: np.ndarray  #: upper bounds of the rows, shape (rows,)
    low: np.ndarray  #: lower bounds of the columns, shape (columns,)
    high: np.ndarray  #: upper bounds of the columns, shape (columns,)
    #: Map from the name or ``id`` of each variable to the indices of its columns.
    columns: Mapping[int | str, np.ndarray] = field(default_factory=dict)
    #: Map from the name or ``id`` of each constraint to the indices of its rows.
    rows: Mapping[int | str, np.ndarray] = field(default_factory=dict)

    @classmethod
    def of(cls, program: "cp.Problem") -> "LinearProgram":
        """Convert a linear program that is declared in CVXPY to arrays."""
        from cvxpy.constraints import Zero

        data = program.get_problem_data("HIGHS", ignore_dpp=True)[0]
        rhs = np.asarray(data["b"], dtype=float)
        equations = data["dims"].zero
        width = len(data["c"])
        first_column = data["param_prob"].var_id_to_col
        low, high = (
            np.full(width, default) if data[name] is None else np.asarray(data[name], dtype=float)
            for name, default in (("lower_bounds", -np.inf), ("upper_bounds", np.inf))
        )
        # CVXPY places all equations before all inequalities, and otherwise keeps the order of declaration.
        declared = sorted(program.constraints, key=lambda row: not isinstance(row, Zero))
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
                id(variable): first_column[variable.id] + np.arange(variable.size, dtype=np.int32)
                for variable in program.variables()
            },
            rows=dict(zip(map(id, declared), np.split(np.arange(last, dtype=np.int32), ends), strict=True)),
        )

    @classmethod
    def of_pyomo(cls, program: Any) -> "LinearProgram":
        """Convert a linear program that is declared in Pyomo to arrays."""
        from pyomo.environ import Constraint, Var
        from pyomo.repn.plugins.standard_form import LinearStandardFormCompiler

        form: Any = LinearStandardFormCompiler().write(program, mixed_form=True, set_sense=None)
        kind = np.array([row.bound_type for row in form.rows])
        rhs = np.asarray(form.rhs, dtype=float)
        bounds = [variable.bounds for variable in form.columns]
        column = {id(variable): index for index, variable in enumerate(form.columns)}
        number = {id(row.constraint): index for index, row in enumerate(form.rows)}
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
            rows={
                constraint.name: np.array([number[id(data)] for data in constraint.values()], dtype=np.int32)
                for constraint in program.component_objects(Constraint, active=True)
            },
        )

    @property
    def size(self) -> LpSize:
        """Return the numbers of rows, columns and nonzeros."""
        rows, columns = self.matrix.shape
        return LpSize(rows, columns, self.matrix.nnz)

    def least(self, multipliers: np.ndarray) -> tuple[float, np.ndarray]:
        """Compute a rigorous lower bound on the cost from dual values ``multipliers``, shape (rows,).

        Any dual values are permitted, because the bound includes all rounding errors.

        The results ``value`` and ``short``, shape (columns,), satisfy ``cost·x ≥ value − short·|x|`` for
        every feasible x. ``short`` is a bound on all rounding errors. If the needed bound of a column
        is infinite, the magnitude of its reduced cost is added to ``short``.
        """
        y = np.where(np.isfinite(self.row_lower), np.maximum(multipliers, 0.0), 0.0)
        y += np.where(np.isfinite(self.row_upper), np.minimum(multipliers, 0.0), 0.0)
        at_rows = np.where(y > 0, self.row_lower, self.row_upper)
        terms = np.where(y == 0.0, 0.0, y * np.where(y == 0.0, 0.0, at_rows))
        reduced = self.cost - self.matrix.T @ y
        longest = int(np.diff(self.matrix.indptr).max(initial=0)) + 3
        rounding = longest * _UNIT_ROUNDOFF * (np.abs(self.cost) + abs(self.matrix).T @ np.abs(y))
        at_columns = np.where(reduced > 0, self.low, self.high)
        has_bound = np.isfinite(at_columns)
        column_terms = np.where(has_bound, reduced, 0.0) * np.where(has_bound, at_columns, 0.0)
        terms = np.concatenate([terms, column_terms])
        value = float(terms.sum() - len(terms) * _UNIT_ROUNDOFF * np.abs(terms).sum())
        return value, np.where(has_bound, 0.0, np.abs(reduced)) + rounding


@dataclass(frozen=True, eq=False)
class Vertex:
    """Vertex (basic solution) of a linear program, with the equations for its dual values.

    The reduced cost of each basic column is zero, and so is the dual value of each basic row.
    """

    rows: np.ndarray  #: indices of the rows that are not basic
    columns: np.ndarray  #: indices of the basic columns, one for each entry of ``rows``
    factors: SuperLU  #: factors of the transpose of the square matrix at ``rows`` and ``columns``
    row_count: int  #: number of rows of the program

    def multipliers(self, costs: np.ndarray) -> np.ndarray:
        """Return the dual values of all rows, shape (rows,), for costs of all columns, shape (columns,)."""
        y = np.zeros(self.row_count)
        y[self.rows] = self.factors.solve(costs[self.columns])
        return y


_STATUS = highspy.HighsModelStatus
_HIGHS_VERDICTS = {
    _STATUS.kOptimal: Verdict.OPTIMAL,
    _STATUS.kInfeasible: Verdict.INFEASIBLE,
    _STATUS.kUnbounded: Verdict.UNBOUNDED,
    _STATUS.kUnboundedOrInfeasible: Verdict.INFEASIBLE_OR_UNBOUNDED,
}


class HighsSession:
    """Linear program that stays loaded in HiGHS between solves.

    The program is a CVXPY problem or a :class:`LinearProgram`. The default solver is the simplex method;
    ``options`` are further options of HiGHS. After a change, the simplex method starts from the last basis.
    """

    def __init__(
        self, program: Any, effort: Effort, purpose: str, solver: Solver | None = None, **options: Any
    ) -> None:
        self.effort = effort
        solver = solver or find_solver("cvxpy", "highs", tolerance=1e-10)
        effort.uses(solver.name, purpose)
        self.lp = lp = program if isinstance(program, LinearProgram) else LinearProgram.of(program)
        self._highs = highspy.Highs()
        self._highs.silent()
        # The simplex method may cycle, so its iterations are limited. A solve without cycling needs less than
        # a tenth of this limit.
        limit = {"simplex_iteration_limit": 10 * sum(lp.matrix.shape)}
        for name, value in {**limit, **solver.options, **options}.items():
            self._highs.setOptionValue(name, value)
        self._highs.passModel(_loaded(lp))

    def start_from(self, session: "HighsSession") -> None:
        """Start the next solve from the last basis of another session, whose program has the same matrix.

        The primal simplex method is used, because a basis that is optimal for other costs remains feasible.
        Nothing changes if the other session has no basis yet.
        """
        basis = session._highs.getBasis()
        if basis.valid:
            self._highs.setBasis(basis)
            primal = highspy.simplex_constants.SimplexStrategy.kSimplexStrategyPrimal
            self._highs.setOptionValue("simplex_strategy", int(primal))

    def set_costs(self, variable: Any, costs: np.ndarray) -> None:
        """Set the cost coefficients of a variable, one for each of its columns."""
        columns = self.columns(variable)
        self._highs.changeColsCost(len(columns), columns, np.asarray(costs, dtype=float))

    def set_most(self, variable: Any, most: np.ndarray) -> None:
        """Set the upper bounds of a variable, one for each of its columns."""
        columns = self.columns(variable)
        self._highs.changeColsBounds(len(columns), columns, self.lp.low[columns], most)

    def set_bounds(self, variable: Any, low: float, high: float) -> None:
        """Set one lower bound and one upper bound for all columns of a variable."""
        columns = self.columns(variable)
        bounds = (np.full(len(columns), bound) for bound in (low, high))
        self._highs.changeColsBounds(len(columns), columns, *bounds)

    def set_room(self, constraint: Any, room: np.ndarray) -> None:
        """Set the difference between the upper and the lower bound of each row of a constraint.

        The upper bounds do not change.
        """
        rows = self.rows(constraint)
        upper = self.lp.row_upper[rows]
        self._highs.changeRowsBounds(len(rows), rows, upper - room, upper)

    def set_column(self, variable: Any, constraint: Any, entries: np.ndarray) -> None:
        """Set the coefficients of a scalar variable in a constraint, one for each row.

        The bounds that ``least`` and ``contradiction`` compute ignore these coefficients.
        """
        column = int(self.columns(variable)[0])
        for row, entry in zip(self.rows(constraint).tolist(), entries.tolist(), strict=True):
            self._highs.changeCoeff(row, column, entry)

    def columns(self, variable: Any) -> np.ndarray:
        """Return the column indices of a variable, in the order of its entries."""
        return self.lp.columns[variable if isinstance(variable, str) else id(variable)]

    def rows(self, constraint: Any) -> np.ndarray:
        """Return the row indices of a constraint, in the order of its entries."""
        return self.lp.rows[constraint if isinstance(constraint, str) else id(constraint)]

    def solve(self, seconds: float = inf) -> Verdict:
        """Solve with the present costs and bounds, within a time limit in seconds.

        If HiGHS fails from a warm start and time remains, the program is solved again from a cold start.
        Raises ProgramLimitReached if the effort permits no further program.
        """
        self.effort.check_programs()
        ends = time.perf_counter() + seconds
        verdict = self.run(seconds)
        if verdict is Verdict.FAILED:
            # The first run may have failed because of its warm start, so the second run starts cold.
            self._highs.clearSolver()
            remaining = ends - time.perf_counter()
            if remaining > 0:
                verdict = self.run(remaining)
        self.effort.lp_solves += 1
        return verdict

    def stop_if_iterations_restart(self) -> None:
        """Stop the next run if the solver HiPO stalls and HiGHS starts its older interior-point method.

        If the older method failed too, the dual values of both methods would be lost. Stopping the run
        preserves the dual values of HiPO. The older method restarts the iteration count, so its start is
        recognised by an iteration count that decreases.
        """
        furthest = 0

        def interrupt_restart(_kind: Any, _message: str, out: Any, reply: Any, _data: Any) -> None:
            nonlocal furthest
            reply.user_interrupt = out.ipm_iteration_count < furthest
            furthest = max(furthest, out.ipm_iteration_count)

        self._highs.setCallback(interrupt_restart, None)
        self._highs.startCallback(highspy.cb.HighsCallbackType.kCallbackIpmInterrupt)

    def run(self, seconds: float) -> Verdict:
        """Run HiGHS once, within a time limit in seconds.

        Raises TimeLimitReached if the time limit of the analysis ends the run.
        """
        check_time()
        start = self._highs.getRunTime()
        # The time limit of HiGHS applies to the total time of all runs, so the time of earlier runs is added.
        self._highs.setOptionValue("time_limit", start + min(seconds, seconds_left()))
        self._highs.run()
        self.effort.add("solve", self._highs.getRunTime() - start)
        self.effort.iterations += iterations_of(self._highs.getInfo())
        verdict = _HIGHS_VERDICTS.get(self._highs.getModelStatus(), Verdict.FAILED)
        if verdict is Verdict.FAILED:
            check_time(SAME_TIME)
        return verdict

    def values(self, variable: Any) -> np.ndarray:
        """Return the values of a variable at the optimum that the most recent run found."""
        return self.point()[self.columns(variable)]

    def point(self) -> np.ndarray:
        """Return the values of all columns after the last run, shape (columns,); empty if HiGHS has none."""
        return np.array(self._highs.getSolution().col_value)

    def duals(self, constraint: Any) -> np.ndarray:
        """Return the dual values of a constraint at the optimum that the most recent run found.

        A dual value is the change of the cost per unit of the bound.
        """
        return self.multipliers()[self.rows(constraint)]

    def multipliers(self) -> np.ndarray:
        """Return the dual values of all rows after the latest run, shape (rows,); empty if HiGHS has none."""
        return np.array(self._highs.getSolution().row_dual)

    def vertex(self) -> "Vertex | None":
        """Return the vertex of the last basis, or None if there is no basis or its matrix is singular."""
        basis, basic = self._highs.getBasis(), highspy.HighsBasisStatus.kBasic
        if not basis.valid:
            return None
        columns = np.flatnonzero([status == basic for status in basis.col_status])
        rows = np.flatnonzero([status != basic for status in basis.row_status])
        try:
            factors = splu(sp.csc_array(self.lp.matrix[rows][:, columns].T))
        except RuntimeError:  # the matrix is singular
            return None
        return Vertex(rows, columns, factors, len(self.lp.row_lower))

    def least(self) -> tuple[float, np.ndarray]:
        """Compute a rigorous lower bound on the cost from the dual values of the most recent run.

        See :meth:`LinearProgram.least`.
        """
        return self._present_program().least(self.multipliers())

    def contradiction(self) -> tuple[float, np.ndarray]:
        """Compute from a dual ray an inequality that every feasible x of the present program satisfies.

        The results ``value`` and ``short``, shape (columns,), define the inequality ``short·|x| ≥ value``. If
        an upper bound on each |x| is known, and the inequality is violated at these bounds, the program has
        no feasible x within the bounds. A value of 0 proves nothing.
        """
        no_cost = np.zeros(len(self.lp.cost))
        _, has_ray, ray = self._highs.getDualRay()
        if not has_ray:
            return 0.0, no_cost
        return replace(self._present_program(), cost=no_cost).least(np.array(ray))

    def dual_ray(self) -> np.ndarray | None:
        """Return a dual ray, which proves the present program infeasible, or None if HiGHS has no ray.

        The ray has shape (rows,).

        A positive entry belongs to the lower bound of its row, a negative entry to the upper bound.
        """
        _, exists, ray = self._highs.getDualRay()
        return np.array(ray) if exists else None

    def accept_rays_up_to(self, residual: float) -> None:
        """Let HiGHS accept a dual ray as a proof of infeasibility if its residuals are at most ``residual``.

        HiGHS compares the residuals of a ray with the option ``small_matrix_value``. With the small value
        that the matrix needs, some small infeasible programs end with the status "Unknown".
        """
        self._highs.setOptionValue("small_matrix_value", residual)

    def set_upper_bound_of_row(self, constraint: Any, bound: float) -> None:
        """Set the upper bound of a constraint that has a single row."""
        rows = self.rows(constraint)
        self._highs.changeRowsBounds(1, rows, self.lp.row_lower[rows], np.array([bound]))

    def _present_program(self) -> LinearProgram:
        """Return the linear program with the costs and bounds that are currently set in HiGHS."""
        lp = self._highs.getLp()
        low, high, lower, upper = map(np.array, (lp.col_lower_, lp.col_upper_, lp.row_lower_, lp.row_upper_))
        cost = np.array(lp.col_cost_)
        return replace(self.lp, cost=cost, low=low, high=high, row_lower=lower, row_upper=upper)


def _loaded(program: LinearProgram) -> highspy.HighsLp:
    """Return a linear program in the format of HiGHS."""
    lp = highspy.HighsLp()
    lp.num_row_, lp.num_col_ = program.matrix.shape
    lp.col_cost_, lp.col_lower_, lp.col_upper_ = program.cost, program.low, program.high
    lp.row_lower_, lp.row_upper_ = program.row_lower, program.row_upper
    lp.a_matrix_.format_ = highspy.MatrixFormat.kColwise
    lp.a_matrix_.start_, lp.a_matrix_.index_ = program.matrix.indptr, program.matrix.indices
    lp.a_matrix_.value_ = program.matrix.data
    return lp

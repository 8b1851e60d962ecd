"""Solve programs that are declared in CVXPY.

Programs with very large coefficients, such as a friction coefficient of 1e6, are scaled before Clarabel
solves them.
"""

import math
import time
import warnings
from collections.abc import Callable
from functools import partial
from types import SimpleNamespace
from typing import Any

import cvxpy as cp
import numpy as np
import scipy.sparse as sp

from masonry_opt.deadline import SAME_TIME, check_time, seconds_left
from masonry_opt.effort import Effort
from masonry_opt.solvers.registry import LpSize, Solved, Solver, Verdict, iterations_of

_CVXPY_VERDICTS = {
    cp.OPTIMAL: Verdict.OPTIMAL,
    cp.INFEASIBLE: Verdict.INFEASIBLE,
    cp.UNBOUNDED: Verdict.UNBOUNDED,
    cp.settings.INFEASIBLE_OR_UNBOUNDED: Verdict.INFEASIBLE_OR_UNBOUNDED,
    cp.OPTIMAL_INACCURATE: Verdict.NEARLY,
}

#: Solver option that limits the time in seconds, by CVXPY's name of the solver. A solver without an entry
#: cannot be stopped, so an analysis may exceed its time limit.
_TIME_LIMITS = {
    cp.CLARABEL: "time_limit",
    cp.HIGHS: "time_limit",
    cp.OSQP: "time_limit",
    cp.SCS: "time_limit_secs",
}

#: CVXPY compiles a program with at least this number of columns again for every solve. A smaller program is
#: compiled once, with parameters. The form with parameters grows with the square of the number of joints, so
#: compiling a large program again is faster.
_COLUMNS_TO_RECOMPILE = 3000

#: Keys under which CVXPY stores the costs of a compiled program.
_COSTS = ("P", "c", "q")

#: Keys under which CVXPY stores the matrices, right-hand sides and bounds of a compiled program. The meaning
#: of a key depends on the solver: "G" is a matrix for some solvers, and a right-hand side for others.
_MATRICES_AND_BOUNDS = ("A", "b", "F", "G", "h", "lower_bounds", "upper_bounds")


class CvxpyEngine:
    """Optimisation program that is declared in CVXPY, with its solver.

    ``effort`` records the solver under ``purpose``. If ``repeats`` is True, the program is solved several
    times with different parameters, and is compiled only once if it is not too large.
    """

    size: LpSize  #: size of the program as last compiled

    def __init__(
        self, program: cp.Problem, solver: Solver, effort: Effort, purpose: str, repeats: bool = False
    ) -> None:
        self.program, self.solver, self.effort = program, solver, effort
        effort.uses(solver.name, purpose)
        self._as_constants = not repeats or program.size_metrics.num_scalar_variables >= _COLUMNS_TO_RECOMPILE
        self._purpose = purpose

    def restart(self, effort: Effort) -> None:
        """Prepare for solves of another problem, and record their time and iterations in ``effort``.

        Earlier solves have no effect on later solves.
        """
        self.effort = effort
        effort.uses(self.solver.name, self._purpose)

    def solve(self) -> Solved:
        """Compile and solve the program, and write the solution into its variables.

        Raises TimeLimitReached if the time limit of the analysis has passed.
        """
        check_time()
        effort = self.effort
        program = self.program
        engine = self.solver.entry.engine
        options = self.solver.options
        with effort.measure("compile"):
            data, chain, inverse = program.get_problem_data(
                engine, ignore_dpp=self._as_constants, solver_opts=dict(options)
            )
        (rows, columns), nonzeros = data["A"].shape, data["A"].nnz
        self.size = LpSize(rows, columns, nonzeros)
        effort.lp_solves += 1
        if not _has_valid_numbers(data):
            return Solved(Verdict.FAILED, "the program contains coefficients that are NaN or infinite", 0.0)
        check_time()
        if engine in _TIME_LIMITS and math.isfinite(seconds_left()):
            options = {**options, _TIME_LIMITS[engine]: seconds_left()}
        # ``chain.solve_via_data`` would keep the solver and its matrix factorisation for a warm start, but no
        # solve is warm-started. On large scenes, the factorisation needs more memory than the program.
        run_solver = partial(
            chain.solver.solve_via_data, warm_start=False, verbose=False, solver_opts=dict(options)
        )
        status = ""
        start = time.perf_counter()
        try:
            raw: Any = solve_balanced(run_solver, data) if engine == cp.CLARABEL else run_solver(data)
            elapsed = time.perf_counter() - start
            is_highs = isinstance(raw, dict) and "model_status" in raw
            status = str(raw["model_status"] if is_highs else getattr(raw, "status", ""))
            with effort.measure("read"), warnings.catch_warnings():
                # CVXPY would warn that a solution is inaccurate, but the status already says so.
                warnings.simplefilter("ignore")
                program.unpack_results(raw, chain, inverse)
        # CVXPY raises ValueError if HiGHS stops with the status "unknown" and has no solution.
        except (cp.SolverError, ValueError) as error:
            check_time(SAME_TIME)
            return Solved(Verdict.FAILED, status or str(error), 0.0)
        stats = program.solver_stats
        seconds = elapsed if stats.solve_time is None else float(stats.solve_time)
        effort.add("solve", seconds)
        # The time outside the solver, in which CVXPY passes the matrices to the solver, counts as
        # compilation.
        effort.add("compile", max(elapsed - seconds, 0.0))
        effort.iterations += iterations_of(raw["info"]) if is_highs else int(stats.num_iters or 0)
        verdict = _CVXPY_VERDICTS.get(program.status, Verdict.FAILED)
        if verdict is Verdict.FAILED:
            check_time(SAME_TIME)
        return Solved(verdict, status or program.status, seconds)


def _has_valid_numbers(data: dict[str, Any]) -> bool:
    """Return True if no number of a compiled program is NaN, and no coefficient is infinite.

    Bounds and right-hand sides may be infinite. HiGHS reports an optimum for some programs with NaN.
    """
    for key in (*_COSTS, *_MATRICES_AND_BOUNDS):
        values = data.get(key)
        if values is None:
            continue
        numbers = values.data if sp.issparse(values) else np.asarray(values)
        is_bound = key in _MATRICES_AND_BOUNDS and values.ndim == 1
        if np.isnan(numbers).any() or (np.isinf(numbers).any() and not is_bound):
            return False
    return True


def has_optimum(
    program: cp.Problem, solver: Solver, effort: Effort, purpose: str, *, nearly: bool = False
) -> bool:
    """Solve a program once, and return True if the solver found a solution.

    For ``nearly``, see :meth:`~.registry.Solved.readable`.
    """
    return CvxpyEngine(program, solver, effort, purpose).solve().readable(nearly)


#: Rows, and then columns, are scaled down if their largest entry exceeds this magnitude. A row with the
#: entries 1 and 1e6 (a large friction coefficient) becomes 1e-3 and 1e3. With another value, one of the two
#: entries would be farther from 1, and would lose digits.
_LARGE_ENTRY = 1e3


def solve_balanced(solve: Callable[[dict[str, Any]], Any], data: dict[str, Any]) -> Any:
    """Solve a conic program with its large coefficients scaled down; return the solution in original units.

    The program is min c·x + ½ x·P x with b − A x in cones, as CVXPY compiles it for Clarabel.
    """
    A, dims = data["A"], data["dims"]
    if not A.nnz or abs(A).max() <= _LARGE_ENTRY:
        return solve(data)
    sizes = [1] * (dims.zero + dims.nonneg) + dims.soc
    cone_of_row = np.repeat(np.arange(len(sizes)), sizes)
    rows = _by_cones(1 / np.maximum(1.0, _largest(A) / _LARGE_ENTRY), cone_of_row, dims.zero)
    balanced = sp.diags_array(rows) @ A
    before = _largest(balanced)
    columns = 1 / np.maximum(1.0, _largest(balanced.T) / _LARGE_ENTRY)
    scale = sp.diags_array(columns)
    # The scaling of columns also reduces the entries of rows that had no large entry, such as p ≥ 0. Scale
    # these rows such that their largest entries return to their former magnitude.
    rows *= _by_cones(before / _largest(balanced @ scale), cone_of_row, dims.zero)
    A = sp.diags_array(rows) @ A
    scaled = data | {"A": (A @ scale).tocsc(), "b": rows * data["b"], "c": columns * data["c"]}
    if "P" in data:
        scaled["P"] = (scale @ data["P"] @ scale).tocsc()
    raw = solve(scaled)
    x = columns * np.asarray(raw.x)
    z = rows * np.asarray(raw.z)
    info = {name: getattr(raw, name) for name in ("status", "solve_time", "iterations", "obj_val")}
    return SimpleNamespace(x=x, z=z, **info)


def _largest(A: Any) -> np.ndarray:
    """Return the largest magnitude of the entries in each row of a matrix."""
    return np.asarray(abs(A).max(axis=1).toarray()).ravel()


def _by_cones(factors: np.ndarray, cone_of_row: np.ndarray, equations: int) -> np.ndarray:
    """Return a scaling factor for each row. Factors are equal within a cone, so the cones do not change.

    All rows of a cone get the smallest of their factors. Equations are not scaled.
    """
    factor_of_cone = np.full(cone_of_row[-1] + 1, np.inf)
    np.minimum.at(factor_of_cone, cone_of_row, factors)
    factor_of_cone[:equations] = 1.0
    return factor_of_cone[cone_of_row]

"""Solves programs declared in CVXPY, those with very large entries (friction of 1e6) scaled."""

import time
import warnings
from collections.abc import Callable
from functools import partial
from types import SimpleNamespace
from typing import Any

import cvxpy as cp
import numpy as np
import scipy.sparse as sp

from masonry_opt.effort import Effort
from masonry_opt.solvers.registry import LpSize, Solved, Solver, Verdict, iterations_of

_VERDICTS = {
    cp.OPTIMAL: Verdict.OPTIMAL,
    cp.INFEASIBLE: Verdict.INFEASIBLE,
    cp.UNBOUNDED: Verdict.UNBOUNDED,
    cp.settings.INFEASIBLE_OR_UNBOUNDED: Verdict.INFEASIBLE_OR_UNBOUNDED,
    cp.OPTIMAL_INACCURATE: Verdict.NEARLY,
}

#: From so many columns on parameters are compiled as constants, again for every solve: CVXPY's tensor over
#: parameters takes memory that grows with the square of the joints, and more time than compiling again.
_TOO_LARGE = 3000


class CvxpyEngine:
    """A declared program and the solver that answers it, which the effort records under the purpose; compiled
    only once if it ``repeats`` with other parameters."""

    size: LpSize  #: as last compiled

    def __init__(
        self, program: cp.Problem, solver: Solver, effort: Effort, purpose: str, repeats: bool = False
    ) -> None:
        self.program, self.solver, self.effort = program, solver, effort
        effort.uses(solver.name, purpose)
        self._as_constants = not repeats or program.size_metrics.num_scalar_variables >= _TOO_LARGE
        self._purpose = purpose

    def restart(self, effort: Effort) -> None:
        """Count in another effort; solves use nothing of earlier ones."""
        self.effort = effort
        effort.uses(self.solver.name, self._purpose)

    def solve(self) -> Solved:
        """Compile, solve and unpack."""
        effort, program, engine = self.effort, self.program, self.solver.entry.engine
        options = self.solver.options
        with effort.measure("compile"):
            data, chain, inverse = program.get_problem_data(
                engine, ignore_dpp=self._as_constants, solver_opts=dict(options)
            )
        (rows, columns), nonzeros = data["A"].shape, data["A"].nnz
        self.size = LpSize(rows, columns, nonzeros)
        effort.lp_solves += 1
        handed_over = partial(chain.solve_via_data, program, solver_opts=dict(options))
        status = ""
        start = time.perf_counter()
        try:
            raw: Any = solve_balanced(handed_over, data) if engine == cp.CLARABEL else handed_over(data)
            elapsed = time.perf_counter() - start
            of_highs = isinstance(raw, dict) and "model_status" in raw
            status = str(raw["model_status"] if of_highs else getattr(raw, "status", ""))
            with effort.measure("read"), warnings.catch_warnings():
                warnings.simplefilter("ignore")  # "may be inaccurate": the status says so and is read
                program.unpack_results(raw, chain, inverse)
        except (cp.SolverError, ValueError) as error:  # ValueError: HiGHS's "unknown", without values
            return Solved(Verdict.FAILED, status or str(error), 0.0)
        stats = program.solver_stats
        seconds = elapsed if stats.solve_time is None else float(stats.solve_time)
        effort.add("solve", seconds)
        effort.add("compile", max(elapsed - seconds, 0.0))  # handing the matrices over
        effort.iterations += iterations_of(raw["info"]) if of_highs else int(stats.num_iters or 0)
        return Solved(_VERDICTS.get(program.status, Verdict.FAILED), status or program.status, seconds)


def has_optimum(
    program: cp.Problem, solver: Solver, effort: Effort, purpose: str, *, nearly: bool = False
) -> bool:
    """Solve a program once; whether there is an optimum to read, see :meth:`~.registry.Solved.readable`."""
    return CvxpyEngine(program, solver, effort, purpose).solve().readable(nearly)


#: Larger entries than this: their inequalities, then variables, are scaled to it. An entry of 1e6 then stands
#: as far above one as the 1 beside it below: with either at one, digits of the other are lost.
_LARGE = 1e3


def solve_balanced(solve: Callable[[dict[str, Any]], Any], data: dict[str, Any]) -> Any:
    """What a solver of min c·x + ½ x·P x with b − A x in cones ends with, in the program's own units, from
    data as CVXPY has it for Clarabel."""
    A, dims = data["A"], data["dims"]
    if not A.nnz or abs(A).max() <= _LARGE:
        return solve(data)
    sizes = [1] * (dims.zero + dims.nonneg) + dims.soc
    each = np.repeat(np.arange(len(sizes)), sizes)
    rows = _by_cones(1 / np.maximum(1.0, _largest(A) / _LARGE), each, dims.zero)
    balanced = sp.diags_array(rows) @ A
    before, columns = _largest(balanced), 1 / np.maximum(1.0, _largest(balanced.T) / _LARGE)
    scale = sp.diags_array(columns)
    # Inequalities keep their size where variables are scaled, as p ≥ 0.
    rows *= _by_cones(before / _largest(balanced @ scale), each, dims.zero)
    A = sp.diags_array(rows) @ A
    scaled = data | {"A": (A @ scale).tocsc(), "b": rows * data["b"], "c": columns * data["c"]}
    if "P" in data:
        scaled["P"] = (scale @ data["P"] @ scale).tocsc()
    raw = solve(scaled)
    x, z = columns * np.asarray(raw.x), rows * np.asarray(raw.z)
    told = {name: getattr(raw, name) for name in ("status", "solve_time", "iterations", "obj_val")}
    return SimpleNamespace(x=x, z=z, **told)


def _largest(A: Any) -> np.ndarray:
    """Largest entry of each row."""
    return np.asarray(abs(A).max(axis=1).toarray()).ravel()


def _by_cones(factors: np.ndarray, each: np.ndarray, zero: int) -> np.ndarray:
    """Factors that may be put to rows: one for all of a cone, the least; none to equations."""
    of_cones = np.full(each[-1] + 1, np.inf)
    np.minimum.at(of_cones, each, factors)
    of_cones[:zero] = 1.0
    return of_cones[each]

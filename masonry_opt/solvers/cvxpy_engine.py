"""Solves programs declared in CVXPY."""

from __future__ import annotations

import time
import warnings
from typing import Any

import cvxpy as cp

from masonry_opt.effort import Effort
from masonry_opt.solvers.balance import solve_balanced
from masonry_opt.solvers.lp import LpSize, Solved, Verdict
from masonry_opt.solvers.registry import Solver

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
    """A declared program and the solver that answers it.

    Parameters
    ----------
    purpose: what it is solved for, under which the effort records the solver.
    repeats: whether it is solved again and again with other parameters; it is then compiled only once.
    """

    def __init__(
        self, program: cp.Problem, solver: Solver, effort: Effort, purpose: str, repeats: bool = False
    ) -> None:
        self.program, self.solver, self.effort = program, solver, effort
        effort.uses(solver.name, purpose)
        self._as_constants = not repeats or program.size_metrics.num_scalar_variables >= _TOO_LARGE
        self._purpose = purpose
        self._size: LpSize | None = None

    def restart(self, effort: Effort) -> None:
        """Count in another effort; solves use nothing of earlier ones."""
        self.effort = effort
        effort.uses(self.solver.name, self._purpose)

    def size(self) -> LpSize:
        """Rows, columns and non-zeros as compiled."""
        if self._size is None:
            self._compiled()
        assert self._size is not None
        return self._size

    def solve(self) -> Solved:
        """Compile, solve and unpack."""
        effort, program = self.effort, self.program
        with effort.measure("compile"):
            data, chain, inverse = self._compiled()
        effort.lp_solves += 1
        balances = self.solver.entry.engine == cp.CLARABEL

        def handed_over(given: dict[str, Any]) -> Any:
            return chain.solve_via_data(program, given, solver_opts=dict(self.solver.options))

        start = time.perf_counter()
        try:
            raw: Any = solve_balanced(handed_over, data) if balances else handed_over(data)
        except (cp.SolverError, ValueError) as error:  # ValueError: HiGHS's "unknown", without values
            return Solved(Verdict.FAILED, str(error), 0.0)
        elapsed = time.perf_counter() - start
        of_highs = isinstance(raw, dict) and "model_status" in raw
        status = str(raw["model_status"]) if of_highs else str(getattr(raw, "status", ""))
        with effort.measure("read"), warnings.catch_warnings():
            warnings.simplefilter("ignore")  # "may be inaccurate": the status says so and is read
            try:
                program.unpack_results(raw, chain, inverse)
            except (cp.SolverError, ValueError):
                return Solved(Verdict.FAILED, status, 0.0)
        stats = program.solver_stats
        seconds = elapsed if stats.solve_time is None else float(stats.solve_time)
        effort.add("solve", seconds)
        effort.add("compile", max(elapsed - seconds, 0.0))  # handing the matrices over
        effort.iterations += _highs_iterations(raw["info"]) if of_highs else int(stats.num_iters or 0)
        return Solved(_VERDICTS.get(program.status, Verdict.FAILED), status or program.status, seconds)

    def _compiled(self) -> Any:
        compiled = self.program.get_problem_data(
            self.solver.entry.engine, ignore_dpp=self._as_constants, solver_opts=dict(self.solver.options)
        )
        matrix = compiled[0]["A"]
        self._size = LpSize(matrix.shape[0], matrix.shape[1], matrix.nnz)
        return compiled


def has_optimum(
    program: cp.Problem, solver: Solver, effort: Effort, purpose: str, *, nearly: bool = False
) -> bool:
    """Solve a program once; whether there is an optimum to read. ``nearly``: or a point at which the solver
    stopped short of its tolerance."""
    solved = CvxpyEngine(program, solver, effort, purpose).solve()
    return solved.optimal or (nearly and solved.verdict is Verdict.NEARLY)


def _highs_iterations(info: Any) -> int:
    return max(info.simplex_iteration_count, 0) + max(info.ipm_iteration_count, 0)

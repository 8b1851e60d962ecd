"""Drives models declared in CVXPY: compiles once, then re-solves as parameters change."""

from __future__ import annotations

import time
import warnings
from typing import Any

import cvxpy as cp
import numpy as np

from masonry_opt.effort import Stopwatch
from masonry_opt.models.cvxpy_at_yield import CvxpyAtYield
from masonry_opt.models.cvxpy_kinematic import CvxpyKinematic
from masonry_opt.models.cvxpy_least_energy import CvxpyForcesFor, CvxpyMotionFor
from masonry_opt.models.cvxpy_mechanism import CvxpyMechanism
from masonry_opt.models.cvxpy_static import CvxpyStatic
from masonry_opt.problem.problem import Problem, ShearLimits
from masonry_opt.solvers.lp import Answer, LpSize, Outcome, outcome_of
from masonry_opt.solvers.registry import Solver, find_solver

_MODELS: dict[str, type[CvxpyStatic] | type[CvxpyKinematic]] = {
    "static": CvxpyStatic,
    "kinematic": CvxpyKinematic,
}

_INFEASIBLE = (cp.INFEASIBLE, cp.settings.INFEASIBLE_OR_UNBOUNDED)
_UNBOUNDED = (cp.UNBOUNDED, cp.settings.INFEASIBLE_OR_UNBOUNDED)


#: From so many joints on parameters are compiled as constants, anew for every solve: CVXPY's tensor over
#: parameters costs memory that grows with the square of the joints, and more time than compiling again.
_CONSTANTS_FROM = 1000


class CvxpyDriver:
    """A declared CVXPY model and the solver that answers it."""

    def __init__(
        self,
        problem: Problem,
        formulation: str,
        limits: ShearLimits,
        solver: Solver,
        watch: Stopwatch,
    ) -> None:
        self.formulation, self.solver, self.watch = formulation, solver, watch
        self.solves = 0
        self._as_constants = problem.joints >= _CONSTANTS_FROM
        with watch.measure("build"):
            self.model = _MODELS[formulation](problem, limits)

    def set_shear_limits(self, limits: ShearLimits) -> None:
        """Change the model's shear limits, and nothing else."""
        with self.watch.measure("compile"):
            self.model.set_shear_limits(limits)

    def size(self) -> LpSize:
        """Rows, columns and non-zeros as compiled."""
        data, _, _ = self.model.program.get_problem_data(
            self.solver.engine, ignore_dpp=self._as_constants, solver_opts={}
        )
        rows, columns = data["A"].shape
        return LpSize(rows, columns, data["A"].nnz)

    def solve(self) -> Answer:
        """Solve with the present shear limits."""
        self.solves += 1
        word, iterations, seconds = _solve(self.model.program, self.solver, self.watch, self._as_constants)
        status = self.model.program.status
        if status == cp.OPTIMAL:
            with self.watch.measure("read"):
                state = self.model.read()
            return Answer(Outcome.OPTIMAL, word, state, iterations, seconds)
        outcome = outcome_of(
            self.formulation, infeasible=status in _INFEASIBLE, unbounded=status in _UNBOUNDED
        )
        return Answer(outcome, word, None, iterations, seconds)


def driven_mechanism(
    problem: Problem, force: np.ndarray, limits: ShearLimits, solver: Solver, watch: Stopwatch
) -> tuple[float, np.ndarray] | None:
    """Power and block velocities, shape (3b,), of the mechanism that ``force`` drives.

    None if the solver fails. A power of (numerically) zero means that nothing moves.
    """
    with watch.measure("build"):
        model = CvxpyMechanism(problem, force, limits)
    _solve(model.program, solver, watch)
    if model.program.status != cp.OPTIMAL:
        return None
    return float(model.program.value), model.read()


def state_at_yield(
    problem: Problem, at_yield: np.ndarray, near: float, watch: Stopwatch
) -> tuple[float, np.ndarray] | None:
    """λ and joint forces, shape (3c,), of the state with these faces at yield, shape (4, c), whose λ is
    nearest to a given value; None if there is no such state or the solver fails."""
    with watch.measure("build"):
        model = CvxpyAtYield(problem, at_yield, near)
    return model.read() if _has_optimum(model.program, watch) else None


def forces_for(
    problem: Problem, rates: np.ndarray, weight: float, watch: Stopwatch
) -> tuple[float, np.ndarray] | None:
    """λ and joint forces, shape (3c,), that leave least energy in faces moving at these rates, shape (4, c);
    None if the solver fails."""
    with watch.measure("build"):
        model = CvxpyForcesFor(problem, rates, weight)
    return model.read() if _has_optimum(model.program, watch) else None


def motion_for(
    problem: Problem, slacks: np.ndarray, slope: np.ndarray, watch: Stopwatch
) -> np.ndarray | None:
    """Block velocities, shape (3b,), that leave least energy in faces with these slacks, shape (4, c), under
    a flow rule, shape (k,); None if there is no mechanism or the solver fails."""
    with watch.measure("build"):
        model = CvxpyMotionFor(problem, slacks, slope)
    return model.read() if _has_optimum(model.program, watch) else None


def _has_optimum(program: cp.Problem, watch: Stopwatch) -> bool:
    _solve(program, find_solver("cvxpy", "clarabel"), watch)
    return bool(program.status == cp.OPTIMAL)


def _solve(
    program: cp.Problem, solver: Solver, watch: Stopwatch, as_constants: bool = False
) -> tuple[str, int, float]:
    """Compile, solve and unpack; the solver's word, its iterations and its own seconds."""
    with watch.measure("compile"):
        data, chain, inverse = program.get_problem_data(
            solver.engine, ignore_dpp=as_constants, solver_opts=dict(solver.options)
        )
    start = time.perf_counter()
    try:
        raw: Any = chain.solve_via_data(program, data, solver_opts=dict(solver.options))
    except (cp.SolverError, ValueError) as error:  # ValueError: HiGHS's "unknown", without values
        program._status = cp.settings.SOLVER_ERROR
        return str(error), 0, 0.0
    elapsed = time.perf_counter() - start
    word = str(raw["model_status"] if isinstance(raw, dict) and "model_status" in raw else "")
    word = str(getattr(raw, "status", word))
    with watch.measure("read"), warnings.catch_warnings():
        warnings.simplefilter("ignore")  # "may be inaccurate": the status says so and is read
        try:
            program.unpack_results(raw, chain, inverse)
        except (cp.SolverError, ValueError):
            program._status = cp.settings.SOLVER_ERROR
            return word, 0, 0.0
    stats = program.solver_stats
    seconds = elapsed if stats.solve_time is None else float(stats.solve_time)
    watch.add("solve", seconds)
    watch.add("compile", max(elapsed - seconds, 0.0))  # handing the matrices over
    of_highs = isinstance(raw, dict) and "model_status" in raw
    iterations = _highs_iterations(raw["info"]) if of_highs else stats.num_iters or 0
    return word or program.status, int(iterations), seconds


def _highs_iterations(info: Any) -> int:
    return max(info.simplex_iteration_count, 0) + max(info.ipm_iteration_count, 0)

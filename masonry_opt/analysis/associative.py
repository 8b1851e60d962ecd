"""Associative limit analysis: one linear program, eq. (9) or eq. (10)."""

from __future__ import annotations

from masonry_opt.analysis.diagnosis import explain_no_answer
from masonry_opt.analysis.finding import Finding
from masonry_opt.analysis.status import Status
from masonry_opt.problem.problem import Problem
from masonry_opt.solvers.driver import declare
from masonry_opt.solvers.registry import Solver
from masonry_opt.timing import Stopwatch


def associative(problem: Problem, formulation: str, solver: Solver, watch: Stopwatch) -> Finding:
    """Load factor, forces and mechanism under associative flow, of a scene that stands."""
    driver = declare(problem, formulation, solver, watch)
    answer = driver.solve()
    finding = Finding(
        Status.OPTIMAL,
        slope=problem.friction,
        iterations=answer.iterations,
        lp_solves=driver.solves,
        size=driver.size(),
    )
    if answer.state is None:
        finding.status, finding.message = explain_no_answer(problem, answer)
    else:
        finding.load_factor = answer.state.load_factor
        finding.take(answer.state)
    return finding

"""Associative limit analysis: one linear program, eq. (9) or eq. (10)."""

from __future__ import annotations

from masonry_opt.answer.solution import Finding
from masonry_opt.answer.status import Status
from masonry_opt.effort import Stopwatch
from masonry_opt.explain.diagnosis import explain_no_answer
from masonry_opt.problem.problem import Problem, ShearLimits
from masonry_opt.solvers.load_units import DriverInUnitsOfLoad
from masonry_opt.solvers.lp import Answer, LpSize
from masonry_opt.solvers.registry import Solver


def associative(problem: Problem, formulation: str, solver: Solver, watch: Stopwatch) -> Finding:
    """Load factor, forces and mechanism under associative flow, of a scene that stands."""
    answer, size = associative_answer(problem, formulation, solver, watch)
    finding = Finding(
        Status.OPTIMAL,
        slope=problem.friction,
        iterations=answer.iterations,
        lp_solves=1,
        size=size,
    )
    if answer.state is None:
        finding.status, finding.message = explain_no_answer(problem, answer)
    else:
        finding.load_factor = answer.state.load_factor
        finding.take(answer.state)
    return finding


def associative_answer(
    problem: Problem, formulation: str, solver: Solver, watch: Stopwatch
) -> tuple[Answer, LpSize]:
    """The solver's answer to a formulation with the joints' own limits, in the problem's units, and the
    size of the linear program.

    It is solved in units of the load (:func:`~masonry_opt.solvers.load_units.in_units_of_load`).
    """
    driver = DriverInUnitsOfLoad(problem, formulation, solver, watch, ShearLimits.associative(problem))
    answer = driver.solve()
    return answer, driver.size()

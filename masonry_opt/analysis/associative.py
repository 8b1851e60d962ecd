"""Associative limit analysis: one linear program, eq. (9) or eq. (10)."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from masonry_opt.analysis.diagnosis import explain_no_answer
from masonry_opt.analysis.finding import Finding
from masonry_opt.analysis.status import Status
from masonry_opt.problem.problem import Problem
from masonry_opt.solvers.answer import Answer, LpSize
from masonry_opt.solvers.driver import declare
from masonry_opt.solvers.registry import Solver
from masonry_opt.timing import Stopwatch


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

    It is solved in units of the whole load (:func:`in_units_of_load`).
    """
    scaled = in_units_of_load(problem)
    driver = declare(scaled, formulation, solver, watch)
    answer = driver.solve()
    if answer.state is not None:
        unit = scaled.force_unit / problem.force_unit
        answer = replace(answer, state=replace(answer.state, q=unit * answer.state.q))
    return answer, driver.size()


def in_units_of_load(problem: Problem) -> Problem:
    """The problem with forces in units of its whole load, live or dead, the lesser.

    The largest forces of a large scene are a thousand block weights. A solver starts from forces near one
    and takes its tolerances relative to the largest: in these units it ends a hundred times nearer the
    optimum (façades of 6000 blocks: 4e-8 instead of 4e-6), in a third more iterations.
    """
    loads = (problem.live_norm, float(np.abs(problem.dead).sum()))
    return problem.in_units_of(min((load for load in loads if load), default=1.0))

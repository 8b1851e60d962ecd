"""Associative limit analysis: one linear program, eq. (9) or eq. (10)."""

from __future__ import annotations

from dataclasses import dataclass, replace

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

    It is solved in units of the load (:func:`in_units_of_load`).
    """
    scaled = in_units_of_load(problem)
    driver = declare(scaled.problem, formulation, solver, watch)
    answer = driver.solve()
    if answer.state is not None:
        state = replace(
            answer.state,
            load_factor=scaled.load_factor * answer.state.load_factor,
            q=scaled.force * answer.state.q,
        )
        answer = replace(answer, state=state)
    return answer, driver.size()


@dataclass(frozen=True)
class Scaled:
    """A problem in other units of force and of λ; velocities are the same in both.

    Attributes
    ----------
    force, load_factor: what its forces and its λ are multiplied by.
    """

    problem: Problem
    force: float
    load_factor: float


def in_units_of_load(problem: Problem) -> Scaled:
    """The problem with forces in units of the dead load of the blocks that carry live load, and a live load
    whose entries sum to one.

    The largest forces of a large scene are a thousand block weights. A solver starts from forces near one
    and takes its tolerances relative to the largest: in these units it ends a hundred times nearer the
    optimum (façades of 6000 blocks: 4e-8 instead of 4e-6), in a third more iterations.
    """
    dead = np.abs(problem.dead).reshape(-1, 3).sum(axis=1)
    loaded = problem.live.reshape(-1, 3).any(axis=1)
    weights = (float(dead[loaded].sum()), float(dead.sum()), problem.live_norm)
    force = next(weight for weight in weights if weight)
    scaled = replace(problem.in_units_of(force), live=problem.live / problem.live_norm)
    return Scaled(scaled, force, force / problem.live_norm)

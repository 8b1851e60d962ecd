"""Why there is no load factor: blocks that fall, or nothing that can move."""

from __future__ import annotations

import numpy as np

from masonry_opt.analysis.status import Status
from masonry_opt.problem.problem import Problem, ShearLimits
from masonry_opt.solvers.answer import Answer, Outcome
from masonry_opt.solvers.cvxpy_driver import driven_mechanism
from masonry_opt.solvers.driver import declare
from masonry_opt.solvers.registry import find_solver
from masonry_opt.timing import Stopwatch

#: Power of a bounded mechanism, in median block weights, below which nothing moves.
_NOTHING = 1e-7


class DeadLoadUndecided(Exception):
    """The solver failed to say whether the scene stands; the message is its word."""


def falling_mechanism(problem: Problem) -> np.ndarray | None:
    """Block velocities with which blocks fall under dead load alone, shape (3b,); None if all stand.

    The scene stands if eq. (9) without live load has a state. Else the mechanism is the dual ray,
    bounded. Checked before every analysis: a maximal λ may exist where λ = 0 is no equilibrium.

    Raises
    ------
    DeadLoadUndecided
        If the solver fails on both.
    """
    solver, watch = find_solver("cvxpy", "clarabel"), Stopwatch()
    dead_only = problem.without_live_load()
    answer = declare(dead_only, "static", solver, watch).solve()
    if answer.outcome is Outcome.OPTIMAL:
        return None
    limits = ShearLimits.associative(problem)
    driven = driven_mechanism(problem, problem.dead, limits, solver, watch)
    if driven is None:
        raise DeadLoadUndecided(answer.word)
    power, velocities = driven
    # A scene may stand so narrowly that no solver finds a state with room around it.
    return velocities if power > _NOTHING else None


def explain_no_answer(problem: Problem, answer: Answer) -> tuple[Status, str]:
    """Status and message for a linear program without an optimum, of a scene that stands.

    Such a program is unlimited or its solver failed. Which, is decided by whether the live load
    drives any mechanism, not by the solver's word.
    """
    k = problem.sliding
    own_flow = _live_load_drives(problem, problem.dilatancy[k])
    associative = _live_load_drives(problem, problem.friction[k])
    if own_flow is None or associative is None or associative:
        return Status.SOLVER_FAILED, f"the solver stopped with '{answer.word}': try another solver"
    if own_flow:
        return Status.LOCKED, (
            "sliding joints that dilate jam the blocks, so that they carry any multiple of the live "
            "load; without dilatancy they can move: method 'nonassociative' tells whether they do"
        )
    return Status.UNLIMITED, (
        "no mechanism lets the live load do work, so the scene carries any multiple of it: "
        "check the direction of 'live' and which blocks carry it"
    )


def _live_load_drives(problem: Problem, slope: np.ndarray) -> bool | None:
    """Whether a mechanism with that opening per unit slip (k,) lets the live load do work; None if
    the solver fails to say."""
    solver, force = find_solver("cvxpy", "clarabel"), problem.live / problem.live_norm
    driven = driven_mechanism(problem, force, ShearLimits(slope), solver, Stopwatch())
    return None if driven is None else driven[0] > _NOTHING


def moving_blocks(d: np.ndarray) -> np.ndarray:
    """Indices of the blocks that take part in a mechanism, fastest first."""
    speed = np.abs(d.reshape(-1, 3)).max(axis=1)
    order = np.argsort(-speed, kind="stable")
    return order[speed[order] > 1e-3 * speed.max()]

"""Why there is no load factor: blocks that fall, or nothing that can move."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from masonry_opt.answer.certificate import finite, rates
from masonry_opt.answer.status import Status
from masonry_opt.effort import Stopwatch
from masonry_opt.problem.problem import Problem, ShearLimits, joint_rates
from masonry_opt.solvers.cvxpy_driver import driven_mechanism
from masonry_opt.solvers.driver import declare
from masonry_opt.solvers.lp import Answer, Outcome
from masonry_opt.solvers.registry import find_solver

#: Power of a bounded mechanism, in median block weights, below which nothing moves.
_NOTHING = 1e-7

#: Share of the largest (velocity or force) below which a joint has no part in locking.
_LITTLE = 1e-2


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


def locking_joints(problem: Problem, status: Status, q: np.ndarray | None) -> np.ndarray:
    """Indices of the joints that keep the live load from causing collapse, those that do most first.

    Locked by dilatancy: those that slide in the mechanism that the live load drives without
    dilatancy, and cannot open there as associative flow demands, by how much they cannot. Unlimited:
    those that carry the live load alone in a state of equilibrium with no more shear than the joints'
    own dilatancy allows (so that no mechanism lets it do work), by their normal force.
    Jammed: those whose normal force ``q`` grows with λ. Empty if the solver fails.
    """
    if status is Status.LOCKED:
        k = problem.sliding
        driven = driven_mechanism(
            problem,
            problem.live / problem.live_norm,
            ShearLimits(problem.dilatancy[k]),
            find_solver("cvxpy", "clarabel"),
            Stopwatch(),
        )
        if driven is None:
            return np.array([], dtype=int)
        u, slope = problem.B.T @ driven[1], finite(problem.friction)
        departure = u - joint_rates(problem, rates(problem, driven[1], problem.friction), slope)
        amount = np.where(np.abs(u[1::3]) > _LITTLE, np.abs(departure[0::3]), 0.0)
    elif status is Status.UNLIMITED:
        # The live load in place of the dead, scaled as the driven mechanism is.
        live_only = replace(problem.without_live_load(), dead=problem.live / problem.live_norm)
        limits = ShearLimits(problem.dilatancy[problem.sliding])
        solver = find_solver("cvxpy", "clarabel")
        answer = declare(live_only, "static", solver, Stopwatch(), limits).solve()
        if answer.state is None:
            return np.array([], dtype=int)
        amount = np.abs(answer.state.q[0::3])
    elif status is Status.JAMMED and q is not None:
        amount = q[0::3]
    else:
        return np.array([], dtype=int)
    order = np.argsort(-amount, kind="stable")
    return order[amount[order] > max(_LITTLE * amount.max(), _NOTHING)]


def moving_blocks(d: np.ndarray) -> np.ndarray:
    """Indices of the blocks that take part in a mechanism, fastest first."""
    speed = np.abs(d.reshape(-1, 3)).max(axis=1)
    order = np.argsort(-speed, kind="stable")
    return order[speed[order] > 1e-3 * speed.max()]

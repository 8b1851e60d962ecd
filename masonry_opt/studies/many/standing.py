"""Whether a scene stands under its dead load, and its margin of either sign."""

from dataclasses import replace
from math import inf
from typing import NamedTuple

import numpy as np

from masonry_opt.answer.acceptance import MARGIN_ENERGY, SMALLEST, Kind
from masonry_opt.answer.answer import Certificate, Found
from masonry_opt.answer.motion import moving_names
from masonry_opt.answer.reasons import Code, Status, reason
from masonry_opt.answer.solution import Solution
from masonry_opt.answer.thresholds import LOWER
from masonry_opt.effort import Effort
from masonry_opt.errors import NoLoadFactorError
from masonry_opt.methods.associative import associative
from masonry_opt.methods.task import Task
from masonry_opt.problem.assembly import assemble
from masonry_opt.problem.problem import Problem
from masonry_opt.result import Result, make_result
from masonry_opt.scene.scene import Scene
from masonry_opt.solvers.registry import Solver, find_solver
from masonry_opt.standing.diagnosis import DeadLoadUndecided, falling_mechanism
from masonry_opt.words.sentences import message


class DeadLoadMargin(NamedTuple):
    """How a scene stands under its dead load alone: the margin in median block weights, below zero where no
    state of equilibrium exists, with its residuals; and a result without a load factor, of the forces that
    carry the dead load, or the mechanism that it drives. Where there is no such number (joints that crush;
    blocks that wedge; smooth joints) it is inf if the scene stands, -inf if it falls, without residuals."""

    margin: float
    certificate: Certificate | None
    result: Result


def standing(scene: Scene) -> DeadLoadMargin:
    """How a scene stands under its dead load alone. Raises CaseError if the scene is wrong, NoLoadFactorError
    if it cannot be decided whether it stands.

    The margin is the load factor λ of a live load that takes a median block weight off the normal force of
    every joint: eq. (9) with the live load B e, where e has one in place of each normal force. It is the
    greatest amount by which all normal forces exceed what shear and moment need.
    """
    assembly, effort, solver = assemble(scene), Effort(), find_solver("cvxpy", None)
    problem, certificate = assembly.problem, None
    normal = np.zeros(problem.B.shape[1])  # one in place of each normal force
    problem.at_points(normal)[:] = 1 / problem.layout.points
    solution = _margin(replace(problem, live=problem.B @ normal), solver, effort)
    if solution is None or solution.answer is None:
        solution, d = Solution(Status.STANDS, Kind.ASSOCIATIVE), _falls(problem, solver, effort)
        margin, found = (inf, Found()) if d is None else (-inf, Found(d=d))
    else:
        answer = solution.answer
        margin, certificate = answer.load_factor + 0.0, answer.certificate
        stands = margin >= -LOWER
        found = Found(q=answer.q + margin * normal) if stands else Found(d=answer.d, slope=answer.slope)
    solution = replace(solution, status=Status.STANDS, found=found)
    if found.d is not None:
        solution = solution.ended(Status.UNSTABLE, Code.FALLS, blocks=moving_names(assembly, found.d))
    # The result has no load factor, and so no live load, tilt or published value.
    still = replace(problem, live=np.zeros_like(problem.live))
    dead = replace(assembly, problem=still, scene=scene.replace(tilt=None, reference={}))
    return DeadLoadMargin(margin, certificate, make_result(dead, solution, effort, "static", solver))


def _margin(pressed: Problem, solver: Solver, effort: Effort) -> Solution | None:
    """Eq. (9) with that live load; None without an answer, and for joints that more pressure would crush."""
    if len(pressed.crushing) or not pressed.live_norm:
        return None
    solution = associative(Task(pressed, solver, effort=effort))
    if solution.load_factor is None:
        return None
    # Complementarity is limited as a share of λ, but the margin may be zero, and the thrust of a long arch is
    # hundreds of block weights: here the energy itself is limited.
    failing = solution.failing()
    energy = failing.pop("complementarity", 0.0)
    gap = inf if energy is None else energy * max(abs(solution.load_factor), SMALLEST)
    return solution if not failing and gap <= MARGIN_ENERGY else None


def _falls(problem: Problem, solver: Solver, effort: Effort) -> np.ndarray | None:
    """The mechanism that the dead load drives; None if the scene stands."""
    try:
        return falling_mechanism(problem, solver, effort)
    except DeadLoadUndecided as stopped:
        why = message([reason(Code.DEAD_LOAD_UNDECIDED, **stopped.values)])
        raise NoLoadFactorError(f"{Status.SOLVER_FAILED}: {why}") from None

"""Whether a scene stands under its dead load, and with what margin, of either sign."""

from __future__ import annotations

from dataclasses import replace
from math import inf

import numpy as np

from masonry_opt.answer.acceptance import MARGIN_ENERGY, SMALLEST, Kind
from masonry_opt.answer.reasons import Code
from masonry_opt.answer.result import Result, make_result
from masonry_opt.answer.solution import Solution
from masonry_opt.answer.status import Status
from masonry_opt.effort import Effort
from masonry_opt.explain.diagnosis import DeadLoadUndecided, falling_mechanism
from masonry_opt.explain.no_load_factor import movers
from masonry_opt.explain.sentences import message, numeral
from masonry_opt.methods.associative import associative
from masonry_opt.methods.task import Task
from masonry_opt.problem.assembly import Assembly, assemble
from masonry_opt.problem.problem import Problem
from masonry_opt.report.summary import texts
from masonry_opt.scene.scene import Scene
from masonry_opt.solvers.registry import Solver, find_solver


def standing(scene: Scene) -> Result:
    """How a scene stands under its dead load alone; its live loads are left aside.

    The load factor of the result is a margin, in median block weights. Its live load takes one such weight
    off the normal force of every joint, as if all were pressed apart: with n = n' + λ and n' at yield,
    statics under the dead load are eq. (9) with the live load B e, where e is that normal force in every
    joint. So λ is the most by which all normal forces exceed what their shear and moment need. Positive, the
    scene stands with that margin; negative, no state of equilibrium exists, whatever the flow rule, and the
    mechanism is one that the dead load drives.

    Returns
    -------
    Result
        With the margin as load factor. Where there is none (joints that crush; blocks that wedge; smooth
        joints): "unstable under dead load", with the mechanism, or "stands under dead load"; "solver failed"
        if that could not be decided.

    Raises
    ------
    CaseError
        If the scene is wrong.
    """
    assembly, effort, solver = assemble(scene), Effort(), find_solver("cvxpy", None)
    pressed = replace(assembly, problem=_pressed_apart(assembly.problem))
    solution = _margin(pressed.problem, solver, effort)
    if solution is None:
        solution = _yes_or_no(assembly, solver, effort)
    return make_result(
        pressed,
        solution,
        effort,
        method="static",
        model=solver.language,
        solver=solver.name,
        message=message(solution.reasons),
    )


def under_dead_load(result: Result, stands: bool) -> Result:
    """What a result of :func:`standing` says of the dead load itself: the forces that carry it, or the
    mechanism that it drives. No load factor, which would be the margin, and no tilt or reference for one."""
    margin, found, problem = result.load_factor, result.solution, result.assembly.problem
    solution = replace(found, load_factor=None)
    assembly = replace(
        result.assembly,
        problem=replace(problem, live=np.zeros_like(problem.live)),
        scene=result.assembly.scene.model_copy(update={"tilt": None, "reference": {}}),
    )
    if margin is not None and stands:
        assert found.q is not None
        solution.status, solution.q, solution.d = Status.STANDS, found.q + margin * _of_normal(problem), None
    elif margin is not None:
        assert found.d is not None
        solution.q = None
        solution.end(Status.UNSTABLE, Code.FALLS, blocks=movers(assembly, found.d))
    effort = Effort()
    shown = make_result(
        assembly,
        solution,
        effort,
        method=result.method,
        model=result.model,
        solver=result.solver,
        message=message(solution.reasons),
    )
    shown = replace(shown, seconds=result.seconds, solvers=result.solvers, lp_solves=result.lp_solves)
    of_margin = "none" if margin is None else f"{numeral(margin, '.6g')} median block weights"
    said = f"{texts(shown)[0]}\n{'margin':<16} {of_margin}"
    return replace(shown, summary=said, details=said)


def _of_normal(problem: Problem) -> np.ndarray:
    """One in place of each normal force, shape (3c,)."""
    one = np.zeros(problem.B.shape[1])
    problem.normal_forces(one)[:] = 1.0
    return one


def _pressed_apart(problem: Problem) -> Problem:
    return replace(problem, live=problem.B @ _of_normal(problem))


def _margin(pressed: Problem, solver: Solver, effort: Effort) -> Solution | None:
    """Eq. (9) with that live load; None where it has no answer. (More pressure crushes joints of limited
    strength, so that no such margin says whether they hold.)"""
    if len(pressed.crushing) or not pressed.live_norm:
        return None
    solution = associative(Task(pressed, solver, effort=effort))
    if solution.load_factor is None:
        return None
    # Complementarity is limited as a share of λ, but the margin is zero where it matters, and the thrust of a
    # long arch hundreds of block weights: there the energy itself is.
    failing = solution.failing(pressed)
    energy = failing.pop("complementarity", 0.0)
    gap = inf if energy is None else energy * max(abs(solution.load_factor), SMALLEST)
    return solution if not failing and gap <= MARGIN_ENERGY else None


def _yes_or_no(assembly: Assembly, solver: Solver, effort: Effort) -> Solution:
    solution = Solution(Status.STANDS, Kind.ASSOCIATIVE)
    try:
        falling = falling_mechanism(assembly.problem, solver, effort)
    except DeadLoadUndecided as word:
        solution.end(Status.SOLVER_FAILED, Code.DEAD_LOAD_UNDECIDED, word=str(word))
        return solution
    if falling is not None:
        solution.d = falling
        solution.end(Status.UNSTABLE, Code.FALLS, blocks=movers(assembly, falling))
    return solution

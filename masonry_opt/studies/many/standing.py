"""Margin of a scene under its dead load alone: positive if the scene is stable, negative if unstable."""

from dataclasses import replace
from math import inf
from typing import NamedTuple

import numpy as np

from masonry_opt.effort import Effort
from masonry_opt.errors import NoLoadFactorError
from masonry_opt.methods.associative import associative
from masonry_opt.methods.registry import HowToSolve
from masonry_opt.methods.task import Task
from masonry_opt.problem.assembly import Assembly, assemble, on_matrices_of
from masonry_opt.problem.load_factor_scale import RELATIVE_ROUNDING
from masonry_opt.problem.problem import Problem
from masonry_opt.reporting.sentences import message
from masonry_opt.result import Result, make_result
from masonry_opt.scene.scene import Scene
from masonry_opt.solution.acceptance import MARGIN_ENERGY, Kind
from masonry_opt.solution.answer import Certificate, FinalState
from masonry_opt.solution.motion import moving_names
from masonry_opt.solution.reasons import Code, Status, reason
from masonry_opt.solution.solution import Solution
from masonry_opt.solvers.driver import ProgramCache
from masonry_opt.solvers.registry import Solver, find_solver
from masonry_opt.stability.dead_load import unit_pressure, with_pressure_removed
from masonry_opt.standing import DeadLoadCheck


class DeadLoadMargin(NamedTuple):
    """Margin of stability of a scene under its dead load alone.

    Some scenes have no finite margin, for example with joints that crush, blocks that wedge, or joints
    without friction. The margin is then inf if the scene is stable and -inf if it is unstable, without a
    certificate. It is also -inf if only self-stress between wedged blocks could carry the dead load: such
    self-stress does not arise from rest.
    """

    #: Largest force, in median block weights, by which every normal force can be reduced while the scene
    #: remains stable. It is negative if the scene is unstable.
    margin: float
    certificate: Certificate | None  #: residuals of the solution that determines the margin
    result: Result  #: result with the forces or the mechanism under dead load, without a load factor


def standing(scene: Scene, last: Assembly | None = None) -> DeadLoadMargin:
    """Return the margin of stability of a scene under its dead load alone.

    The margin is the load factor λ, by eq. (9), of a live load that reduces the normal force of every joint
    by a median block weight; see :func:`~masonry_opt.stability.dead_load.with_pressure_removed`.

    If the scene differs from the scene of the assembly ``last`` only in loads and joint properties, the
    matrices of ``last`` are reused.

    Raises CaseError if the scene is wrong, and NoLoadFactorError if its stability cannot be decided.
    """
    on_last_matrices = None if last is None else on_matrices_of(last, scene)
    assembly, effort, solver = on_last_matrices or assemble(scene), Effort(), find_solver("cvxpy", None)
    problem, certificate = assembly.problem, None
    solution = _margin(with_pressure_removed(problem), solver, effort)
    if solution is None or solution.answer is None:
        solution, d = Solution(Status.STABLE, Kind.ASSOCIATIVE), _falls(problem, solver, effort)
        margin, state = (inf, FinalState()) if d is None else (-inf, FinalState(d=d))
    else:
        answer = solution.answer
        margin, certificate = answer.load_factor + 0.0, answer.certificate
        stands = margin >= -RELATIVE_ROUNDING
        state = (
            FinalState(q=answer.q + margin * unit_pressure(problem))
            if stands
            else FinalState(d=answer.d, slope=answer.slope)
        )
    solution = replace(solution, status=Status.STABLE, state=state)
    if state.d is not None:
        solution = solution.ended(Status.UNSTABLE, Code.FALLS, blocks=moving_names(assembly, state.d))
    else:
        fallen = DeadLoadCheck(assembly, HowToSolve(), ProgramCache(), effort).fall_from_rest(effort)
        if fallen is not None:
            margin, certificate, solution = -inf, None, fallen
    # The result is for the dead load alone, so the live load, the tilt and the reference load factors are
    # removed.
    unloaded = replace(problem, live=np.zeros_like(problem.live))
    dead = replace(assembly, problem=unloaded, scene=scene.replace(tilt=None, reference={}))
    return DeadLoadMargin(margin, certificate, make_result(dead, solution, effort, "static", solver))


def _margin(pressed: Problem, solver: Solver, effort: Effort) -> Solution | None:
    """Return the solution whose λ is the margin of stability under the dead load.

    The live load of ``pressed`` reduces every normal force by a median block weight: see :func:`standing`.

    The static program, eq. (9) of the paper, is solved. None is returned if there is no acceptable answer, or
    if the strength of joints is limited, because a larger normal force may then crush them.
    """
    if len(pressed.crushing) or not pressed.live_norm:
        return None
    solution = associative(Task(pressed, solver, effort=effort))
    if solution.load_factor is None:
        return None
    failing = solution.failing()
    # The complementarity error is an energy divided by λ. Here λ is the margin, which may be zero, so the
    # energy itself is compared with its limit.
    energy = failing.pop("complementarity", 0.0)
    divisor = pressed.load_factor_scale.divisor(solution.load_factor)
    gap = inf if energy is None else energy * divisor
    return solution if not failing and gap <= MARGIN_ENERGY else None


def _falls(problem: Problem, solver: Solver, effort: Effort) -> np.ndarray | None:
    """Return a mechanism, shape (3b,), that the dead load drives, or None if the scene is stable.

    Raises NoLoadFactorError if the stability cannot be decided.
    """
    # The import is local, because it loads CVXPY, which takes a second. Only the few scenes without a finite
    # margin need it.
    from masonry_opt.stability.diagnosis import DeadLoadUndecided, falling_mechanism

    try:
        return falling_mechanism(problem, solver, effort)
    except DeadLoadUndecided as stopped:
        why = message([reason(Code.DEAD_LOAD_UNDECIDED, **stopped.values)])
        raise NoLoadFactorError(f"{Status.SOLVER_FAILED}: {why}") from None

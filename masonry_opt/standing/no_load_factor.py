"""Reasons why an analysis ended without a load factor, with the names of blocks and joints."""

from __future__ import annotations

import numpy as np

from masonry_opt.answer.infeasibility import Existence
from masonry_opt.answer.motion import moving_blocks
from masonry_opt.answer.reasons import Code, reason
from masonry_opt.answer.solution import Solution
from masonry_opt.answer.status import Status
from masonry_opt.effort import Effort
from masonry_opt.problem.assembly import Assembly
from masonry_opt.solvers.registry import Solver
from masonry_opt.standing.diagnosis import locking_joints
from masonry_opt.standing.existence import existence


def held_by_wedging(assembly: Assembly, solution: Solution) -> None:
    """Withdraw a load factor below zero: the scene has a state of equilibrium at λ = 0 by wedging alone."""
    moving = [] if solution.d is None else movers(assembly, solution.d)
    solution.withdraw(Status.UNSTABLE, Code.WEDGED, blocks=moving)


def settle_existence(assembly: Assembly, solution: Solution, effort: Effort, associative: bool) -> None:
    """Prove, as far as possible, that the load factor that a method did not find does not exist."""
    if solution.infeasibility is None:
        solution.infeasibility = existence(assembly.problem, effort, of_mechanism=not associative)
    if associative:
        return
    _settle(solution)
    undecided = solution.status is not Status.UNSTABLE and not solution.proven_none
    if undecided and solution.associative is not None:
        solution.add(Code.AT_MOST, associative=solution.associative)
    clamped = solution.infeasibility.clamped if solution.infeasibility else ()
    if clamped:
        solution.add(Code.CLAMPED, pairs=assembly.pairs(np.array(clamped)))


def _settle(solution: Solution) -> None:
    """Set status and reasons to what is proven, unless the scene does not stand."""
    found = solution.infeasibility
    if found is None or solution.status is Status.UNSTABLE:
        return
    if found.existence is Existence.NO_MECHANISM and solution.status is not Status.UNLIMITED:
        solution.status = Status.UNLIMITED
        solution.reasons.insert(0, reason(Code.NO_MECHANISM))
    elif found.existence is Existence.NO_STATE:
        if found.equilibrium is not None:
            solution.status = Status.JAMMED
        counts = {"static_cuts": found.static_cuts, "kinematic_cuts": found.kinematic_cuts}
        solution.reasons.insert(0, reason(Code.NO_COLLAPSE, **counts))
    elif found.existence is Existence.UNBOUNDED:
        solution.add(Code.CARRIES_ANY)


def name_locking_joints(assembly: Assembly, solution: Solution, solver: Solver) -> None:
    """Add to the reasons for an unlimited load factor the joints that make it so."""
    found = locking_joints(assembly.problem, solution.status, solution.q, solver, Effort())
    if len(found) == 0:
        return
    solution.add(Code.JOINTS, status=str(solution.status), pairs=assembly.pairs(found))


def movers(assembly: Assembly, d: np.ndarray) -> list[str]:
    """Names of the blocks that a mechanism moves."""
    return assembly.names(assembly.movable[moving_blocks(assembly, d)])

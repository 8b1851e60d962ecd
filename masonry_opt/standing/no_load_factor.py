"""Reasons why an analysis ended without a load factor, with the names of blocks and joints."""

from __future__ import annotations

import numpy as np

from masonry_opt.answer.infeasibility import Existence, InfeasibilityCertificate
from masonry_opt.answer.motion import moving_names
from masonry_opt.answer.reasons import Code, reason
from masonry_opt.answer.solution import Solution
from masonry_opt.answer.status import Status
from masonry_opt.effort import Effort
from masonry_opt.problem.assembly import Assembly
from masonry_opt.solvers.registry import Solver
from masonry_opt.standing.diagnosis import locking_joints
from masonry_opt.standing.existence import existence


def explain(
    assembly: Assembly, solution: Solution, solver: Solver, effort: Effort, associative: bool
) -> None:
    """Set status and reasons of a solution without a load factor: that none exists is proven as far as
    possible, and the joints that carry the load are named."""
    if solution.infeasibility is None:
        if solution.associative is None or associative:
            solution.infeasibility = existence(assembly.problem, effort, of_mechanism=not associative)
        else:  # statics are bounded
            solution.infeasibility = InfeasibilityCertificate(Existence.UNDECIDED)
    if not associative:
        if solution.status is not Status.UNSTABLE:
            _settle(solution)
        if solution.infeasibility and solution.infeasibility.clamped:
            solution.add(Code.CLAMPED, pairs=assembly.pairs(np.array(solution.infeasibility.clamped)))
    locking = locking_joints(assembly.problem, solution.status, solution.q, solver, Effort())
    if len(locking):
        solution.add(Code.JOINTS, status=str(solution.status), pairs=assembly.pairs(locking))


def withdraw(assembly: Assembly, solution: Solution, rests: bool) -> None:
    """Withdraw a load factor below zero, or of a scene that does not carry its dead load from rest: ``rests``
    tells whether it does, and would fall with the forces found alone, or is held by wedging alone."""
    if rests:
        solution.withdraw(Status.SOLVER_FAILED, Code.BELOW_ZERO)
    else:
        moving = [] if solution.d is None else moving_names(assembly, solution.d)
        solution.withdraw(Status.UNSTABLE, Code.WEDGED, blocks=moving)


def _settle(solution: Solution) -> None:
    """Set status and reasons to what is proven; the associative load factor bounds what is not."""
    found = solution.infeasibility
    if found is None:
        pass
    elif found.existence is Existence.NO_MECHANISM and solution.status is not Status.UNLIMITED:
        solution.status = Status.UNLIMITED
        solution.reasons.insert(0, reason(Code.NO_MECHANISM))
    elif found.existence is Existence.NO_STATE:
        if found.equilibrium is not None:
            solution.status = Status.JAMMED
        counts = {"static_cuts": found.static_cuts, "kinematic_cuts": found.kinematic_cuts}
        solution.reasons.insert(0, reason(Code.NO_COLLAPSE, **counts))
    elif found.existence is Existence.UNBOUNDED:
        solution.add(Code.CARRIES_ANY)
    if not solution.proven_none and solution.associative is not None:
        solution.add(Code.AT_MOST, associative=solution.associative)

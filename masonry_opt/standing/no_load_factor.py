"""Reasons why an analysis ended without a load factor, with the names of blocks and joints."""

from __future__ import annotations

from dataclasses import replace

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


def explained(
    assembly: Assembly, solution: Solution, solver: Solver, effort: Effort, associative: bool
) -> Solution:
    """A solution without a load factor, with status and reasons: that none exists is proven as far as
    possible, and the joints that carry the load are named."""
    found = solution.infeasibility
    if found is None:
        if solution.associative is None or associative:
            found = existence(assembly.problem, effort, of_mechanism=not associative)
        else:  # statics are bounded
            found = InfeasibilityCertificate(Existence.UNDECIDED)
        solution = replace(solution, infeasibility=found)
    if not associative:
        if solution.status is not Status.UNSTABLE:
            solution = _as_proven(solution)
        if found and found.clamped:
            solution = solution.telling(reason(Code.CLAMPED, pairs=assembly.pairs(np.array(found.clamped))))
    locking = locking_joints(assembly.problem, solution.status, solution.q, solver, Effort())
    if not len(locking):
        return solution
    return solution.telling(reason(Code.JOINTS, status=str(solution.status), pairs=assembly.pairs(locking)))


def withdrawn(assembly: Assembly, solution: Solution, rests: bool) -> Solution:
    """A solution without its load factor, which is below zero, or of a scene that does not carry its dead
    load from rest: ``rests`` tells whether it does, and would fall with the forces found alone, or is held by
    wedging alone."""
    if rests:
        # The way to a ray below zero may lead over a load that the scene carries.
        rays = [said for said in solution.reasons if said.code is Code.RAY and said.values["peak"]]
        return solution.withdrawn(Status.SOLVER_FAILED, Code.BELOW_ZERO).telling(*rays)
    moving = [] if solution.d is None else moving_names(assembly, solution.d)
    return solution.withdrawn(Status.UNSTABLE, Code.WEDGED, blocks=moving)


def _as_proven(solution: Solution) -> Solution:
    """A solution with what is proven as status and reasons; the associative load factor bounds the rest."""
    found = solution.infeasibility
    if found is None:
        pass
    elif found.existence is Existence.NO_MECHANISM and solution.status is not Status.UNLIMITED:
        solution = replace(solution, status=Status.UNLIMITED).telling_first(reason(Code.NO_MECHANISM))
    elif found.existence is Existence.NO_STATE:
        counts = {"static_cuts": found.static_cuts, "kinematic_cuts": found.kinematic_cuts}
        status = solution.status if found.equilibrium is None else Status.JAMMED
        solution = replace(solution, status=status).telling_first(reason(Code.NO_COLLAPSE, **counts))
    elif found.existence is Existence.UNBOUNDED:
        solution = solution.telling(reason(Code.CARRIES_ANY))
    if solution.proven_none or solution.associative is None:
        return solution
    return solution.telling(reason(Code.AT_MOST, associative=solution.associative))

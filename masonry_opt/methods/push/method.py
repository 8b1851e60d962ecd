"""The load to expect by the push: λ at the ray that proves it, or that friction jams."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

from masonry_opt.answer.acceptance import Kind
from masonry_opt.answer.answer import certified
from masonry_opt.answer.reasons import Code
from masonry_opt.answer.solution import GivingState, Solution
from masonry_opt.answer.status import Status
from masonry_opt.answer.thresholds import PLATEAU, ZERO
from masonry_opt.methods.push.laws import takes
from masonry_opt.methods.push.push import Ended, Pushed, push, push_on
from masonry_opt.methods.task import Task
from masonry_opt.problem.problem import Problem
from masonry_opt.standing.weightless import weightless

#: Joints up to which a path is followed from event to event: beyond, passes come near its end sooner. Of a
#: joint so many events at most: on rubble of 60 and 120 stones there are 3 to 11, on walls 2 to 4.
PATH_UP_TO, EVENTS_A_JOINT = 500, 25

#: The same from the state of a pass on: of rubble of 200 stones there are no events, of a façade of 1 × 3
#: openings 59. On façades of 2 × 6 its cell is not found.
ON_UP_TO, EVENTS_ON = 3000, 200


def by_push(task: Task) -> Solution | None:
    """The exact state at the ray that a path from rest ends in, or that none does, for λ grows without end on
    it; None where the path is not followed, or to no such end."""
    problem, effort = task.problem, task.effort
    if problem.joints > PATH_UP_TO or not takes(problem):
        return None
    effort.begins("pushed from rest")
    effort.uses(task.solver.name, "complementarity problem")
    with effort.measure("solve"):
        found = push(problem, EVENTS_A_JOINT * problem.joints)
    return _ending(task, found)


def goes_on(problem: Problem) -> bool:
    """Whether a path is followed from the state of a pass on, where the way from rest is long."""
    return problem.joints <= ON_UP_TO and takes(problem)


def by_events_from(task: Task, state: GivingState) -> Solution | None:
    """The exact state at the ray that the path from a state of contacts that give ends in, if it does. It may
    not be where the path from rest leads."""
    task.effort.begins("pushed on")
    with task.effort.measure("solve"):
        found = push_on(task.problem, state, EVENTS_ON)
    return None if found.ended is Ended.JAM else _ending(task, found)


def _ending(task: Task, found: Pushed) -> Solution | None:
    """The solution that a push ends in, if it is one."""
    problem, effort = task.problem, task.effort
    events = (*found.settling, *found.events)
    ending = Solution(Status.SOLVER_FAILED, Kind.COMPLIANT, history=events, solver=task.solver)
    if found.ended is Ended.JAM:
        effort.iterations += len(events)
        return ending.ended(Status.SOLVER_FAILED, Code.JAMS, **_told(found))
    if found.load_factor is None or found.q is None or found.d is None or found.ended is not Ended.RAY:
        return None
    answer = certified(problem, found.load_factor, found.q, found.d)
    if not answer.exact or weightless(problem, answer.load_factor, answer.d):
        return None
    effort.iterations += len(events)
    return replace(ending, found=answer).ended(Status.CONVERGED, Code.RAY, **_told(found))


def _told(found: Pushed) -> dict[str, Any]:
    """The number of events and folds, the highest load factor on the path, where that is higher, a deep fall
    before, and the displacement from which it was followed, 0 at rest."""
    peak, end = found.peak or 0.0, found.load_factor
    higher = end is not None and peak > end * (1 + PLATEAU) + ZERO
    told = {"peak": peak if higher else None, "deep_fall": found.deep_fall, "begun": found.begun}
    return told | {"events": len(found.settling) + len(found.events), "folds": found.folds}

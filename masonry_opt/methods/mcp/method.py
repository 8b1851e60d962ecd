"""Method "mcp": an exact state of Coulomb friction next to the load to expect, the lowest of a few."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Annotated

from pydantic import Strict

from masonry_opt.answer.acceptance import Kind
from masonry_opt.answer.answer import Answer
from masonry_opt.answer.infeasibility import Existence
from masonry_opt.answer.reasons import Code, reason
from masonry_opt.answer.solution import Solution
from masonry_opt.answer.status import Status
from masonry_opt.methods.exact.alternation import alternated
from masonry_opt.methods.exact.refiner import ExactState, refiner_of
from masonry_opt.methods.exact.search import SMALL, Met, Search, lower_of
from masonry_opt.methods.loop.nonassociative import nonassociative
from masonry_opt.methods.loop.options import LoopOptions
from masonry_opt.methods.mcp.compliant import jams, pushed
from masonry_opt.methods.mcp.passes import Passes, follow, prepared
from masonry_opt.methods.mcp.schedule import BRAKES
from masonry_opt.methods.task import Options, Task
from masonry_opt.problem.state import State
from masonry_opt.solvers.registry import find_solver

#: Joints up to which simplex makes states exact and descends: beyond, it takes longer than all else.
_SIMPLEX_UP_TO = 500


class McpOptions(Options):
    """Options of the default method.

    Attributes
    ----------
    descent: whether, on scenes of up to 500 joints, lower states are sought, and on small ones further starts
        are tried; else the first state will do.
    """

    descent: Annotated[bool, Strict()] = True


def mcp(task: Task) -> Solution:
    """Load factor of an exact state that forces under contacts that give lead to, on small scenes the lowest
    of several; where they lead to none, of one that those of a pass with rigid contacts lead to.

    Where these lead to none either, a proof is sought that there is none, and on small scenes further starts
    are tried. Dilatancy that falls with stress is for the loop.
    """
    problem, effort, options = task.problem, task.effort, task.options or McpOptions()
    if problem.dilatancy_depends_on_stress:
        solution = nonassociative(task.with_options(LoopOptions(), find_solver("cvxpy", None)))
        solution.reasons.insert(0, reason(Code.DILATANCY_FALLS))
        return solution
    # The passes of the load to expect are the first of this method.
    history = list(task.expected.history) if task.expected else []
    effort.iterations += len(history)
    for step in history:
        task.progress(step)
    solution = Solution(Status.SOLVER_FAILED, Kind.EXACT, history=history)
    passes = prepared(task)
    search = None
    if problem.joints <= _SIMPLEX_UP_TO:
        search = Search(refiner_of(task), passes.over, Met())
    lowest: ExactState | None = None
    answer: Answer | None = None
    first: Answer | State | None = None
    for start in _starts(task, passes, solution):
        first = first or start
        effort.begins("exact states nearby")
        lowest = search.start(start.q).state if search else None
        answer = lowest.answer if lowest else alternated(problem, start.load_factor, start.q, effort)
        if answer is not None:
            break
    if solution.proven_none:
        solution.end(Status.SOLVER_FAILED, Code.PASS_LOST)
        return solution
    if search and options.descent and problem.joints <= SMALL:
        for candidate in search.few(lowest, first.q if first else None):
            lowest = lower_of(lowest, candidate.state)
        answer = lowest.answer if lowest else answer
    if answer is None:
        endless = solution.infeasibility and solution.infeasibility.existence is Existence.UNBOUNDED
        if endless and (grows := jams(task)):
            # Not proven; but from rest no multiple of the load brings the blocks down.
            solution.status, solution.reasons = Status.JAMMED, [grows]
            return solution
        attempts = len({step.attempt for step in solution.history})
        solution.end(Status.SOLVER_FAILED, Code.PASS_STOPPED, word=str(passes.outcome), attempts=attempts)
        return solution
    solution.found = answer
    steps, attempt = len(solution.history), max(step.attempt for step in solution.history)
    solution.end(Status.CONVERGED, Code.ONE_PASS, steps=steps, attempt=attempt)
    if answer.failing(Kind.EXACT):
        solution.kind = Kind.ONE_PASS
    else:
        solution.add(Code.EXACT, fall=first.load_factor - answer.load_factor if first else None)
    if search and search.met.load_factors:
        solution.reasons.append(search.met.reason)
    return solution


def _starts(task: Task, passes: Passes, solution: Solution) -> Iterator[Answer | State]:
    """Forces under contacts that give, then those of passes with rigid ones, of those that end; without any
    proof that there is no load factor, which is sought after the first of these."""
    effort, history = task.effort, solution.history
    effort.begins("contacts that give")
    given = task.expected.answer if task.expected else pushed(task, history)
    if given is not None:
        yield given
    attempt = history[-1].attempt if history else 0
    for brake in BRAKES:
        effort.begins("rigid contacts")
        attempt += 1
        if last := follow(task, passes, history, attempt, brake):
            yield last
        if brake == BRAKES[0]:
            # Declared in Pyomo, which takes .3 s to import.
            from masonry_opt.standing.existence import existence

            solution.infeasibility = existence(task.problem, effort)
            if solution.proven_none or task.problem.joints <= SMALL:
                return

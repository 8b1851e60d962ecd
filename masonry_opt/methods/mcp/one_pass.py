"""Method "mcp": passes by one set of rules after another, and the loop where none ends."""

from __future__ import annotations

from dataclasses import replace
from math import inf
from typing import Annotated, Any

from pydantic import Strict

from masonry_opt.answer.acceptance import Kind
from masonry_opt.answer.answer import Answer, certified
from masonry_opt.answer.reasons import Code, reason
from masonry_opt.answer.solution import Solution
from masonry_opt.answer.status import Status
from masonry_opt.answer.thresholds import same
from masonry_opt.effort import Effort
from masonry_opt.methods.exact.energy import motion_for
from masonry_opt.methods.exact.refiner import ExactState, refiner_of
from masonry_opt.methods.exact.search import SMALL, Met, Search, lower_of
from masonry_opt.methods.loop.exact_end import rough_end
from masonry_opt.methods.loop.nonassociative import nonassociative
from masonry_opt.methods.loop.options import LoopOptions
from masonry_opt.methods.loop.run import Iteration
from masonry_opt.methods.mcp.interior_point import Outcome
from masonry_opt.methods.mcp.passes import NEAR, Passes, follow, prepared
from masonry_opt.methods.mcp.rules import (
    ATTEMPTS,
    DESCENT_UP_TO,
    FAR,
    NEARLY,
    OF_LARGE,
    PASSES_UP_TO,
    Rules,
)
from masonry_opt.methods.task import Options, Task
from masonry_opt.problem.load_units import in_units_of_load
from masonry_opt.problem.problem import Problem
from masonry_opt.problem.state import State
from masonry_opt.solvers.registry import find_solver


class McpOptions(Options):
    """Options of the one pass.

    Attributes
    ----------
    fallback: whether the loop takes over where no pass ends in a state, and begins above 8000 joints.
        (Dilatancy that falls with stress is for the loop all the same.)
    descent: whether the lowest of a few exact states is sought, as by "refined" without search (up to 500
        joints).
    """

    fallback: Annotated[bool, Strict()] = True
    descent: Annotated[bool, Strict()] = True


def mcp(task: Task) -> Solution:
    """Load factor with the joints' own flow rule, from one interior-point pass, and on small scenes the
    lowest of a few exact states, where one is as low or the pass's state is not exact.

    Where a pass stalls another follows, by the next of the rules; where one grows without end, or none ends
    in a state that its certificate bears out, other starts are tried on small scenes, then the loop takes
    over, and the reasons say so. Dilatancy that falls with stress, and scenes of more than 8000 joints, are
    for the loop at once; of the latter a pass takes over where the loop's first sub-problems stay far from
    the true law.
    """
    problem, effort, options = task.problem, task.effort, task.options or McpOptions()
    if problem.dilatancy_depends_on_stress:
        return _by_loop(task, Solution(Status.SOLVER_FAILED, Kind.ONE_PASS), Code.DILATANCY_FALLS)
    if problem.joints > PASSES_UP_TO and options.fallback:
        return _large(task)
    solution = Solution(Status.SOLVER_FAILED, Kind.ONE_PASS)
    passes = prepared(task)
    for attempt, rules in enumerate(ATTEMPTS, start=1):
        last = _run(task, passes, rules, solution, attempt)
        answer = None if last is None else _exact(problem, last, effort)
        if answer is not None:
            solution.found = answer
            solution.end(Status.CONVERGED, Code.ONE_PASS, steps=len(solution.history), attempt=attempt)
            if options.descent and problem.joints <= DESCENT_UP_TO:
                return _descended(task, passes, solution)
            return solution
        if passes.outcome is Outcome.LOST:
            # Declared in Pyomo, which takes .3 s to import.
            from masonry_opt.standing.existence import existence

            solution.infeasibility = existence(problem, effort)
            if solution.proven_none:
                solution.end(Status.SOLVER_FAILED, Code.PASS_LOST)
                return solution
            break
    word = "its certificate failed" if passes.outcome is Outcome.SOLVED else str(passes.outcome)
    if options.descent and problem.joints <= SMALL:
        found = _descended(task, passes, solution)
        if found is not solution:
            found.status = Status.CONVERGED
            found.reasons.insert(0, reason(Code.OTHER_STARTS, word=word))
            return found
    if options.fallback:
        return _by_loop(task, solution, Code.LOOP_TOOK_OVER, word=word)
    solution.end(Status.SOLVER_FAILED, Code.PASS_STOPPED, word=word, attempts=attempt)
    return solution


def _run(
    task: Task, passes: Passes, rules: Rules, solution: Solution, attempt: int = 1, near: float = NEAR
) -> State | None:
    """What a pass ends in, its steps told and recorded."""
    task.effort.begins(f"pass {attempt}")
    return follow(task, passes, rules, solution.history, attempt, near)


class _FarError(Exception):
    """The loop's sub-problems are far from the true law."""


def _large(task: Task) -> Solution:
    """The loop's solution; a pass's where the loop's first sub-problems are far from the true law and the
    pass comes near a state."""
    problem, effort, off = task.problem, task.effort, 0.0
    solution = Solution(Status.SOLVER_FAILED, Kind.ONE_PASS)
    first: list[Iteration] = []

    def watch(step: Iteration) -> None:
        task.progress(step)
        first.append(replace(step, solved=None))
        if step.attempt == 1 and step.mismatch > FAR.get(step.iteration, inf) * abs(step.load_factor):
            raise _FarError

    try:
        return _by_loop(replace(task, progress=watch), solution, Code.TOO_LARGE, joints=problem.joints)
    except _FarError:
        solution.history, solution.associative = [*first], first[0].load_factor
        off = first[-1].mismatch / abs(first[-1].load_factor)
    passes = prepared(task)
    last = _run(task, passes, OF_LARGE, solution, near=NEARLY)
    steps = len(solution.history) - len(first)
    if last is not None and passes.gap <= NEAR and (answer := _exact(problem, last, effort)):
        solution.found = answer
        solution.end(Status.CONVERGED, Code.ONE_PASS, steps=steps, attempt=1)
    elif last is not None and (end := _exact_forces(problem, last, effort)):
        solution.kind, solution.exact_end, solution.found = Kind.LOOP, True, end
        solution.end(Status.CONVERGED, Code.PASS_NEAR, steps=steps, gap=passes.gap)
    else:
        return _by_loop(task, solution, Code.LOOP_TOOK_OVER, word=str(passes.outcome))
    solution.reasons.insert(0, reason(Code.LOOP_FAR, joints=problem.joints, count=len(first), off=off))
    return solution


def _exact_forces(problem: Problem, state: State, effort: Effort) -> Answer | None:
    """Exact forces and a mechanism near a state that is not exact."""
    effort.begins("exact forces")
    return rough_end(problem, state, find_solver("cvxpy", None), effort)


def _exact(problem: Problem, state: State, effort: Effort) -> Answer | None:
    """The state if it is exact; else its forces with the motion that leaves least energy for them."""
    answer = certified(problem, state.load_factor, state.q, state.d)
    if not answer.failing(Kind.ONE_PASS):
        return answer
    effort.begins("exact motion")
    scaled = in_units_of_load(problem)
    d = motion_for(scaled, state.q / scaled.force, find_solver("cvxpy", None), effort, "motion")
    if d is None:
        return None
    answer = certified(problem, state.load_factor, state.q, d)
    return None if answer.failing(Kind.ONE_PASS) else answer


def _descended(task: Task, passes: Passes, solution: Solution) -> Solution:
    """The lowest of a few exact states that a pass's forces, if it ended in any, lead to, if it is as low,
    else the pass's; but for a pass's that is not exact itself any exact state will do: there need be none as
    low."""
    met = Met()
    task.effort.begins("exact states nearby")
    exact: ExactState | None = None
    for candidate in Search(refiner_of(task), passes.over, met).few(solution.q):
        exact = lower_of(exact, candidate.state)
    if exact is None or exact.answer is None:
        return solution
    fall, passed = None, solution.answer
    if passed is not None:
        fall = passed.load_factor - exact.load_factor
        higher = fall < 0 and not same(exact.load_factor, passed.load_factor)
        if higher and not passed.failing(Kind.EXACT):
            return solution
    return replace(
        solution,
        kind=Kind.EXACT,
        found=exact.answer,
        reasons=[*solution.reasons, reason(Code.EXACT, fall=fall), met.reason],
    )


def _by_loop(task: Task, before: Solution, code: Code, **values: Any) -> Solution:
    """The loop's solution, which tells that it took over; the passes' steps come first in the history."""
    solution = nonassociative(task.with_options(LoopOptions(), find_solver("cvxpy", None)))
    solution.reasons.insert(0, reason(code, **values))
    solution.history = [*before.history, *solution.history]
    solution.infeasibility = before.infeasibility
    return solution

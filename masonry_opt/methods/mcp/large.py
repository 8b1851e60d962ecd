"""Large scenes: the loop, which ends soonest on façades, unless it stays far from the true law."""

from __future__ import annotations

from dataclasses import replace
from math import inf

from masonry_opt.answer.reasons import Code, Reason, reason, size_of
from masonry_opt.answer.solution import Solution
from masonry_opt.methods.loop.nonassociative import nonassociative
from masonry_opt.methods.loop.options import LoopOptions
from masonry_opt.methods.loop.run import Iteration
from masonry_opt.methods.task import Task
from masonry_opt.solvers.registry import find_solver

#: By number of the loop's sub-problem, energy by which its sliding joints are off the true law, over λ, from
#: which on passes take a scene over. Façades of up to 10 × 30 openings leave 0.04, and end after eight at
#: most; solid walls of 5,000 blocks leave 0.05 and 0.16, and end after 46; of 10,000 blocks 0.10, and are
#: farther off after fourteen.
_FAR = {2: 0.07, 12: 0.12}


class _FarError(Exception):
    """The loop's sub-problems are far from the true law."""


def by_loop(task: Task, code: Code) -> Solution:
    """The loop's solution; the code, with the number of joints, tells why it was asked."""
    solution = nonassociative(task.with_options(LoopOptions(), find_solver("cvxpy", None)))
    return solution.telling_first(reason(code, **size_of(task.problem)))


def by_loop_unless_far(task: Task) -> Solution | Reason:
    """The same of a large scene, or the reason why the loop was left."""
    last: Iteration | None = None

    def watch(step: Iteration) -> None:
        nonlocal last
        last = step
        task.progress(step)
        far = _FAR.get(step.iteration, inf) if step.attempt == 1 else inf
        if step.mismatch > far * abs(step.load_factor):
            raise _FarError

    try:
        return by_loop(replace(task, progress=watch), Code.TOO_LARGE)
    except _FarError:
        assert last is not None
        off = last.mismatch / abs(last.load_factor)
        return reason(Code.LOOP_FAR, **size_of(task.problem), count=last.iteration, off=off)

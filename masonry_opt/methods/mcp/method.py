"""Method "mcp", the default: a list of steps that look for the lowest exact collapse state.

The steps run in the order of ``STEPS``. Each runs if it applies to what the steps before it found, and leaves
a record with its result and its time in the log of the solution. See :mod:`~masonry_opt.methods.mcp.steps`.
"""

import time
from dataclasses import replace
from typing import Annotated

from pydantic import Strict

from masonry_opt.answer.acceptance import Kind
from masonry_opt.answer.reasons import Status
from masonry_opt.answer.solution import LogEntry, Solution
from masonry_opt.methods.mcp.run import CoulombRun
from masonry_opt.methods.mcp.steps import ExactFrom, FurtherStarts, Incremental, Loop, Step
from masonry_opt.methods.task import Options, Task

#: Steps of the default method, in order.
STEPS: tuple[Step, ...] = (
    Incremental(),
    ExactFrom("incremental"),
    ExactFrom("associative"),
    FurtherStarts(),
    Loop(),
)


class McpOptions(Options):
    """Options of the default method.

    Attributes
    ----------
    descent: whether lower states are sought, in the plane on scenes of up to 500 joints. On small scenes in
        the plane, and in space, further starts are tried too. Without descent the first exact state is the
        answer.
    """

    descent: Annotated[bool, Strict()] = True


def mcp(task: Task) -> Solution:
    """Return an exact collapse state near the end of a load history, on small scenes the lowest of several.

    The loop solves scenes of more than 3000 joints (in space contact points), scenes whose dilatancy falls
    with stress, and scenes that stand from rest on which no exact state is found.
    """
    options = task.options or McpOptions()
    run = CoulombRun(task, options.descent)
    log: list[LogEntry] = []
    for step in STEPS:
        if run.ended is not None or not step.applies(run):
            continue
        began = time.perf_counter()
        step.run(run)
        seconds = time.perf_counter() - began
        log.append(LogEntry(step.name, run.load_factor, run.exact_states, seconds))
    return replace(_solution(run), log=tuple(log))


def _solution(run: CoulombRun) -> Solution:
    """Return how the steps ended: the end of a step, or else the lowest state."""
    if run.ended is not None:
        return run.ended
    solution = run.recorded(Status.CONVERGED)
    if solution.is_exact(run.problem):
        return solution
    return replace(solution, kind=Kind.NEARLY_COMPLEMENTARY)

"""Method "coulomb", the default: a list of steps that look for the lowest exact collapse state.

The steps run in the order of ``STEPS``. Depending on the results so far, a step may be skipped. The log of
the solution records the result and the time of each step. See :mod:`~.coulomb.steps`. With the option
``search`` the method then looks for lower states (:mod:`~.coulomb.search`).
"""

import time
from dataclasses import replace
from typing import Annotated, Any

from pydantic import Field, InstanceOf, Strict, field_validator, model_validator

from masonry_opt.deadline import TimeLimitReached
from masonry_opt.errors import OptionError
from masonry_opt.methods.bounds.settings import BUDGET, ProofBudget
from masonry_opt.methods.coulomb.run import CoulombRun
from masonry_opt.methods.coulomb.search import SearchLimits, search_lower
from masonry_opt.methods.coulomb.steps import (
    CoulombStep,
    ExactFrom,
    FurtherStarts,
    Incremental,
    LeastProven,
    Loop,
)
from masonry_opt.methods.exact.settings import SEARCH, SearchSettings
from masonry_opt.methods.task import Options, Task, of_same_scene
from masonry_opt.solution.acceptance import Kind
from masonry_opt.solution.reasons import Code, Status
from masonry_opt.solution.solution import LogEntry, Solution
from masonry_opt.solution.stopped import with_answer

#: Steps of the default method, in order.
STEPS: tuple[CoulombStep, ...] = (
    Incremental(),
    ExactFrom("incremental"),
    ExactFrom("associative"),
    LeastProven(),
    FurtherStarts(),
    Loop(),
)

_SEARCH = "search for lower states"  #: Name of the search in the log of a solution


class CoulombOptions(Options):
    """Options of the default method.

    Attributes
    ----------
    descent: True to look for states with a lower load factor, in the plane on scenes of up to 500 joints. On
        small scenes in the plane, and in space, further starts are tried too. If False, the first exact state
        is the answer. The options ``search`` and ``start`` look for lower states in any case.
    search: time in seconds of a further search for lower states, from other starts and near the lowest state
        so far. On small scenes in the plane the search alternates with the search for a proof, and ends when
        a proof shows that no state is lower.
    until: load factor at or below which the search ends early.
    seed: seed of the random numbers of the search. One seed always leads to the same states in the same
        order; the time determines how many of them are reached.
    start: result of the same scene from which the method starts, instead of the steps before the search. If
        ``search`` is None, only the exact state near its forces is looked for. Only Python can pass a result.
    settings: numbers that control the search for exact states, as :class:`~masonry_opt.SearchSettings`. Only
        Python can pass them. The load history always has the default settings.
    budget: numbers that limit the proof that no state is lower, as :class:`~masonry_opt.ProofBudget`. Only
        Python can pass them.
    """

    descent: Annotated[bool, Strict()] = True
    search: Annotated[float, Strict(), Field(gt=0, le=1e6)] | None = None
    until: Annotated[float, Strict()] | None = None
    seed: Annotated[int, Strict(), Field(ge=0)] = 0
    start: InstanceOf[Solution] | None = None
    settings: InstanceOf[SearchSettings] = SEARCH
    budget: InstanceOf[ProofBudget] = BUDGET

    @model_validator(mode="after")
    def _ends_a_search(self) -> "CoulombOptions":
        if self.until is not None and self.search is None:
            raise ValueError(
                "'until' only ends a search early: also set option 'search' to a time limit in seconds"
            )
        return self

    @field_validator("start", mode="before")
    @classmethod
    def _is_a_result(cls, start: Any) -> Any:
        if start is None or isinstance(start, Solution):
            return start
        raise ValueError("must be a result of mo.solve(scene), so it can be set only in Python")


def coulomb(task: Task) -> Solution:
    """Return the exact collapse state with the lowest load factor that the default method finds.

    The paper's loop of linear programs solves the scene instead in three cases:

    - the scene has more than 3000 joints (in space: contact points);
    - dilatancy falls with stress;
    - the scene is stable under its dead load, but no exact state is found.

    Raises
    ------
    OptionError
        If the option ``search`` or ``start`` is used although dilatancy falls with stress, or if ``start`` is
        a result of another scene.
    """
    options = task.options or CoulombOptions()
    searches = options.search is not None or options.start is not None
    if searches and task.problem.dilatancy_depends_on_stress:
        name = "start" if options.search is None else "search"
        raise OptionError(
            f"option '{name}' does not support dilatancy that falls with stress: omit this option, or omit "
            "'dilatancy_stress'"
        )
    start = options.start
    first = _run_steps(task, options) if start is None else of_same_scene(start, task.problem)
    if not searches or first.has(Code.TIME_LIMIT):
        return first
    try:
        return _search_on(task, first, options)
    except TimeLimitReached as stop:
        if first.answer is None:
            raise
        return with_answer(first, stop, task.effort)


def _run_steps(task: Task, options: CoulombOptions) -> Solution:
    """Run all steps that apply to the scene, and return the solution with a log of the steps."""
    run = CoulombRun(task, options.descent, options.settings, options.budget)
    log: list[LogEntry] = []
    for step in STEPS:
        if run.is_over or not step.applies(run):
            continue
        began = time.perf_counter()
        _run_step(step, run)
        seconds = time.perf_counter() - began + run.seconds_before
        log.append(LogEntry(step.name, run.load_factor, run.exact_states, seconds, run.note))
        run.seconds_before, run.note = 0.0, ""
    solution = replace(_solution(run), log=tuple(log))
    return solution if run.stopped is None else with_answer(solution, run.stopped, task.effort)


def _run_step(step: CoulombStep, run: CoulombRun) -> None:
    """Run a step. If the time limit stops the step, end the run with the lowest known collapse state.

    Raises TimeLimitReached if no collapse state is known.
    """
    try:
        with run.effort.step(step.name):
            step.run(run)
    except TimeLimitReached as stop:
        if run.answer is None:
            raise
        run.stopped, run.note = stop, f"stopped by the {stop}"


def _search_on(task: Task, first: Solution, options: CoulombOptions) -> Solution:
    """Search for exact states with a lower λ than a solution; return the state with the lowest λ.

    The log of the returned solution has an additional entry for the search.
    """
    began = time.perf_counter()
    limits = SearchLimits(options.search, options.until, options.seed)
    solution = search_lower(task, first, limits, options.settings, options.budget)
    seconds = time.perf_counter() - began
    entry = LogEntry(_SEARCH, solution.load_factor, solution.exact_states or 0, seconds)
    return replace(solution, log=(*first.log, entry))


def _solution(run: CoulombRun) -> Solution:
    """Return the solution of the step that ended the run, or else the state with the lowest λ."""
    if run.ended is not None:
        return run.ended
    solution = run.recorded(Status.CONVERGED)
    if solution.is_exact(run.problem):
        return solution
    return replace(solution, kind=Kind.NEARLY_COMPLEMENTARY)

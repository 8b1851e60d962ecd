"""Method "refined": exact states of Coulomb friction, from a push down, and searched for if asked."""

import time
from dataclasses import dataclass, replace
from math import inf
from typing import Annotated, Any

from pydantic import Field, InstanceOf, Strict, field_validator, model_validator

from masonry_opt.answer.acceptance import Kind
from masonry_opt.answer.reasons import Code, Status, reason
from masonry_opt.answer.solution import Solution
from masonry_opt.methods.exact.alternation import alternation_of
from masonry_opt.methods.exact.refiner import ConeRefiner, ExactState, OutOfTime, StateFinder, refiner_of
from masonry_opt.methods.exact.search import Met, Search, lower_of
from masonry_opt.methods.incremental.analysis import analysis_of, is_meaningful
from masonry_opt.methods.mcp.method import mcp
from masonry_opt.methods.task import Options, Task, of_same_scene
from masonry_opt.solvers.registry import MATRICES, find_solver


class RefinedOptions(Options):
    """Parameters of the refinement.

    Attributes
    ----------
    start: a result of the same scene, whose forces alone are refined (default: those of a push and, on small
        scenes, of further starts).
    search: seconds for which lower states are searched for, from other starts and around the lowest found.
    until: load factor at or below which the search ends before its time.
    seed: of the search's random numbers. One seed visits the same states in the same order; the time decides
        how far it gets.
    """

    start: InstanceOf[Solution] | None = None
    search: Annotated[float, Strict(), Field(gt=0, le=1e6)] | None = None
    until: Annotated[float, Strict()] | None = None
    seed: Annotated[int, Strict(), Field(ge=0)] = 0

    @model_validator(mode="after")
    def _ends_a_search(self) -> "RefinedOptions":
        if self.until is not None and self.search is None:
            raise ValueError("'until' ends a search: give 'search', its seconds at most, too")
        return self

    @field_validator("start", mode="before")
    @classmethod
    def _is_a_result(cls, start: Any) -> Any:
        if isinstance(start, str):
            raise ValueError(f"takes a result, such as that of method '{start}'")
        return start


@dataclass(frozen=True)
class Refinement:
    """One state that lowered λ on the way."""

    load_factor: float
    #: Start that led to the state: "start" (the state of the first method, or the given result), "random
    #: forces", "ties at 0.75 of their strength" (or 0.5, 0.25), a push with other "loads" or from other
    #: "self-stress", a "fixed point", a "neighbour" of the lowest state, or in space the forces of the
    #: "lowest state".
    origin: str
    candidate: int  #: its number, counted from 1
    lp_solves: int  #: linear programs solved since the method began, in space cone programs too
    seconds: float  #: time passed since then


def refined(task: Task) -> Solution:
    """The lowest of the exact states that a push and further starts, or a result, and the search lead to; it
    ends when its time is over or the user interrupts it."""
    problem, options = task.problem, task.options or RefinedOptions()
    if options.start is None:
        first = mcp(task.with_options(None, find_solver(MATRICES, None)))
    else:
        first = of_same_scene(options.start, problem)
    if first.proven_none or (first.q is None and options.search is None):
        return first
    refiner: StateFinder
    if problem.layout.round:
        refiner = ConeRefiner(problem, task.effort, alternation_of(task))
    else:
        refiner = refiner_of(task)
    lowest = _Lowest(task, refiner)
    search = Search(refiner, analysis_of(task), lowest.met)
    if options.search is not None:
        refiner.deadline = time.perf_counter() + options.search
    try:
        if first.q is not None:
            lowest.see("start", search.start(first.q))
        if options.search is not None:
            candidates = search.endless(lowest.state, options.seed)
            until = -inf if options.until is None else options.until
            while lowest.state is None or lowest.state.load_factor > until:
                lowest.see(*next(candidates))
    except OutOfTime:
        lowest.missed = Code.NO_TIME
    except KeyboardInterrupt:
        if options.search is None or lowest.state is None:
            raise
        lowest.interrupted = True
    return _solution(task, first, lowest, refiner)


class _Lowest:
    """The lowest state seen, and every one that was the lowest before it."""

    def __init__(self, task: Task, refiner: StateFinder) -> None:
        self._task, self._refiner, self._began = task, refiner, time.perf_counter()
        self.state: ExactState | None = None
        self.stationary: bool | None = None  #: whether nothing that was tried lowers it; None: not known
        self.interrupted = False  #: whether the user ended the search
        self.missed = Code.NOT_REFINED  #: why there is no state, if there is none
        self.history: list[Refinement] = []
        self.met = Met()  #: the states of all candidates

    def see(self, origin: str, state: ExactState | None) -> None:
        """Keep a candidate's state if it is the lowest."""
        if state is None or not is_meaningful(analysis_of(self._task), state.load_factor, state.d):
            return
        self.met.lowest = min(self.met.lowest, state.load_factor, state.below)
        if lower_of(self.state, state) is not state:
            return
        self.state = state
        undecided = self._refiner.undecided
        self.stationary = None if undecided is None or state.below < 0 else undecided == 0
        counts = self.met.candidates, self._task.effort.lp_solves, time.perf_counter() - self._began
        self.history.append(Refinement(state.load_factor, origin, *counts))
        self._task.progress(self.history[-1])


def _solution(task: Task, first: Solution, lowest: _Lowest, refiner: StateFinder) -> Solution:
    """The lowest state as a solution; the first solution where there is none."""
    best = lowest.state
    if best is None:
        return first.telling(reason(lowest.missed))
    same_law = first.found.forms == best.answer.forms
    # Programs begun anew from the first state may end above it.
    kept = first.answer if same_law and first.kind is Kind.EXACT else None
    answer = lower_of(best.answer, kept) or best.answer
    if is_kept := answer is kept:
        lowest.met.count(kept)
    lowest.met.lowest = min(lowest.met.lowest, first.below_zero)
    kind = Kind.EXACT if answer.exact else Kind.NEARLY_COMPLEMENTARY
    history = tuple(lowest.history)
    solution = Solution(Status.CONVERGED, kind, (), answer, history=history, solver=task.solver)
    solution = replace(lowest.met.recorded_in(solution), interrupted=lowest.interrupted)
    if task.options is not None and task.options.search is not None:
        told = {"candidates": lowest.met.candidates, "interrupted": lowest.interrupted}
        solution = solution.telling(reason(Code.SEARCHED, **told))
    stationary, matters = None if is_kept else lowest.stationary, first.flow_rule_matters
    return replace(solution, flow_rule_matters=matters, stationary=stationary, size=refiner.size)

"""Search for exact states with a lower λ, starting from the forces of a solution.

The search ends when its time is over, when λ has decreased to the value of option ``until``, when a proof
shows that no state has a lower λ, or when the user stops the search.
"""

import time
from dataclasses import dataclass, replace
from math import inf
from typing import TYPE_CHECKING

from masonry_opt.deadline import TimeLimitReached
from masonry_opt.methods.bounds.settings import BUDGET, ProofBudget
from masonry_opt.methods.coulomb.run import with_proof
from masonry_opt.methods.exact.refiner import (
    ConeRefiner,
    ExactState,
    RefinerTimeout,
    StateFinder,
    exact_state_of,
    refiner_of,
)
from masonry_opt.methods.exact.search import Search, StateRecord, lower_of
from masonry_opt.methods.exact.settings import SEARCH, SearchSettings
from masonry_opt.methods.incremental.analysis import analysis_of, is_meaningful
from masonry_opt.methods.task import Task
from masonry_opt.solution.acceptance import Kind
from masonry_opt.solution.proof import Proof
from masonry_opt.solution.reasons import Code, Status, reason
from masonry_opt.solution.solution import Solution
from masonry_opt.solution.stopped import with_answer

if TYPE_CHECKING:
    from masonry_opt.methods.bounds.least import LeastProof


@dataclass(frozen=True)
class LowerState:
    """Record of an exact state whose load factor was the lowest so far when the search found it.

    Attributes
    ----------
    load_factor: load factor of the state.
    origin: kind of the start that led to the state:

        - "start": the state of the steps before the search, or the result that the user passed;
        - "random forces";
        - "self-stress": a load history with another self-stress;
        - "fixed point";
        - "neighbour": forces close to the forces of the lowest state;
        - "proof": the search for a proof that λ is least;
        - "lowest state": in space, the forces of the lowest state.
    candidate: number of the start, counted from 1.
    lp_solves: number of linear programs (in space also cone programs) since the method began.
    seconds: time since the search began.
    """

    load_factor: float
    origin: str
    candidate: int
    lp_solves: int
    seconds: float


@dataclass(frozen=True)
class SearchLimits:
    """End conditions and random seed of a search for exact states with a lower load factor.

    Attributes
    ----------
    seconds: time after which the search ends; None to search only near the forces of the first solution.
    until: load factor at or below which the search ends before its time.
    seed: seed of the random numbers.
    """

    seconds: float | None = None
    until: float | None = None
    seed: int = 0


def search_lower(
    task: Task,
    first: Solution,
    limits: SearchLimits,
    settings: SearchSettings = SEARCH,
    budget: ProofBudget = BUDGET,
) -> Solution:
    """Search for exact states with a lower λ, from the forces of a solution and from further starts.

    Return the exact state with the lowest load factor as a solution. The search ends when its time is over,
    when a proof shows that no state has a lower load factor, or when the user or the time limit interrupts
    it. If no exact state is found, the first solution is returned with a reason.
    """
    if first.proven_none or (first.q is None and limits.seconds is None):
        return first
    finder: StateFinder
    if task.problem.layout.round:
        # The import is local, because the module imports a modelling language, which takes seconds.
        from masonry_opt.methods.exact.alternation import alternation_of

        finder = ConeRefiner(task.problem, task.effort, alternation_of(task, settings))
    else:
        finder = refiner_of(task, settings)
    lowest = _Lowest(task, finder)
    search = Search(finder, analysis_of(task), lowest.met, settings)
    if limits.seconds is not None:
        finder.deadline = time.perf_counter() + limits.seconds
    try:
        if first.q is not None:
            lowest.see("start", search.start(first.q))
        if limits.seconds is not None and first.proof is None:
            _search_on(search, lowest, limits, budget)
    except RefinerTimeout:
        lowest.missed = Code.NO_TIME
    except KeyboardInterrupt as stop:
        if limits.seconds is None or lowest.state is None:
            raise
        lowest.stop = stop
    return _solution(task, first, lowest, finder, limits.seconds is not None)


def _search_on(search: Search, lowest: "_Lowest", limits: SearchLimits, budget: ProofBudget) -> None:
    """Search from successive starts until λ is at most ``limits.until`` or is proven to be the least.

    On small scenes the starts alternate with the search for a proof. The lengths of these periods are numbers
    of linear programs rather than times, so that one seed always leads to the same states in the same order.
    Raises RefinerTimeout when the time is over.
    """
    candidates = search.endless(lowest.state, limits.seed)
    until = -inf if limits.until is None else limits.until
    effort, turn = search.effort, budget.first_turn
    turn_ends = effort.lp_solves + turn
    while lowest.state is None or lowest.state.load_factor > until:
        lowest.see(*next(candidates))
        if effort.lp_solves < turn_ends or not budget.covers(search.problem):
            continue
        lowest.prove(turn)
        if lowest.proof is not None:
            return
        search.known = lowest.state
        turn *= 2
        turn_ends = effort.lp_solves + turn


class _Lowest:
    """Record of the state with the lowest λ so far, and of earlier states that were the lowest when found."""

    def __init__(self, task: Task, finder: StateFinder) -> None:
        self._task, self._finder, self._began = task, finder, time.perf_counter()
        self.state: ExactState | None = None
        #: True if no mechanism that was tried lowers λ; None if unknown.
        self.stationary: bool | None = None
        self.stop: KeyboardInterrupt | None = None  #: user interrupt or time limit that ended the search
        self.missed = Code.NOT_FOUND  #: reason why no state was found
        self.history: list[LowerState] = []
        self.met = StateRecord(
            task.problem.load_factor_scale
        )  #: load factors of the states found from all starts
        self._attempt: LeastProof | None = None

    @property
    def proof(self) -> Proof | None:
        """Proof that no state has a lower load factor, or None if there is no proof."""
        return None if self._attempt is None else self._attempt.proof

    def see(self, origin: str, state: ExactState | None) -> None:
        """Store a state that was found from a start, if its load factor is the lowest so far."""
        if state is None or not self._is_lowest(state):
            return
        undecided = self._finder.undecided
        self.stationary = None if undecided is None or state.below < 0 else undecided == 0
        self._keep(origin, state)

    def prove(self, programs: int) -> None:
        """Try to prove that no state has a lower λ. Solve up to ``programs`` linear programs for the proof.

        If the search for the proof finds a state with a lower λ, this state is stored.
        """
        if self.state is None or not self.state.exact:
            return
        if self._attempt is None:
            # The import is local, because the module imports the SAT solver.
            from masonry_opt.methods.bounds.least import LeastProof

            self._attempt = LeastProof(self._task, self.state.answer, None)
        self._task.effort.begins("proof of the least")
        self._attempt.lower_to(self.state.answer)
        self._attempt.run(self._finder.seconds_left, programs)
        best = self._attempt.best
        state = None if best is None else exact_state_of(self._task.problem, best)
        if state is not None and self._is_lowest(state):
            self.met.add(state.load_factor)
            self.stationary = None
            self._keep("proof", state)

    def _is_lowest(self, state: ExactState) -> bool:
        """Record the load factor of a state. Return True if this load factor is the lowest so far.

        If the state does not count as a collapse (see :func:`.is_meaningful`), its load factor is not
        recorded, and False is returned.
        """
        if not is_meaningful(analysis_of(self._task), state.load_factor, state.d):
            return False
        self.met.lowest = min(self.met.lowest, state.load_factor, state.below)
        # A start may lead to the state with the lowest λ again, and return the object that is already stored.
        # This does not count as a lower λ.
        return state is not self.state and lower_of(self.state, state, self.met.scale) is state

    def _keep(self, origin: str, state: ExactState) -> None:
        """Keep a state as the state with the lowest λ, and add it to the history."""
        self.state = state
        counts = self.met.candidates, self._task.effort.lp_solves, time.perf_counter() - self._began
        self.history.append(LowerState(state.load_factor, origin, *counts))
        self._task.effort.lowers(state.load_factor)
        self._task.progress(self.history[-1])


def _without_state(first: Solution, missed: Code) -> Solution:
    """Add to a solution the reason why the search from its forces found no exact state."""
    reasons = (
        replace(own_reason, values=own_reason.values | {"searched": True})
        if own_reason.code is Code.UNDECIDED
        else own_reason
        for own_reason in first.reasons
    )
    return replace(first, reasons=tuple(reasons)).telling(reason(missed))


def _solution(task: Task, first: Solution, lowest: _Lowest, finder: StateFinder, searched: bool) -> Solution:
    """Return the state with the lowest λ as a solution, or ``first`` with a reason if none was found."""
    best = lowest.state
    if best is None:
        return _without_state(first, lowest.missed)
    has_same_law = first.state.forms == best.answer.forms
    # If the answer of ``first`` is exact, keep it for comparison, because the search may end at a higher load
    # factor.
    exact_answer = first.answer if has_same_law and first.kind is Kind.EXACT else None
    answer = lower_of(best.answer, exact_answer, lowest.met.scale) or best.answer
    is_first_answer = answer is exact_answer
    if is_first_answer:
        lowest.met.count(exact_answer)
    lowest.met.lowest = min(lowest.met.lowest, first.below_zero)
    kind = Kind.EXACT if answer.exact else Kind.NEARLY_COMPLEMENTARY
    history = tuple(lowest.history)
    solution = Solution(Status.CONVERGED, kind, (), answer, history=history, solver=task.solver)
    solution = replace(lowest.met.recorded_in(solution), interrupted=lowest.stop is not None)
    if searched:
        counts = {"candidates": lowest.met.candidates, "interrupted": lowest.stop is not None}
        solution = solution.telling(reason(Code.SEARCHED, **counts))
    if isinstance(lowest.stop, TimeLimitReached):
        solution = with_answer(solution, lowest.stop, task.effort)
    stationary = None if is_first_answer else lowest.stationary
    matters = first.flow_rule_matters
    solution = with_proof(solution, lowest.proof or first.proof, lowest.met.scale)
    return replace(solution, flow_rule_matters=matters, stationary=stationary, size=finder.size)

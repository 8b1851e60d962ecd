"""The least Coulomb load factor of a plane scene, with a proof by conflict learning and by products.

Conflict learning (:mod:`masonry_opt.methods.bounds.search`) and relaxations by products
(:mod:`masonry_opt.methods.bounds.products`) take turns. Many scenes are proven quickly by one of them only. A
relaxation that does not reach the load factor still helps: the search for conflicts then includes only states
above the bound of the relaxation.
"""

import time
from dataclasses import replace
from math import ceil
from typing import TYPE_CHECKING

from masonry_opt.deadline import seconds_left
from masonry_opt.effort import ProgramLimitReached
from masonry_opt.methods.bounds.conflicts import Undecided
from masonry_opt.methods.bounds.products import ProductChain, closes_much
from masonry_opt.methods.bounds.search import (
    ConflictSearch,
    ConflictSearchTimeout,
    NoLoadFactorLeft,
    bound_below,
)
from masonry_opt.methods.bounds.settings import SETTINGS, ProofSettings
from masonry_opt.methods.task import Task
from masonry_opt.problem.load_factor_scale import LoadFactorScale
from masonry_opt.problem.problem import Problem
from masonry_opt.solution.answer import Answer
from masonry_opt.solution.proof import Proof

if TYPE_CHECKING:
    pass


def refusal(problem: Problem) -> str:
    """Return the reason why no proof is possible for a problem, or "" if a proof is possible."""
    if problem.layout.round:
        return "proofs exist only for scenes in the plane, because in space friction is limited by a cone"
    if problem.dilatancy_depends_on_stress:
        return "proofs need constant dilatancy, but here dilatancy depends on stress: omit 'dilatancy_stress'"
    if (problem.dilatancy > problem.friction).any():
        return "the dilatancy of a joint exceeds its friction, so that sliding would create energy"
    return ""


class LeastProof:
    """Search for the least load factor; the search can be interrupted and continued.

    Attributes
    ----------
    best: exact state with the lowest load factor, known before or found by the search.
    proof: the proof that no state has a lower load factor than ``best``, or, without ``best``, that no state
        has a load factor within the range of the search; None as long as there is no proof.
    why: reason why no proof was found; empty if a proof was found, or if the search can be continued.
    """

    def __init__(
        self, task: Task, known: Answer | None, upper: float | None, settings: ProofSettings = SETTINGS
    ) -> None:
        """Prepare the search; see :func:`prove_least` for the arguments."""
        self.best: Answer | None = known
        self.proof: Proof | None = None
        self._task, self._settings = task, settings
        self._scale = task.problem.load_factor_scale
        self._start = _start(known, upper, settings, self._scale)
        self.why = refusal(task.problem) or _without_range(task.problem, self._start)
        self._search: ConflictSearch | None = None
        self._chain = ProductChain(task.problem, task.effort, settings)
        self._selections = self._chain.selections.copy()  # products of the relaxations that remain
        self._next_products = settings.first_products

    @property
    def is_open(self) -> bool:
        """True if the search is not complete, so that it may still find a proof."""
        return self.proof is None and not self.why

    @property
    def programs(self) -> int:
        """Number of linear programs that the search has solved."""
        return 0 if self._search is None else self._search.programs

    def lower_to(self, state: Answer) -> None:
        """Store an exact state in ``best`` if its load factor is lower than that of the stored state."""
        if self.best is None or self._scale.is_lower(state.load_factor, self.best.load_factor):
            self.best = state

    def run(self, seconds: float, programs: int) -> bool:
        """Search up to a time limit and a number of linear programs. Return True if the search is complete.

        The search solves at most ``programs`` linear programs, including the programs of its preparation. It
        is complete if it has found a proof, or the reason why there is no proof. A search that a limit has
        stopped can be run again; it then continues with all learned clauses.
        """
        if not self.is_open:
            return True
        try:
            self._continue(time.perf_counter() + min(seconds, seconds_left()), programs)
        except (ConflictSearchTimeout, ProgramLimitReached):
            return False
        except Undecided as error:
            self.why = str(error)
        return True

    def _continue(self, ends: float, programs: int) -> None:
        """Search for a proof until the time ``ends``, or until ``programs`` more programs are solved."""
        last = self.programs + min(programs, self._settings.most_programs - self.programs)
        while self.proof is None:
            try:
                self._search_conflicts(ends, min(last, self._next_products) if self._selections else last)
            except ProgramLimitReached:
                if self.programs >= last:
                    raise
                self._next_products = ceil(self._next_products * self._settings.products_growth)
                self._raise_bound(ends)

    def _search_conflicts(self, ends: float, last: int) -> None:
        """Search for conflicts until the proof is complete, or ``last`` programs have been solved in all."""
        with self._task.effort.at_most(last - self.programs):
            if self._search is None:
                assert self._start is not None
                self._search = ConflictSearch(self._task, self._start, self._settings)
            search = self._search
            try:
                if self.best is not None:
                    search.lower_to(self.best.load_factor)
                search.run(ends)
            except NoLoadFactorLeft:
                self.proof = self._chain.proof(search.known, search.highest)
                return
            finally:
                if search.best is not None:
                    self.lower_to(search.best)
        self.proof = search.proof()
        if self._chain.steps:
            steps, excluded = tuple(self._chain.steps), self._chain.excluded(search.known)
            self.proof = replace(self.proof, relaxations=steps, excluded_by_products=excluded)

    def _raise_bound(self, ends: float) -> None:
        """Solve relaxations by products, as long as each closes much of the gap between the bounds on λ.

        The proof is complete if the bound reaches the lowest known load factor.
        """
        if self.best is None:
            return
        chain, load_factor = self._chain, self.best.load_factor
        needed = bound_below(load_factor, self._settings, self._scale)
        selected = self._selections.pop(0)
        gains = True
        while gains and time.perf_counter() < ends:
            before = chain.bound
            chain.raise_bound(load_factor, selected, ends - time.perf_counter())
            if chain.bound >= needed:
                self.proof = chain.proof(load_factor, needed)
                return
            gains = closes_much(before, chain.bound, load_factor, self._settings)
        if chain.bound < self._settings.least_share * load_factor:
            self._selections.clear()
        if self._search is not None:
            self._search.raise_to(chain.bound)


def _start(
    known: Answer | None, upper: float | None, settings: ProofSettings, scale: LoadFactorScale
) -> float | None:
    """Return the upper end of the range of load factors to search, or None if no upper end is known."""
    if known is not None:
        return known.load_factor
    if upper is None:
        return None
    # Add a small margin to the upper bound, so that a state with exactly this load factor is found too.
    return upper + 2 * settings.gap * scale.divisor(upper)


def _without_range(problem: Problem, start: float | None) -> str:
    """Return the reason why the range of load factors cannot be searched, or "" if it can be searched."""
    if start is None:
        return "the search has no upper limit: neither an exact state nor an upper bound on λ is known"
    if start <= problem.load_factor_scale.zero:
        return (
            "the upper limit of the search is zero or less, and a proof cannot cover load factors below zero"
        )
    return ""


def prove_least(
    task: Task,
    known: Answer | None,
    seconds: float,
    upper: float | None = None,
    settings: ProofSettings = SETTINGS,
) -> LeastProof:
    """Search for the least load factor, and try to prove that no collapse state has a lower load factor.

    Parameters
    ----------
    task: the problem. Its effort counts the linear programs.
    known: the lowest exact state known; None if none is known.
    seconds: time limit of the search.
    upper: load factor up to which states are searched for; used if ``known`` is None. A proof then excludes
        all states if no state exceeds this load factor, as with the associative load factor.
    settings: settings of the search.
    """
    attempt = LeastProof(task, known, upper, settings)
    if not attempt.run(seconds, settings.most_programs):
        attempt.why = (
            f"the search did not end within {seconds:g} s or {settings.most_programs} linear programs"
        )
    return attempt

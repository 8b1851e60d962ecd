"""Data of a run of the default method: its load history, the exact states found, and how it ended."""

from collections.abc import Iterable
from dataclasses import replace
from functools import cached_property
from math import inf
from typing import TYPE_CHECKING

import numpy as np

from masonry_opt.deadline import TimeLimitReached
from masonry_opt.methods.bounds.settings import BUDGET, ProofBudget
from masonry_opt.methods.exact.refiner import ConeRefiner, ExactState, exact_state_of, refiner_of
from masonry_opt.methods.exact.search import Search, StateRecord, lower_of
from masonry_opt.methods.exact.settings import SEARCH, SearchSettings
from masonry_opt.methods.incremental.analysis import IncrementalAnalysis, analysis_of, is_meaningful
from masonry_opt.methods.task import Task
from masonry_opt.problem.load_factor_scale import LoadFactorScale
from masonry_opt.solution.acceptance import Kind
from masonry_opt.solution.answer import Answer
from masonry_opt.solution.load_history import LoadHistory
from masonry_opt.solution.only_state import is_only_load_factor
from masonry_opt.solution.proof import Proof
from masonry_opt.solution.reasons import Code, Status, reason
from masonry_opt.solution.solution import Solution

if TYPE_CHECKING:
    from masonry_opt.methods.exact.alternation import Alternation


class CoulombRun:
    """Data of one run of the default method, which the steps of the method read and extend.

    Attributes
    ----------
    seeks_lower: True if the search continues for states with a lower load factor after it has found an exact
        state. If False, the first exact state is the answer.
    settings: settings of the search for exact states.
    budget: budget of the search for a proof that no state has a lower load factor.
    incremental: the solution of the incremental analysis, once it is known.
    known: solution without an exact state: it has the load history, the associative load factor and proofs.
    ended: the solution of a run that has ended without an exact state; None before the end.
    stopped: the time limit that has ended the run, whose answer is the lowest state; None before the end.
    seconds_before: time of a load history that was computed before the run, in seconds.
    note: further result of the current step in words, for the log.
    proof: the proof that no state has a lower load factor; None if there is no proof.
    """

    def __init__(
        self,
        task: Task,
        seeks_lower: bool,
        settings: SearchSettings = SEARCH,
        budget: ProofBudget = BUDGET,
    ) -> None:
        self.task, self.problem, self.effort = task, task.problem, task.effort
        self.settings, self.budget = settings, budget
        self.seeks_lower = seeks_lower
        self.incremental: Solution | None = None
        self.known = Solution(Status.SOLVER_FAILED, Kind.EXACT, solver=task.solver)
        self.ended: Solution | None = None
        self.stopped: TimeLimitReached | None = None
        self.seconds_before = 0.0
        self.note = ""
        self.proof: Proof | None = None

    @property
    def is_over(self) -> bool:
        """True if the run is over, because a step or the time limit has ended it."""
        return self.ended is not None or self.stopped is not None

    @cached_property
    def analysis(self) -> IncrementalAnalysis:
        """Incremental analysis of the scene, an object that all steps of the run share."""
        return analysis_of(self.task)

    @cached_property
    def states(self) -> "LowestState":
        """Record of the exact states found so far, and of the state with the lowest load factor."""
        return LowestState(self.task, self.analysis, self.settings, self.seeks_lower)

    @property
    def answer(self) -> Answer | None:
        """Collapse state with the lowest load factor so far, or None if no state was found."""
        # Without a load history no state is known yet, because every search for a state needs the load
        # history.
        return None if self.incremental is None else self.states.answer

    @property
    def load_factor(self) -> float | None:
        """Load factor of the answer so far; without an answer, the incremental load factor or None."""
        if self.ended is not None:
            return self.ended.load_factor
        if self.answer is not None:
            return self.answer.load_factor
        return None if self.incremental is None else self.incremental.incremental_value

    @property
    def is_only_state(self) -> bool:
        """True if all exact states have the same load factor as the answer.

        This is so if equilibrium fixes all forces, or if all joints follow associative flow. Further starts
        are then useless.
        """
        answer = self.answer
        if answer is None or not answer.exact:
            return False
        return self.problem.flow_is_associative or is_only_load_factor(self.problem, answer.load_factor)

    @property
    def exact_states(self) -> int:
        """Number of different exact states found so far."""
        return 0 if self.incremental is None else len(self.states.met.load_factors)

    def recorded(self, status: Status) -> Solution:
        """Return the state with the lowest λ as a solution, with the numbers of starts and of states."""
        answer = self.states.answer
        assert answer is not None
        solution = replace(self.known, state=answer, status=status, reasons=())
        solution = self.states.met.recorded_in(solution)
        return with_proof(solution, self.proof, self.states.met.scale)


def with_proof(solution: Solution, proof: Proof | None, scale: LoadFactorScale) -> Solution:
    """Add to a solution the proof that no state has a lower load factor than its answer.

    The solution is returned unchanged if there is no proof, or if the proof is for another load factor.
    """
    if proof is None or solution.load_factor is None:
        return solution
    if not scale.equal(proof.load_factor, solution.load_factor):
        return solution
    solution = replace(solution, bound=proof.bound, bound_derived=True, proof=proof)
    values = {"bound": proof.bound, "load_factor": solution.load_factor, "rates": None, "forces": False}
    return solution.telling(reason(Code.PROVEN, **values))


class LowestState:
    """Record of the exact states that were found, and of the state with the lowest load factor."""

    def __init__(
        self,
        task: Task,
        analysis: IncrementalAnalysis,
        settings: SearchSettings = SEARCH,
        seeks_lower: bool = True,
    ) -> None:
        self._task, self._problem, self._effort = task, task.problem, task.effort
        self._analysis, self._settings = analysis, settings
        self.met = StateRecord(task.problem.load_factor_scale)
        simplex = self._problem.joints <= settings.simplex_up_to and not self._problem.layout.round
        refiner = refiner_of(task, settings, descends=seeks_lower) if simplex else None
        self._search = Search(refiner, analysis, self.met, settings) if refiner else None
        self._lowest: ExactState | None = None
        self._lowest_without_simplex: Answer | None = None

    @cached_property
    def _alternation(self) -> "Alternation":
        """Algorithm that finds exact states by solving kinematic and static programs alternately.

        Interior-point methods solve the programs.
        """
        from masonry_opt.methods.exact.alternation import alternation_of

        return alternation_of(self._task, self._settings)

    @property
    def answer(self) -> Answer | None:
        """State with the lowest load factor found so far, or None if no state was found.

        States from the simplex method or from a proof have priority over states from the load history or from
        cone programs.
        """
        return self._lowest.answer if self._lowest else self._lowest_without_simplex

    def lower_to(self, state: Answer) -> None:
        """Store an exact state with a lower λ, which the search for a proof has found.

        A state with a load factor of zero or less is recorded, but it is not an answer, because the scene
        would then collapse without live load.
        """
        self.met.lowest = min(self.met.lowest, state.load_factor)
        if state.load_factor > self.met.scale.zero:
            self._lowest = lower_of(self._lowest, exact_state_of(self._problem, state), self.met.scale)
            self.met.add(state.load_factor)
            self._report()

    def near(self, start: Answer) -> None:
        """Look for an exact state near the joint forces of ``start``, by a simplex or interior-point method.

        If the start itself is exact, it is recorded as a state too.
        """
        if self._search:
            self._keep(self._search.start(start.q))
        if self._lowest is not None:
            return
        # Compute the certificate of the start again: the start may be exact with a friction polygon, but not
        # with the friction cone.
        start = start.certified_by(self._problem.by(start.forms), self._problem.dilatancy)
        exact = start if start.exact and self._counts(start) else None
        self._lowest_without_simplex = self._exact_or_lower(exact)
        nearby = self._alternation.state_near(start.q, start.d if start.exact else None)
        nearby = nearby if nearby is not None and self._counts(nearby) else None
        self._lowest_without_simplex = self._exact_or_lower(nearby)
        self._report()
        if self._problem.layout.round:
            self.met.count(nearby if nearby is not None and nearby.exact else exact)

    def look_further_in_the_plane(self, starts: int) -> None:
        """Look for states with a lower λ. Stop after ``starts`` successive starts that do not lower λ."""
        assert self._search is not None
        for state in self._search.until_in_vain(self._lowest, starts):
            self._keep(state)

    def look_further_in_space(self, history: LoadHistory | None) -> None:
        """Look for states with a lower load factor, from a fixed number of starts.

        The first starts are forces of earlier steps of the load history. The other starts are random, or
        on scenes with many contacts the forces of the lowest state.
        """
        settings = self._settings
        finder = ConeRefiner(
            self._problem, self._effort, self._alternation, settings.weight_series_in_space[0]
        )
        search = Search(finder, self._analysis, self.met, settings)
        lowest = self._lowest_without_simplex
        known = None if lowest is None else exact_state_of(self._problem.by_cone, lowest)
        for state in search.fixed_number(known, _forces_of_steps(history, settings.steps_in_space)):
            if state is not None and self._counts(state, state.below):
                self._lowest_without_simplex = self._exact_or_lower(state.answer)
                self._report()

    def _keep(self, state: ExactState | None) -> None:
        if state is not None and self._counts(state, state.below):
            self._lowest = lower_of(self._lowest, state, self.met.scale)
            self._report()

    def _exact_or_lower(self, other: Answer | None) -> Answer | None:
        """Return the exact answer if only one of two answers is exact, otherwise the answer with the lower λ.

        The first answer is the present answer without the simplex method, the second answer is ``other``.
        """
        present = self._lowest_without_simplex
        exact = [answer for answer in (present, other) if answer and answer.exact]
        return exact[0] if len(exact) == 1 else lower_of(present, other, self.met.scale)

    def _report(self) -> None:
        """Report the load factor of the present answer, if any, to the user."""
        if self.answer is not None:
            self._effort.lowers(self.answer.load_factor)

    def _counts(self, state: Answer | ExactState, below: float = inf) -> bool:
        """Record the load factor of a state. Return True if the state may be the answer.

        If the state does not count as a collapse (see :func:`.is_meaningful`), its load factor is not
        recorded, and False is returned. If the forces at rest are prescribed, False is also returned for a
        negative load factor.
        """
        if not is_meaningful(self._analysis, state.load_factor, state.d):
            return False
        self.met.lowest = min(self.met.lowest, state.load_factor, below)
        return self._problem.settled is None or state.load_factor >= -self.met.scale.zero


def _forces_of_steps(history: LoadHistory | None, shares: Iterable[float]) -> list[np.ndarray]:
    """Return the joint forces of selected steps of the load history.

    The shape of the forces of one step is (3c + t,). ``shares`` are the positions of these steps in the
    history: 0.5 selects the step halfway through it.
    """
    if history is None:
        return []
    last = len(history.steps) - 1
    numbers = dict.fromkeys(int(share * last) for share in shares)
    # Skip the first load step, which has no live load, and the last load step, which was already used as a
    # start.
    return [history.steps[number].forces for number in numbers if 0 < number < last]

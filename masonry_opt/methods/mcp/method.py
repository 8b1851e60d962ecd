"""Method "mcp": the lowest of a few exact collapse states near the end of a load history."""

from dataclasses import replace
from math import inf
from typing import Annotated

from pydantic import Strict

from masonry_opt.answer.acceptance import Kind
from masonry_opt.answer.answer import Answer, Existence
from masonry_opt.answer.reasons import Code, Status
from masonry_opt.answer.solution import Solution
from masonry_opt.answer.thresholds import ZERO
from masonry_opt.methods.associative import associative, with_associative
from masonry_opt.methods.exact.alternation import alternation_of
from masonry_opt.methods.exact.refiner import SMALL, ConeRefiner, ExactState, exact_state_of, refiner_of
from masonry_opt.methods.exact.search import Met, Search, lower_of
from masonry_opt.methods.exact.settings import SEARCH
from masonry_opt.methods.incremental.analysis import analysis_of, is_meaningful
from masonry_opt.methods.incremental.method import incremental
from masonry_opt.methods.incremental.settings import IncrementalSettings
from masonry_opt.methods.loop.nonassociative import nonassociative
from masonry_opt.methods.loop.options import LoopOptions
from masonry_opt.methods.task import Options, Task
from masonry_opt.solvers.registry import find_solver
from masonry_opt.standing.existence import existence

_SIMPLEX_UP_TO = 500  #: Joints in the plane up to which simplex descends: beyond, it takes longest of all.


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
    if task.problem.dilatancy_depends_on_stress or task.problem.joints > IncrementalSettings().most_joints:
        return _by_loop(task)
    effort, options = task.effort, task.options or McpOptions()
    expected = task.expected
    if expected is None or not expected.history:
        expected = incremental(task.with_options(None))
    else:
        # The load history of the incremental load factor is the first step of this method: its solver and
        # steps are reported, and it is not computed again.
        effort.uses(task.solver.name, "incremental analysis")
        effort.iterations += len(expected.history)
        for step in expected.history:
            task.progress(step)
    if expected.status is Status.UNSTABLE:
        return replace(expected, kind=Kind.EXACT)
    states = _States(task)
    effort.begins("exact states nearby")
    if expected.answer is not None:
        states.near(expected.answer)
    known = Solution(Status.SOLVER_FAILED, Kind.EXACT, solver=task.solver, history=expected.history)
    if states.answer is None:
        known = with_associative(task, known)
        if known.associative is None:
            known = replace(known, infeasibility=existence(task.problem, task.effort))
        if known.proven_none:
            return known
    if states.answer is None and known.associative is not None:
        # Without a collapse from rest, as where joints hardly slide, associative forces may lead to a state.
        by_statics = associative(Task(task.problem, kept=task.kept)).answer
        if by_statics is not None:
            states.near(by_statics)
    if options.descent:
        states.further()
    answer = states.answer
    if answer is None:
        return _without(task, known, states.met.lowest, expected)
    solution = states.met.recorded_in(replace(known, found=answer, status=Status.CONVERGED, reasons=()))
    return solution if solution.is_exact(task.problem) else replace(solution, kind=Kind.NEARLY_COMPLEMENTARY)


class _States:
    """The lowest of the exact states that forces lead to, and all that were met."""

    def __init__(self, task: Task) -> None:
        self._problem, self._effort, self._analysis = task.problem, task.effort, analysis_of(task)
        self._alternation = alternation_of(task)
        self.met = Met()
        simplex = self._problem.joints <= _SIMPLEX_UP_TO and not self._problem.layout.round
        self._search = Search(refiner_of(task), self._analysis, self.met) if simplex else None
        self._lowest: ExactState | None = None
        self._by_programs: Answer | None = None

    @property
    def answer(self) -> Answer | None:
        """The lowest state: by simplex, or of the load history and by programs, in space of cones."""
        return self._lowest.answer if self._lowest else self._by_programs

    def near(self, start: Answer) -> None:
        """Look for a state near forces: by simplex, or else by two programs in turn, beside those that are
        exact already."""
        if self._search:
            self._keep(self._search.start(start.q))
        if self._lowest is None:
            # A state that is exact by the cone may not be so by another law.
            start = start.certified_by(self._problem.by(start.forms), self._problem.dilatancy)
            exact = start if start.exact and self._tells(start) else None
            self._by_programs = _exact_or_lower(self._by_programs, exact)
            found = self._alternation.state_near(start.q, start.d if start.exact else None)
            found = found if found is not None and self._tells(found) else None
            self._by_programs = _exact_or_lower(self._by_programs, found)
            if self._problem.layout.round:
                self.met.count(found if found is not None and found.exact else exact)

    def further(self) -> None:
        """Look for lower states from further starts.

        On small scenes in the plane the search ends after many starts in a row without a lower state. In
        space the number of starts is fixed.
        """
        if self._problem.layout.round:
            self._further_in_space()
        elif self._problem.joints <= SMALL:
            self._further_in_the_plane()

    def _further_in_the_plane(self) -> None:
        assert self._search is not None
        self._effort.begins("further starts")
        for state in self._search.until_in_vain(self._lowest):
            self._keep(state)

    def _further_in_space(self) -> None:
        self._effort.begins("further starts")
        finder = ConeRefiner(self._problem, self._effort, self._alternation, SEARCH.weights_in_space)
        search = Search(finder, self._analysis, self.met)
        lowest = self._by_programs
        known = None if lowest is None else exact_state_of(self._problem.by_cone, lowest)
        for state in search.fixed_number(known):
            if state is not None and self._tells(state, state.below):
                self._by_programs = _exact_or_lower(self._by_programs, state.answer)

    def _keep(self, state: ExactState | None) -> None:
        if state is not None and self._tells(state, state.below):
            self._lowest = lower_of(self._lowest, state)

    def _tells(self, state: Answer | ExactState, below: float = inf) -> bool:
        """Whether a state tells of the load, and is then met; but none below zero where the forces at rest
        are known."""
        if not is_meaningful(self._analysis, state.load_factor, state.d):
            return False
        self.met.lowest = min(self.met.lowest, state.load_factor, below)
        return self._problem.settled is None or state.load_factor >= -ZERO


def _exact_or_lower(one: Answer | None, other: Answer | None) -> Answer | None:
    """The one of two answers that alone is exact, else the lower."""
    exact = [answer for answer in (one, other) if answer and answer.exact]
    return exact[0] if len(exact) == 1 else lower_of(one, other)


def _by_loop(task: Task) -> Solution:
    return nonassociative(task.with_options(LoopOptions(), find_solver("cvxpy", None)))


def _without(task: Task, solution: Solution, lowest: float, expected: Solution) -> Solution:
    """Return how a run without an exact state ends, by the first case that applies.

    1. Statics carry any multiple, and joints press ever harder as the load grows from rest: no collapse.
    2. All states met lie below zero: no load factor.
    3. The dead load is not carried from rest: unstable.
    4. The loop ends with a load factor, or its load grows without end as statics allow: the loop's end.
    5. Neither the load history nor the loop comes to an end: no load factor.
    """
    found = solution.infeasibility
    grows = next((said for said in expected.reasons if said.code is Code.UNBOUNDED), None)
    if grows and found is not None and found.existence is Existence.UNBOUNDED:
        return replace(solution, status=Status.JAMMED, reasons=(grows,))
    if lowest < -ZERO:
        ended = solution.ended(Status.BELOW_ZERO, Code.BELOW_ZERO, load_factor=lowest)
        return replace(ended, below_zero=lowest)
    word, steps = "no exact state lies nearby", len(expected.history)
    if expected.has(Code.UNDECIDED):
        word = expected.values_of(Code.UNDECIDED)["word"]
    if analysis_of(task).preload_forces is None:
        return solution.ended(Status.UNSTABLE, Code.UNDECIDED, word=word, steps=steps, looped=False)
    by_loop = _by_loop(task).accepted()
    statics = solution.associative_ended
    endless = statics is not None and statics.unlimited and by_loop.status.unlimited
    if by_loop.answer is not None or endless:
        by_loop = replace(by_loop, associative=solution.associative, associative_ended=statics)
        return replace(by_loop, infeasibility=found)
    return solution.ended(Status.SOLVER_FAILED, Code.UNDECIDED, word=word, steps=steps, looped=True)

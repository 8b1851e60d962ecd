"""Method "mcp": an exact state of Coulomb friction next to the load to expect, the lowest of a few."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import Annotated, Any, TypeVar

from pydantic import Strict

from masonry_opt.answer.acceptance import Kind
from masonry_opt.answer.answer import Answer, certified
from masonry_opt.answer.infeasibility import Existence
from masonry_opt.answer.reasons import Code, reason
from masonry_opt.answer.solution import Solution
from masonry_opt.answer.status import Status
from masonry_opt.answer.thresholds import ZERO
from masonry_opt.methods.associative import with_associative
from masonry_opt.methods.exact.alternation import alternated
from masonry_opt.methods.exact.refiner import SMALL, ExactState, Refiner, refiner_of
from masonry_opt.methods.exact.search import Met, Search, lower_of
from masonry_opt.methods.mcp.compliant import jams, pushed
from masonry_opt.methods.mcp.large import by_loop, by_loop_unless_far
from masonry_opt.methods.mcp.passes import PASSES_UP_TO, Passes, follow, prepared
from masonry_opt.methods.mcp.schedule import BRAKES, NewtonStep
from masonry_opt.methods.task import Options, Task
from masonry_opt.problem.state import State

_State = TypeVar("_State", Answer, ExactState)

#: Joints in the plane up to which simplex makes states exact and descends: beyond, it takes longer than all
#: else, and in space there are cones.
_SIMPLEX_UP_TO = 500

#: Compliance of the contacts whose forces lead to states that are sometimes lower: of wall 3 with a friction
#: of .7 and more to .3558, where stiff ones lead to .389 and more.
_SOFT = 1e-2

#: Joints in the plane up to which the bracket's first program is asked for lower states: of 231 random scenes
#: 3 ended more than 1e-3 above the lowest known without it, 1 with it, in 1.7 times the time (at most 5).
_PRODUCTS_UP_TO = 12


class McpOptions(Options):
    """Options of the default method.

    Attributes
    ----------
    descent: whether, on scenes in space and of up to 500 joints in the plane, lower states are sought, and on
        small ones further starts are tried; else the first state will do.
    """

    descent: Annotated[bool, Strict()] = True


def mcp(task: Task) -> Solution:
    """Load factor of an exact state that forces under contacts that give lead to, on small scenes the lowest
    of several; where they lead to none, of one that those of passes with rigid contacts lead to.

    Scenes of more than 8000 joints (in space contact points) are for the loop, as long as its sub-problems
    come near the true law; dilatancy that falls with stress always.
    """
    if task.problem.dilatancy_depends_on_stress:
        return by_loop(task, Code.DILATANCY_FALLS)
    if task.problem.joints <= PASSES_UP_TO:
        return _by_passes(task)
    begun = by_loop_unless_far(task)
    if isinstance(begun, Solution):
        return begun
    solution = _by_passes(task)
    return by_loop(task, Code.TOO_LARGE) if solution.answer is None else solution.telling_first(begun)


def _by_passes(task: Task) -> Solution:
    effort, options = task.effort, task.options or McpOptions()
    # The passes of the load to expect are the first of this method.
    given = task.expected.history if task.expected else ()
    history = [step for step in given if isinstance(step, NewtonStep)]
    effort.iterations += len(history)
    for step in history:
        task.progress(step)
    passes = prepared(task)
    states, starts = _States(task, passes), _Starts(task, passes, history)
    first: Answer | State | None = None
    for start in starts:
        first = first or start
        effort.begins("exact states nearby")
        states.near(start)
        if states.answer is not None:
            break
    solution = replace(starts.known, solver=task.solver)
    if solution.proven_none:
        ended = solution.ended(Status.SOLVER_FAILED, Code.PASS_LOST)
        return replace(ended, history=tuple(history))
    if options.descent and states.descend:
        effort.begins("softer contacts")
        if soft := follow(task, passes.giving(_SOFT), history, _passes_in(history) + 1):
            states.near(soft)
        states.further()
    answer, solution = states.answer, replace(solution, history=tuple(history))
    if answer is None:
        return _without(task, solution, states.met.lowest, str(passes.outcome))
    told = {"steps": len(history), "attempt": _passes_in(history)}
    solution = replace(solution, found=answer).ended(Status.CONVERGED, Code.ONE_PASS, **told)
    if not solution.is_exact(task.problem):
        solution = replace(solution, kind=Kind.ONE_PASS)
    else:
        # Passes are by the sides of cones in space: the difference of two laws is no fall.
        same_law = answer.forms == task.problem.forms
        fall = first.load_factor - answer.load_factor if first and same_law else None
        solution = solution.telling(reason(Code.EXACT, fall=fall))
    return solution.telling(*states.met.reasons) if states.met.load_factors else solution


class _States:
    """The lowest of the exact states that forces lead to.

    Attributes
    ----------
    descend: whether further starts pay: in space, and in the plane where simplex is quick.
    met: the states.
    """

    def __init__(self, task: Task, passes: Passes) -> None:
        self._problem, self._effort, self._passes = task.problem, task.effort, passes
        self.met = Met()
        in_space, small = task.problem.layout.round, task.problem.joints <= _SIMPLEX_UP_TO
        self._search = None
        if small and not in_space:
            self._search = Search(refiner_of(task), passes.over, self.met)
        self.descend = in_space or small
        self._lowest: ExactState | None = None
        self._by_programs: Answer | None = None
        self._of_sides: Answer | None = None

    @property
    def answer(self) -> Answer | None:
        """The lowest state: by simplex, or by programs, in space of cones; where these lead to none there,
        that of a pass over rigid contacts, under the sides of cones."""
        if self._lowest:
            return self._lowest.answer
        return self._by_programs or self._of_sides

    def near(self, start: Answer | State) -> None:
        """Look for a state near forces: by simplex, or else by two programs in turn."""
        if self._search:
            self._keep(self._search.start(start.q).state)
        if self._lowest is None:
            found = alternated(self._problem, start.load_factor, start.q, self._effort)
            if found is None and isinstance(start, Answer) and start.exact:
                found = start
            found = found and self._recorded(found)
            self._by_programs = _exact_or_lower(self._by_programs, found)
            if self._problem.layout.round:
                self.met.count(found if found is not None and found.exact else None)
        if self.answer is None and self._problem.layout.round:
            # Where nothing slides between the corners of a polygon it is a state of the cone too.
            given = (
                certified(problem, start.load_factor, start.q, start.d)
                for problem in (self._problem.by_cone, self._problem)
            )
            self._of_sides = next((one for one in given if not one.failing(Kind.ONE_PASS)), None)

    def further(self) -> None:
        """Look further on small scenes in the plane."""
        search = self._search
        if search is None or self._problem.joints > SMALL:
            return
        if self._lowest is None:
            # Of blocks of very different sizes the vertex that a stalled pass led to may lead nowhere else.
            search = Search(Refiner(self._problem, self._effort), self._passes.over, self.met)
        for candidate in search.few(self._lowest):
            self._keep(candidate.state)
        self._next_to_products(search)

    def _next_to_products(self, search: Search) -> None:
        """Look for states that the bracket's first program is near, on scenes where it is quick."""
        problem, lowest = self._problem, self._lowest
        limited = len(problem.crushing) > 0 or problem.B.shape[1] > 3 * problem.joints
        if lowest is None or lowest.load_factor <= ZERO or problem.joints > _PRODUCTS_UP_TO or limited:
            return
        # Declared in Pyomo.
        from masonry_opt.methods.bracket.rising import Rising, assumed_rates

        rising = Rising(problem, lowest.load_factor, assumed_rates(problem, lowest.d), self._effort)
        _, _, forces = next(rising.programs())
        for q in forces:
            self._keep(search.start(q).state)

    def _keep(self, state: ExactState | None) -> None:
        if state is not None:
            self._lowest = lower_of(self._lowest, self._recorded(state, state.below))

    def _recorded(self, state: _State, *below: float) -> _State | None:
        """Count a state that tells of the load among those met, and return it; None for any other, and for
        one below zero where the forces at rest are known."""
        if not self._passes.tells(state.load_factor, state.d):
            return None
        self.met.lowest = min(self.met.lowest, state.load_factor, *below)
        return state if self._problem.settled is None or state.load_factor >= -ZERO else None


def _exact_or_lower(one: Answer | None, other: Answer | None) -> Answer | None:
    """The one of two answers that alone is exact, else the lower."""
    exact = [answer for answer in (one, other) if answer and answer.exact]
    return exact[0] if len(exact) == 1 else lower_of(one, other)


class _Starts:
    """Forces under contacts that give, then those of passes with rigid ones. After the first of these, unless
    statics bound the load factor, a proof is sought that there is none; without it others follow under other
    brakes, where a pass takes longer than further starts.

    Attributes
    ----------
    known: a solution without answer, with what is known beside it: the associative load factor, and what is
        proven.
    """

    def __init__(self, task: Task, passes: Passes, history: list[Any]) -> None:
        self._task, self._passes, self._history = task, passes, history
        self.known = Solution(Status.SOLVER_FAILED, Kind.EXACT)

    def __iter__(self) -> Iterator[Answer | State]:
        task, history = self._task, self._history
        effort, joints = task.effort, task.problem.joints
        effort.begins("contacts that give")
        expected = task.expected
        known = expected is not None and (history or expected.answer)
        given = expected.answer if expected and known else pushed(task, history)
        if given is not None:
            yield given
        attempt = _passes_in(history)
        for number, brake in enumerate(BRAKES, start=1):
            effort.begins("rigid contacts")
            if last := follow(task, self._passes, history, attempt + number, brake):
                yield last
            if number == 1:
                if joints > PASSES_UP_TO:
                    return
                self._look_beside()
                if self.known.proven_none:
                    return
                if joints <= SMALL:
                    break

    def _look_beside(self) -> None:
        self.known = with_associative(self._task, self.known)
        if self.known.associative is None:
            # Declared in Pyomo, which takes .3 s to import.
            from masonry_opt.standing.existence import existence

            found = existence(self._task.problem, self._task.effort)
            self.known = replace(self.known, infeasibility=found)


def _without(task: Task, solution: Solution, lowest: float, word: str) -> Solution:
    """The end without a load factor: none was found, or all lie below zero, as the lowest; or friction jams
    the blocks, which is not proven; but from rest no multiple of the load brings them down."""
    found = solution.infeasibility
    endless = found is not None and found.existence is Existence.UNBOUNDED
    if endless and (grows := jams(task)):
        return replace(solution, status=Status.JAMMED, reasons=(grows,))
    if lowest < -ZERO:
        return solution.ended(Status.SOLVER_FAILED, Code.BELOW_ZERO, load_factor=lowest)
    attempts = _passes_in(solution.history)
    return solution.ended(Status.SOLVER_FAILED, Code.PASS_STOPPED, word=word, attempts=attempts)


def _passes_in(history: Sequence[Any]) -> int:
    return history[-1].attempt if history else 0

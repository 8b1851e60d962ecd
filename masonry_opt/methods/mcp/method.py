"""Method "mcp": an exact state of Coulomb friction next to the load to expect, the lowest of a few."""

from dataclasses import replace
from typing import Annotated, TypeVar

from pydantic import Strict

from masonry_opt.answer.acceptance import Kind
from masonry_opt.answer.answer import Answer
from masonry_opt.answer.infeasibility import Existence
from masonry_opt.answer.reasons import Code, Status
from masonry_opt.answer.solution import Solution
from masonry_opt.answer.thresholds import ZERO
from masonry_opt.methods.associative import associative, with_associative
from masonry_opt.methods.exact.alternation import alternated
from masonry_opt.methods.exact.refiner import SMALL, ExactState, refiner_of
from masonry_opt.methods.exact.search import Met, Search, lower_of
from masonry_opt.methods.loop.nonassociative import nonassociative
from masonry_opt.methods.loop.options import LoopOptions
from masonry_opt.methods.push.compliant import PUSHED_UP_TO, compliant, jams
from masonry_opt.methods.push.push import elastic_of
from masonry_opt.methods.task import Options, Task
from masonry_opt.solvers.registry import find_solver
from masonry_opt.standing.existence import existence

_State = TypeVar("_State", Answer, ExactState)

#: Joints in the plane up to which simplex makes states exact and descends: beyond, it takes longer than all
#: else, and in space there are cones.
_SIMPLEX_UP_TO = 500

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
    """Load factor of an exact state that a push from rest leads to, on small scenes the lowest of several.

    Scenes of more than 3000 joints (in space contact points) are for the loop, those whose dilatancy falls
    with stress, and those of more than 500 joints that stand and on which none is found.
    """
    if task.problem.dilatancy_depends_on_stress or task.problem.joints > PUSHED_UP_TO:
        return _by_loop(task)
    return _by_push(task)


def _by_loop(task: Task) -> Solution:
    return nonassociative(task.with_options(LoopOptions(), find_solver("cvxpy", None)))


def _by_push(task: Task) -> Solution:
    effort, options = task.effort, task.options or McpOptions()
    expected = task.expected
    if expected is None or not expected.history:
        expected = compliant(task.with_options(None))
    else:
        # The push to the load to expect is the first of this method.
        effort.uses(task.solver.name, "complementarity problem")
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
        known = _looked_beside(task, known)
        if known.proven_none:
            return known
        states.beside()
    if states.answer is None:
        # Where a push stops, as where friction is so high that hardly anything slides, statics may lead on.
        by_statics = None if known.associative is None else associative(Task(task.problem, kept=task.kept))
        if by_statics is not None and by_statics.answer is not None:
            states.near(by_statics.answer)
    if options.descent and states.descend:
        if expected.softer is not None:
            effort.begins("softer contacts")
            states.near(expected.softer.answer)
        states.further()
    answer = states.answer
    if answer is None:
        return _without(task, known, states.met.lowest, expected)
    met = tuple(states.met.reasons) if states.met.load_factors else ()
    solution = replace(known, found=answer, status=Status.CONVERGED, reasons=met)
    return solution if solution.is_exact(task.problem) else replace(solution, kind=Kind.ONE_PASS)


class _States:
    """The lowest of the exact states that forces lead to.

    Attributes
    ----------
    descend: whether further starts pay: in space, and in the plane where simplex is quick.
    met: the states.
    """

    def __init__(self, task: Task) -> None:
        self._problem, self._effort, self._elastic = task.problem, task.effort, elastic_of(task)
        self.met = Met()
        in_space, small = task.problem.layout.round, task.problem.joints <= _SIMPLEX_UP_TO
        self._search = None
        if small and not in_space:
            self._search = Search(refiner_of(task), self._elastic, self.met)
        self.descend = in_space or small
        self._lowest: ExactState | None = None
        self._by_programs: Answer | None = None

    @property
    def answer(self) -> Answer | None:
        """The lowest state: by simplex, or of the push and by programs, in space of cones."""
        return self._lowest.answer if self._lowest else self._by_programs

    def near(self, start: Answer) -> None:
        """Look for a state near forces: by simplex, or else by two programs in turn, beside those that are
        exact already."""
        if self._search:
            self._keep(self._search.start(start.q).state)
        if self._lowest is None:
            # What is exact of contacts that give may be none of rigid ones.
            start = start.certified_by(self._problem.by(start.forms), self._problem.dilatancy)
            exact = self._recorded(start) if start.exact else None
            self._by_programs = _exact_or_lower(self._by_programs, exact)
            found = alternated(self._problem, start.q, start.d if start.exact else None, self._effort)
            found = found and self._recorded(found)
            self._by_programs = _exact_or_lower(self._by_programs, found)
            if self._problem.layout.round:
                self.met.count(found if found is not None and found.exact else exact)

    def beside(self) -> None:
        """Look for a state where a push has led to none, near those of contacts with much rounder corners."""
        for found in self._elastic.beside():
            self.near(found)
            if self.answer is not None:
                return

    def further(self) -> None:
        """Look further on small scenes in the plane."""
        if self._search is None or self._problem.joints > SMALL:
            return
        for candidate in self._search.few(self._lowest):
            self._keep(candidate.state)
        self._next_to_products(self._search)

    def _next_to_products(self, search: Search) -> None:
        """Look for states that the bracket's first program is near, on scenes where it is quick."""
        problem, lowest = self._problem, self._lowest
        limited = len(problem.crushing) > 0 or problem.B.shape[1] > 3 * problem.joints
        if lowest is None or lowest.load_factor <= ZERO or problem.joints > _PRODUCTS_UP_TO or limited:
            return
        # Declared in Pyomo.
        from masonry_opt.methods.bracket.relaxation import Rising, assumed_rates

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
        if not self._elastic.tells(state.load_factor, state.d):
            return None
        self.met.lowest = min(self.met.lowest, state.load_factor, *below)
        return state if self._problem.settled is None or state.load_factor >= -ZERO else None


def _exact_or_lower(one: Answer | None, other: Answer | None) -> Answer | None:
    """The one of two answers that alone is exact, else the lower."""
    exact = [answer for answer in (one, other) if answer and answer.exact]
    return exact[0] if len(exact) == 1 else lower_of(one, other)


def _looked_beside(task: Task, known: Solution) -> Solution:
    """A solution without answer, with what is known beside it: the associative load factor, and what is
    proven."""
    known = with_associative(task, known)
    if known.associative is None:
        known = replace(known, infeasibility=existence(task.problem, task.effort))
    return known


def _without(task: Task, solution: Solution, lowest: float, expected: Solution) -> Solution:
    """The end without a load factor: none was found, or all lie below zero, as the lowest; or friction jams
    the blocks, which is not proven; but from rest no multiple of the load brings them down. What does not
    carry its dead load from rest does not stand. Where none was found of a large scene, the loop's."""
    found = solution.infeasibility
    endless = found is not None and found.existence is Existence.UNBOUNDED
    if endless and (grows := jams(replace(task, expected=expected))):
        return replace(solution, status=Status.JAMMED, reasons=(grows,))
    if lowest < -ZERO:
        return solution.ended(Status.SOLVER_FAILED, Code.BELOW_ZERO, load_factor=lowest)
    if elastic_of(task).settled is None:
        return solution.ended(Status.UNSTABLE, Code.PUSH_STOPPED, **_stopped(expected))
    by_loop = _by_loop(task) if task.problem.joints > _SIMPLEX_UP_TO else None
    if by_loop is not None and by_loop.answer is not None and not by_loop.failing():
        return by_loop
    stopped = _stopped(expected, by_loop is not None)
    return solution.ended(Status.SOLVER_FAILED, Code.PUSH_STOPPED, **stopped)


def _stopped(expected: Solution, looped: bool = False) -> dict[str, object]:
    """How a push stopped, after how many steps, and whether the loop was asked too."""
    said = next((said for said in expected.reasons if said.code is Code.PUSH_STOPPED), None)
    word = said.values["word"] if said else "no exact state lies nearby"
    return {"word": word, "steps": len(expected.history), "looped": looped}

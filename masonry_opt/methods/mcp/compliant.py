"""Method "compliant": the load to expect of a scene that stands under its weight and is then pushed.

Coulomb's problem has many states. Where contacts give a little, forces are unique and a pass is easy: with a
small elastic compliance E of each joint, Bᵀd in eqs (5) and (6) becomes Bᵀd + E (q - q₀), and all else stays:
q₀ are the forces under the dead load alone, whose slip is past when the live load comes. As contacts stiffen,
λ comes to a plateau that hardly depends on them.
"""

from __future__ import annotations

from dataclasses import replace
from math import inf, log10
from typing import Annotated, Any

from pydantic import Field, Strict, model_validator

from masonry_opt.answer.acceptance import SMALLEST, Kind, over_load_factor
from masonry_opt.answer.answer import Answer, Found, certified
from masonry_opt.answer.reasons import Code, Reason, reason
from masonry_opt.answer.solution import GivingState, Solution
from masonry_opt.answer.status import Status
from masonry_opt.answer.thresholds import PLATEAU, ZERO
from masonry_opt.methods.mcp.edge_form import Iterate
from masonry_opt.methods.mcp.passes import follow, prepared
from masonry_opt.methods.mcp.schedule import BRAKES
from masonry_opt.methods.push.method import by_events_from, by_push, goes_on
from masonry_opt.methods.task import Options, Task
from masonry_opt.problem.state import State

#: Compliances of the passes that look for the plateau, from soft to stiff; softer, where one ends at most.
STIFF, SOFT = (1e-3, 1e-4, 1e-5, 1e-6), (1e-2, 1e-1)

#: The same of contact points in space, where stiffer contacts more often stall a pass.
_STIFF_IN_SPACE = (3e-3, 1e-3, 3e-4, 1e-4)

#: Brakes of the passes with one compliance, the second where the first stalls.
_BRAKES = BRAKES[0], BRAKES[2]

#: The same, of the passes whose forces alone are wanted: the first that ends.
_FIRST = (1e-4, 1e-5, 1e-3, *SOFT)

#: How much softer contacts are with which a state is compared whose work is elastic.
_SOFTER = 10.0

#: The softest compliance of a curve, and its passes a decade.
_SOFTEST, _A_DECADE = 10.0, 4

#: Elastic share of the live load's work above which a state is of no collapse; and power of the stiffness
#: with which λ grows where nothing collapses: friction jams the blocks.
_ELASTIC, _GROWS = 0.5, 0.9

#: Where from rest no load brings a scene down: proven, or as passes show.
_JAMMED = (Code.JAMS, Code.GROWS_WITH_STIFFNESS)

#: The same share, which falls with the compliance, above which λ is far from its plateau: in the plane such a
#: pass is left out, which on façades takes longest.
_STILL_ELASTIC = 0.05


class CompliantOptions(Options):
    """Options of contacts that give.

    Attributes
    ----------
    give: motion of a contact of mean length under the mean contact force of the dead load, as a share of the
        motion at collapse (in which the live load does the work Σ|f_L|); by default, as little as brings λ to
        its plateau.
    curve: whether to follow λ over displacement too: ``result.curve``, some twenty passes more.
    """

    give: Annotated[float, Strict(), Field(gt=0, le=1e3)] | None = None
    curve: Annotated[bool, Strict()] = False

    @model_validator(mode="after")
    def _has_a_plateau(self) -> CompliantOptions:
        if self.curve and self.give is not None:
            raise ValueError("'curve' goes through all compliances: leave 'give' out")
        return self


def compliant(task: Task) -> Solution:
    """Load factor at the ray that a path from rest ends in; where it is not followed, with contacts so stiff
    that ten times softer ones (in space three times) change it by ``PLATEAU`` at most.

    Where they change it more, or only one pass ends, the reason says so; where nearly all work is elastic
    there is no load factor.
    """
    options = task.options or CompliantOptions()
    proven = by_push(task) if options.give is None else None
    if proven is not None and not options.curve:
        return proven
    contacts = _Contacts(task)
    if proven is None and options.give is None and goes_on(task.problem):
        begun = contacts.state(STIFF[1])
        proven = by_events_from(task, begun) if begun is not None else None
    if proven is None:
        _look_for_plateau(contacts, options)
    ending = proven or contacts.ending
    ending = _with_curve(contacts, ending) if options.curve else ending
    return replace(ending, history=(*contacts.history, *ending.history))


def pushed(task: Task, history: list[Any]) -> Answer | State | None:
    """The state at the end of the push, or the first that a pass with contacts that give ends in."""
    if (proven := by_push(task)) is not None:
        return proven.answer
    passes = prepared(task)
    for attempt, give in enumerate(_FIRST, start=1):
        if state := follow(task, passes.giving(give), history, attempt):
            return state
    return None


def jams(task: Task) -> Reason | None:
    """That the load factor grows with the stiffness of contacts; None if it does not."""
    solution = task.expected or compliant(task.with_options(None))
    return next((said for said in solution.reasons if said.code in _JAMMED), None)


def _look_for_plateau(contacts: _Contacts, options: CompliantOptions) -> None:
    """Lead contacts to an end: the plateau, the state nearest to it, or why there is none."""
    stiff = _STIFF_IN_SPACE if contacts.in_space else STIFF
    for give in stiff if options.give is None else (options.give,):
        far = not contacts.in_space and contacts.elastic * give / contacts.give > _STILL_ELASTIC
        if not far and contacts.settle(give):
            return
    if options.give is None:
        # A state that no other bears out may be of another branch than softer contacts lead to.
        if contacts.elastic <= _ELASTIC:
            contacts.last = None
            for give in sorted((*SOFT, *contacts.states), reverse=True):
                if contacts.settle(give):
                    return
        if contacts.elastic > _ELASTIC:
            grows = contacts.grows_from(contacts.state(_SOFTER * contacts.give))
            contacts.withdraw(Code.GROWS_WITH_STIFFNESS if grows else Code.STILL_ELASTIC)
            return
    if contacts.last is None:
        told = {"word": contacts.word, "attempts": contacts.attempts}
        contacts.ending = contacts.ending.ended(Status.SOLVER_FAILED, Code.PASS_STOPPED, **told)


def _with_curve(contacts: _Contacts, ending: Solution) -> Solution:
    """An end with states from the softest contacts to the stiffest of the passes before."""
    decades = round(log10(_SOFTEST / min(contacts.states, default=STIFF[1])))
    gives = [_SOFTEST / 10 ** (number / _A_DECADE) for number in range(decades * _A_DECADE + 1)]
    curve = tuple(state for give in gives if (state := contacts.state(give)))
    ending = replace(ending, curve=curve)
    if not curve:
        return ending
    load_factors = [state.answer.load_factor for state in curve]
    told = {"peak": max(load_factors), "last": load_factors[-1], "left_out": len(gives) - len(curve)}
    return ending.telling(reason(Code.CURVE, states=len(curve), **told))


class _Contacts:
    """Passes over a problem with contacts that give.

    Attributes
    ----------
    ending: the solution that they lead to, but for its history.
    history: a record of each step.
    in_space: whether they are contact points in space.
    states: that the passes so far ended in, by compliance; None of those that ended in none.
    word, attempts: how the last pass ended, and the number of passes.
    last: the state that decides on the end; None before the first.
    """

    def __init__(self, task: Task) -> None:
        self._task, self._passes = task, prepared(task)
        self.ending = Solution(Status.SOLVER_FAILED, Kind.COMPLIANT, solver=task.solver)
        self.history: list[Any] = []
        self.in_space = task.problem.layout.round
        self._settled = task.problem.settled
        if self._settled is None:
            with task.effort.measure("solve"):
                self._settled = self._passes.settled_forces()
        self.states: dict[float, GivingState | None] = {}
        self.word, self.attempts = "", 0
        self.last: GivingState | None = None
        self._inside: Iterate | None = None

    @property
    def give(self) -> float:
        """Compliance of the last state."""
        return self.last.give if self.last else inf

    @property
    def elastic(self) -> float:
        """Elastic share of the work there."""
        return _elastic_share(self.last) if self.last else 0.0

    def state(self, give: float) -> GivingState | None:
        """The state with this compliance; None if no pass ends in one."""
        if give not in self.states:
            self.states[give] = self._ended(give)
        return self.states[give]

    def _ended(self, give: float) -> GivingState | None:
        self._task.effort.begins(f"contacts that give by {give:.0e}")
        passes = self._passes.giving(give, self._settled)
        tries: list[tuple[float, Iterate | None]] = [(brake, None) for brake in _BRAKES]
        if self.in_space and self._inside:
            # On a plateau stiffer contacts change no forces: a step leads from one state to the other.
            tries.insert(0, (_BRAKES[0], self._inside))
        for brake, begun in tries:
            self.attempts += 1
            state = follow(self._task, passes, self.history, self.attempts, brake, begun)
            self.word = str(passes.outcome)
            if state is not None:
                answer = certified(passes.problem, state.load_factor, state.q, state.d)
                if not answer.failing(Kind.COMPLIANT):
                    self._inside = passes.inside
                    return GivingState(give, passes.problem, answer)
        return None

    def settle(self, give: float) -> bool:
        """Whether a pass with this compliance decides on the load factor, or that there is none."""
        state, before = self.state(give), self.last
        if state is None:
            return False
        self.last = state
        change = softer = None
        if before is not None:
            found, softer = state.answer.load_factor, before.give / give
            change = over_load_factor(abs(found - before.answer.load_factor), found)
        decided = change is not None and change <= PLATEAU
        told = {"give": give, "change": change, "softer": softer, "steps": len(self.history)}
        code = Code.PLATEAU if decided else Code.NO_PLATEAU
        self.ending = replace(self.ending, found=state.answer).ended(Status.CONVERGED, code, **told)
        if self.grows_from(before):
            self.withdraw(Code.GROWS_WITH_STIFFNESS)
            return True
        return decided

    def grows_from(self, softer: GivingState | None) -> bool:
        """Whether the last load factor has grown with the stiffness of contacts, and nothing bounds it."""
        from masonry_opt.methods.associative import with_associative

        if self.last is None or softer is None:
            return False
        low, high = softer.answer.load_factor, self.last.answer.load_factor
        if min(low, high) <= ZERO or log10(high / low) <= _GROWS * log10(softer.give / self.give):
            return False
        # However stiff contacts are, no load factor exceeds the associative one.
        self.ending = with_associative(self._task, self.ending)
        return self.ending.associative_ended in (Status.UNLIMITED, Status.LOCKED)

    def withdraw(self, code: Code) -> None:
        """End without the last state, whose work is elastic."""
        told = {"load_factor": self.ending.load_factor, "give": self.give, "elastic": self.elastic}
        self.ending = replace(self.ending, found=Found()).ended(Status.SOLVER_FAILED, code, **told)


def _elastic_share(state: GivingState) -> float:
    """Elastic energy E (q - q₀)·(q - q₀), over the live load's work."""
    answer, problem = state.answer, state.problem
    work = max(abs(answer.load_factor), SMALLEST) * problem.live_norm
    more = answer.q if problem.settled is None else answer.q - problem.settled
    return float(more @ (problem.compliance * more)) / work

"""What a method returns, before names and units are put to it."""

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from math import inf
from typing import Any, Self

import numpy as np

from masonry_opt.answer.acceptance import Kind
from masonry_opt.answer.answer import Answer, Found, InfeasibilityCertificate
from masonry_opt.answer.reasons import Code, Reason, Status, reason
from masonry_opt.problem.problem import Of, Problem
from masonry_opt.solvers.registry import LpSize, Solver


@dataclass(frozen=True, eq=False)
class GivingState:
    """A state of contacts that give elastically."""

    give: float  #: how much, over the motion of the live load
    problem: Problem  #: with that compliance
    answer: Answer  #: λ, forces and motion


@dataclass(frozen=True, eq=False)
class Way:
    """Keyframes of a push, from rest to three times as far as to where λ stays."""

    problem: Problem  #: whose contacts give by one in their own units, in which d and u are
    displacement: np.ndarray  #: u, work of the live load over Σ|f_L|, shape (k,)
    load_factor: np.ndarray  #: λ, shape (k,)
    d: np.ndarray  #: displacements from rest, shape (k, 3b)
    q: np.ndarray  #: forces of the contacts' law there, shape (k, 3c)
    rounding: float  #: of that law, in mean forces: by so much contacts at yield have moved, if by no more


@dataclass(frozen=True, eq=False)
class Solution:
    """How an analysis ended, in the problem's dimensionless units."""

    status: Status  #: how
    kind: Kind  #: of answer, which decides what its certificate must show
    reasons: tuple[Reason, ...] = ()  #: why, in codes
    #: The answer, if the status is usable; else what forces and velocities there are.
    found: Found = field(default_factory=Found)
    flow_rule_matters: bool = True  #: False if the associative answer already obeys the joints' own flow rule
    exact_end: bool = False  #: whether the loop ended with forces that obey the true law exactly
    history: tuple[Any, ...] = ()  #: one record a step of the method
    stationary: bool | None = None  #: whether a refined state stays: no mechanism tried at yield lowers λ
    associative: float | None = None  #: λ with associative flow; None where unlimited, or not computed
    associative_ended: Status | None = None  #: how a program ended that was solved for it alone
    #: What method "compliant" found beside, or why it was not asked; None if switched off, or a scene falls.
    expected: "Solution | None" = None
    bound: float | None = None  #: lower bound of λ, of method "global"; the reasons list its assumptions
    bound_derived: bool = False  #: True if the bound assumes nothing
    #: Starts from which exact states were looked for; None of methods that do not look for several states.
    starts: int | None = None
    exact_states: int | None = None  #: number of different exact states found from these starts
    #: Load factor, zero or below, of an exact state found besides the answer; infinite without such a state.
    below_zero: float = inf
    #: True if no other load factor above zero can be one of collapse, as equilibrium alone fixes all forces.
    is_only_state: bool = False
    interrupted: bool = False  #: True if the user ended the method, so that a longer run may find a lower λ
    #: True if the load history was followed to its end: blocks move on for ever, or λ stays constant.
    followed_to_end: bool = False
    #: Largest λ of the load history where its end lies lower; None where the end is the largest.
    peak: float | None = None
    infeasibility: InfeasibilityCertificate | None = None  #: what is proven where there is no λ, if tried
    size: LpSize | None = None  #: of the linear program
    curve: tuple[GivingState, ...] | None = None  #: of contacts that give less and less, if asked for
    way: Callable[[], Way | None] | None = None  #: makes keyframes of a push, which few ask for
    #: Of a push in space, the state of contacts that are soft still, from which lower ones are sought.
    softer: GivingState | None = None
    solver: Solver | None = None  #: of the method that ended with it, which another may have asked

    q = Of[np.ndarray | None]("found")
    d = Of[np.ndarray | None]("found")

    @property
    def answer(self) -> Answer | None:
        """The state with a load factor, and its certificate."""
        return self.found if isinstance(self.found, Answer) else None

    @property
    def load_factor(self) -> float | None:
        """λ of the answer."""
        return self.answer.load_factor if self.answer else None

    @property
    def associative_value(self) -> float | None:
        """Load factor with associative flow: its own if its flow is that; None if it was not computed."""
        return self.load_factor if self.kind is Kind.ASSOCIATIVE else self.associative

    @property
    def at_expected(self) -> "Solution | None":
        """The solution of the incremental analysis: this one, or the one beside it; None without either."""
        return self if self.kind is Kind.COMPLIANT else self.expected

    @property
    def expected_value(self) -> float | None:
        """Largest load factor of the load history; None if it was not computed or has no end."""
        state = self.at_expected
        if state is None:
            return None
        return state.peak or state.load_factor

    @property
    def end(self) -> float | None:
        """Load factor at the end of the load history; None if the history was not followed to its end."""
        state = self.at_expected
        return state.load_factor if state and state.followed_to_end else None

    def has(self, code: Code) -> bool:
        """Return True if one of the reasons has a code."""
        return any(said.code is code for said in self.reasons)

    def values_of(self, code: Code) -> dict[str, Any]:
        """Return the values of the reason with a code; empty if the solution has no such reason."""
        return next((said.values for said in self.reasons if said.code is code), {})

    @property
    def proven_none(self) -> bool:
        """Whether it is proven that no load factor exists."""
        return self.infeasibility is not None and self.infeasibility.proven

    @property
    def carries_any_load(self) -> bool:
        """Whether the scene stands and no multiple of the live load makes it collapse: proven, or the
        associative program is unbounded. The status of a Coulomb method proves nothing."""
        if self.status is Status.UNSTABLE:
            return False
        endless = self.kind is Kind.ASSOCIATIVE and self.status in (Status.UNLIMITED, Status.LOCKED)
        return endless or self.proven_none

    def is_exact(self, problem: Problem) -> bool:
        """Whether it is an exact Coulomb state under the joints' own flow rule, in space by the cone."""
        answer = self.answer
        if answer is None:
            return False
        return answer.certified_by(problem.by(answer.forms).by_cone, problem.dilatancy).exact

    def ended(self, status: Status, code: Code, **values: Any) -> Self:
        """Return a solution with a status and its one reason, without the facts that other reasons state."""
        return replace(
            self,
            status=status,
            reasons=(reason(code, **values),),
            starts=None,
            exact_states=None,
            below_zero=inf,
            is_only_state=False,
            interrupted=False,
            followed_to_end=False,
            peak=None,
        )

    def telling(self, *more: Reason) -> Self:
        """The same with more reasons."""
        return replace(self, reasons=(*self.reasons, *more))

    def telling_first(self, why: Reason) -> Self:
        """The same with a reason before all others."""
        return replace(self, reasons=(why, *self.reasons))

    def withdrawn(self, status: Status, code: Code, **values: Any) -> Self:
        """The same, with the status and the one reason for which what was found is no answer."""
        found = self.found
        kept = Found(q=found.q, d=found.d, slope=found.slope, forms=found.forms)
        return replace(self.ended(status, code, load_factor=self.load_factor, **values), found=kept)

    def failing(self) -> dict[str, float | None]:
        """Residuals that exceed the limits of its kind; none without an answer."""
        return self.answer.failing(self.kind) if self.answer else {}

    def accepted(self) -> Self:
        """Itself where its certificate bears the answer out, else without it."""
        if failing := self.failing():
            return self.withdrawn(Status.SOLVER_FAILED, Code.NOT_CERTIFIED, residuals=failing)
        return self

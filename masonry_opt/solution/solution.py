"""Solutions that methods return, as numbers without the names and units of the scene."""

from dataclasses import dataclass, field, replace
from math import inf
from typing import Any, Self

import numpy as np

from masonry_opt.brief import brief
from masonry_opt.problem.problem import Problem
from masonry_opt.solution.acceptance import Kind
from masonry_opt.solution.answer import Answer, FinalState, InfeasibilityCertificate
from masonry_opt.solution.load_history import LoadHistory, LoadStep
from masonry_opt.solution.proof import Proof
from masonry_opt.solution.reasons import Code, Reason, Status, reason
from masonry_opt.solution.stability import Stability
from masonry_opt.solvers.registry import LpSize, Solver


@dataclass(frozen=True)
class LogEntry:
    """Log entry for one step of a method with several steps."""

    step: str  #: name of the step
    load_factor: float | None  #: lowest load factor known after the step
    exact_states: int  #: number of different exact states known after the step
    seconds: float  #: duration of the step
    note: str = ""  #: additional information about the step, as text


@dataclass(frozen=True, eq=False)
class Solution:
    """Outcome of a method: status, answer and reasons, in the dimensionless units of the problem."""

    status: Status  #: status in which the analysis ended
    kind: Kind  #: kind of the answer, such as "exact", which determines the limits of its residuals
    reasons: tuple[Reason, ...] = ()  #: reasons for the status, as codes
    #: Answer, if the status is usable; otherwise the forces and velocities that are known.
    state: FinalState = field(default_factory=FinalState)
    #: False if the associative answer already satisfies the joints' own flow rule.
    flow_rule_matters: bool = True
    exact_end: bool = False  #: True if the loop ended with forces that satisfy the exact friction law
    history: tuple[Any, ...] = ()  #: one record for each step of the method
    #: True if the search (option ``search``) tried other mechanisms, and none of them lowers λ. None if
    #: unknown.
    stationary: bool | None = None
    associative: float | None = None  #: λ with associative flow; None if unlimited or not computed
    #: Status of a program that was solved only for the value ``associative``; None if there was none.
    associative_ended: Status | None = None
    #: Solution of method "incremental", or a solution with the reasons why the method was not run. None if
    #: the incremental load factor was not requested, or if the scene is unstable under its dead load.
    incremental: "Solution | None" = None
    #: Lower bound on λ from ``proof`` or from method "global". If method "global" assumed limits on rates and
    #: forces, ``reasons`` state these limits.
    bound: float | None = None
    #: True if ``proof`` proves the bound, or if method "global" computed the bound without assumed limits on
    #: rates and forces.
    bound_derived: bool = False
    proof: Proof | None = None  #: proof that no collapse state has a lower λ; None if there is no proof
    #: Number of starts of the search for exact states; None if the method does not search.
    starts: int | None = None
    exact_states: int | None = None  #: number of different exact states found from all starts
    #: Load factor of an exact state with λ ≤ 0 that is not the answer; infinite if no such state was found.
    below_zero: float = inf
    #: True if equilibrium alone determines all forces, and it is proven that no other load factor above zero
    #: causes collapse.
    is_only_state: bool = False
    #: True if the user or the time limit ended the method, so that a longer run may find a lower λ.
    interrupted: bool = False
    #: True if the load history was followed to its end, and the answer is the exact state at this end.
    followed_to_end: bool = False
    #: Largest load factor of the load history, if the load history ends at a lower load factor; otherwise
    #: None.
    peak: float | None = None
    #: Proof that no load factor exists, or the undecided result of an attempt to prove it; None if no proof
    #: was attempted.
    infeasibility: InfeasibilityCertificate | None = None
    #: Safety margins of a scene that has no live load and is stable; None for all other scenes.
    stability: Stability | None = None
    size: LpSize | None = None  #: size of the linear program
    tells_curve: bool = False  #: True if the user requested the load–displacement curve
    log: tuple[LogEntry, ...] = ()  #: one entry for each step of a method with several steps
    #: Solver that computed this solution. It may differ from the solver that the user chose, because a method
    #: can run other methods with other solvers. None if the method does not state its solver.
    solver: Solver | None = None

    __repr__ = brief

    @property
    def q(self) -> np.ndarray | None:
        """Joint forces of the state in which the method ended, shape (3c + t,); None if unknown."""
        return self.state.q

    @property
    def d(self) -> np.ndarray | None:
        """Block velocities of the state in which the method ended, shape (3b,); None if unknown."""
        return self.state.d

    @property
    def answer(self) -> Answer | None:
        """Collapse state with its load factor and certificate; None if there is no load factor."""
        return self.state if isinstance(self.state, Answer) else None

    @property
    def load_history(self) -> LoadHistory | None:
        """Load history of the method; None if the method has no load steps."""
        if not self.history or not isinstance(self.history[0], LoadStep):
            return None
        return LoadHistory(self.history)

    @property
    def load_factor(self) -> float | None:
        """Load factor λ of the answer; None if there is no answer."""
        return self.answer.load_factor if self.answer else None

    @property
    def associative_value(self) -> float | None:
        """Load factor with associative flow; None if it was not computed.

        For a method with associative flow it is the load factor of the answer.
        """
        return self.load_factor if self.kind is Kind.ASSOCIATIVE else self.associative

    @property
    def at_incremental(self) -> "Solution | None":
        """Solution of the incremental analysis; None if no incremental analysis was requested.

        It is ``self`` if this solution is incremental, and otherwise ``self.incremental``. It is also None
        if the scene is unstable under its dead load.
        """
        return self if self.kind is Kind.INCREMENTAL else self.incremental

    @property
    def incremental_value(self) -> float | None:
        """Largest load factor of the load history; None unless the history ends in an accepted collapse."""
        state = self.at_incremental
        if state is None:
            return None
        return state.peak or state.load_factor

    @property
    def end(self) -> float | None:
        """Load factor at the end of the load history; None if the history was not followed to its end."""
        state = self.at_incremental
        return state.load_factor if state and state.followed_to_end else None

    def has(self, code: Code) -> bool:
        """Return True if one of the reasons has the given code."""
        return any(entry.code is code for entry in self.reasons)

    def values_of(self, code: Code) -> dict[str, Any]:
        """Return the values of the reason with the given code; empty if no reason has the code."""
        return next((entry.values for entry in self.reasons if entry.code is code), {})

    @property
    def proven_none(self) -> bool:
        """True if it is proven that no load factor exists."""
        return self.infeasibility is not None and self.infeasibility.proven

    @property
    def carries_any_load(self) -> bool:
        """True if the scene is stable, and it is proven that no multiple of the live load causes collapse.

        The evidence is a proof or an unbounded associative program. The status of a Coulomb method is not
        sufficient.
        """
        if self.status is Status.UNSTABLE:
            return False
        is_unbounded = self.kind is Kind.ASSOCIATIVE and self.status in (Status.UNLIMITED, Status.LOCKED)
        return is_unbounded or self.proven_none

    def is_exact(self, problem: Problem) -> bool:
        """Return True if the answer is an exact Coulomb state for the joints' own dilatancy.

        In space friction is limited by the cone.
        """
        answer = self.answer
        if answer is None:
            return False
        return answer.certified_by(problem.by(answer.forms).by_cone, problem.dilatancy).exact

    def ended(self, status: Status, code: Code, **values: Any) -> Self:
        """Return a copy of the solution with a new status and a new reason instead of all former reasons.

        Data about the former answer are reset to their defaults.
        """
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
        """Return a copy of the solution with the given reasons appended to its present reasons."""
        return replace(self, reasons=(*self.reasons, *more))

    def telling_first(self, why: Reason) -> Self:
        """Return a copy of the solution with a reason placed before all other reasons."""
        return replace(self, reasons=(why, *self.reasons))

    def withdrawn(self, status: Status, code: Code, **values: Any) -> Self:
        """Return a copy of the solution without its load factor, with the reason for the withdrawal.

        The forces and velocities remain available.
        """
        state = self.state
        without_load_factor = FinalState(q=state.q, d=state.d, slope=state.slope, forms=state.forms)
        ended = self.ended(status, code, load_factor=self.load_factor, **values)
        return replace(ended, state=without_load_factor)

    def failing(self) -> dict[str, float | None]:
        """Return the residuals that exceed the limits for the kind of answer; empty if there is no answer."""
        return self.answer.failing(self.kind) if self.answer else {}

    def accepted(self) -> Self:
        """Return the solution, or a copy without its load factor if a residual exceeds its limit."""
        failing = self.failing()
        if failing:
            return self.withdrawn(Status.SOLVER_FAILED, Code.NOT_CERTIFIED, residuals=failing)
        return self

"""What a method returns, before names and units are put to it."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np

from masonry_opt.answer.acceptance import LIMITS, Kind, residuals
from masonry_opt.answer.infeasibility import InfeasibilityCertificate
from masonry_opt.answer.reasons import Code, Reason, reason
from masonry_opt.answer.status import Status
from masonry_opt.problem.problem import Problem
from masonry_opt.problem.state import State
from masonry_opt.solvers.lp import LpSize


@dataclass
class Solution:
    """How an analysis ended, in the problem's dimensionless units.

    Attributes
    ----------
    status: how.
    kind: of answer, which decides what its certificate must show.
    reasons: why, in codes.
    load_factor: λ, None unless the status is usable.
    q, d: joint forces (3c,) and block velocities (3b,), where there are any.
    slope: opening per unit slip under the flow rule the answer claims, shape (k,).
    flow_rule_matters: False if the associative answer already obeys the joints' own flow rule.
    exact_end: whether the loop ended with forces that obey the true law exactly.
    history: one record a step of the method.
    stationary: of a refined state: True if no mechanism tried among the faces at yield lowers λ.
    associative: associative load factor; None where it is unlimited or nobody computed it.
    bound: lower bound of λ, of the bracket; what it assumes, if anything, stands in the reasons.
    bound_derived: whether it assumes nothing.
    parabola: whether crushing was limited by the parabola itself and not by its chords.
    infeasibility: what is proven where there is no λ; None if nobody looked.
    size: of the linear program.
    """

    status: Status
    kind: Kind
    reasons: list[Reason] = field(default_factory=list)
    load_factor: float | None = None
    q: np.ndarray | None = None
    d: np.ndarray | None = None
    slope: np.ndarray | None = None
    flow_rule_matters: bool = True
    exact_end: bool = False
    history: list[Any] = field(default_factory=list)
    stationary: bool | None = None
    associative: float | None = None
    bound: float | None = None
    bound_derived: bool = False
    parabola: bool = False
    infeasibility: InfeasibilityCertificate | None = None
    size: LpSize | None = None

    @property
    def associative_value(self) -> float | None:
        """Load factor with associative flow: its own if it claims that; None if nobody computed it."""
        return self.load_factor if self.kind is Kind.ASSOCIATIVE else self.associative

    @property
    def proven_none(self) -> bool:
        """Whether it is proven that no load factor exists."""
        return self.infeasibility is not None and self.infeasibility.proven

    @property
    def interrupted(self) -> bool:
        """Whether the user ended the method, which gives what it had by then."""
        return any(said.values.get("interrupted", False) for said in self.reasons)

    @property
    def states_met(self) -> int | None:
        """How many different exact states were met on the way; None of methods that look for none."""
        met = (said.values["count"] for said in self.reasons if said.code is Code.STATES_MET)
        return next(met, None)

    @property
    def carries_any_load(self) -> bool:
        """Whether the scene stands, and no multiple of the live load makes it collapse: it is proven that no
        load factor exists, or the program of associative flow, which alone decides there, has no end. Of a
        Coulomb method a status proves nothing."""
        if self.status is Status.UNSTABLE:
            return False
        endless = self.kind is Kind.ASSOCIATIVE and self.status in (Status.UNLIMITED, Status.LOCKED)
        return endless or self.proven_none

    def take(self, state: State) -> None:
        """Keep a state's forces and velocities."""
        self.q, self.d = state.q, state.d

    def end(self, status: Status, code: Code, **values: Any) -> None:
        """Set the status, and the one reason for it."""
        self.status, self.reasons = status, [reason(code, **values)]

    def add(self, code: Code, **values: Any) -> None:
        """Add a reason."""
        self.reasons.append(reason(code, **values))

    def failing(self, problem: Problem) -> dict[str, float | None]:
        """Residuals that exceed the limits of its kind; none if it passes or there is no load factor."""
        if self.load_factor is None or self.q is None or self.d is None:
            return {}
        slope = problem.dilatancy if self.slope is None else self.slope
        left = residuals(problem, self.load_factor, self.q, self.d, slope, self.parabola)
        return LIMITS[self.kind].failing(left)

    def accept(self, problem: Problem) -> bool:
        """Whether its own certificate bears it out; if not, its load factor is taken away."""
        failing = self.failing(problem)
        if failing:
            self.end(
                Status.SOLVER_FAILED, Code.NOT_CERTIFIED, load_factor=self.load_factor, residuals=failing
            )
            self.load_factor = None
        return not failing

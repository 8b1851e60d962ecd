"""What a solver says of one linear program, whichever language declared it."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum

from masonry_opt.problem.state import State


class Outcome(Enum):
    """What a linear program turned out to be, seen from the statics."""

    OPTIMAL = "optimal"
    #: Eq. (9) is infeasible, eq. (10) unbounded.
    NO_EQUILIBRIUM = "no equilibrium"
    #: Eq. (9) is unbounded, eq. (10) infeasible.
    NO_MECHANISM = "no mechanism"
    #: A presolve that stops at "infeasible or unbounded".
    NEITHER_KNOWN = "no equilibrium or no mechanism"
    FAILED = "solver failed"


@dataclass(frozen=True)
class Answer:
    """One solve.

    Attributes
    ----------
    outcome: what the program turned out to be.
    word: the solver's own word for it.
    state: the optimum; None unless ``outcome`` is OPTIMAL.
    iterations: the solver's own iterations (interior point or simplex).
    seconds: the solver's own time.
    """

    outcome: Outcome
    word: str
    state: State | None
    iterations: int
    seconds: float


@dataclass(frozen=True)
class LpSize:
    """Size of the linear program as the solver received it."""

    rows: int
    columns: int
    nonzeros: int


def outcome_of(formulation: str, *, infeasible: bool, unbounded: bool) -> Outcome:
    """Translate a solver's verdict on one formulation; both flags: it does not know which."""
    if infeasible and unbounded:
        return Outcome.NEITHER_KNOWN
    if formulation == "kinematic":
        infeasible, unbounded = unbounded, infeasible
    if infeasible:
        return Outcome.NO_EQUILIBRIUM
    return Outcome.NO_MECHANISM if unbounded else Outcome.FAILED

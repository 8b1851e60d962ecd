"""What a solver says of one linear program, whichever language declared it."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum

from masonry_opt.problem.state import State


class Verdict(Enum):
    """What a solver found of a program."""

    OPTIMAL = "optimal"
    INFEASIBLE = "infeasible"
    UNBOUNDED = "unbounded"
    #: A presolve that stops at "infeasible or unbounded".
    INFEASIBLE_OR_UNBOUNDED = "infeasible or unbounded"
    FAILED = "solver failed"


@dataclass(frozen=True)
class Solved:
    """One solve.

    Attributes
    ----------
    verdict: what the program turned out to be.
    status: the solver's own.
    seconds: the solver's own time.
    """

    verdict: Verdict
    status: str
    seconds: float

    @property
    def optimal(self) -> bool:
        """Whether there is an optimum to read."""
        return self.verdict is Verdict.OPTIMAL

    @property
    def failed(self) -> bool:
        """Whether the solver did not find out what the program is."""
        return self.verdict is Verdict.FAILED


@dataclass(frozen=True)
class LpAnswer:
    """A solve of eq. (9) or eq. (10), with the state at the optimum if there is one."""

    solved: Solved
    state: State | None


@dataclass(frozen=True)
class LpSize:
    """Size of a linear program as the solver received it."""

    rows: int
    columns: int
    nonzeros: int

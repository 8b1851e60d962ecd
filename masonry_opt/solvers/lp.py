"""The outcome of one linear program, in either modelling language."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum

from masonry_opt.problem.state import State


class Verdict(Enum):
    """Outcome of a solve."""

    OPTIMAL = "optimal"
    INFEASIBLE = "infeasible"
    UNBOUNDED = "unbounded"
    #: A presolve that stops at "infeasible or unbounded".
    INFEASIBLE_OR_UNBOUNDED = "infeasible or unbounded"
    FAILED = "solver failed"
    #: A point short of the solver's tolerance, which a certificate must judge.
    NEARLY = "nearly optimal"


@dataclass(frozen=True)
class Solved:
    """One solve: its outcome, the same in the solver's own words, and the solver's own time (s)."""

    verdict: Verdict
    status: str
    seconds: float

    @property
    def optimal(self) -> bool:
        """Whether there is an optimum to read."""
        return self.verdict is Verdict.OPTIMAL

    @property
    def failed(self) -> bool:
        """Whether the solver decided nothing."""
        return self.verdict in (Verdict.FAILED, Verdict.NEARLY)


@dataclass(frozen=True)
class LpAnswer:
    """A solve of eq. (9) or eq. (10), with the state at the optimum, or near it, if there is one."""

    solved: Solved
    state: State | None


@dataclass(frozen=True)
class LpSize:
    """Size of a linear program as the solver received it."""

    rows: int
    columns: int
    nonzeros: int

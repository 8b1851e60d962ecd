"""How an analysis can end."""

from __future__ import annotations

from enum import StrEnum


class Status(StrEnum):
    """How an analysis ended; only the first two come with a load factor."""

    OPTIMAL = "optimal"
    CONVERGED = "converged"
    ITERATION_LIMIT = "not converged: iteration limit"
    CYCLING = "not converged: cycling"
    NO_STATE = "not converged: a sub-problem has no equilibrium state"
    HOMOTOPY = "not converged: the relaxation could not be followed to its end"
    UNSTABLE = "unstable under dead load"
    STANDS = "stands under dead load"
    UNLIMITED = "unlimited: the live load cannot cause collapse"
    LOCKED = "unlimited: dilatancy locks the blocks"
    JAMMED = "unlimited: friction jams the blocks"
    SOLVER_FAILED = "solver failed"

    @property
    def usable(self) -> bool:
        """Whether there is a load factor to use."""
        return self in (Status.OPTIMAL, Status.CONVERGED)

    @property
    def live_load_acts(self) -> bool:
        """Whether the live load acts on what was found, forces or a motion; else the dead load alone."""
        return self not in (Status.UNSTABLE, Status.STANDS)

"""Cache of what is compiled for a problem, for those that differ from it in the joints' law alone."""

from __future__ import annotations

from collections.abc import Callable, Hashable
from typing import Protocol, Self, TypeVar, cast

from masonry_opt.effort import Effort
from masonry_opt.problem.problem import Problem


class Keepable(Protocol):
    """Programs or factors that serve for other friction, cohesion and dilatancy."""

    def again_for(self, problem: Problem, effort: Effort) -> Self:
        """The same for a problem of which :meth:`~.problem.Problem.same_program` holds, solved from a cold
        start and counted in another effort."""


_T = TypeVar("_T", bound=Keepable)


class Kept:
    """Programs and factors by what they are for, one each.

    What is kept may change the time of an analysis, never its load factor: every solve begins cold. (Forces
    kept of another scene may show that a scene stands, where a solver alone would not decide.)

    Parameters
    ----------
    keeps: whether anything is kept; for a single analysis nothing is.
    """

    def __init__(self, keeps: bool = False) -> None:
        self.keeps = keeps
        self._held: dict[Hashable, tuple[Problem, Keepable]] = {}

    def of(self, key: Hashable, problem: Problem, effort: Effort, build: Callable[[], _T]) -> _T:
        """What is kept under a key, for this problem; built where there is nothing, or it is of other
        matrices, loads or strengths."""
        before, held = self._held.get(key, (None, None))
        if before is not None and problem.same_program(before):
            return cast(_T, held).again_for(problem, effort)
        built = build()
        if self.keeps:
            self._held[key] = problem, built
        return built

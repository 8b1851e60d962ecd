"""What was built for a problem, kept for those that differ from it in the joints' law alone."""

from __future__ import annotations

from collections.abc import Callable, Hashable
from typing import Any, TypeVar

from masonry_opt.problem.problem import Problem

_T = TypeVar("_T")


class Kept:
    """Programs and factors by what they are for, one each.

    What is kept may change the time of an analysis, never its load factor: whoever renews a program begins
    cold. (That a scene stands may be seen from forces kept of another, where a solver would be undecided.)

    Parameters
    ----------
    keeps: whether anything is kept; for a single analysis nothing is.
    """

    def __init__(self, keeps: bool = False) -> None:
        self.keeps = keeps
        self._held: dict[Hashable, tuple[Problem, Any]] = {}

    def of(self, key: Hashable, problem: Problem, build: Callable[[], _T], renew: Callable[[_T], _T]) -> _T:
        """What there is under a key, renewed for this problem; built where there is nothing, or it is of
        other matrices."""
        if self.keeps and key in self._held:
            before, held = self._held[key]
            if problem.same_matrices(before):
                return renew(held)
        built = build()
        if self.keeps:
            self._held[key] = problem, built
        return built

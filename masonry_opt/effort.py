"""Effort of an analysis: seconds by part, numbers of programs and iterations, and the solvers used."""

import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager

from masonry_opt.brief import brief

#: Function that is called with the name of each phase when the phase begins, such as "finding joints".
Phases = Callable[[str], None]

#: Parts of an analysis whose time is measured, in the order in which they run.
PARTS = (
    "scene",  # reading the scene, finding its joints, assembling the matrices
    "dead_load",  # deciding whether the scene is stable under its dead load
    "incremental",  # computing the incremental load factor in addition to the method's load factor
    "build",  # declaring the model in the modelling language
    "compile",  # converting the model to solver data, or updating the data
    "solve",  # running the solver
    "read",  # converting the solver's answer to arrays
    "associative",  # computing the associative load factor in addition to the method's load factor
)


class Effort:
    """Total time, number of solved programs and number of iterations of an analysis."""

    __repr__ = brief

    def __init__(self, begins: Phases = lambda _: None) -> None:
        """Start with zero effort.

        ``begins`` is called with the name of each phase as the phase begins.
        """
        self.begins = begins
        self.seconds = dict.fromkeys(PARTS, 0.0)  #: seconds by part
        self.lp_solves = 0  #: number of linear programs solved; in space, cone programs count too
        self.nlp_solves = 0  #: number of nonlinear programs solved
        self.iterations = 0  #: sum of the iterations of the solvers
        #: Names of the solvers by purpose, such as "dead load" or "sub-problems".
        self.solvers: dict[str, list[str]] = {}

    def uses(self, solver: str, purpose: str) -> None:
        """Record that a solver is used for a purpose."""
        names = self.solvers.setdefault(purpose, [])
        if solver not in names:
            names.append(solver)

    def beside(self) -> "Effort":
        """Return a new effort with zero counts and times that shares the record of solvers."""
        other = Effort()
        other.solvers = self.solvers
        return other

    @contextmanager
    def measure(self, part: str) -> Iterator[None]:
        """Add the duration of the ``with`` block to a part of the analysis."""
        start = time.perf_counter()
        try:
            yield
        finally:
            self.add(part, time.perf_counter() - start)

    def add(self, part: str, seconds: float) -> None:
        """Add seconds to a part."""
        self.seconds[part] += seconds

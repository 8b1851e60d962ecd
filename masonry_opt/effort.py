"""Effort of an analysis: seconds by part, numbers of programs and iterations, and the solvers used."""

import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager

#: Function that is called with the name of each phase as it begins, such as "finding joints".
Phases = Callable[[str], None]

#: Parts of an analysis, in the order in which they run.
PARTS = (
    "scene",  # read the scene, find its joints, assemble the matrices
    "dead_load",  # decide whether the scene is stable under its dead load
    "incremental",  # compute the incremental load factor in addition to a Coulomb answer
    "build",  # declare the model
    "compile",  # convert the model to solver data, or update the data
    "solve",  # run the solver
    "read",  # convert the solver's answer to arrays
    "associative",  # compute the associative load factor in addition to a Coulomb answer
)


class Effort:
    """Time, programs and iterations of an analysis, summed up."""

    def __init__(self, begins: Phases = lambda _: None) -> None:
        """Start with zero effort. ``begins`` is called with the name of each phase as it begins."""
        self.begins = begins
        self.seconds = dict.fromkeys(PARTS, 0.0)  #: seconds by part
        self.lp_solves = 0  #: number of linear programs solved, in space also of cone programs
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
        """Return a new effort with zero counts and seconds that shares the record of solvers."""
        other = Effort()
        other.solvers = self.solvers
        return other

    @contextmanager
    def measure(self, part: str) -> Iterator[None]:
        """Add the duration of the ``with`` block to a part."""
        start = time.perf_counter()
        try:
            yield
        finally:
            self.add(part, time.perf_counter() - start)

    def add(self, part: str, seconds: float) -> None:
        """Add seconds to a part."""
        self.seconds[part] += seconds

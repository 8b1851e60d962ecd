"""Effort of an analysis: seconds by part, programs and iterations, and which solver did what."""

import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager

#: Called with the name of each phase as it begins, such as "finding joints" or "sub-problem 3".
Phases = Callable[[str], None]

#: The parts of an analysis, in the order in which they happen.
PARTS = (
    "scene",  # read the scene, find its joints, assemble the matrices
    "dead_load",  # decide whether the scene is stable under its dead load
    "incremental",  # compute the incremental load factor beside a Coulomb answer
    "build",  # declare the model
    "compile",  # convert the model to solver data, or update the data
    "solve",  # the solver's own time
    "read",  # convert the solver's answer to arrays
    "associative",  # compute the associative load factor beside a Coulomb answer
)


class Effort:
    """Counts of an analysis, added up: linear programs solved, cone programs in space among them, nonlinear
    ones, and iterations of the solvers. ``begins`` is called with the name of each phase as it begins."""

    def __init__(self, begins: Phases = lambda _: None) -> None:
        self.begins = begins
        self.seconds = dict.fromkeys(PARTS, 0.0)  #: by part
        self.lp_solves = self.nlp_solves = self.iterations = 0
        #: Names of the solvers by what they did, such as "dead load" or "sub-problems".
        self.solvers: dict[str, list[str]] = {}

    def uses(self, solver: str, purpose: str) -> None:
        """Record that a solver does something."""
        names = self.solvers.setdefault(purpose, [])
        if solver not in names:
            names.append(solver)

    def beside(self) -> "Effort":
        """Another account, which shares what solvers did, but neither counts nor seconds."""
        other = Effort()
        other.solvers = self.solvers
        return other

    @contextmanager
    def measure(self, part: str) -> Iterator[None]:
        """Add the time spent inside to a part."""
        start = time.perf_counter()
        try:
            yield
        finally:
            self.add(part, time.perf_counter() - start)

    def add(self, part: str, seconds: float) -> None:
        """Add seconds to a part."""
        self.seconds[part] += seconds

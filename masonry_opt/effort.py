"""Effort of an analysis: seconds by part, programs and iterations, and which solver did what."""

import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager

#: Called with the name of each phase as it begins, such as "finding joints" or "sub-problem 3".
Phases = Callable[[str], None]

#: The parts, in the order in which they happen.
PARTS = ("scene", "dead_load", "expected", "build", "compile", "solve", "read", "associative")


class Effort:
    """Counts of an analysis, added up.

    Attributes
    ----------
    seconds: by part: ``scene`` (reading, joints, matrices), ``dead_load`` (does the scene stand?),
        ``expected`` (the load to expect beside a Coulomb answer), ``build`` (declaring the model),
        ``compile`` (to solver data, updates included), ``solve`` (the solver's own time), ``read`` (its
        answer to arrays), ``associative`` (the program beside a Coulomb answer).
    lp_solves, nlp_solves: linear programs solved, cone programs in space among them, and nonlinear ones.
    iterations: of the solvers, summed.
    solvers: names of the solvers by what they did, such as "dead load" or "sub-problems".
    begins: called with the name of each phase as it begins.
    """

    def __init__(self, begins: Phases = lambda _: None) -> None:
        self.begins = begins
        self.seconds = dict.fromkeys(PARTS, 0.0)
        self.lp_solves = self.nlp_solves = self.iterations = 0
        self.solvers: dict[str, list[str]] = {}

    def uses(self, solver: str, purpose: str) -> None:
        """Record that a solver does something."""
        names = self.solvers.setdefault(purpose, [])
        if solver not in names:
            names.append(solver)

    @contextmanager
    def beside(self) -> "Iterator[Effort]":
        """Another account, of which this one records what its solvers did, but neither counts nor seconds."""
        other = Effort()
        try:
            yield other
        finally:
            for purpose, solvers in other.solvers.items():
                for solver in solvers:
                    self.uses(solver, purpose)

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

"""Effort of an analysis: seconds by part, numbers of programs and iterations, and the solvers used."""

import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

from masonry_opt.brief import brief
from masonry_opt.deadline import check_time

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

    def __init__(self, phases: Phases = lambda _: None) -> None:
        """Start with zero effort.

        ``phases`` is called with the name of each phase as the phase begins, and again with the name and the
        load factor if a lower collapse state is found.
        """
        self._phases = phases
        self._step, self._phase = "", ""  # names of the present step of the method, and of its phase
        self._lowest: float | None = None  # load factor of the lowest collapse state found so far
        self.seconds = dict.fromkeys(PARTS, 0.0)  #: seconds by part
        self.lp_solves = 0  #: number of linear programs solved; in space, cone programs count too
        self.nlp_solves = 0  #: number of nonlinear programs solved
        self.iterations = 0  #: sum of the iterations of the solvers
        #: Names of the solvers by purpose, such as "dead load" or "sub-problems".
        self.solvers: dict[str, list[str]] = {}

    @property
    def phase(self) -> str:
        """Name of the present phase, preceded by the method's step if the phase is part of a step."""
        return ": ".join(filter(None, dict.fromkeys((self._step, self._phase))))

    def begins(self, phase: str) -> None:
        """Report that a phase begins. Raises TimeLimitReached if the time limit is over."""
        self._phase = phase
        check_time()
        self._report()

    @contextmanager
    def step(self, name: str) -> Iterator[None]:
        """Report that a step of a method begins. Phases within the ``with`` block are parts of the step."""
        self._step = name
        self.begins(name)
        try:
            yield
        finally:
            self._step, self._phase = "", self.phase

    def lowers(self, load_factor: float) -> None:
        """Report the load factor of the lowest collapse state that was found so far."""
        if load_factor != self._lowest:
            self._lowest = load_factor
            self._report()

    def _report(self) -> None:
        lowest = "" if self._lowest is None else f", lowest λ so far {self._lowest:.6g}"
        self._phases(f"{self.phase}{lowest}")

    def counts(self) -> dict[str, Any]:
        """Return the seconds, the numbers of programs and iterations, and the solvers, by name."""
        return {name: count for name, count in vars(self).items() if not name.startswith("_")}

    def uses(self, solver: str, purpose: str) -> None:
        """Record that a solver is used for a purpose."""
        names = self.solvers.setdefault(purpose, [])
        if solver not in names:
            names.append(solver)

    def beside(self) -> "Effort":
        """Return a new effort with zero counts and times. The two efforts share the record of solvers."""
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

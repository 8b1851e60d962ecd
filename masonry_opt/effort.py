"""Effort of an analysis: seconds by part, numbers of programs and iterations, and the solvers used."""

import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from math import inf
from typing import Any

from masonry_opt.brief import brief
from masonry_opt.deadline import check_time
from masonry_opt.errors import OptionError

#: Function that is called at the beginning of each phase with its name, such as "finding joints".
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


def ignore_progress(*_: object) -> None:
    """Do nothing. This is the default of the options ``progress`` and ``phases``."""


def refuse_if_no_function(name: str, value: object) -> None:
    """Raise OptionError if the value of an option is not a function."""
    if not callable(value):
        raise OptionError(f"{name} must be a function (found {value!r})")


def phases_from(options: dict[str, Any]) -> Phases:
    """Remove the option ``phases`` from the options of a study, and return its value.

    The option is documented in :func:`~masonry_opt.solve`. Raises OptionError if its value is not a function.
    """
    phases: Phases = options.pop("phases", ignore_progress)
    refuse_if_no_function("phases", phases)
    return phases


class ProgramLimitReached(Exception):
    """Raised if the limit on the number of linear programs permits no further program."""


class Effort:
    """Counter of the seconds, the solved programs and the solver iterations of an analysis."""

    __repr__ = brief

    def __init__(self, phases: Phases = ignore_progress) -> None:
        """Start with zero effort.

        ``phases`` is called with the name of each phase as the phase begins, and again with the name and the
        load factor if a lower collapse state is found.
        """
        self._phases = phases
        self._step, self._phase = "", ""  # names of the method's current step and of the current phase
        self._lowest: float | None = None  # load factor of the lowest collapse state found so far
        self.seconds = dict.fromkeys(PARTS, 0.0)  #: seconds by part
        self.lp_solves = 0  #: number of solved linear programs and cone programs
        self._most_lp_solves = inf  # value of ``lp_solves`` at which HiGHS solves no further linear program
        self.nlp_solves = 0  #: number of solved nonlinear programs
        self.iterations = 0  #: sum of the iterations of the solvers
        #: Names of the solvers by purpose, such as "dead load" or "sub-problems".
        self.solvers: dict[str, list[str]] = {}

    @property
    def phase(self) -> str:
        """Name of the current phase; during a step of the method, the name of the step comes first."""
        return ": ".join(filter(None, dict.fromkeys((self._step, self._phase))))

    def begins(self, phase: str) -> None:
        """Report that a phase begins.

        Raises TimeLimitReached if the time limit has passed.
        """
        self._phase = phase
        check_time()
        self._report()

    @contextmanager
    def step(self, name: str) -> Iterator[None]:
        """Report that the ``with`` block performs a step of the method."""
        self._step = name
        self.begins(name)
        try:
            yield
        finally:
            self._step, self._phase = "", self.phase

    @contextmanager
    def at_most(self, programs: int) -> Iterator[None]:
        """Let HiGHS solve at most ``programs`` further linear programs in the ``with`` block.

        The next program raises ProgramLimitReached. The limit is exact: no program is solved after it.
        """
        before = self._most_lp_solves
        self._most_lp_solves = min(before, self.lp_solves + programs)
        try:
            yield
        finally:
            self._most_lp_solves = before

    def check_programs(self) -> None:
        """Raise ProgramLimitReached if the limit that :meth:`at_most` has set permits no further program."""
        if self.lp_solves >= self._most_lp_solves:
            raise ProgramLimitReached

    def lowers(self, load_factor: float) -> None:
        """Report the lowest load factor of the collapse states found so far, if this value is new."""
        if load_factor != self._lowest:
            self._lowest = load_factor
            self._report()

    def _report(self) -> None:
        lowest = "" if self._lowest is None else f", lowest λ so far {self._lowest:.6g}"
        self._phases(f"{self.phase}{lowest}")

    def counts(self) -> dict[str, Any]:
        """Return the effort as a dictionary: seconds, numbers of programs and iterations, and solvers."""
        return {name: count for name, count in vars(self).items() if not name.startswith("_")}

    def uses(self, solver: str, purpose: str) -> None:
        """Record the name of a solver and the purpose for which it is used."""
        names = self.solvers.setdefault(purpose, [])
        if solver not in names:
            names.append(solver)

    def separate_counter(self) -> "Effort":
        """Return a new counter of solver work, which starts from zero, for work to be counted separately.

        Both counters share one list of solvers.
        """
        counter = Effort()
        counter.solvers = self.solvers
        return counter

    @contextmanager
    def measure(self, part: str) -> Iterator[None]:
        """Measure the duration of a ``with`` block, and add it to the time of a part of the analysis."""
        start = time.perf_counter()
        try:
            yield
        finally:
            self.add(part, time.perf_counter() - start)

    def add(self, part: str, seconds: float) -> None:
        """Add seconds to the time of a part of the analysis."""
        self.seconds[part] += seconds

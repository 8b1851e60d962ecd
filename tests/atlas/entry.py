"""What an entry of the failure atlas is made of, and how a run is held against its expectation."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import Any

from masonry_opt.analysis import solve
from masonry_opt.answer.reasons import Reason, Status
from masonry_opt.errors import CaseError, MasonryError
from masonry_opt.result import Result
from masonry_opt.scene.scene import Scene


@dataclass(frozen=True)
class Expectation:
    """One method and solver on an entry's scene, and what must come of it.

    Attributes
    ----------
    expected: the status, or CaseError where the scene must be refused.
    method, model, solver, options: as ``solve`` takes them.
    load_factor: λ, or the interval it lies in; None if nothing is said about it.
    tolerance: relative, of λ (absolute where λ is 0).
    source: of λ: a closed form, another formulation, or what is wrong with it.
    why: a reason that must be given, such as the remedy that was taken: its code, and of its values what the
        text of the value must contain.
    exact: whether it must be an exact state; of the loop, whether it must end with exact forces.
    names: what the error must name, where the scene must be refused.
    """

    expected: Status | type[CaseError]
    method: str = "nonassociative"
    model: str | None = None
    solver: str | None = None
    options: Mapping[str, Any] = field(default_factory=dict)
    load_factor: float | tuple[float, float] | None = None
    tolerance: float = 1e-6
    source: str = ""
    why: Reason | None = None
    exact: bool = False
    names: str = ""

    @property
    def name(self) -> str:
        """Method, model, solver and options in words."""
        words = [self.method, self.model, self.solver]
        own = [f"{name}={value}" for name, value in self.options.items()]
        return " ".join([*(word for word in words if word), *own])

    @property
    def interval(self) -> tuple[float, float] | None:
        """The smallest and largest λ that are as expected."""
        if self.load_factor is None:
            return None
        if isinstance(self.load_factor, tuple):
            return self.load_factor
        margin = self.tolerance * (abs(self.load_factor) or 1.0)
        return self.load_factor - margin, self.load_factor + margin


@dataclass(frozen=True)
class Entry:
    """A scene that one method or another fails on.

    Attributes
    ----------
    name: short.
    fails: what fails, and why, in a sentence.
    scene: builds the scene; given the folder of the case files.
    runs: what each method and solver must answer.
    """

    name: str
    fails: str
    scene: Callable[[Path], Scene]
    runs: tuple[Expectation, ...]


@dataclass(frozen=True)
class Observation:
    """What came of a run.

    Attributes
    ----------
    entry, run: what was run.
    result: None if ``solve`` raised.
    error: what it raised, by name and in words; "" if nothing.
    """

    entry: Entry
    run: Expectation
    result: Result | None
    error: str

    @property
    def got(self) -> str:
        """Status, or the name of what was raised."""
        return str(self.result.status) if self.result else self.error.partition(":")[0]

    @property
    def message(self) -> str:
        """The result's message, or that of the error."""
        return self.result.message if self.result else self.error.partition(": ")[2]

    @cached_property
    def difference(self) -> str:
        """What is not as expected; "" if all is."""
        if self.got != expected_text(self.run):
            return f"{self.got} ({self.message}), expected: {expected_text(self.run)}"
        if self.result is None:
            unnamed = self.run.names not in self.message
            return f"the error does not name {self.run.names}: {self.message}" if unnamed else ""
        if self.run.why and not any(map(self._shows, self.result.reasons)):
            return f"not given as a reason: {self.run.why.as_dict()}; given: {self.message}"
        if self.run.exact and not (self.result.exact or self.result.solution.exact_end):
            return f"no exact state: {self.result.certificate}"
        found, interval = self.result.load_factor, self.run.interval
        if interval and (found is None or not interval[0] <= found <= interval[1]):
            return f"λ = {found}, expected {interval[0]:.7g} to {interval[1]:.7g} ({self.run.source})"
        return ""

    def _shows(self, given: Reason) -> bool:
        """Whether a reason is the one that must be given."""
        why = self.run.why
        return (
            why is not None
            and given.code is why.code
            and all(str(part) in str(given.values[name]) for name, part in why.values.items())
        )


def expected_text(run: Expectation) -> str:
    """The expected status, or the name of the expected error."""
    return str(run.expected) if isinstance(run.expected, Status) else run.expected.__name__


def carry_out(entry: Entry, run: Expectation, cases: Path) -> Observation:
    """Run one method and solver on an entry's scene.

    A traceback is an outcome too: the atlas is where it must show.
    """
    result, error = None, ""
    try:
        result = solve(
            entry.scene(cases), run.method, model=run.model, solver=run.solver, **dict(run.options)
        )
    except MasonryError as refused:
        error = f"{type(refused).__name__}: {refused}"
    except Exception as traceback:
        error = f"traceback of {type(traceback).__name__}: {traceback}"
    return Observation(entry, run, result, error)

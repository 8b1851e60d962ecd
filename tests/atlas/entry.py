"""What an entry of the failure atlas is made of, and how a run is held against its expectation."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from masonry_opt.analysis import solve
from masonry_opt.errors import CaseError, MasonryError
from masonry_opt.scene.scene import Scene
from masonry_opt.solution.reasons import Reason, Status


@dataclass(frozen=True)
class Expectation:
    """One method and solver on an entry's scene, and what must come of it.

    Attributes
    ----------
    method, model, solver, options: as ``solve`` takes them.
    load_factor: λ, or the interval it lies in; None if nothing is said about it.
    source: of λ: a closed form, another formulation, or what is wrong with it.
    expected: the status, or CaseError where the scene must be refused.
    tolerance: relative, of λ (absolute where λ is 0).
    why: a reason that must be given, such as the remedy that was taken: its code, and of its values what the
        text of the value must contain.
    exact: whether it must be an exact state; of the loop, whether it must end with exact forces.
    names: what the error must name, where the scene must be refused.
    """

    method: str = "nonassociative"
    load_factor: float | tuple[float, float] | None = None
    source: str = ""
    expected: Status | type[CaseError] = Status.CONVERGED
    model: str | None = None
    solver: str | None = None
    options: Mapping[str, Any] = field(default_factory=dict)
    tolerance: float = 1e-6
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


def entry(name: str, fails: str, scene: Callable[[Path], Scene], *runs: Expectation) -> Entry:
    return Entry(name, fails, scene, runs)


def difference(of: Entry, run: Expectation, cases: Path) -> str:
    """What is not as expected of one method and solver on an entry's scene; "" if all is."""
    expected = getattr(run.expected, "__name__", run.expected)
    try:
        result = solve(of.scene(cases), run.method, model=run.model, solver=run.solver, **run.options)
    except MasonryError as refused:
        if type(refused) is not run.expected:
            return f"{type(refused).__name__} ({refused}), expected: {expected}"
        return "" if run.names in str(refused) else f"the error does not name {run.names}: {refused}"
    if result.status is not run.expected:
        return f"{result.status} ({result.message}), expected: {expected}"
    if run.why and not any(_shows(run.why, given) for given in result.reasons):
        return f"not given as a reason: {run.why.as_dict()}; given: {result.message}"
    if run.exact and not (result.exact or result.solution.exact_end):
        return f"no exact state: {result.certificate}"
    found, interval = result.load_factor, run.interval
    if interval and (found is None or not interval[0] <= found <= interval[1]):
        return f"λ = {found}, expected {interval[0]:.7g} to {interval[1]:.7g} ({run.source})"
    return ""


def _shows(why: Reason, given: Reason) -> bool:
    parts = why.values.items()
    return given.code is why.code and all(str(part) in str(given.values[name]) for name, part in parts)

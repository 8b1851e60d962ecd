"""Entries of the failure atlas, and the comparison of a run with its expectation."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from masonry_opt.analysis import solve
from masonry_opt.errors import CaseError, MasonryError
from masonry_opt.methods.registry import DEFAULT
from masonry_opt.scene.scene import Scene
from masonry_opt.solution.reasons import Reason, Status


@dataclass(frozen=True)
class Expectation:
    """The expected outcome of one method and solver on the scene of an entry.

    Attributes
    ----------
    method, model, solver, options: arguments of ``solve``.
    load_factor: expected λ, or an interval that must contain it; None if λ is not checked.
    source: source of λ, such as a closed form or another formulation, or the error of λ.
    expected: expected status, or CaseError if the scene must be refused.
    tolerance: relative tolerance of λ (absolute if λ is 0).
    why: a reason that the result must have, such as the remedy that was used. Each value of the reason must
        appear in the text of the result's value.
    exact: True if the result must be an exact state or, with the loop, end with exact forces.
    names: text that the error must contain if the scene must be refused.
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
        """Method, model, solver and options, separated by spaces."""
        words = [self.method, self.model, self.solver]
        own = [f"{name}={value}" for name, value in self.options.items()]
        return " ".join([*(word for word in words if word), *own])

    @property
    def interval(self) -> tuple[float, float] | None:
        """Smallest and largest λ that agree with the expectation."""
        if self.load_factor is None:
            return None
        if isinstance(self.load_factor, tuple):
            return self.load_factor
        margin = self.tolerance * (abs(self.load_factor) or 1.0)
        return self.load_factor - margin, self.load_factor + margin


@dataclass(frozen=True)
class Entry:
    """A scene on which some method fails.

    Attributes
    ----------
    name: short name.
    fails: a sentence that says which method or solver fails, and why.
    scene: function that builds the scene from the folder of the case files.
    runs: expected outcome of each method and solver.
    """

    name: str
    fails: str
    scene: Callable[[Path], Scene]
    runs: tuple[Expectation, ...]


def entry(name: str, fails: str, scene: Callable[[Path], Scene], *runs: Expectation) -> Entry:
    return Entry(name, fails, scene, runs)


def difference(of: Entry, run: Expectation, cases: Path) -> str:
    """Solve the scene of an entry, and return a description of the first difference; "" if there is none."""
    expected = getattr(run.expected, "__name__", run.expected)
    try:
        # The default begins with the load history. Other methods do not need it.
        own = {"model": run.model, "solver": run.solver, "incremental": run.method == DEFAULT}
        result = solve(of.scene(cases), run.method, **own, **run.options)
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

"""Which runs a comparison consists of: everything named, as far as methods and solvers admit it."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Sequence
from dataclasses import dataclass

from masonry_opt.errors import OptionError
from masonry_opt.methods.registry import METHODS
from masonry_opt.solvers.registry import LANGUAGES, SOLVERS, find_entry, find_solver, names


@dataclass(frozen=True, order=True)
class Pair:
    """A method and the solver it runs with, at one tolerance (None: the method's or solver's own)."""

    method: str
    model: str
    solver: str
    tolerance: float | None

    @property
    def label(self) -> str:
        """The pair without its tolerance."""
        return f"{self.method} · {self.model} · {self.solver}"


@dataclass(frozen=True)
class PlannedRun:
    """One process: a scene's name, a pair, and which of the repeats (from 1) it is."""

    scene: str
    pair: Pair
    repeat: int


@dataclass(frozen=True)
class NotApplicable:
    """A combination that was named and cannot be, and why."""

    method: str
    model: str
    solver: str
    reason: str


@dataclass(frozen=True)
class Plan:
    """The pairs of a comparison, and the combinations left out."""

    pairs: tuple[Pair, ...]
    left_out: tuple[NotApplicable, ...]

    def runs(self, scenes: Sequence[str], repeats: int) -> Iterator[PlannedRun]:
        """Every run. Repeats come last: an interrupted comparison has seen everything once."""
        for repeat in range(1, repeats + 1):
            for scene in scenes:
                for pair in self.pairs:
                    yield PlannedRun(scene, pair, repeat)


def plan(
    methods: Sequence[str], models: Sequence[str], solvers: Sequence[str], tolerances: Sequence[float]
) -> Plan:
    """The admissible combinations, by the registries METHODS and SOLVERS.

    A method with tolerances of its own has one rung; if none of its solvers is named it runs with its
    default, so that it can stand beside the others.

    Raises
    ------
    OptionError
        If a name is unknown, a tolerance is out of range, or nothing is left to run.
    """
    _known("method", methods, METHODS)
    _known("model", models, LANGUAGES)
    _known("solver", solvers, names())
    for tolerance in tolerances:
        find_solver(LANGUAGES[0], None, tolerance)  # refuses what is out of range
    pairs: list[Pair] = []
    left_out: list[NotApplicable] = []
    for method in methods:
        for model, solver in _combinations(method, models, solvers):
            if reason := _reason(method, model, solver):
                left_out.append(NotApplicable(method, model, solver, reason))
            else:
                pairs += [Pair(method, model, solver, t) for t in _rungs(method, model, solver, tolerances)]
    if not pairs:
        why = "; ".join(f"{item.method}, {item.model}, {item.solver}: {item.reason}" for item in left_out)
        raise OptionError(f"nothing to compare: {why}")
    return Plan(tuple(dict.fromkeys(pairs)), tuple(left_out))


def _combinations(method: str, models: Sequence[str], solvers: Sequence[str]) -> list[tuple[str, str]]:
    """Models and solvers as named; of a method with machinery of its own, those it has."""
    own = METHODS[method]
    if not own.own_tolerances:
        return [(model, solver) for model in models for solver in solvers]
    every = [(model, solver) for model, allowed in own.solvers.items() for solver in allowed]
    return [pair for pair in every if pair[1] in solvers] or every[:1]


def _rungs(method: str, model: str, solver: str, tolerances: Sequence[float]) -> Sequence[float | None]:
    takes_one = find_entry(model, solver).options is not None
    return tolerances if takes_one and not METHODS[method].own_tolerances else [None]


def _reason(method: str, model: str, solver: str) -> str:
    """Why a combination cannot be; "" if it can."""
    own = METHODS[method]
    if model not in own.solvers:
        return f"the method is declared in {', '.join(own.solvers)} only"
    driven = [language for language, name in SOLVERS if name == solver] or [LANGUAGES[0]]
    if model not in driven:
        return f"the solver is driven from {', '.join(driven)} only"
    allowed = own.solvers[model]
    if allowed and solver not in allowed:
        return f"the method takes there: {', '.join(allowed)}"
    try:
        entry = find_entry(model, solver)
    except OptionError as error:
        return str(error).split(": ", 1)[-1]
    return "a solver of nonlinear programs" if entry.nonlinear and not allowed else ""


def _known(what: str, names: Sequence[str], known: Collection[str]) -> None:
    for name in names:
        if name not in known:
            raise OptionError(f"{what} '{name}' is unknown; choose from: {', '.join(known)}")

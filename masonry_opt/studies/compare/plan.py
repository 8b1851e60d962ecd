"""Which runs a comparison consists of: everything named, as far as methods and solvers admit it."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Sequence
from dataclasses import dataclass

from masonry_opt.errors import OptionError
from masonry_opt.methods.registry import IPOPT, METHODS
from masonry_opt.solvers.registry import (
    FOUND_BY_CVXPY,
    HIPO,
    LANGUAGES,
    SOLVERS,
    TOLERANCE,
    find_solver,
    found_by_cvxpy,
)


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
    everywhere = {solver for _, solver in SOLVERS}
    _known("solver", solvers, sorted({*everywhere, HIPO, *FOUND_BY_CVXPY, *found_by_cvxpy(), *IPOPT}))
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
    if not own.fixed_tolerance:
        return [(model, solver) for model in models for solver in solvers]
    every = [(model, solver) for model, allowed in own.solvers.items() for solver in allowed]
    return [pair for pair in every if pair[1] in solvers] or every[:1]


def _rungs(method: str, model: str, solver: str, tolerances: Sequence[float]) -> Sequence[float | None]:
    takes_one = (model, solver) in SOLVERS or solver in FOUND_BY_CVXPY
    return [None] if METHODS[method].fixed_tolerance or not takes_one else tolerances


def _reason(method: str, model: str, solver: str) -> str:
    """Why a combination cannot be; "" if it can."""
    own = METHODS[method]
    if model not in own.solvers:
        return f"the method is declared in {', '.join(own.solvers)} only"
    if solver == HIPO and (model, solver) not in SOLVERS:
        return "not installed: pip install 'masonry_opt[solvers]'"
    allowed = own.solvers[model]
    if allowed and solver not in allowed:
        return f"the method takes there: {', '.join(allowed)}"
    driven = [language for language, name in SOLVERS if name == solver]
    if driven and model not in driven:
        return f"the solver is driven from {', '.join(driven)} only"
    if model != "cvxpy" and not driven and solver not in IPOPT:
        return "the solver is driven from cvxpy only"
    try:
        if solver in IPOPT:
            if allowed:
                IPOPT[solver].require()
                return ""
            return "a solver of method 'mpec' only"
        find_solver(model, solver, TOLERANCE)
    except OptionError as error:
        return str(error).split(";")[0]
    return ""


def _known(what: str, names: Sequence[str], known: Collection[str]) -> None:
    for name in names:
        if name not in known:
            raise OptionError(f"{what} '{name}' is unknown; choose from: {', '.join(known)}")

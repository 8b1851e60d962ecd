"""Every method by name (adding one is one entry), and the record of how to solve that names one."""

import difflib
import reprlib
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field
from functools import cached_property, partial
from typing import Any

from pydantic import ValidationError

from masonry_opt.errors import OptionError
from masonry_opt.methods.task import Method
from masonry_opt.solvers.registry import MATRICES, MODELS, SOLVERS, TOLERANCE, Solver, capable, find_solver

_VARYING = frozenset({"dilatancy"})  #: What methods of a constant dilatancy refuse.
_MOST = _VARYING | {"strength", "forces", "space"}  #: What the bracket does.

#: A vertex has joints without normal force, which the loop then locks: it prefers interior points.
_OF_LOOP = {"cvxpy": (), "pyomo": ("highs-ipm", "highs", "highs-hipo")}
_NEWTON = {MATRICES: ("newton",)}
_NONLINEAR = {"pyomo": capable("pyomo", lambda solver: solver.nonlinear)}
_PYOMO = {"pyomo": ("highs",)}

_own = partial(Method, own_tolerances=True, refuses=_VARYING)
_lowest = partial(_own, seeks_lowest=True)

_ALL = (
    Method("static", "associative:associative", associative=True),
    Method("kinematic", "associative:kinematic", associative=True),
    Method("nonassociative", "loop.nonassociative:nonassociative", "loop.options:LoopOptions", _OF_LOOP),
    _lowest(
        "coulomb", "coulomb.method:coulomb", "coulomb.method:CoulombOptions", _NEWTON, refuses=frozenset()
    ),
    _own("incremental", "incremental.method:incremental", "incremental.method:IncrementalOptions", _NEWTON),
    _lowest("mpec", "mpec:mpec", "mpec:MpecOptions", _NONLINEAR),
    _lowest(
        "global", "bracket.bracket:global_search", "bracket.bracket:GlobalOptions", _PYOMO, refuses=_MOST
    ),
)

METHODS = {method.name: method for method in _ALL}

DEFAULT = "coulomb"  #: The method of whoever names none.

#: Present names of methods, by the names that they had in former versions.
FORMER_METHODS = {
    "mcp": "called 'coulomb'",
    "compliant": "called 'incremental'",
    "refined": "the option search=SECONDS of method 'coulomb'",
}

#: What is said with a method and is no option of it.
_BESIDE = (
    "scene",
    "method",
    "model",
    "solver",
    "tolerance",
    "incremental",
    "load_case",
    "progress",
    "phases",
)


@dataclass(frozen=True)
class HowToSolve:
    """What :func:`~masonry_opt.analysis.solve` is told beside the scene, as it was told.

    Raises OptionError if something of it is unknown or not available, whatever the scene.
    """

    method: str = DEFAULT
    model: str | None = None
    solver: str | None = None
    tolerance: float | None = None
    incremental: bool = True
    options: Mapping[str, Any] = field(default_factory=dict)  #: the method's own, by name

    def __post_init__(self) -> None:
        if not isinstance(self.incremental, bool):
            raise OptionError(f"incremental must be True or False (found {self.incremental!r})")
        _ = self.chosen, self.own_options, self.engine

    def refuse_functions(self) -> None:
        """Raise OptionError if an option is a function, which no worker can be sent."""
        for name, value in self.options.items():
            if callable(value):
                raise OptionError(f"option '{name}': a function is for a single scene, not for many")

    @cached_property
    def chosen(self) -> Method:
        """The method."""
        if self.method in FORMER_METHODS:
            raise OptionError(f"method '{self.method}' is now {FORMER_METHODS[self.method]}")
        if not isinstance(self.method, str) or self.method not in METHODS:
            raise OptionError(f"method '{self.method}' is unknown; choose from: {', '.join(METHODS)}")
        return METHODS[self.method]

    @cached_property
    def own_options(self) -> Any:
        """The method's options; None if it has none."""
        method = self.chosen
        known = list(method.options.model_fields) if method.options else []
        for option in self.options:
            if option == "expected":
                raise OptionError("option 'expected' is now called 'incremental'")
            if option not in known:
                raise OptionError(f"method '{method.name}' has no option '{option}'{_instead(option, known)}")
        try:
            # What goes on from a result takes its solution.
            given = {name: getattr(of, "solution", of) for name, of in self.options.items()}
            return method.options(**given) if method.options else None
        except ValidationError as error:
            # Of an option that may be one of several things, what is said of the first will do.
            wrong = {
                ".".join(map(str, item["loc"][:1])): f"{item['msg']} (found {reprlib.repr(item['input'])})"
                for item in reversed(error.errors())
            }
            said = [f"option '{option}': {words}" if option else words for option, words in wrong.items()]
            raise OptionError(f"method '{method.name}': {'; '.join(said)}") from None

    @cached_property
    def engine(self) -> Solver:
        """The solver, with its tolerance."""
        method, model = self.chosen, self.model
        for what, given in (("model", model), ("solver", self.solver)):
            if not isinstance(given, str | None):
                raise OptionError(f"{what} must be a name (found {given!r})")
        model = model or next(iter(method.solvers))
        if model in MODELS and model not in method.solvers:
            raise OptionError(
                f"method '{method.name}' takes model: {', '.join(method.solvers)} (found '{model}'); methods "
                f"that take it: {_names(lambda other: model in other.solvers)}"
            )
        allowed = method.solvers.get(model, ())
        name = self.solver.lower() if self.solver else (allowed[0] if allowed else None)
        linear = all(entry.linear for entry in SOLVERS.values() if entry.name == name)
        if name not in allowed if allowed else not linear:
            raise OptionError(
                f"method '{method.name}' with model '{model}' takes solver: "
                f"{', '.join(allowed) or 'any of linear programs'} (found '{name}'){_takers(name)}"
            )
        if self.tolerance is not None and method.own_tolerances:
            raise OptionError(
                f"method '{method.name}' has tolerances of its own: leave 'tolerance' out, or name a method "
                f"that takes one: {_names(lambda other: not other.own_tolerances)}"
            )
        return find_solver(model, name, TOLERANCE if self.tolerance is None else self.tolerance)

    @cached_property
    def of_dead_load(self) -> Solver:
        """The solver that decides whether a scene stands: a quick one where the method brings its own."""
        quick = self.solver is None and self.chosen.own_tolerances
        return find_solver("cvxpy", None) if quick else self.engine


def _instead(option: str, known: Iterable[str]) -> str:
    """What to write in place of an option that a method does not have."""
    if homes := _homes(option):
        return f"; methods that have it: {', '.join(homes)}"
    if close := difflib.get_close_matches(option, [*known, *_BESIDE], n=1):
        return f"; did you mean '{close[0]}'?"
    others = [other for has in METHODS.values() if has.options for other in has.options.model_fields]
    if close := difflib.get_close_matches(option, others, n=1):
        return f"; did you mean '{close[0]}'? Methods that have it: {', '.join(_homes(close[0]))}"
    return f"; it has: {', '.join(known) or 'none'}"


def _homes(option: str) -> list[str]:
    return [name for name, has in METHODS.items() if has.options and option in has.options.model_fields]


def _takers(name: str | None) -> str:
    """Which methods take a solver, in the first language that has it; which take solvers that CVXPY finds."""
    known = [entry for (_, called), entry in SOLVERS.items() if called == name]
    if known:
        takers = _names(lambda method: method.solved_by(known[0]))
        return f"; methods that take it, with model '{known[0].language}': {takers}"
    others = _names(lambda method: not method.own_tolerances)
    return f"; methods of linear programs, which take others: {others}"


def _names(of: Callable[[Method], bool]) -> str:
    return ", ".join(name for name, method in METHODS.items() if of(method))

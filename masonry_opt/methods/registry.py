"""List all methods by name, and check the arguments with which a scene is solved.

A new method needs one entry in this module.
"""

import difflib
import math
import reprlib
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, fields
from functools import cached_property, partial
from typing import Any

from pydantic import ValidationError

from masonry_opt.errors import OptionError
from masonry_opt.methods.task import Method
from masonry_opt.scene.mistakes import did_you_mean, instead_of
from masonry_opt.solution.acceptance import Kind
from masonry_opt.solvers.registry import (
    MATRICES,
    MODELS,
    SOLVER_TOLERANCE,
    SOLVERS,
    Solver,
    capable,
    find_solver,
)

#: Property of scenes that some methods do not support: dilatancy that falls with stress.
_VARYING_DILATANCY = frozenset({"dilatancy"})

#: Properties of scenes that method "global" does not support.
_REFUSED_BY_GLOBAL = _VARYING_DILATANCY | {"strength", "forces", "space"}

#: Solvers of the loop by modelling language, interior-point methods first. A simplex method returns a vertex,
#: at which some joints have no normal force. The shear limits of the next sub-problem then permit almost no
#: normal force in these joints.
_OF_LOOP = {"cvxpy": (), "pyomo": ("highs-ipm", "highs", "highs-hipo")}

#: Solver of methods that work on the matrices directly, without a modelling language.
_NEWTON = {MATRICES: ("newton",)}

#: Solvers of nonlinear programs.
_NONLINEAR = {"pyomo": capable("pyomo", lambda solver: solver.nonlinear)}

#: Solver of method "global", by modelling language.
_PYOMO = {"pyomo": ("highs",)}

_own = partial(Method, own_tolerances=True, refuses=_VARYING_DILATANCY)
_lowest = partial(_own, seeks_lowest=True)
_lowest_from_rest = partial(_lowest, begins_with_load_history=True)

_ALL_METHODS = (
    Method("static", "associative:associative", associative=True),
    Method("kinematic", "associative:kinematic", associative=True),
    Method("nonassociative", "loop.nonassociative:nonassociative", "loop.options:LoopOptions", _OF_LOOP),
    _lowest_from_rest(
        "coulomb", "coulomb.method:coulomb", "coulomb.method:CoulombOptions", _NEWTON, refuses=frozenset()
    ),
    _own("incremental", "incremental.method:incremental", "incremental.method:IncrementalOptions", _NEWTON),
    _lowest("mpec", "mpec:mpec", "mpec:MpecOptions", _NONLINEAR),
    _lowest_from_rest(
        "global",
        "bracket.bracket:global_search",
        "bracket.bracket:GlobalOptions",
        _PYOMO,
        refuses=_REFUSED_BY_GLOBAL,
    ),
)

#: All methods by name.
METHODS = {method.name: method for method in _ALL_METHODS}

DEFAULT = "coulomb"  #: Name of the default method.
INCREMENTAL_METHOD = "incremental"  #: Name of the method whose answer is the incremental load factor.

#: Former names of methods. Each value completes the error message "method NAME is now ...".
FORMER_METHODS = {
    "mcp": "called 'coulomb'",
    "compliant": "called 'incremental'",
    "refined": "the option search=SECONDS of method 'coulomb'",
}

#: Name of the time limit, which is an argument of ``solve`` and also an option of some methods.
_TIME_LIMIT = "time_limit"

#: Name of the argument for movements of supports, which only some functions accept.
_SETTLED_ARGUMENT = "settled"

#: Arguments that functions accept in addition to the options of a method. An error about an unknown option
#: suggests the argument with a similar name.
_PASSED_ARGUMENTS = ("model", "solver", "tolerance", "incremental", "time_limit", "phases")


@dataclass(frozen=True)
class HowToSolve:
    """Checked arguments that control how :func:`~masonry_opt.solve` solves a scene.

    Raises OptionError if an argument is unknown or not available for any scene.
    """

    method: str = DEFAULT
    model: str | None = None
    solver: str | None = None
    tolerance: float | None = None
    incremental: bool = True
    time_limit: float | None = None  #: longest time of an analysis in seconds; None if there is no limit
    options: Mapping[str, Any] = field(default_factory=dict)  #: options of the method, by name
    #: Names of the arguments of the calling function. An error about an unknown option suggests a similar
    #: name from this list.
    arguments: Sequence[str] = ()

    def __post_init__(self) -> None:
        if not isinstance(self.incremental, bool):
            raise OptionError(f"incremental must be True or False (found {self.incremental!r})")
        limit = self.time_limit
        is_number = isinstance(limit, int | float) and not isinstance(limit, bool)
        if limit is not None and not (is_number and 0 < limit < math.inf):
            raise OptionError(f"time_limit must be a number of seconds above 0 (found {limit!r})")
        _ = self.chosen, self.own_options, self.engine

    def refuse_functions(self) -> None:
        """Raise OptionError if an option is a function, which cannot be sent to a worker process."""
        for name, value in self.options.items():
            if callable(value):
                raise OptionError(
                    f"option '{name}' is a function, and studies of many scenes cannot use functions: "
                    "omit the option"
                )

    @cached_property
    def chosen(self) -> Method:
        """Registry entry of the method. Raises OptionError if the name is unknown or no longer used."""
        if isinstance(self.method, str) and self.method in FORMER_METHODS:
            raise OptionError(f"method '{self.method}' is now {FORMER_METHODS[self.method]}")
        if not isinstance(self.method, str) or self.method not in METHODS:
            raise OptionError(f"method '{self.method}' is unknown{instead_of(self.method, METHODS)}")
        return METHODS[self.method]

    @property
    def kind(self) -> Kind:
        """Kind of answer that the method computes. Results without an answer have this kind too."""
        return Kind.ASSOCIATIVE if self.chosen.associative else Kind.EXACT

    @property
    def adds_incremental(self) -> bool:
        """True if the incremental load factor is computed in addition to the method's load factor."""
        return self.incremental and not self.chosen.associative and self.chosen.name != INCREMENTAL_METHOD

    @cached_property
    def _has_own_limit(self) -> bool:
        """True if the method has its own option ``time_limit`` and divides this time among its steps."""
        return self.chosen.options is not None and _TIME_LIMIT in self.chosen.options.model_fields

    @cached_property
    def own_options(self) -> Any:
        """Checked options of the method, or None if the method has no options.

        Raises OptionError if an option is unknown or has a wrong value.
        """
        method = self.chosen
        known = list(method.options.model_fields) if method.options else []
        options = dict(self.options)
        if self._has_own_limit and self.time_limit is not None:
            options[_TIME_LIMIT] = float(self.time_limit)
        for option in options:
            if option == "expected":
                raise OptionError("option 'expected' is now called 'incremental'")
            if option not in known:
                raise OptionError(
                    f"method '{method.name}' has no option '{option}'{self._instead(option, known)}"
                )
        try:
            # If an option is a result of an analysis, pass only the ``solution`` of the result to the method.
            values = {name: getattr(value, "solution", value) for name, value in options.items()}
            return method.options(**values) if method.options else None
        except ValidationError as error:
            # Report only the first error of each option. An option that permits several types has one error
            # per type.
            wrong = {
                ".".join(map(str, item["loc"][:1])): f"{_mistake(item)} (found {reprlib.repr(item['input'])})"
                for item in reversed(error.errors())
            }
            parts = [f"option '{option}': {text}" if option else text for option, text in wrong.items()]
            raise OptionError(f"method '{method.name}': {'; '.join(parts)}") from None

    def _instead(self, option: str, known: Iterable[str]) -> str:
        """Return the end of an error message that suggests what to use instead of an unknown option."""
        if option == _SETTLED_ARGUMENT:
            return "; functions that accept 'settled': solve, solve_cases, directions, crossing"
        homes = _homes(option)
        if homes:
            return f"; methods that have this option: {', '.join(homes)}"
        setting = self._setting_named(option)
        if setting:
            return setting
        near = did_you_mean(option, [*known, *self.arguments, *_PASSED_ARGUMENTS])
        if near:
            return near
        all_options = [
            name
            for candidate in METHODS.values()
            if candidate.options
            for name in candidate.options.model_fields
        ]
        close = difflib.get_close_matches(option, all_options, n=1)
        if close:
            return f"; did you mean '{close[0]}'? It is an option of {', '.join(_homes(close[0]))}"
        return f"; its options: {', '.join(known) or 'none'}"

    def _setting_named(self, option: str) -> str:
        """Return advice for an error message if an option is a field of a settings class, otherwise "".

        The settings classes of the chosen method come first.
        """
        for method in (self.chosen, *METHODS.values()):
            for name, settings in method.settings.items():
                if option in (setting.name for setting in fields(settings)):
                    prefix = "" if method is self.chosen else f"use method '{method.name}' and "
                    return f"; {prefix}pass {name}=mo.{settings.__name__}({option}=...) in Python"
        return ""

    @cached_property
    def engine(self) -> Solver:
        """Check that the method supports the solver and the tolerance. Return the solver with the tolerance.

        Raises OptionError if

        - a name is not a string;
        - the solver is not available;
        - the method does not support the model, the solver or a tolerance.
        """
        method, model = self.chosen, self.model
        for argument, value in (("model", model), ("solver", self.solver)):
            if not isinstance(value, str | None):
                raise OptionError(f"{argument} must be a name (found {value!r})")
        model = model or next(iter(method.solvers))
        if model in MODELS and model not in method.solvers:
            raise OptionError(
                f"method '{method.name}' supports the models {', '.join(method.solvers)} (found '{model}'); "
                f"methods that support this model: {_names(lambda candidate: model in candidate.solvers)}"
            )
        allowed = method.solvers.get(model, ())
        name = self.solver.lower() if self.solver else (allowed[0] if allowed else None)
        linear = all(entry.linear for entry in SOLVERS.values() if entry.name == name)
        if name not in allowed if allowed else not linear:
            raise OptionError(
                f"method '{method.name}' with model '{model}' supports the solvers: "
                f"{', '.join(allowed) or 'all for linear programs'} (found '{name}'){_takers(name)}"
            )
        if self.tolerance is not None and method.own_tolerances:
            raise OptionError(
                f"method '{method.name}' chooses its own tolerances: omit 'tolerance', or use a method that "
                f"supports a tolerance: {_names(lambda candidate: not candidate.own_tolerances)}"
            )
        return find_solver(model, name, SOLVER_TOLERANCE if self.tolerance is None else self.tolerance)

    @cached_property
    def of_dead_load(self) -> Solver:
        """Solver of the program that decides whether a scene is stable under its dead load.

        If the method sets its own tolerances and the user names no solver, the default solver of linear
        programs is used.
        """
        quick = self.solver is None and self.chosen.own_tolerances
        return find_solver("cvxpy", None) if quick else self.engine


def _mistake(error: Mapping[str, Any]) -> str:
    """Return the part of an error message that states what is wrong with the value of an option."""
    if error["type"] == "is_instance_of":
        return f"must be an object of class mo.{error['ctx']['class']}, so it can be set only in Python"
    return str(error["msg"]).removeprefix("Value error, ")


def _homes(option: str) -> list[str]:
    """Return the names of all methods that have an option with a given name."""
    classes = {name: method.options for name, method in METHODS.items()}
    return [name for name, options in classes.items() if options and option in options.model_fields]


def _takers(name: str | None) -> str:
    """Return the end of an error message, which lists the methods that support a solver.

    If several modelling languages have the solver, the methods are those of the first language. For an
    unknown solver, the methods that support any solver of CVXPY are listed.
    """
    known = [entry for (_, solver), entry in SOLVERS.items() if solver == name]
    if known:
        takers = _names(lambda method: method.solved_by(known[0]))
        return f"; methods that support this solver with model '{known[0].language}': {takers}"
    methods = _names(lambda method: not method.own_tolerances)
    return f"; methods that support all solvers of linear programs: {methods}"


def _names(is_listed: Callable[[Method], bool]) -> str:
    """Return the names of all methods that satisfy a condition, separated by commas."""
    return ", ".join(name for name, method in METHODS.items() if is_listed(method))

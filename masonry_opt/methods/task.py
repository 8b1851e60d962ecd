"""Define the interface of all methods: a method takes a task and returns a solution."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from importlib import import_module
from typing import Any, get_args

from pydantic import BaseModel, ConfigDict

from masonry_opt.effort import Effort, ignore_progress
from masonry_opt.errors import OptionError
from masonry_opt.methods.settings import Settings
from masonry_opt.problem.problem import Problem
from masonry_opt.solution.solution import Solution
from masonry_opt.solvers.driver import ProgramCache
from masonry_opt.solvers.registry import Solver, SolverEntry, find_solver

#: Function that reports progress: it is called with the record of each step of a method.
Progress = Callable[[Any], None]


class Options(BaseModel):
    """Options of a method.

    Unknown names, wrong types and values out of range raise pydantic.ValidationError. ``mo.solve`` turns this
    error into OptionError.
    """

    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False)


@dataclass(frozen=True)
class Task:
    """Input of a method: problem, solver, options, and objects that record effort and progress."""

    problem: Problem  #: problem of a scene that is stable under its dead load
    solver: Solver = field(default_factory=lambda: find_solver("cvxpy", None))
    options: Any = None  #: options of the method, or None if the method has no options
    effort: Effort = field(default_factory=Effort)  #: counts of time, programs and solvers
    progress: Progress = ignore_progress
    #: Cache of compiled programs. Analyses of the same scene with other friction, cohesion or dilatancy use
    #: them again.
    cache: ProgramCache = field(default_factory=ProgramCache)
    #: Solution of the same problem by method "incremental", or None if this method is switched off.
    incremental: Solution | None = None

    def with_options(self, options: Any, solver: Solver | None = None) -> "Task":
        """Return a copy of this task with the options of another method. The copy shares ``effort``."""
        return replace(self, options=options, solver=solver or self.solver)


def of_same_scene(solution: Solution, problem: Problem) -> Solution:
    """Check that an analysis of a problem can start from a solution. Return the solution without ``history``.

    Raises OptionError if the solution has no forces, or if it belongs to another scene.
    """
    if solution.q is None or solution.d is None:
        raise OptionError(
            "option 'start' is a result without forces, so no analysis can start from it: pass another result"
        )
    if (solution.q.size, solution.d.size) != (problem.B.shape[1], problem.B.shape[0]):
        raise OptionError("option 'start' is a result of another scene: pass a result of this scene")
    return replace(solution, history=())


@dataclass(frozen=True)
class Method:
    """Registry entry of a method: how it is run, and which solvers and scenes it supports."""

    name: str  #: name of the method, as users write it
    runs: str  #: function that runs the method, as "module:name" in package ``methods``
    takes: str = ""  #: class of the options, as "module:name" in package ``methods``; "" if there are none
    #: Names of the solvers that the method can use, for each value of the option ``model`` (see ``MODELS``).
    #: The first model and its first solver are the defaults. An empty tuple means all solvers of linear
    #: programs.
    solvers: Mapping[str, tuple[str, ...]] = field(default_factory=lambda: {"cvxpy": (), "pyomo": ()})
    associative: bool = False  #: True if the method assumes associative flow
    #: True if the method looks for the exact Coulomb state with the lowest load factor. The runs of a study
    #: share the exact states of such a method. A valid state of another run replaces the answer of a run if
    #: its load factor is lower.
    seeks_lowest: bool = False
    begins_with_load_history: bool = False  #: True if the load history is the first step of the method
    own_tolerances: bool = False  #: True if the method chooses the tolerances of its solvers
    #: Properties of scenes that the method does not support: "dilatancy" that falls with stress, joints of
    #: limited "strength", limited "forces" such as ties, and scenes in "space".
    refuses: frozenset[str] = frozenset()

    @property
    def run(self) -> Callable[[Task], Solution]:
        """Function that runs the method. Its module is imported at the first use, which may take seconds."""
        return _named(self.runs)

    @property
    def options(self) -> type[Options] | None:
        """Class of the method's options, or None if the method has no options."""
        return _named(self.takes) if self.takes else None

    @property
    def settings(self) -> dict[str, type[Settings]]:
        """Settings classes that the method accepts as values of its options, by name of the option."""
        known = self.options.model_fields if self.options else {}
        return {
            name: kind
            for name, field_info in known.items()
            for kind in _classes_in(field_info.annotation)
            if issubclass(kind, Settings)
        }

    def solved_by(self, entry: SolverEntry) -> bool:
        """Return True if the method can use the given solver."""
        allowed = self.solvers.get(entry.language)
        return allowed is not None and (entry.name in allowed or (not allowed and entry.linear))


def _classes_in(annotation: Any) -> list[type]:
    """Return the classes in an annotation such as ``InstanceOf[SearchSettings] | None``."""
    parts = get_args(annotation)
    if parts:
        return [kind for part in parts for kind in _classes_in(part)]
    return [annotation] if isinstance(annotation, type) else []


def _named(path: str) -> Any:
    """Import and return the object with a path "module:name" in package ``methods``."""
    module, name = path.split(":")
    return getattr(import_module(f"masonry_opt.methods.{module}"), name)

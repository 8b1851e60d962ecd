"""Define the interface of all methods: each takes a task and returns a solution."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from importlib import import_module
from typing import Any

from pydantic import BaseModel, ConfigDict

from masonry_opt.answer.solution import Solution
from masonry_opt.effort import Effort
from masonry_opt.errors import OptionError
from masonry_opt.problem.problem import Problem
from masonry_opt.solvers.driver import Kept
from masonry_opt.solvers.registry import Solver, SolverEntry, find_solver

#: Function that is called with each step of a method, as the history records it.
Progress = Callable[[Any], None]


class Options(BaseModel):
    """Options of a method.

    Unknown names, wrong types and values out of range raise pydantic.ValidationError. ``mo.solve`` turns this
    error into OptionError.
    """

    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False)


@dataclass(frozen=True)
class Task:
    """Arguments of a method."""

    problem: Problem  #: problem of a scene that is stable under its dead load
    solver: Solver = field(default_factory=lambda: find_solver("cvxpy", None))
    options: Any = None  #: options of the method; None if it has no options
    effort: Effort = field(default_factory=Effort)  #: counts of time, programs and solvers
    progress: Progress = lambda _: None
    #: Compiled programs of earlier analyses, for problems that differ only in the law of their joints.
    kept: Kept = field(default_factory=Kept)
    #: Solution of the problem by method "incremental"; None if it is switched off.
    incremental: Solution | None = None

    def with_options(self, options: Any, solver: Solver | None = None) -> "Task":
        """Return this task for another method; both tasks share one count of their effort."""
        return replace(self, options=options, solver=solver or self.solver)


def of_same_scene(solution: Solution, problem: Problem) -> Solution:
    """Return a solution as a start for a problem, without its history.

    Raises OptionError if the solution has no forces, or if it belongs to another scene.
    """
    if solution.q is None or solution.d is None:
        raise OptionError("option 'start': the result has no forces to start from")
    if (solution.q.size, solution.d.size) != (problem.B.shape[1], problem.B.shape[0]):
        raise OptionError("option 'start': the result is of another scene")
    return replace(solution, history=())


@dataclass(frozen=True)
class Method:
    """Entry of a method in the registry."""

    name: str  #: name of the method, as users write it
    runs: str  #: function of the analysis, as module:name within ``methods``
    takes: str = ""  #: class of the options, as module:name within ``methods``; "" without options
    #: Names of the solvers that the method can use, by model (one of ``MODELS``), the default first. An empty
    #: tuple stands for all solvers of linear programs. The first model is the method's default.
    solvers: Mapping[str, tuple[str, ...]] = field(default_factory=lambda: {"cvxpy": (), "pyomo": ()})
    associative: bool = False  #: True if the method's answer is that of associative flow
    #: True if the method looks for the lowest exact Coulomb state. A lower state from elsewhere is a better
    #: answer of such a method.
    seeks_lowest: bool = False
    own_tolerances: bool = False  #: True if the method sets the tolerances of its solvers
    #: Properties of scenes that the method does not support: "dilatancy" that falls with stress, joints of
    #: limited "strength", limited "forces" such as ties, and scenes in "space".
    refuses: frozenset[str] = frozenset()

    @property
    def run(self) -> Callable[[Task], Solution]:
        """Return the function of the analysis; its module is imported late, since this may take seconds."""
        return _named(self.runs)

    @property
    def options(self) -> type[Options] | None:
        """Return the class of the method's options; None if it has no options."""
        return _named(self.takes) if self.takes else None

    def solved_by(self, entry: SolverEntry) -> bool:
        """Return True if the method can use a solver."""
        allowed = self.solvers.get(entry.language)
        return allowed is not None and (entry.name in allowed or (not allowed and entry.linear))


def _named(path: str) -> Any:
    """Return the object at a path, written as module:name within ``methods``."""
    module, name = path.split(":")
    return getattr(import_module(f"masonry_opt.methods.{module}"), name)

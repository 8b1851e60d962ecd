"""The interface of every method: a task in, a solution out."""

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

#: Called with every step of a method, as it is recorded in the history.
Progress = Callable[[Any], None]


class Options(BaseModel):
    """Options of a method. Unknown names, wrong types and values out of range raise
    pydantic.ValidationError, which ``mo.solve`` turns into OptionError."""

    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False)


@dataclass(frozen=True)
class Task:
    """Arguments of a method."""

    problem: Problem  #: of a scene that stands
    solver: Solver = field(default_factory=lambda: find_solver("cvxpy", None))
    options: Any = None  #: the method's own; None if it has none
    effort: Effort = field(default_factory=Effort)  #: where time, programs and solvers are counted
    progress: Progress = lambda _: None
    #: Programs of earlier analyses, of problems that differ in the joints' law alone.
    kept: Kept = field(default_factory=Kept)
    #: What method "incremental" found of the problem; None where it was not wanted.
    incremental: Solution | None = None

    def with_options(self, options: Any, solver: Solver | None = None) -> "Task":
        """The same task for another method, its effort counted with this one's."""
        return replace(self, options=options, solver=solver or self.solver)


def of_same_scene(solution: Solution, problem: Problem) -> Solution:
    """A solution to start from. Raises OptionError if it is of another scene or has no forces."""
    if solution.q is None or solution.d is None:
        raise OptionError("option 'start': the result has no forces to start from")
    if (solution.q.size, solution.d.size) != (problem.B.shape[1], problem.B.shape[0]):
        raise OptionError("option 'start': the result is of another scene")
    return replace(solution, history=())


@dataclass(frozen=True)
class Method:
    """Description of a method."""

    name: str
    runs: str  #: the analysis, as module:name within ``methods``
    takes: str = ""  #: the class of its options, alike; "" for none
    #: By model (one of ``MODELS``) names of those it can use, its default first; empty for any of linear
    #: programs. The first model is the method's default.
    solvers: Mapping[str, tuple[str, ...]] = field(default_factory=lambda: {"cvxpy": (), "pyomo": ()})
    associative: bool = False  #: whether its answer is that of associative flow
    #: Whether it looks for the lowest exact Coulomb state. A lower one found elsewhere is a better answer.
    seeks_lowest: bool = False
    own_tolerances: bool = False  #: whether it sets the tolerances of its solvers itself
    #: What it does not know: "dilatancy" that falls with stress, joints of limited "strength", limited
    #: "forces", such as ties, scenes in "space".
    refuses: frozenset[str] = frozenset()

    @property
    def run(self) -> Callable[[Task], Solution]:
        """The analysis, imported when first asked for: modelling languages take seconds."""
        return _named(self.runs)

    @property
    def options(self) -> type[Options] | None:
        """Class of its own options; None if it has none."""
        return _named(self.takes) if self.takes else None

    def solved_by(self, entry: SolverEntry) -> bool:
        """Whether it can use a solver."""
        allowed = self.solvers.get(entry.language)
        return allowed is not None and (entry.name in allowed or (not allowed and entry.linear))


def _named(where: str) -> Any:
    module, name = where.split(":")
    return getattr(import_module(f"masonry_opt.methods.{module}"), name)

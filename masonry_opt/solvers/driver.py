"""Eq. (9) or eq. (10), declared in either language, with the solver that answers it; what is kept of them."""

from collections.abc import Callable, Hashable
from dataclasses import dataclass
from typing import Any, TypeVar, cast

import numpy as np

from masonry_opt.effort import Effort
from masonry_opt.problem.problem import Problem, ShearLimits, State, in_units_of_live_load, in_units_of_load
from masonry_opt.solvers.registry import LpSize, Solved, Solver


def _declared(language: str, problem: Problem) -> tuple[Any, dict[str, Any]]:
    """The engine, and the models by formulation. Only the language used is imported, which takes a second."""
    if language == "pyomo":
        from masonry_opt.models.pyomo_kinematic import PyomoKinematic
        from masonry_opt.models.pyomo_static import PyomoStatic
        from masonry_opt.solvers.pyomo_engine import PyomoEngine

        return PyomoEngine, {"static": PyomoStatic, "kinematic": PyomoKinematic}
    from masonry_opt.models.cvxpy_kinematic import CvxpyKinematic
    from masonry_opt.models.cvxpy_parabola import CvxpyParabolaKinematic, CvxpyParabolaStatic
    from masonry_opt.models.cvxpy_static import CvxpyStatic
    from masonry_opt.solvers.cvxpy_engine import CvxpyEngine

    if problem.by_strength.conic:
        return CvxpyEngine, {"static": CvxpyParabolaStatic, "kinematic": CvxpyParabolaKinematic}
    return CvxpyEngine, {"static": CvxpyStatic, "kinematic": CvxpyKinematic}


@dataclass(frozen=True)
class LpAnswer:
    """A solve of eq. (9) or eq. (10), with the state at the optimum, or near it, if there is one."""

    solved: Solved
    state: State | None


class Driver:
    """A declared formulation, "static" or "kinematic", at first with the joints' own shear limits, and the
    solver that answers it (see :class:`~.cvxpy_engine.CvxpyEngine`). Problems by the cone or the parabola
    are for CVXPY alone, and for solvers of conic programs.

    Limits and states are in the problem's units. A program ``of_load`` is declared in units of the load, in
    which it is solved more accurately, not in those of the live load alone.
    """

    def __init__(
        self,
        problem: Problem,
        formulation: str,
        solver: Solver,
        effort: Effort,
        of_load: bool = False,
        purpose: str = "load factor",
        repeats: bool = False,
    ) -> None:
        engine, models = _declared(solver.language, problem)
        self.effort = effort
        self._scaled = (in_units_of_load if of_load else in_units_of_live_load)(problem)
        with effort.measure("build"):
            scaled = self._scaled.problem
            self.model = models[formulation](scaled, ShearLimits.true(scaled))
        self._engine = engine(self.model.program, solver, effort, purpose, repeats=repeats)

    def again_for(self, problem: Problem, effort: Effort) -> "Driver":
        """The same program with the shear limits of another problem (see :class:`Kept`)."""
        self.effort = effort
        self._engine.restart(effort)
        self.set_shear_limits(ShearLimits.true(problem))
        return self

    def set_shear_limits(self, limits: ShearLimits) -> None:
        """Change the model's shear limits, and nothing else."""
        with self.effort.measure("compile"):
            self.model.limits.set(self._scaled.limits(limits))

    def solve(self, nearly: bool = False, near: np.ndarray | None = None) -> LpAnswer:
        """Solve with the present shear limits; ``nearly`` as of :meth:`~.registry.Solved.readable`. Parabolas
        are scaled by the size of the forces that a state is near, shape (3c,), if any are known."""
        if self._scaled.problem.by_strength.conic:
            self.model.resize(None if near is None else near / self._scaled.force)
        solved = self._engine.solve()
        if not solved.readable(nearly):
            return LpAnswer(solved, None)
        with self.effort.measure("read"):
            return LpAnswer(solved, self._scaled.state(self.model.read()))

    def size(self) -> LpSize:
        """Rows, columns and non-zeros of the linear program, which has been solved."""
        return self._engine.size


_T = TypeVar("_T")


class Kept:
    """Programs and factors by what they are for, one each. They serve for other friction, cohesion and
    dilatancy: their ``again_for(problem, effort)`` is the same for a problem of which
    :meth:`~.problem.Problem.same_program` holds, solved from a cold start and counted in another effort.

    They change the time of an analysis, never its load factor: every solve begins cold. (Forces kept of
    another scene may show that a scene stands, where a solver alone would not decide.)
    """

    def __init__(self, keeps: bool = False) -> None:
        self.keeps = keeps  #: whether anything is kept for other problems
        self._held: dict[Hashable, tuple[Problem | None, Any]] = {}

    def of(
        self, key: Hashable, problem: Problem, effort: Effort, build: Callable[[], _T], own: bool = False
    ) -> _T:
        """What is kept under a key; built if nothing is, or it is of other matrices, loads or strengths.
        What is the problem's ``own`` is kept for it in any case."""
        before, held = self._held.get(key, (None, None))
        again = before is problem or (self.keeps and before is not None and problem.same_program(before))
        found = cast(_T, held.again_for(problem, effort)) if again else build()
        if self.keeps or own:
            self._held[key] = problem, found
        return found

    def driver(
        self, problem: Problem, formulation: str, solver: Solver, effort: Effort, **how: Any
    ) -> Driver:
        """A driver of the problem, kept by how it was made."""
        key = (formulation, solver.key, problem.forms, *how.items())
        return self.of(key, problem, effort, lambda: Driver(problem, formulation, solver, effort, **how))

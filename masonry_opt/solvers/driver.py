"""Drive the static and kinematic programs, eqs (9) and (10), and cache compiled programs."""

from collections.abc import Callable, Hashable
from dataclasses import dataclass
from typing import Any, TypeVar, cast

import numpy as np

from masonry_opt.effort import Effort
from masonry_opt.problem.problem import Problem, ShearLimits, State, in_units_of_live_load, in_units_of_load
from masonry_opt.solvers.registry import LpSize, Solved, Solver


def _declared(language: str, problem: Problem) -> tuple[Any, dict[str, Any]]:
    """Return the engine class of a modelling language, and a map from formulations to model classes.

    Only the modelling language that is used is imported, because its import takes a second.
    """
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
    """Outcome of the static program, eq. (9), or the kinematic program, eq. (10): verdict and optimal state.

    The state is None if the solver found no solution. If the outcome is nearly optimal, the state is near the
    optimum.
    """

    solved: Solved
    state: State | None


class Driver:
    """Static or kinematic program of a problem, with its solver.

    ``formulation`` is "static", eq. (9), or "kinematic", eq. (10).

    The initial shear limits follow from the joints' own friction and cohesion. Limits and states are in the
    problem's units, but the program is scaled. If ``of_load`` is True, it is scaled to units of the load,
    which is more accurate; otherwise only the live load is scaled.

    Problems with the friction cone or the crushing parabola need CVXPY and a conic solver. See
    :class:`~.cvxpy_engine.CvxpyEngine` for the arguments ``purpose`` and ``repeats``.
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
        self._scaled = in_units_of_load(problem) if of_load else in_units_of_live_load(problem)
        with effort.measure("build"):
            scaled = self._scaled.problem
            self.model = models[formulation](scaled, ShearLimits.true(scaled))
        self._engine = engine(self.model.program, solver, effort, purpose, repeats=repeats)

    def again_for(self, problem: Problem, effort: Effort) -> "Driver":
        """Adapt this driver to the shear limits of another problem, and return the driver.

        The problem may differ from the driver's own problem only in friction, cohesion and dilatancy.
        """
        self.effort = effort
        self._engine.restart(effort)
        self.set_shear_limits(ShearLimits.true(problem))
        return self

    def set_shear_limits(self, limits: ShearLimits) -> None:
        """Set the shear limits of the program."""
        with self.effort.measure("compile"):
            self.model.limits.set(self._scaled.limits(limits))

    def solve(self, nearly: bool = False, near: np.ndarray | None = None) -> LpAnswer:
        """Solve the program with the shear limits that are currently set.

        Parameters
        ----------
        nearly : bool
            Accept a nearly optimal point, see :meth:`~.registry.Solved.readable`.
        near : ndarray, shape (3c,), optional
            Forces of a state near the solution. The program scales its crushing parabolas by them.
        """
        if self._scaled.problem.by_strength.conic:
            self.model.resize(None if near is None else near / self._scaled.force)
        solved = self._engine.solve()
        if not solved.readable(nearly):
            return LpAnswer(solved, None)
        with self.effort.measure("read"):
            return LpAnswer(solved, self._scaled.state(self.model.read()))

    def size(self) -> LpSize:
        """Return the numbers of rows, columns and nonzeros of the program.

        The program must have been solved before.
        """
        return self._engine.size


_T = TypeVar("_T")


class ProgramCache:
    """Cache that holds, for each purpose, one compiled program or factorisation.

    An entry is also used for problems that differ only in friction, cohesion and dilatancy
    (:meth:`~.problem.Problem.same_program` is True). Its method ``again_for(problem, effort)`` prepares it
    for such a problem.

    The cache changes the time of an analysis, but not its load factor, because no solve starts from the
    solution of another problem. Forces of an earlier scene may however show that a scene is stable although a
    solver alone could not decide.
    """

    def __init__(self, keeps: bool = False) -> None:
        self.keeps = keeps  #: True if entries are reused for other problems
        self._entries: dict[Hashable, tuple[Problem | None, Any]] = {}

    def of(
        self, key: Hashable, problem: Problem, effort: Effort, build: Callable[[], _T], own: bool = False
    ) -> _T:
        """Return the cached entry of a key if it fits the problem; otherwise build and return a new entry.

        An entry does not fit if its problem has other matrices, loads or strengths. If ``own`` is True, the
        entry is stored even if the cache does not reuse entries for other problems.
        """
        before, cached = self._entries.get(key, (None, None))
        fits_other = self.keeps and before is not None and problem.same_program(before)
        fits = before is problem or fits_other
        entry = cast(_T, cached.again_for(problem, effort)) if fits else build()
        if self.keeps or own:
            self._entries[key] = problem, entry
        return entry

    def store(self, key: Hashable, problem: Problem, entry: Any) -> None:
        """Store an entry under a key, for later calls of :meth:`stored` with this key and problem."""
        self._entries[key] = problem, entry

    def stored(self, key: Hashable, problem: Problem) -> Any:
        """Return the entry that was stored for a key and exactly this problem, or None if there is none."""
        before, entry = self._entries.get(key, (None, None))
        return entry if before is problem else None

    def driver(
        self, problem: Problem, formulation: str, solver: Solver, effort: Effort, **how: Any
    ) -> Driver:
        """Return a cached driver that fits the problem; otherwise build and return a new driver.

        The key consists of the formulation, the solver and the options ``how``.
        """
        key = (formulation, solver.key, problem.forms, *how.items())
        return self.of(key, problem, effort, lambda: Driver(problem, formulation, solver, effort, **how))

"""Find exact states of scenes of any size by two alternating programs and interior-point methods.

The first program finds the mechanism with the least energy z·p for forces near a state. The second program
finds forces with a low λ and little energy z·p for the rates of this mechanism. Interior-point methods reduce
the energy below its limit, the setting ``largest_energy``, also on façades that are too large for the simplex
method.
"""

from collections.abc import Callable, Iterable
from functools import cached_property

import cvxpy as cp
import numpy as np

from masonry_opt.effort import Effort
from masonry_opt.methods.exact.settings import SEARCH, SearchSettings
from masonry_opt.methods.task import Task
from masonry_opt.models.cvxpy_cone import ConeForces, ConeMotion
from masonry_opt.models.cvxpy_exact import CvxpyForces, CvxpyMotion
from masonry_opt.problem.problem import Problem, Scaled, in_units_of_load
from masonry_opt.solution.acceptance import Kind
from masonry_opt.solution.answer import Answer, certified
from masonry_opt.solvers.cvxpy_engine import CvxpyEngine
from masonry_opt.solvers.registry import Solver, find_solver

#: Key of ``result.solvers`` under which the solvers of the programs that find an exact state are listed.
_EXACT_STATE_PURPOSE = "exact state"


class _PlaneForces:
    """Program ``CvxpyForces`` for plane scenes, with the cost coefficients as a CVXPY parameter.

    The compiled program can therefore be solved again with other costs.
    """

    def __init__(self, problem: Problem) -> None:
        self._problem = problem
        self._cost = cp.Parameter(problem.B.shape[1], name="cost")
        forces = CvxpyForces(problem, (problem.live_norm, self._cost))
        self.statics, self.program = forces.statics, forces.program

    def set(self, p: np.ndarray, weight: float) -> None:
        """Set the costs for rates p of a mechanism, shape (faces,), and for the weight of the energy z·p."""
        self._cost.value = self._problem.energy_costs(p, weight)[1]


class _PlaneMotion:
    """Program ``CvxpyMotion`` for plane scenes, with the cost coefficients as a CVXPY parameter.

    The compiled program can therefore be solved again with other costs.
    """

    def __init__(self, problem: Problem, slope: np.ndarray) -> None:
        self._problem = problem
        self._cost = cp.Parameter(problem.faces, name="cost", nonneg=True)
        motion = CvxpyMotion(problem, self._cost, slope)
        self.mechanism, self.program = motion.mechanism, motion.program

    def set(self, q: np.ndarray) -> None:
        """Set the costs to the slacks of the yield conditions under the joint forces q, shape (3c + t,)."""
        self._cost.value = np.maximum(self._problem.slacks(q), 0.0) / self._problem.steep


class ExactPrograms:
    """Two optimisation programs, compiled once each: the first computes forces, the second a mechanism.

    A program that the first solver does not solve to its tolerance is passed to the next solver. No solve is
    warm-started, so that an answer does not depend on earlier solves. Forces and load factors are in the
    units of the scaled problem.
    """

    def __init__(
        self, scaled: Scaled, solvers: Iterable[Solver], effort: Effort, purpose: str, nearly: bool
    ) -> None:
        """Store the arguments. If ``nearly`` is True, the last solver may return a nearly optimal point."""
        self._problem, self._solvers = scaled.problem, tuple(solvers)
        self._effort, self._purpose, self._nearly = effort, purpose, nearly
        self._slope = self._problem.dilatancy

    @cached_property
    def _forces(self) -> ConeForces | _PlaneForces:
        """Return the optimisation program that computes joint forces for the rates of a mechanism."""
        with self._effort.measure("build"):
            return (ConeForces if self._problem.by_friction.conic else _PlaneForces)(self._problem)

    @cached_property
    def _motion(self) -> ConeMotion | _PlaneMotion:
        """Return the optimisation program that computes a mechanism for the present dilatancy."""
        with self._effort.measure("build"):
            conic = self._problem.by_friction.conic
            return (ConeMotion if conic else _PlaneMotion)(self._problem, self._slope)

    @cached_property
    def _engines_of_forces(self) -> list[CvxpyEngine]:
        """Return the program that computes forces, compiled for each solver."""
        return self._engines(self._forces.program)

    @cached_property
    def _engines_of_motion(self) -> list[CvxpyEngine]:
        """Return the program that computes a mechanism, compiled for each solver."""
        return self._engines(self._motion.program)

    def _engines(self, program: cp.Problem) -> list[CvxpyEngine]:
        """Return the given program, compiled for each solver."""
        effort, purpose = self._effort, self._purpose
        return [CvxpyEngine(program, solver, effort, purpose, repeats=True) for solver in self._solvers]

    def forces(
        self, p: np.ndarray, weight: float = SEARCH.weight, before_each: Callable[[], None] = lambda: None
    ) -> tuple[float, np.ndarray] | None:
        """Return λ and the forces that minimise λ Σ|f_L| plus the weighted energy z·p, for given rates p.

        The rates have shape (faces,), the forces have shape (3c + t,). Return None if no solver finds an
        optimum. ``before_each`` is called before each solve.
        """
        self._forces.set(p, weight)
        return self._forces.statics.forces() if self._solved(self._engines_of_forces, before_each) else None

    def motion(self, q: np.ndarray, before_each: Callable[[], None] = lambda: None) -> np.ndarray | None:
        """Return the velocities of the mechanism with the least energy z·p for given forces q.

        The shapes are (3b,) and (3c + t,). The mechanism obeys the joints' own flow rule. Return None if no
        solver finds an optimum. ``before_each`` is called before each solve.
        """
        self._follow_dilatancy(self._problem.dilatancy_at(self._problem.normal_forces(q)))
        self._motion.set(q)
        if not self._solved(self._engines_of_motion, before_each):
            return None
        return np.asarray(self._motion.mechanism.d.value)

    def _follow_dilatancy(self, slope: np.ndarray) -> None:
        """Set the dilatancy of the joints that can slide, shape (k,).

        If the dilatancy changes, the compiled program for mechanisms is discarded, because it contains the
        old dilatancy.
        """
        if not np.array_equal(slope, self._slope):
            self._slope = slope
            self.__dict__.pop("_motion", None)
            self.__dict__.pop("_engines_of_motion", None)

    def _solved(self, engines: list[CvxpyEngine], before_each: Callable[[], None]) -> bool:
        """Run the solvers one after the other, and return True as soon as a solver succeeds.

        A solver succeeds if it finds an optimum. For the last solver, a nearly optimal point may suffice.
        """
        for engine in engines:
            before_each()
            nearly = self._nearly and engine is engines[-1]
            if engine.solve().readable(nearly):
                return True
        return False


class Alternation:
    """Algorithm that finds exact states by computing forces and a mechanism in turn."""

    def __init__(self, problem: Problem, effort: Effort, settings: SearchSettings = SEARCH) -> None:
        self._given, self._effort, self._settings = problem, effort, settings
        self._problem = problem.by_cone
        self._conic = self._problem.by_friction.conic
        self._scaled = in_units_of_load(self._problem)
        tolerances = settings.tolerances if self._conic else settings.tolerances[:1]
        solvers = [find_solver("cvxpy", None, tolerance) for tolerance in tolerances]
        # In space, also accept solutions that the solver reports as nearly optimal: Clarabel often misses its
        # tolerance if equilibrium does not determine the forces of the contact points.
        self._programs = ExactPrograms(
            self._scaled, solvers, effort, _EXACT_STATE_PURPOSE, nearly=self._conic
        )

    def again_for(self, problem: Problem, effort: Effort) -> "Alternation":
        """Return this object if it was created for the given problem and effort, otherwise a new object."""
        same = problem is self._given and effort is self._effort
        return self if same else Alternation(problem, effort, self._settings)

    def state_near(
        self,
        q: np.ndarray,
        d: np.ndarray | None = None,
        before_each: Callable[[], None] = lambda: None,
        weights: tuple[float, ...] = (),
    ) -> Answer | None:
        """Return a state near given forces q. The state is exact, except for a small energy z·p.

        By default, the energy is at most 1e-5 λ f_L·d. The forces have shape (3c + t,). The velocities d,
        shape (3b,), are a mechanism for these forces; None if no mechanism is known. The function
        ``before_each`` is called before each solve, and at the end. If ``weights`` are passed, they replace
        the series of weights of the settings. Return None if the forces lead to no state.
        """
        self._effort.begins("exact state")
        settings = self._settings
        own = settings.weight_series_in_space if self._conic else (settings.weights_in_plane,)
        series = (weights,) if weights else own
        states = (self._in_turn(q, d, weights, before_each) for weights in series)
        state = next((state for state in states if state is not None), None)
        before_each()
        return state

    def _in_turn(
        self, q: np.ndarray, d: np.ndarray | None, weights: Iterable[float], before_each: Callable[[], None]
    ) -> Answer | None:
        """Solve both programs alternately. Return the last exact or else the last nearly complementary state.

        A state is nearly complementary if its energy z·p is at most the setting ``largest_energy``, and its
        residuals are within the limits for ``Kind.NEARLY_COMPLEMENTARY``. Return None if no state is nearly
        complementary.
        """
        problem, scaled = self._problem, self._scaled
        # Start with the load factor at which the unbalanced forces are smallest. The given forces, such as
        # forces of elastic contacts, may not balance the loads.
        fitted = -float(problem.live @ problem.unbalanced(0.0, q)) / float(problem.live @ problem.live)
        forces: tuple[float, np.ndarray] | None = fitted / scaled.load_factor, q / scaled.force
        last: Answer | None = None
        for weight in (*weights, None):
            if forces is None:
                break
            d = self._programs.motion(forces[1], before_each) if d is None else d
            if d is None:
                break
            load_factor, q = scaled.load_factor * forces[0], scaled.force * forces[1]
            answer = certified(problem, load_factor, q, d)
            energy = answer.residuals["complementarity"]
            is_within = energy <= self._settings.largest_energy and not answer.failing(
                Kind.NEARLY_COMPLEMENTARY
            )
            if is_within and (last is None or answer.exact or not last.exact):
                last = answer
            if weight is not None:
                p, d = problem.rates(d, problem.dilatancy), None
                forces = self._programs.forces(p, weight, before_each)
        return last


def alternation_of(task: Task, settings: SearchSettings = SEARCH) -> Alternation:
    """Return the :class:`Alternation` of a task.

    Later calls with the same task and settings return the same object, with its compiled programs.
    """
    problem, effort = task.problem, task.effort

    def build() -> Alternation:
        return Alternation(problem, effort, settings)

    return task.cache.of(("alternation", settings), problem, effort, build, own=True)

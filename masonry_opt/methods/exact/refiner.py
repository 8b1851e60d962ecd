"""Find exact states by two linear programs with warm starts.

(a) Mechanism: for the yield slacks z of a state, minimise z·p over the kinematics of the joints' own flow
rule. Each slack of sliding is divided by max(1, μ). The faces with p > 0 are the support S of the mechanism.

(b) Statics: minimise λ subject to equilibrium and yield, with z = 0 on S.

The forces of (b) and the mechanism of (a) together satisfy every condition of both programs exactly. The dual
variables of z = 0 on S show which faces keep λ from decreasing, and how strongly. Another mechanism of the
faces at yield, in which the rates of these faces are as small as possible, may have a lower λ.
"""

import time
from abc import ABC, abstractmethod
from dataclasses import dataclass, replace
from functools import cached_property
from math import inf
from typing import TYPE_CHECKING

import numpy as np
import scipy.sparse as sp

from masonry_opt.effort import Effort
from masonry_opt.methods.exact.settings import SEARCH, SearchSettings
from masonry_opt.methods.task import Task
from masonry_opt.problem.problem import Problem
from masonry_opt.solution.acceptance import Kind
from masonry_opt.solution.answer import Answer, certified
from masonry_opt.solution.motion import weightless
from masonry_opt.solvers.highs import SMALLEST_COEFFICIENT, HighsSession, LinearProgram
from masonry_opt.solvers.registry import LpSize, Verdict

if TYPE_CHECKING:
    from masonry_opt.methods.exact.alternation import Alternation

#: Key, in ``result.solvers``, of the solver of the two linear programs that compute an exact state.
_REFINEMENT_PURPOSE = "refinement"

#: Largest residual of a dual ray with which HiGHS may report the program of forces as infeasible (the default
#: of HiGHS). With a smaller value, many infeasible programs remain undecided. With a larger value, collapse
#: states may be missed in scenes with nearly parallel joints.
_RAY_TOLERANCE = 1e-9


@dataclass(frozen=True)
class ExactState:
    """Collapse state from two programs: one computes the forces, the other the mechanism.

    The mechanism has the joints' own dilatancy. The state is exact only if its residuals are within the
    limits of exact states, see :attr:`exact`. A joint without normal force, for example, may slide in both
    directions at once: this satisfies every row of the programs, but violates the flow rule.
    """

    problem: Problem
    load_factor: float  #: load factor λ
    q: np.ndarray  #: joint forces, shape (3c,)
    d: np.ndarray  #: block velocities, shape (3b,)
    rates: np.ndarray  #: rates p of the mechanism, one for each yield condition (face), shape (faces,)
    #: Dual variables of the constraints z = 0, shape (faces,). The constraint is imposed on each yield
    #: condition whose rate is not zero; the entries of all others are zero. The larger an entry is, the more
    #: strongly its constraint keeps λ from decreasing.
    duals: np.ndarray
    #: Load factor of the state with λ ≤ 0 that the search for a lower λ reached from this state. Infinite if
    #: the search reached no such state.
    below: float = inf

    @property
    def exact(self) -> bool:
        """True if the residuals are small enough for an exact state."""
        return self.answer.exact

    @cached_property
    def answer(self) -> Answer:
        """This state as an answer with a certificate, whose residuals are computed from the matrices."""
        return certified(self.problem, self.load_factor, self.q, self.d)


class RefinerTimeout(Exception):
    """Error that is raised when the search for exact states has reached its deadline."""


def programs(problem: Problem) -> tuple[LinearProgram, LinearProgram]:
    """Return the linear programs of forces and of a mechanism, with all costs zero.

    Both are built from the matrices, and equal the programs that CVXPY compiles from
    :class:`~masonry_opt.models.cvxpy_exact.CvxpyForces` and ``CvxpyMotion``. The first has the columns "q"
    and "load_factor" and the rows "yield". The second has the columns "p" and "d".
    """
    (height, width), faces, live = problem.B.shape, problem.faces, sp.csc_array(problem.live[:, None])
    at_yield = sp.diags_array(-1 / problem.steep) @ problem.true_yield
    forces = LinearProgram(
        cost=np.zeros(width + 1),
        matrix=sp.block_array([[problem.B, live], [at_yield, None]], format="csc"),
        row_lower=np.r_[-problem.dead, np.full(faces, -inf)],
        row_upper=np.r_[-problem.dead, problem.face_cohesion / problem.steep],
        low=np.full(width + 1, -inf),
        high=np.full(width + 1, inf),
        columns={"q": _numbers(width), "load_factor": _numbers(1, width)},
        rows={"yield": _numbers(faces, height)},
    )
    work = np.r_[np.zeros(width), problem.live_norm]
    motion = LinearProgram(
        cost=np.zeros(faces + height),
        matrix=sp.block_array([[-problem.D(problem.dilatancy), problem.B.T], [None, live.T]], format="csc"),
        row_lower=work,
        row_upper=work,
        low=np.r_[np.zeros(faces), np.full(height, -inf)],
        high=np.full(faces + height, inf),
        columns={"p": _numbers(faces), "d": _numbers(height, faces)},
    )
    return forces, motion


def _numbers(count: int, first: int = 0) -> np.ndarray:
    """Return ``count`` consecutive column or row numbers that start with ``first``."""
    return np.arange(first, first + count, dtype=np.int32)


class StateFinder(ABC):
    """Base class of algorithms that compute an exact state near given joint forces."""

    def __init__(self, problem: Problem, effort: Effort) -> None:
        self.problem, self.effort = problem, effort
        self._scale = problem.load_factor_scale
        self.deadline = inf  #: value of ``time.perf_counter`` at which the search must end
        #: Number of programs that the solver left undecided since λ last decreased; None if they are not
        #: counted. If any are undecided, a state with a lower λ may have been missed.
        self.undecided: int | None = None
        #: Numbers of rows, columns and nonzeros of the linear program of forces; None if unknown.
        self.size: LpSize | None = None

    @abstractmethod
    def state_near(self, q: np.ndarray) -> ExactState | None:
        """Return the exact state found from joint forces q, shape (3c,), or None if no state is found."""

    @property
    def seconds_left(self) -> float:
        """Seconds until the deadline."""
        return max(self.deadline - time.perf_counter(), 0.0)

    def check_time(self) -> None:
        """Raise RefinerTimeout if the deadline has passed."""
        if time.perf_counter() >= self.deadline:
            raise RefinerTimeout


class Refiner(StateFinder):
    """Algorithm that finds exact states in the plane by solving two linear programs in turn.

    One program determines a mechanism, the other determines forces. Both are warm-started. If ``descends`` is
    False, the algorithm stops at the first exact state, and looks for no state with a lower λ.
    """

    undecided: int

    def __init__(
        self, problem: Problem, effort: Effort, settings: SearchSettings = SEARCH, descends: bool = True
    ) -> None:
        super().__init__(problem, effort)
        self._settings, self._descends = settings, descends
        forces, motion = programs(problem)
        #: Linear program of the forces, loaded in HiGHS. Other programs of the forces can start from its last
        #: basis.
        self.statics = HighsSession(
            forces, effort, _REFINEMENT_PURPOSE, small_matrix_value=SMALLEST_COEFFICIENT
        )
        self.statics.accept_rays_up_to(_RAY_TOLERANCE)
        self.size = forces.size
        self._kinematics = HighsSession(motion, effort, _REFINEMENT_PURPOSE)
        self.undecided = 0
        #: Results of earlier searches for a lower λ, by the state from which a search began. Many starts lead
        #: to the same few states. Results with undecided programs are not stored.
        self._ends: dict[tuple[str, bytes], ExactState | None] = {}

    def mechanism(
        self, cost: np.ndarray, banned: np.ndarray | bool = False
    ) -> tuple[np.ndarray, np.ndarray] | None:
        """Return the rates p and the velocities d of the mechanism with the least total cost·p.

        The shapes are (faces,) and (3b,). This is program (a) of this module. The rates of the ``banned``
        faces are zero. None is returned if there is no mechanism.
        """
        self._kinematics.set_costs("p", cost)
        self._kinematics.set_most("p", np.where(banned, 0.0, np.full(len(cost), inf)))
        if not self._solved(self._kinematics):
            return None
        return self._kinematics.values("p"), self._kinematics.values("d")

    def least(self, rates: np.ndarray, d: np.ndarray) -> ExactState | None:
        """Return the state of least λ with a given mechanism, or None if no state is found.

        This is program (b) of this module: all faces with a nonzero rate are at yield. The mechanism has the
        rates ``rates``, shape (faces,), and the velocities ``d``, shape (3b,).
        """
        support = rates > self._settings.at_rest
        if not self._forces_at(self.problem.live_norm, np.zeros(self.problem.B.shape[1]), support):
            return None
        load_factor, q = float(self.statics.values("load_factor")[0]), self.statics.values("q")
        duals = np.where(support, np.abs(self.statics.duals("yield")), 0.0)
        return ExactState(self.problem, load_factor, q, d, rates, duals)

    def state_near(self, q: np.ndarray) -> ExactState | None:
        """Return the exact state found from joint forces q, shape (3c,), or None if no state is found.

        The first state has the mechanism with the least energy for the given forces. States with a lower λ
        and other mechanisms follow, until λ no longer decreases, or would decrease from a positive value to
        zero or less. If ``descends`` is False, the search stops at the first exact state. If an earlier start
        led to the same first state (λ to ten digits and dual variables to six), its result is returned,
        unless the solver left programs undecided.

        A state whose residuals are too large for an exact state is not returned, see :class:`ExactState`.
        """
        first = self.first(q)
        if first is None:
            return None
        largest = first.duals.max(initial=0.0) or 1.0
        key = f"{first.load_factor:.9e}", np.round(first.duals / largest, 6).tobytes()
        if key in self._ends:
            self.undecided = 0
            return self._ends[key]
        state = self._lowest_from(first)
        if not self.undecided:
            self._ends[key] = state
        return state

    def _lowest_from(self, first: ExactState) -> ExactState | None:
        """Step from state to state with decreasing λ. Return the last state if it is exact, otherwise None.

        If ``descends`` is False, the first exact state is returned.
        """
        state = first
        while self._descends or not state.exact:
            lower = self._lower(state)
            if lower is None or lower.load_factor <= self._scale.zero < state.load_factor:
                return self._last_of_descent(state, lower)
            state = lower
        return state

    def _last_of_descent(self, state: ExactState, lower: ExactState | None) -> ExactState | None:
        """Return the last state of a descent if it is exact, otherwise None.

        If the next state, ``lower``, is exact and has λ ≤ 0, its load factor is stored with the last state.
        """
        if not state.exact:
            return None
        if lower and lower.exact and not self._weightless(lower):
            return replace(state, below=lower.load_factor)
        return state

    def first(self, q: np.ndarray) -> ExactState | None:
        """Return the first state that the two linear programs find from given forces, or None.

        The forces ``q`` have shape (3c,). If no forces bring all faces with a nonzero rate p to yield, both
        programs are solved again. They then start from forces that minimise λ Σ|f_L| plus a weight times z·p.
        The weight and the largest number of such repetitions are settings.
        """
        repairs = 0
        while True:
            mechanism = self.mechanism(np.maximum(self.problem.slacks(q), 0.0) / self.problem.steep)
            if mechanism is None:
                return None
            state = self.least(*mechanism)
            if state is not None or repairs == self._settings.repairs:
                return state
            if not self._forces_at(*self.problem.energy_costs(mechanism[0], self._settings.weight)):
                return None
            q = self.statics.values("q")
            repairs += 1

    def _lower(self, state: ExactState) -> ExactState | None:
        """Return a state with a lower λ than the given state, or None if none is found.

        In the new mechanism, only faces at yield have nonzero rates. The faces that keep λ from decreasing
        have rates that are as small as possible, each weighted by its dual variable. If this does not lower
        λ, or if only blocks without a load move, the mechanism with the least energy for the forces of the
        state is tried.
        """
        self.undecided = 0
        if state.duals.any():
            slack = self.problem.slacks(state.q) / self.problem.steep
            mechanism = self.mechanism(state.duals / state.duals.max(), slack > self._settings.at_yield)
            lower = mechanism and self.least(*mechanism)
            if lower and self._is_lower(lower, state) and not self._weightless(lower):
                return lower
        other_state = self.first(state.q)
        return other_state if other_state and self._is_lower(other_state, state) else None

    def _is_lower(self, first: ExactState, second: ExactState) -> bool:
        """Return True if the first state has a lower λ than the second, by more than rounding errors."""
        return self._scale.is_lower(first.load_factor, second.load_factor)

    def _weightless(self, state: ExactState) -> bool:
        """Return True if λ is negative and no moving block carries a net load at this λ."""
        return weightless(self.problem, state.load_factor, state.d)

    def at_cost(self, cost: np.ndarray) -> tuple[np.ndarray, np.ndarray] | None:
        """Maximise λ Σ|f_L| − cost·n, with the normal forces n. Return the joint forces and the rates.

        The shapes are (3c,) and (faces,). The rates are dual variables. The cost, shape (k,), has one entry
        for the normal force n of each joint that can slide. None is returned if the program has no optimum.
        """
        problem = self.problem
        if not self._forces_at(-problem.live_norm, problem.N.T @ cost):
            return None
        return self.statics.values("q"), np.abs(self.statics.duals("yield")) / problem.steep

    def _forces_at(
        self, load_cost: float, force_cost: np.ndarray, at_yield: np.ndarray | bool = False
    ) -> bool:
        """Minimise a linear cost of λ and joint forces. Return True if the program has an optimum.

        The faces of the mask ``at_yield``, shape (faces,), have to be at yield; by default no face has to.
        """
        self.statics.set_costs("load_factor", np.array([load_cost]))
        self.statics.set_costs("q", force_cost)
        self.statics.set_room("yield", np.where(at_yield, 0.0, np.full(self.problem.faces, inf)))
        return self._solved(self.statics)

    def _solved(self, session: HighsSession) -> bool:
        """Solve a program, and return True if it has an optimum.

        Raise RefinerTimeout if the deadline has passed.
        """
        self.check_time()
        verdict = session.solve(
            min(self.seconds_left, self._settings.seconds_per_joint * self.problem.joints)
        )
        if verdict is Verdict.FAILED:
            self.check_time()
        self.undecided += verdict is Verdict.FAILED
        return verdict is Verdict.OPTIMAL


def refiner_of(task: Task, settings: SearchSettings = SEARCH, descends: bool = True) -> Refiner:
    """Return a new :class:`Refiner` for the problem of a task, and store it in the cache of the task."""
    with task.effort.measure("build"):
        refiner = Refiner(task.problem, task.effort, settings, descends)
    task.cache.store(_REFINEMENT_PURPOSE, task.problem, refiner)
    return refiner


def last_refiner_of(task: Task) -> Refiner | None:
    """Return the last :class:`Refiner` that was made for the problem of a task, or None."""
    refiner: Refiner | None = task.cache.stored(_REFINEMENT_PURPOSE, task.problem)
    return refiner


class ConeRefiner(StateFinder):
    """Algorithm that finds exact states in space by solving two cone programs in turn.

    Its states have no dual variables of yield conditions, which the start "neighbour" of a search needs.
    """

    def __init__(
        self, problem: Problem, effort: Effort, alternation: "Alternation", weights: tuple[float, ...] = ()
    ) -> None:
        super().__init__(problem, effort)
        self._alternation, self._weights = alternation, weights

    def state_near(self, q: np.ndarray) -> ExactState | None:
        """Return the exact state that is found from joint forces ``q``, or None if no exact state is found.

        The shape of ``q`` is (3c + t,), for c contact points and t limited forces.
        """
        answer = self._alternation.state_near(q, None, self.check_time, self._weights)
        if answer is None or answer.failing(Kind.EXACT):
            return None
        return exact_state_of(self.problem.by_cone, answer)


def exact_state_of(problem: Problem, answer: Answer) -> ExactState:
    """Convert an answer to an exact state, with zeros for the unknown rates and dual variables."""
    nothing = np.zeros(problem.faces)
    return ExactState(problem, answer.load_factor, answer.q, answer.d, nothing, nothing)

"""Exact refinement by two linear programs with warm starts.

(a) Mechanism: with the yield slacks z of a state held fixed, minimise z·p over the kinematics of the
joints' own flow rule; the faces with p > 0 are its support S.
(b) Statics: minimise λ subject to equilibrium and yield with z = 0 on S.

The state of (b) and the mechanism of (a) meet every condition exactly. The duals of z = 0 on S tell
which faces hold λ up, and how strongly; another mechanism among the faces now at yield, that moves them
least, may lower it.
"""

import time
from abc import ABC, abstractmethod
from dataclasses import dataclass, replace
from functools import cached_property
from math import inf
from typing import TYPE_CHECKING

import numpy as np
import scipy.sparse as sp

from masonry_opt.answer.acceptance import Kind, over_load_factor
from masonry_opt.answer.answer import Answer, certified
from masonry_opt.answer.motion import weightless
from masonry_opt.answer.thresholds import ZERO, is_lower
from masonry_opt.effort import Effort
from masonry_opt.methods.exact.settings import WEIGHT
from masonry_opt.methods.task import Task
from masonry_opt.problem.problem import Of, Problem
from masonry_opt.solvers.highs import HighsSession, LinearProgram
from masonry_opt.solvers.registry import LpSize, Verdict

if TYPE_CHECKING:
    from masonry_opt.methods.exact.alternation import Alternation

SMALL = 60  #: Joints of a small scene. Larger ones take simplex several times as long with random costs.
_RESTS, _AT_YIELD = 1e-9, 1e-7  #: A rate above this is at work, and a slack below this at yield.

#: Of small scenes rates are at work above this share of the largest: corners moved by 1e-8 of a block turn
#: rates of zero into some 1e-7. Where joints dilate by less than the second number such rates are their own.
_AT_WORK, _HARDLY_DILATES = 1e-6, 1e-4

#: Weight, over λ, of the energy that smaller rates leave, and the most over λ on such scenes: above 1e-8 the
#: state is exact but for it.
_SMALL_RATES, _LEFT = 10.0, 1e-6

_RANDOM = 1e-5  #: Share of random costs, of seed 0: of many optima, as of aligned joints, one is the least.
_REPAIRS = 2  #: Forces are replaced by nearer ones so often at most: more repairs seldom end low.
_LONGEST = 0.2  #: Seconds that a program may take, for each joint: HiGHS may do nothing for ever.
_PURPOSE = "refinement"  #: What HiGHS does here, as a result tells it.


@dataclass(frozen=True)
class ExactState:
    """A state under the joints' own flow rule, exact to the solver's rounding."""

    problem: Problem
    load_factor: float
    q: np.ndarray  #: joint forces, shape (3c,)
    d: np.ndarray  #: block velocities, shape (3b,)
    rates: np.ndarray  #: of the mechanism, shape (faces,)
    strength: np.ndarray  #: how strongly each face at work holds λ up (the dual of its z = 0), shape (faces,)
    below: float = inf  #: λ of a state below zero that lies on the way down from here; infinite without one

    exact = Of[bool]("answer")

    @cached_property
    def answer(self) -> Answer:
        """The state with its certificate."""
        return certified(self.problem, self.load_factor, self.q, self.d)


class OutOfTime(Exception):
    """The deadline of a refiner has passed."""


def programs(problem: Problem) -> tuple[LinearProgram, LinearProgram]:
    """:class:`~masonry_opt.models.cvxpy_exact.CvxpyForces` and ``CvxpyMotion`` without costs, as CVXPY
    compiles them, but at once: columns "q" and "load_factor", rows "yield"; columns "p" and "d"."""
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
    return np.arange(first, first + count, dtype=np.int32)


class StateFinder(ABC):
    """What leads forces to exact states."""

    def __init__(self, problem: Problem, effort: Effort) -> None:
        self.problem, self.effort = problem, effort
        self.deadline = inf  #: time of ``time.perf_counter`` from which every program raises OutOfTime
        #: Programs of the last descent that the solver neither solved nor found infeasible: with any of them
        #: it is not known that nothing lowers λ. None where nothing is known of what does.
        self.undecided: int | None = None
        self.size: LpSize | None = None  #: of a linear program that is solved again and again

    @abstractmethod
    def state_near(self, q: np.ndarray) -> ExactState | None:
        """The exact state that forces (3c,) lead to; None if they lead to none."""

    @property
    def seconds_left(self) -> float:
        """Return the time until the deadline."""
        return max(self.deadline - time.perf_counter(), 0.0)

    def check_time(self) -> None:
        """Raise OutOfTime from the deadline on."""
        if time.perf_counter() >= self.deadline:
            raise OutOfTime


class Refiner(StateFinder):
    """The two linear programs of one problem, loaded once."""

    undecided: int

    def __init__(self, problem: Problem, effort: Effort) -> None:
        super().__init__(problem, effort)
        forces, motion = programs(problem)
        self._small = small = problem.joints <= SMALL
        hardly = (problem.dilatancy != 0) & (np.abs(problem.dilatancy) < _HARDLY_DILATES)
        self._roughly = small and not hardly.any()
        # HiGHS drops entries below 1e-9 unless told: joints askew by as little then contradict each other.
        drops = 1e-12 if small else 1e-9
        self._statics = HighsSession(forces, effort, _PURPOSE, small_matrix_value=drops)
        self.size = forces.size
        self._kinematics = HighsSession(motion, effort, _PURPOSE)
        self._random = _RANDOM * small * np.random.default_rng(0).uniform(0.5, 1.5, problem.faces)
        self._random_of_forces = problem.true_yield.T @ (self._random / problem.steep)
        self.undecided = 0

    def mechanism(
        self, cost: np.ndarray, banned: np.ndarray | bool = False
    ) -> tuple[np.ndarray, np.ndarray] | None:
        """(a): rates (faces,) and velocities (3b,) of the mechanism of least cost·p in which the banned faces
        are at rest; None if there is none."""
        self._kinematics.set_costs("p", cost)
        self._kinematics.set_most("p", np.where(banned, 0.0, np.full(len(cost), inf)))
        if not self._solved(self._kinematics):
            return None
        return self._kinematics.values("p"), self._kinematics.values("d")

    def least(self, rates: np.ndarray, d: np.ndarray) -> ExactState | None:
        """(b): least load factor with every face at yield that is at work at these rates (faces,), beside
        velocities (3b,); None if there is none."""
        support = rates > (_AT_WORK * rates.max() if self._roughly else _RESTS)
        small = np.where(support, 0.0, rates) * self._roughly
        if not self._forces_at(*self.problem.energy_costs(small, _SMALL_RATES), support):
            return None
        load_factor, q = float(self._statics.values("load_factor")[0]), self._statics.values("q")
        strength = np.where(support, np.abs(self._statics.duals("yield")), 0.0)
        return ExactState(self.problem, load_factor, q, d, rates, strength)

    def state_near(self, q: np.ndarray) -> ExactState | None:
        """The exact state that forces (3c,) lead to: on the mechanism that goes with them, then on others,
        until λ falls no more, or would fall to zero; if its certificate bears it out: a joint without normal
        force that contracts in both senses at once meets every row of the programs, and no flow rule."""
        state, lower = None, self.first(q)
        while lower is not None and (state is None or not lower.load_factor <= ZERO < state.load_factor):
            state, lower = lower, self._lower(lower)
        if state is None:
            return None
        left = over_load_factor(state.answer.certificate.complementarity, state.load_factor)
        if state.answer.failing(Kind.NEARLY_COMPLEMENTARY if self._roughly and left <= _LEFT else Kind.EXACT):
            return None
        if lower and lower.exact and not self._weightless(lower):
            return replace(state, below=lower.load_factor)
        return state

    def first(self, q: np.ndarray) -> ExactState | None:
        """(a) and (b) from forces (3c,); where no statics bring the whole support to yield, without random
        costs, which may choose faces whose yield is one condition but for rounding, and then from the forces
        that come nearest (least p·z)."""
        for at_random in (*[True] * self._small, *[False] * _REPAIRS):
            cost = np.maximum(self.problem.slacks(q), 0.0) / self.problem.steep
            found = self.mechanism(cost + cost.mean() * self._random if at_random else cost)
            if found is None:
                return None
            if exact := self.least(*found):
                return exact
            if at_random:
                continue
            if not self._forces_at(*self.problem.energy_costs(found[0], WEIGHT)):
                return None
            q = self._statics.values("q")
        return None

    def _lower(self, state: ExactState) -> ExactState | None:
        """A lower state: on the mechanism among the faces at yield that moves least of those that hold λ up,
        each weighed by how strongly it does, unless what moves there weighs nothing; or else on the mechanism
        that goes with the state's forces."""
        self.undecided = 0
        if state.strength.any():
            slack = self.problem.slacks(state.q) / self.problem.steep
            found = self.mechanism(state.strength / state.strength.max(), slack > _AT_YIELD)
            lower = found and self.least(*found)
            if lower and is_lower(lower.load_factor, state.load_factor) and not self._weightless(lower):
                return lower
        again = self.first(state.q)
        return again if again and is_lower(again.load_factor, state.load_factor) else None

    def _weightless(self, state: ExactState) -> bool:
        return weightless(self.problem, state.load_factor, state.d)

    def at_cost(self, cost: np.ndarray) -> tuple[np.ndarray, np.ndarray] | None:
        """Forces (3c,) that maximise λ times the live load's norm less cost·n of the joints that can slide,
        cost of shape (k,), and the rates (faces,) that go with them; None if there are none."""
        problem = self.problem
        if not self._forces_at(-problem.live_norm, problem.N.T @ cost):
            return None
        return self._statics.values("q"), np.abs(self._statics.duals("yield")) / problem.steep

    def _forces_at(self, load_cost: float, force_cost: np.ndarray, held: np.ndarray | bool = False) -> bool:
        """Whether there are forces of least cost with the held faces, if any, at yield."""
        self._statics.set_costs("load_factor", np.array([load_cost]))
        self._statics.set_costs("q", force_cost + self._random_of_forces)
        self._statics.set_room("yield", np.where(held, 0.0, np.full(self.problem.faces, inf)))
        return self._solved(self._statics)

    def _solved(self, session: HighsSession) -> bool:
        self.check_time()
        verdict = session.solve(min(self.seconds_left, _LONGEST * self.problem.joints))
        if verdict is Verdict.FAILED:
            self.check_time()
        self.undecided += verdict is Verdict.FAILED
        return verdict is Verdict.OPTIMAL


def refiner_of(task: Task) -> Refiner:
    """The programs of a task's problem."""
    with task.effort.measure("build"):
        return Refiner(task.problem, task.effort)


class ConeRefiner(StateFinder):
    """The alternation of two cone programs. It reports neither what holds λ up nor neighbours of a state."""

    def __init__(
        self, problem: Problem, effort: Effort, alternation: "Alternation", weights: tuple[float, ...] = ()
    ) -> None:
        super().__init__(problem, effort)
        self._alternation, self._weights = alternation, weights

    def state_near(self, q: np.ndarray) -> ExactState | None:
        """Return the exact state that forces (3c + t,) lead to; None if they lead to none."""
        answer = self._alternation.state_near(q, None, self.check_time, self._weights)
        if answer is None or answer.failing(Kind.EXACT):
            return None
        return exact_state_of(self.problem.by_cone, answer)


def exact_state_of(problem: Problem, answer: Answer) -> ExactState:
    """Return an answer as an exact state of which the conditions that hold λ up are not known."""
    nothing = np.zeros(problem.faces)
    return ExactState(problem, answer.load_factor, answer.q, answer.d, nothing, nothing)

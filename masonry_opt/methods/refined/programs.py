"""Exact refinement by two linear programs with warm starts.

(a) Mechanism: with the yield slacks z of a state held fixed, minimise z·p over the kinematics of the
joints' own flow rule; the faces with p > 0 are its support S.
(b) Statics: minimise λ subject to equilibrium and yield with z = 0 on S.

The state of (b) and the mechanism of (a) meet every condition exactly. The duals of z = 0 on S tell
which faces hold λ up; another mechanism among the faces now at yield that avoids them may lower it.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from masonry_opt.models.pyomo_kinematic import PyomoKinematic
from masonry_opt.models.pyomo_static import PyomoStatic
from masonry_opt.problem.problem import Problem, ShearLimits
from masonry_opt.solvers.highs_session import HighsSession
from masonry_opt.solvers.lp import LpSize

#: A rate above this takes part in a mechanism; a slack below this is at yield.
_AT_WORK, _AT_YIELD = 1e-9, 1e-7

#: λ must fall by this share to count as lower.
_LOWER = 1e-9

#: How often forces are replaced by nearer ones in search of a first exact state, and λ's weight there.
_REPAIRS = 10
_TIE_BREAK = 0.01

#: A kicked state is looked into if it is above the best by at most the first share of λ, and followed
#: if, after descending, it is above the last by at most a random part of the second.
_WORTH_A_LOOK, _WORTH_FOLLOWING = 0.03, 0.01

#: Every part of the certificate of an exact state is below this.
EXACT = 1e-8


@dataclass(frozen=True)
class ExactState:
    """A state under the joints' own flow rule, exact to the solver's rounding.

    Attributes
    ----------
    load_factor: λ.
    q, d: joint forces (3c,) and block velocities (3b,).
    slack: yield slack of each face, shape (faces,).
    support: faces at work in the mechanism, shape (faces,).
    holding: faces of the support that hold λ up, the strongest first.
    """

    load_factor: float
    q: np.ndarray
    d: np.ndarray
    slack: np.ndarray
    support: np.ndarray
    holding: np.ndarray


class Refiner:
    """The two linear programs of one problem, loaded once.

    A *face* is one yield condition: sliding (+, −) of the k joints that can slide, then rocking
    (+, −) of all c joints.

    Attributes
    ----------
    reason: why ``first`` last found nothing.
    undecided: programs that the solver neither solved nor found infeasible in the last round of
        ``descend``: where there are any, that nothing lowers λ is not known.
    """

    def __init__(self, problem: Problem) -> None:
        self.problem = problem
        k = problem.sliding
        statics = PyomoStatic(problem, ShearLimits.associative(problem))
        kinematics = PyomoKinematic(problem, ShearLimits(problem.dilatancy[k]))
        self.statics, self.kinematics = HighsSession(statics.program), HighsSession(kinematics.program)
        program = statics.program
        self._faces = self.statics.rows(program.slide, program.rock)
        self._forces = self.statics.columns(program.n, program.s, program.m)
        self._load_factor = self.statics.columns(program.load_factor)
        self._minimise_load_factor()
        motion = kinematics.program
        self._rates = self.kinematics.columns(motion.slide, motion.rock)
        self._velocities = self.kinematics.columns(motion.d)
        self._limits = self.statics.rhs[self._faces]
        self.undecided = 0
        self.reason = ""

    @property
    def solves(self) -> int:
        """Linear programs solved so far."""
        return self.statics.solves + self.kinematics.solves

    @property
    def iterations(self) -> int:
        """Simplex iterations so far."""
        return self.statics.iterations + self.kinematics.iterations

    @property
    def seconds(self) -> float:
        """HiGHS's own time so far."""
        return self.statics.seconds + self.kinematics.seconds

    @property
    def size(self) -> LpSize:
        """Of the static program."""
        rows, columns = self.statics.matrix.shape
        return LpSize(rows, columns, self.statics.matrix.nnz)

    def mechanism(
        self, cost: np.ndarray, banned: np.ndarray | None = None
    ) -> tuple[np.ndarray, np.ndarray] | None:
        """(a): velocities (3b,) and support (faces,) of the mechanism of least cost·p, without the
        banned faces; None if there is none."""
        upper = np.full(len(self._rates), np.inf)
        if banned is not None:
            upper[banned] = 0.0
        self.kinematics.set_costs(self._rates, cost)
        self.kinematics.set_column_bounds(self._rates, np.zeros_like(upper), upper)
        if not self._solved(self.kinematics):
            return None
        values = self.kinematics.values
        return values[self._velocities], values[self._rates] > _AT_WORK

    def least(self, support: np.ndarray, d: np.ndarray) -> ExactState | None:
        """(b): least load factor with every face of the support at yield; None if there is none."""
        self._hold_at_yield(support)
        if not self._solved(self.statics):
            return None
        values, duals = self.statics.values, self.statics.row_duals[self._faces]
        strength = np.where(support, np.abs(duals), 0.0)
        order = np.argsort(-strength, kind="stable")
        return ExactState(
            load_factor=float(values[self._load_factor][0]),
            q=(q := self._forces_of(values)),
            d=d,
            slack=self.slack(q),
            support=support,
            holding=order[strength[order] > _LOWER],
        )

    def _minimise_load_factor(self) -> None:
        self.statics.set_costs(self._load_factor, np.array([self.problem.live_norm]))

    def _hold_at_yield(self, support: np.ndarray) -> None:
        """z = 0 on the support, z ≥ 0 elsewhere."""
        lower = np.where(support, self._limits, -np.inf)
        self.statics.set_row_bounds(self._faces, lower, self._limits)

    def _solved(self, session: HighsSession) -> bool:
        solved = session.solve()
        self.undecided += not (solved or session.infeasible)
        return solved

    def slack(self, q: np.ndarray) -> np.ndarray:
        """Yield slack of each face under forces q (3c,); negative is a violation."""
        x = np.zeros(self.statics.matrix.shape[1])
        x[self._forces] = np.concatenate([q[0::3], q[1::3], q[2::3]])
        return self._limits - (self.statics.matrix @ x)[self._faces]

    def first(self, q: np.ndarray) -> ExactState | None:
        """(a) and (b) from any forces; None if they do not lead to an exact state.

        Where no statics bring the whole support to yield, the forces that come nearest (least p·z)
        take the place of those given, and (a) and (b) are tried again.
        """
        self.reason = "no statics bring every face of a mechanism to yield"
        for _ in range(_REPAIRS):
            found = self.mechanism(np.maximum(self.slack(q), 0.0))
            if found is None:
                self.reason = "kinematics allow no mechanism"
                return None
            exact = self.least(found[1], found[0])
            if exact is not None:
                return exact
            nearest = self._least_gap(self.kinematics.values[self._rates])
            if nearest is None:
                return None
            q = nearest
        return None

    def _least_gap(self, rates: np.ndarray) -> np.ndarray | None:
        """Forces of least p·z for given rates, with a little weight on λ, which breaks ties."""
        columns = np.arange(self.statics.matrix.shape[1], dtype=np.int32)
        cost = -(self.statics.matrix[self._faces].T @ rates)
        cost[self._load_factor] += _TIE_BREAK * self.problem.live_norm
        self.statics.set_costs(columns, cost)
        self._hold_at_yield(np.zeros(len(self._faces), dtype=bool))
        solved = self._solved(self.statics)
        q = self._forces_of(self.statics.values) if solved else None
        self.statics.set_costs(columns, np.zeros(len(columns)))
        self._minimise_load_factor()
        return q

    def _forces_of(self, values: np.ndarray) -> np.ndarray:
        q = np.empty(3 * self.problem.joints)
        q[0::3], q[1::3], q[2::3] = values[self._forces].reshape(3, -1)
        return q

    def largest_normal_forces(self, highest: float) -> np.ndarray:
        """Largest normal force of each joint over all states with 0 ≤ λ ≤ ``highest``, shape (c,);
        ``inf`` where the solver finds no largest."""
        c = self.problem.joints
        normal = self._forces[:c]
        self._hold_at_yield(np.zeros(len(self._faces), dtype=bool))
        self.statics.set_column_bounds(self._load_factor, np.zeros(1), np.array([highest]))
        self.statics.set_costs(self._load_factor, np.zeros(1))
        largest = np.full(c, np.inf)
        for joint in range(c):
            self.statics.set_costs(normal[[joint]], np.array([-1.0]))
            if self.statics.solve():
                largest[joint] = self.statics.values[normal[joint]]
            self.statics.set_costs(normal[[joint]], np.zeros(1))
        self.statics.set_column_bounds(self._load_factor, np.array([-np.inf]), np.array([np.inf]))
        self._minimise_load_factor()
        return largest

    def largest_rates(self, highest: float) -> np.ndarray:
        """Largest rate of each face over the mechanisms on which raising the blocks takes at most
        ``highest`` times the live load's work, shape (4, c); ``inf`` where the solver finds no largest.

        While a joint slides in one sense the other is held at rest. After the first face without a
        largest rate the others are not tried.
        """
        problem = self.problem
        k, c = len(problem.sliding), problem.joints
        faces = len(self._rates)
        nothing = np.zeros(faces)
        self.kinematics.set_costs(self._rates, nothing)
        self.kinematics.add_row(self._velocities, -problem.dead, highest * problem.live_norm)
        largest = np.full(faces, np.inf)
        for face in range(faces):
            upper = np.full(faces, np.inf)
            if face < 2 * k:
                upper[(face + k) % (2 * k)] = 0.0
            self.kinematics.set_column_bounds(self._rates, nothing, upper)
            self.kinematics.set_costs(self._rates[[face]], np.array([-1.0]))
            if self.kinematics.solve():
                largest[face] = self.kinematics.values[self._rates[face]]
            elif self.kinematics.empty:
                largest[face] = 0.0  # at rest in every such mechanism: there is none
            else:
                break
            self.kinematics.set_costs(self._rates[[face]], np.zeros(1))
        self.kinematics.drop_last_row()
        bound = np.zeros((4, c))
        bound[0, problem.sliding], bound[1, problem.sliding] = largest[: 2 * k].reshape(2, k)
        bound[2], bound[3] = largest[2 * k :].reshape(2, c)
        return bound

    def descend(self, state: ExactState, one_by_one: bool) -> ExactState:
        """Lower λ among the faces at yield, avoiding those that hold it up: all at once, then, if
        asked, one by one, until none helps."""
        while (lower := self._lower(state, one_by_one)) is not None:
            state = lower
        return state

    def _lower(self, state: ExactState, one_by_one: bool) -> ExactState | None:
        self.undecided = 0
        trials = [state.holding]
        if one_by_one:
            trials += [state.holding[[index]] for index in range(len(state.holding))]
        inactive = state.slack > _AT_YIELD
        for avoided in trials:
            if len(avoided) == 0:
                continue
            banned = inactive.copy()
            banned[avoided] = True
            # Any mechanism will do; the least sum of rates keeps it finite and small.
            found = self.mechanism(np.ones(len(self._rates)), banned)
            if found is None:
                continue
            candidate = self.least(found[1], found[0])
            if candidate is not None and _is_lower(candidate, state):
                return candidate
        return None

    def kick(self, state: ExactState, rng: np.random.Generator) -> ExactState | None:
        """A state near another: let go of some of the faces that hold λ up, and look from the lower
        forces that this allows (or from between them and the old) for a mechanism again."""
        if len(state.holding) == 0:
            return None
        share = max(10 ** rng.uniform(-2, 0), 1 / len(state.holding))
        dropped = state.holding[rng.random(len(state.holding)) < share]
        support = state.support.copy()
        support[dropped] = False
        relaxed = self.least(support, state.d)
        if relaxed is None:
            return None
        weight = rng.uniform()
        q = weight * relaxed.q + (1 - weight) * state.q
        # A trace of noise breaks ties among mechanisms of no cost.
        noise = 1e-6 * rng.random(len(self._rates))
        found = self.mechanism(np.maximum(self.slack(q), 0.0) + noise)
        return None if found is None else self.least(found[1], found[0])


def search(
    refiner: Refiner,
    state: ExactState,
    kicks: int,
    seed: int,
    progress: Callable[[ExactState], None] = lambda _: None,
) -> tuple[ExactState, bool]:
    """Descend, then kick and descend again; the best state, and whether it is stationary.

    Stationary: for each face that holds λ up a mechanism among the faces at yield that avoids it was
    tried, and none lowered λ (or there is none). Kicks follow slightly worse states for a while.
    """
    rng = np.random.default_rng(seed)
    best = current = refiner.descend(state, one_by_one=True)
    stationary = refiner.undecided == 0
    progress(best)
    for _ in range(kicks):
        kicked = refiner.kick(current, rng)
        if kicked is None or kicked.load_factor > best.load_factor + _WORTH_A_LOOK * _size(best):
            continue
        kicked = refiner.descend(kicked, one_by_one=False)
        worse = kicked.load_factor - current.load_factor
        if _is_lower(kicked, best):
            best = current = refiner.descend(kicked, one_by_one=True)
            stationary = refiner.undecided == 0
            progress(best)
        elif worse < _WORTH_FOLLOWING * rng.random() * _size(current):
            current = kicked
        else:
            current = best
    return best, stationary


def _size(state: ExactState) -> float:
    """|λ|, kept away from zero."""
    return max(abs(state.load_factor), 1e-3)


def _is_lower(one: ExactState, other: ExactState) -> bool:
    return one.load_factor < other.load_factor - _LOWER * max(abs(other.load_factor), 1.0)

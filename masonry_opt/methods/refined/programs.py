"""Exact refinement by two linear programs with warm starts.

(a) Mechanism: with the yield slacks z of a state held fixed, minimise z·p over the kinematics of the
joints' own flow rule; the faces with p > 0 are its support S.
(b) Statics: minimise λ subject to equilibrium and yield with z = 0 on S.

The state of (b) and the mechanism of (a) meet every condition exactly. The duals of z = 0 on S tell
which faces hold λ up; another mechanism among the faces now at yield that avoids them may lower it.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from masonry_opt.answer.reasons import Code
from masonry_opt.effort import Effort
from masonry_opt.models.pyomo_refinement import PyomoForces, PyomoMotion
from masonry_opt.problem.problem import Problem
from masonry_opt.solvers.highs_session import HighsSession
from masonry_opt.solvers.lp import LpSize, Verdict

#: A rate above this takes part in a mechanism; a slack below this is at yield.
_AT_WORK, _AT_YIELD = 1e-9, 1e-7

#: λ must fall by this share to count as lower.
_LOWER = 1e-9

#: How often forces are replaced by nearer ones in search of a first exact state, and λ's weight there.
_REPAIRS = 10
_TIE_BREAK = 0.01

#: What HiGHS does here, as a result tells it.
_PURPOSE = "refinement"


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


def is_lower(one: ExactState, other: ExactState) -> bool:
    """Whether the first load factor is lower by more than rounding."""
    return one.load_factor < other.load_factor - _LOWER * max(abs(other.load_factor), 1.0)


class Refiner:
    """The two linear programs of one problem, loaded once.

    Attributes
    ----------
    why: why ``first`` last found nothing.
    undecided: programs that the solver neither solved nor found infeasible in the last round of
        ``descend``: where there are any, that nothing lowers λ is not known.
    """

    def __init__(self, problem: Problem, effort: Effort) -> None:
        self.problem = problem
        self._forces, self._motion = PyomoForces(problem), PyomoMotion(problem)
        forces, motion = self._forces.program, self._motion.program
        self._statics = HighsSession(
            forces,
            effort,
            _PURPOSE,
            costs=[(forces.load_factor, forces.load_cost), (forces.q, forces.force_cost)],
            room=[(forces.within_yield, forces.room)],
        )
        self._kinematics = HighsSession(
            motion, effort, _PURPOSE, costs=[(motion.p, motion.cost)], most=[(motion.p, motion.most)]
        )
        self._minimise_load_factor()
        self.undecided = 0
        self.why = Code.NO_STATICS

    @property
    def size(self) -> LpSize:
        """Of the static program."""
        return self._statics.size

    def mechanism(
        self, cost: np.ndarray, banned: np.ndarray | None = None
    ) -> tuple[np.ndarray, np.ndarray] | None:
        """(a): velocities (3b,) and rates (faces,) of the mechanism of least cost·p, without the
        banned faces; None if there is none."""
        program = self._motion.program
        most = np.full(self.problem.faces, np.inf)
        if banned is not None:
            most[banned] = 0.0
        self._kinematics.set(program.cost, cost)
        self._kinematics.set(program.most, most)
        if not self._solved(self._kinematics):
            return None
        return self._kinematics.values(program.d), self._kinematics.values(program.p)

    def least(self, support: np.ndarray, d: np.ndarray) -> ExactState | None:
        """(b): least load factor with every face of the support at yield; None if there is none."""
        program = self._forces.program
        self._statics.set(program.room, np.where(support, 0.0, np.inf))
        if not self._solved(self._statics):
            return None
        strength = np.where(support, np.abs(self._statics.duals(program.within_yield)), 0.0)
        order = np.argsort(-strength, kind="stable")
        q = self._statics.values(program.q)
        return ExactState(
            load_factor=float(self._statics.values(program.load_factor)[0]),
            q=q,
            d=d,
            slack=self.problem.slacks(q),
            support=support,
            holding=order[strength[order] > _LOWER],
        )

    def first(self, q: np.ndarray) -> ExactState | None:
        """(a) and (b) from any forces; None if they do not lead to an exact state.

        Where no statics bring the whole support to yield, the forces that come nearest (least p·z)
        take the place of those given, and (a) and (b) are tried again.
        """
        self.why = Code.NO_STATICS
        for _ in range(_REPAIRS):
            found = self.mechanism(np.maximum(self.problem.slacks(q), 0.0))
            if found is None:
                self.why = Code.NO_KINEMATICS
                return None
            d, p = found
            exact = self.least(p > _AT_WORK, d)
            if exact is not None:
                return exact
            nearest = self._least_energy(p)
            if nearest is None:
                return None
            q = nearest
        return None

    def descend(self, state: ExactState, one_by_one: bool) -> ExactState:
        """Lower λ among the faces at yield, avoiding those that hold it up: all at once, then, if
        ``one_by_one``, each by itself, until none helps."""
        while (lower := self._lower(state, one_by_one)) is not None:
            state = lower
        return state

    def perturbed(self, state: ExactState, rng: np.random.Generator) -> ExactState | None:
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
        noise = 1e-6 * rng.random(self.problem.faces)
        found = self.mechanism(np.maximum(self.problem.slacks(q), 0.0) + noise)
        return None if found is None else self.least(found[1] > _AT_WORK, found[0])

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
            found = self.mechanism(np.ones(self.problem.faces), banned)
            if found is None:
                continue
            candidate = self.least(found[1] > _AT_WORK, found[0])
            if candidate is not None and is_lower(candidate, state):
                return candidate
        return None

    def _least_energy(self, rates: np.ndarray) -> np.ndarray | None:
        """Forces (3c,) of least p·z for given rates, with a little weight on λ, which breaks ties."""
        problem, program = self.problem, self._forces.program
        self._statics.set(program.load_cost, np.array([_TIE_BREAK * problem.live_norm]))
        self._statics.set(program.force_cost, problem.true_yield.T @ rates)
        self._statics.set(program.room, np.full(problem.faces, np.inf))
        solved = self._solved(self._statics)
        self._minimise_load_factor()
        return self._statics.values(program.q) if solved else None

    def _minimise_load_factor(self) -> None:
        program = self._forces.program
        self._statics.set(program.load_cost, np.array([self.problem.live_norm]))
        self._statics.set(program.force_cost, np.zeros(3 * self.problem.joints))

    def _solved(self, session: HighsSession) -> bool:
        verdict = session.solve()
        self.undecided += verdict is Verdict.FAILED
        return verdict is Verdict.OPTIMAL

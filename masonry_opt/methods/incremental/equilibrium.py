"""Equilibrium under a load: Newton's method, and where it fails the damped motion of the blocks.

From a state, a displacement d of the blocks changes the trial forces of the contacts to q~ - k Bᵀd. The
blocks are in equilibrium under a load f if the forces q of the contact law balance it:

    (1)  B q(q~ - k Bᵀd) + f = 0

Friction without dilatancy has no potential: near the state (1) may have no solution, or several. Where
Newton's method fails, the blocks therefore move by implicit Euler steps of a motion with the viscous
damping η,

    (2)  B (q(q~ - k Bᵀd) - η k Bᵀd) + f = 0,

each from the state after the last one, which remembers the slip. The damping falls after steps that succeed
and grows after each that fails. Either the blocks come to rest in a new equilibrium, or they move on
without end: a collapse. A motion has no end if the forces out of balance stay the same up to the
displacement ``far``.
"""

from dataclasses import dataclass
from math import inf, sqrt

import numpy as np

from masonry_opt.methods.incremental.contact_law import (
    ContactLaw,
    Response,
    by_joint,
    mean_force_and_compliance,
)
from masonry_opt.methods.incremental.settings import IncrementalSettings
from masonry_opt.methods.incremental.stiffness import Factors, StiffnessMatrix
from masonry_opt.problem.problem import Problem

#: Share of the predicted decrease of the residual that a Newton step must achieve (Armijo's rule). If
#: larger, more steps are halved.
SUFFICIENT_DECREASE = 1e-4

#: Share of the forces out of balance that no contact resists, even if all contacts stick, from which on
#: blocks move without moving any joint. It lies far above rounding, some 1e-12.
UNRESISTED = 1e-3

#: Motion of the contacts over that of the blocks below which a motion moves no joint. It covers rounding.
NO_JOINT_MOVES = 1e-9


@dataclass(frozen=True)
class BlockState:
    """Trial forces that the contacts remember, and displacements of the blocks."""

    trial: np.ndarray  #: shape (3, m)
    d: np.ndarray  #: shape (3b,)


@dataclass(frozen=True)
class Equilibrium:
    """A state of equilibrium."""

    state: BlockState
    response: Response  #: of the contacts
    by_motion: bool  #: True if Newton's method failed and the blocks came to rest after a damped motion


@dataclass(frozen=True)
class Collapse:
    """A motion without end."""

    state: BlockState  #: during the motion
    motion: np.ndarray  #: displacement with which the motion goes on from there, shape (3b,)


@dataclass(frozen=True)
class _Step:
    """A solution of (1) or (2)."""

    state: BlockState
    response: Response
    displacement: np.ndarray  #: d, shape (3b,)
    unbalanced: np.ndarray  #: forces out of balance without damping, shape (3b,)


class EquilibriumSolver:
    """Solver of equations (1) and (2) for one problem.

    Attributes
    ----------
    mean_force: mean contact force under the dead load.
    iterations: number of linear solves so far.
    factorisations: number of factorisations so far. A tangent that is the same as the last one is not
        factorised again.
    """

    def __init__(
        self,
        problem: Problem,
        settings: IncrementalSettings | None = None,
        compliance: np.ndarray | None = None,
        matrix: StiffnessMatrix | None = None,
    ) -> None:
        """Set up contact law and matrix.

        The compliance, shape (3c + t,), is by default that of :func:`mean_force_and_compliance`. A matrix of
        another problem is used again if it suits the contacts.
        """
        self.problem, self.settings = problem, settings or IncrementalSettings()
        self.mean_force, by_extent = mean_force_and_compliance(problem)
        compliance = by_extent if compliance is None else compliance
        self.law = ContactLaw(problem, compliance, self.mean_force)
        suits = matrix is not None and matrix.suits(problem, self.law)
        self.matrix = matrix if matrix is not None and suits else StiffnessMatrix(problem, self.law)
        self.iterations = self.factorisations = 0
        self._last: tuple[np.ndarray, float, Factors] | None = None

    def at_rest(self, forces: np.ndarray | None = None) -> BlockState:
        """Return a state without displacement; forces (3c + t,) are in the problem's order."""
        if forces is None:
            forces = np.zeros(self.problem.B.shape[1])
        return BlockState(by_joint(forces, self.law.joints), np.zeros(self.matrix.size))

    def equilibrate(
        self, state: BlockState, load: np.ndarray, predictor: np.ndarray | None = None
    ) -> Equilibrium | Collapse:
        """Return the equilibrium that the blocks reach from a state under a load (3b,), or their collapse.

        Newton's method starts from the predictor, a displacement (3b,); by default from none. An equilibrium
        beyond ``far`` does not count: joints that are not quite parallel jam there.
        """
        step = self._solve(state, load, 0.0, predictor)
        if step is not None and self.size_of_motion(step.displacement) <= self.far(load):
            return Equilibrium(step.state, step.response, by_motion=False)
        return self._move(state, load)

    def trial_change(self, displacement: np.ndarray) -> np.ndarray:
        """Return the change of the trial forces, shape (3, m), under a displacement (3b,): -k Bᵀd."""
        change: np.ndarray = -self.law.stiffness * (self.matrix.Bt @ displacement).reshape(3, -1)
        return change

    def size_of_motion(self, displacement: np.ndarray) -> float:
        """Return the root mean square motion of the contacts, in elastic displacements."""
        return self.size(self.trial_change(displacement))

    def size(self, forces: np.ndarray) -> float:
        """Return the root mean square of forces, relative to the mean contact force."""
        flat = forces.ravel()
        return sqrt(float(flat @ flat) / flat.size) / self.mean_force

    def unbalanced(self, response: Response, load: np.ndarray) -> np.ndarray:
        """Return the forces out of balance, shape (3b,)."""
        left: np.ndarray = self.matrix.B @ response.forces.ravel() + load
        return left

    def is_balanced(self, unbalanced: np.ndarray, load: np.ndarray) -> bool:
        """Return True if forces out of balance are negligible."""
        return self.size(unbalanced) <= self._negligible(load)

    def factors(self, tangent: np.ndarray, damping: float) -> Factors:
        """Return the factors of the stiffness matrix for a tangent (3, 3, m) and a damping."""
        if self._last is not None:
            last_tangent, last_damping, factors = self._last
            if damping == last_damping and np.array_equal(tangent, last_tangent):
                return factors
        factors = self.matrix.factorise(tangent, damping)
        self.factorisations += 1
        self._last = tangent, damping, factors
        return factors

    def solve_linear(self, tangent: np.ndarray, damping: float, right: np.ndarray) -> np.ndarray:
        """Return the displacements under loads, shape (3b,) or (3b, count), for a tangent (3, 3, m)."""
        self.iterations += 1
        return self.factors(tangent, damping).solve(right)

    def far(self, load: np.ndarray) -> float:
        """Return the displacement beyond which the blocks have collapsed under a load (3b,)."""
        return self.settings.far * max(1.0, self.size(load))

    def _negligible(self, load: np.ndarray) -> float:
        return self.settings.equilibrium * max(1.0, self.size(load))

    def _move(self, state: BlockState, load: np.ndarray) -> Equilibrium | Collapse:
        """Follow the damped motion (2) to rest or to a collapse."""
        rigid = self._find_rigid_motion(state, load)
        if rigid is not None:
            return Collapse(state, rigid)
        settings, damping = self.settings, self.settings.damping
        succeeded, travelled, last_size = True, 0.0, inf
        motion = np.zeros(self.matrix.size)
        for _ in range(settings.damped_steps):
            step = self._solve(state, load, damping, None)
            if step is None:
                damping *= settings.acceleration
                succeeded = False
                continue
            state, motion = step.state, step.displacement
            if self.is_balanced(step.unbalanced, load):
                return Equilibrium(state, step.response, by_motion=True)
            travelled += self.size_of_motion(motion)
            if travelled > self.far(load):
                return Collapse(state, motion)
            size = self.size(step.unbalanced)
            if size > last_size / 2:
                endless = self._find_endless_motion(step, load)
                if endless is not None:
                    return Collapse(state, endless)
            last_size = size
            if succeeded:
                damping /= settings.acceleration
            succeeded = True
        return Collapse(state, motion)

    def _find_rigid_motion(self, state: BlockState, load: np.ndarray) -> np.ndarray | None:
        """Return the motion of blocks that no contact resists, even if all contacts stick; None without one.

        The damping, which is that of the contacts, does not slow such a motion.
        """
        response = self.law.respond(state.trial)
        unbalanced = self.unbalanced(response, load)
        sticks = np.broadcast_to(np.eye(3)[:, :, None], response.tangent.shape)
        motion = self.solve_linear(sticks, 0.0, unbalanced)
        left = unbalanced + self.matrix.B @ self.trial_change(motion).ravel()
        if self.size(left) <= UNRESISTED * self.size(unbalanced):
            return None
        rigid: np.ndarray = motion / np.abs(motion).max()
        return rigid

    def moves_no_joint(self, displacement: np.ndarray) -> bool:
        """Return True if a displacement (3b,) moves blocks without moving any joint."""
        return self.size_of_motion(displacement) <= NO_JOINT_MOVES * float(np.abs(displacement).max())

    def _find_endless_motion(self, step: _Step, load: np.ndarray) -> np.ndarray | None:
        """Return the displacement ``far`` along the motion if the forces out of balance stay the same.

        Without damping these forces cause a displacement that is this large only along a mechanism.
        """
        state, far = step.state, self.far(load)
        tangent = self.law.respond(state.trial).tangent
        motion = self.solve_linear(tangent, 0.0, step.unbalanced)
        size = self.size_of_motion(motion)
        if not size > far:
            return None
        motion = motion * (far / size)
        response = self.law.respond(state.trial + self.trial_change(motion))
        change = self.size(self.unbalanced(response, load) - step.unbalanced)
        return motion if change <= self.settings.steady * self.size(step.unbalanced) else None

    def _solve(
        self, state: BlockState, load: np.ndarray, damping: float, predictor: np.ndarray | None
    ) -> _Step | None:
        """Solve (1), or (2) if there is damping, by Newton's method with backtracking; None if it fails."""
        d = np.zeros(self.matrix.size) if predictor is None else predictor
        step, left = self._evaluate(state, load, damping, d)
        size, enough = self.size(left), self._negligible(load)
        if damping:
            enough = max(enough, self.settings.motion * size)
        for _ in range(self.settings.newton_iterations):
            if size <= enough:
                return step
            direction = self.solve_linear(step.response.tangent, damping, left)
            length = 1.0
            for _ in range(self.settings.halvings + 1):
                step, left = self._evaluate(state, load, damping, d + length * direction)
                new_size = self.size(left)
                if new_size <= max(enough, (1 - SUFFICIENT_DECREASE * length) * size):
                    break
                length /= 2
            else:
                return None
            d, size = step.displacement, new_size
        return None

    def _evaluate(
        self, state: BlockState, load: np.ndarray, damping: float, d: np.ndarray
    ) -> tuple[_Step, np.ndarray]:
        """Return the step with a displacement (3b,), and what it leaves of (1) or (2), shape (3b,)."""
        change = self.trial_change(d)
        response = self.law.respond(state.trial + change)
        left = unbalanced = self.unbalanced(response, load)
        if damping:
            left = unbalanced + damping * (self.matrix.B @ change.ravel())
        return _Step(BlockState(response.remembered, state.d + d), response, d, unbalanced), left

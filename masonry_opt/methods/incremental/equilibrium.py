"""Equilibrium under a load, by Newton's method and, if this method fails, by a damped motion of the blocks.

From a state, a displacement d of the blocks changes the trial forces of the contacts to q~ - k Bᵀd. The
blocks are in equilibrium under a load f if the forces q of the contact law balance the load:

    (1)  r(d) = B q(q~ - k Bᵀd) + f = 0

Friction without dilatancy has no potential, so that near the state (1) may have no solution, or several. If
Newton's method fails, the blocks move against a viscous damping η until they are in equilibrium again, or
until they have moved by more than ``far``, which counts as collapse. A time step of the implicit Euler method
solves

    (2)  r(d) - η B k Bᵀd = 0

by Newton's method until the residual is at most half of the unbalanced forces at the start of the step. The
first iteration alone is often enough (linearly implicit Euler method, Deuflhard 1985). If contacts open,
close, slip or stick, Newton's method may fail. Then the displacement of the first iteration is halved until
the error of its linear prediction is at most half of the unbalanced forces at the start. The damping
decreases after a complete step and increases after a shortened step.
"""

from dataclasses import dataclass
from math import sqrt

import numpy as np

from masonry_opt.deadline import check_time
from masonry_opt.methods.incremental.contact_law import (
    ContactLaw,
    Response,
    by_joint,
    mean_force_and_compliance,
)
from masonry_opt.methods.incremental.settings import IncrementalSettings
from masonry_opt.methods.incremental.stiffness import Factors, StiffnessMatrix
from masonry_opt.problem.problem import Problem


@dataclass(frozen=True)
class BlockState:
    """State of the blocks in a load history: trial forces of the contacts, and block displacements."""

    #: Elastic trial forces of the contacts, shape (3, m). Permanent slip is subtracted from the deformation
    #: that causes these forces.
    trial: np.ndarray
    d: np.ndarray  #: displacements, shape (3b,)


@dataclass(frozen=True)
class Equilibrium:
    """State of equilibrium, with the forces of the contacts."""

    state: BlockState
    response: Response  #: response of the contacts
    by_motion: bool  #: True if Newton's method failed, and a damped motion ended at rest


@dataclass(frozen=True)
class Collapse:
    """Motion that counts as collapse, because contacts do not stop it within the displacement ``far``."""

    state: BlockState  #: state of the blocks during the motion
    motion: np.ndarray  #: displacements of the blocks in the last time step of the motion, shape (3b,)


@dataclass(frozen=True)
class SlowMotion:
    """Damped motion that reached neither rest nor collapse within ``motion_solves`` linear solves."""

    state: BlockState  #: state of the blocks at the end of the motion


@dataclass(frozen=True)
class Step:
    """Displacement of the blocks from a state, with the contact forces and the residuals that result."""

    state: BlockState
    response: Response
    displacement: np.ndarray  #: d, shape (3b,)
    unbalanced: np.ndarray  #: r, shape (3b,)
    #: Residual of the damped motion, or of equilibrium if there is no damping, shape (3b,): eq. (2) or
    #: eq. (1) of the module docstring.
    residual: np.ndarray


class EquilibriumSolver:
    """Solver for equilibrium and damped motion of the blocks of one problem: eqs (1) and (2) of the module.

    Attributes
    ----------
    mean_force: mean contact force under the dead load.
    iterations: number of linear solves so far.
    factorisations: number of factorisations so far. If the tangent has not changed, its last factors are
        used again.
    """

    def __init__(
        self,
        problem: Problem,
        settings: IncrementalSettings | None = None,
        compliance: np.ndarray | None = None,
        matrix: StiffnessMatrix | None = None,
    ) -> None:
        """Set up the contact law and the stiffness matrix.

        The compliance has shape (3c + t,). By default :func:`mean_force_and_compliance` computes it. The
        stiffness matrix ``matrix`` of another problem is reused if both problems have the same joints and the
        same elastic stiffness.
        """
        self.problem, self.settings = problem, settings or IncrementalSettings()
        self.mean_force, by_extent = mean_force_and_compliance(problem, self.settings)
        compliance = by_extent if compliance is None else compliance
        self.law = ContactLaw(problem, compliance, self.mean_force, self.settings)
        suits = matrix is not None and matrix.suits(problem, self.law)
        if matrix is None or not suits:
            matrix = StiffnessMatrix(problem, self.law, self.settings)
        self.matrix = matrix
        self.iterations = self.factorisations = 0
        self._last: tuple[np.ndarray, float, Factors] | None = None

    def at_rest(self, forces: np.ndarray | None = None) -> BlockState:
        """Return a state of blocks without displacement. The forces, shape (3c + t,), are zero by default."""
        if forces is None:
            forces = np.zeros(self.problem.B.shape[1])
        return BlockState(by_joint(forces, self.law.joints), np.zeros(self.matrix.size))

    def equilibrate(self, state: BlockState, load: np.ndarray) -> Equilibrium | Collapse | SlowMotion:
        """Return the equilibrium or the motion that a load, shape (3b,), causes from a given state.

        An equilibrium beyond the displacement ``far`` is ignored, because joints that are not quite parallel
        may jam at such large displacements.
        """
        equilibrium = self.find_equilibrium(state, load, self.evaluate(state, load))
        return self.move(state, load) if equilibrium is None else equilibrium

    def find_equilibrium(self, state: BlockState, load: np.ndarray, first: Step) -> Equilibrium | None:
        """Return the equilibrium that Newton's method finds, or None if the method fails.

        Newton's method starts from the displacement of ``first``, a step from the same state under the same
        load.
        """
        step = self._solve(state, load, first)
        if step is None or self.size_of_motion(step.displacement) > self.far(load):
            return None
        return Equilibrium(step.state, step.response, by_motion=False)

    def move(self, state: BlockState, load: np.ndarray) -> Equilibrium | Collapse | SlowMotion:
        """Follow the damped motion up to equilibrium, collapse or the largest number of linear solves."""
        rigid = self._find_rigid_motion(state, load)
        if rigid is not None:
            return Collapse(state, rigid)
        settings, damping = self.settings, 1.0
        travelled = checked = 0.0
        start = self.evaluate(state, load)
        last = self.iterations + settings.motion_solves
        while self.iterations < last:
            step, share = self._step_in_time(start, load, damping)
            damping *= settings.acceleration if share < 1.0 else 1 / settings.acceleration
            if step is None:
                # Stop: with this damping, the blocks move in a time step by less than the rounding errors.
                if damping * settings.rounding**2 > 1.0:
                    break
                continue
            start = self.evaluate(step.state, load)
            if self.is_balanced(start.unbalanced, load):
                return Equilibrium(start.state, start.response, by_motion=True)
            travelled += self.size_of_motion(step.displacement)
            if travelled > self.far(load):
                return Collapse(start.state, step.displacement)
            if share == 1.0 and travelled > 10 * checked:
                checked = travelled
                endless = self._find_endless_motion(start, load)
                if endless is not None:
                    return Collapse(start.state, endless)
        return SlowMotion(start.state)

    def trial_change(self, displacement: np.ndarray) -> np.ndarray:
        """Return the change of the trial forces under a displacement d: −k Bᵀd, shape (3, m).

        The displacement has shape (3b,).
        """
        change: np.ndarray = -self.law.stiffness * (self.matrix.Bt @ displacement).reshape(3, -1)
        return change

    def size_of_motion(self, displacement: np.ndarray) -> float:
        """Return the root mean square of the relative motions that a displacement causes at all contacts.

        The displacement has shape (3b,). The unit of the result is the elastic displacement that
        :class:`IncrementalSettings` defines.
        """
        return self.size(self.trial_change(displacement))

    def size(self, forces: np.ndarray) -> float:
        """Return the size of forces: their root mean square, relative to the mean contact force."""
        flat = forces.ravel()
        return sqrt(float(flat @ flat) / flat.size) / self.mean_force

    def unbalanced(self, response: Response, load: np.ndarray) -> np.ndarray:
        """Return the unbalanced forces on the blocks, shape (3b,)."""
        unbalanced: np.ndarray = self.matrix.B @ response.forces.ravel() + load
        return unbalanced

    def is_balanced(self, unbalanced: np.ndarray, load: np.ndarray) -> bool:
        """Return True if unbalanced forces are negligible compared with a load."""
        return self.size(unbalanced) <= self._negligible(load)

    def factors(self, tangent: np.ndarray, damping: float) -> Factors:
        """Factorise the stiffness matrix that results from a contact tangent and a damping coefficient.

        ``tangent`` has the shape (3, 3, m). The last factorisation is reused if the arguments are unchanged.
        """
        if self._last is not None:
            last_tangent, last_damping, factors = self._last
            if damping == last_damping and np.array_equal(tangent, last_tangent):
                return factors
        factors = self.matrix.factorise(tangent, damping)
        self.factorisations += 1
        self._last = tangent, damping, factors
        return factors

    def solve_linear(self, tangent: np.ndarray, damping: float, right: np.ndarray) -> np.ndarray:
        """Return the displacements that loads cause, for given derivatives of the contact forces.

        The loads ``right`` have shape (3b,) or (3b, count). The derivatives ``tangent`` of the contact forces
        with respect to the trial forces have shape (3, 3, m).

        Raises TimeLimitReached if the time limit of the analysis is over.
        """
        check_time()
        self.iterations += 1
        return self.factors(tangent, damping).solve(right)

    def far(self, load: np.ndarray) -> float:
        """Return the displacement beyond which the blocks count as collapsed under a load.

        The load has shape (3b,).
        """
        return self.settings.far * max(1.0, self.size(load))

    def _negligible(self, load: np.ndarray) -> float:
        return self.settings.equilibrium * max(1.0, self.size(load))

    def _find_rigid_motion(self, state: BlockState, load: np.ndarray) -> np.ndarray | None:
        """Return a motion of the blocks that no contact resists, or None if contacts resist every motion.

        Damping cannot slow a motion without resistance, because only the contacts are damped.
        """
        response = self.law.respond(state.trial)
        unbalanced = self.unbalanced(response, load)
        sticks = np.broadcast_to(np.eye(3)[:, :, None], response.tangent.shape)
        motion = self.solve_linear(sticks, 0.0, unbalanced)
        residual = unbalanced + self.matrix.B @ self.trial_change(motion).ravel()
        if self.size(residual) <= self.settings.unresisted * self.size(unbalanced):
            return None
        rigid: np.ndarray = motion / np.abs(motion).max()
        return rigid

    def moves_no_joint(self, displacement: np.ndarray) -> bool:
        """Return True if a displacement, shape (3b,), moves blocks without relative motion at any joint."""
        return self.size_of_motion(displacement) <= self.settings.rounding * float(np.abs(displacement).max())

    def _find_endless_motion(self, step: Step, load: np.ndarray) -> np.ndarray | None:
        """Return a displacement of size ``far`` that no contact stops, or None if the blocks may stop.

        Without damping, the unbalanced forces cause such a large displacement only along a mechanism. The
        unbalanced forces must hardly change along the displacement (setting ``steady``).
        """
        far = self.far(load)
        motion = self.solve_linear(step.response.tangent, 0.0, step.unbalanced)
        size = self.size_of_motion(motion)
        if not size > far:
            return None
        motion = motion * (far / size)
        change = self.evaluate(step.state, load, 0.0, motion).unbalanced - step.unbalanced
        return motion if self.size(change) <= self.settings.steady * self.size(step.unbalanced) else None

    def _step_in_time(self, start: Step, load: np.ndarray, damping: float) -> tuple[Step | None, float]:
        """Return an implicit Euler step of the damped motion, and its length as a fraction of the full step.

        Newton's method continues as long as each iteration halves the residual. If the method fails, the
        displacement of the first iteration is shortened. The step is None if it would become too short.
        """
        size = self.size(start.unbalanced)
        limit = 2 * size
        first = step = self._iterate(start, start, load, damping)
        error = self.size(step.residual)
        while size / 2 < error <= limit:
            limit = error / 2
            step = self._iterate(start, step, load, damping)
            error = self.size(step.residual)
        if error <= size / 2:
            return step, 1.0
        return self._shorten(start, first, load)

    def _iterate(self, start: Step, step: Step, load: np.ndarray, damping: float) -> Step:
        """Return the result of one further Newton iteration of the time step that begins at ``start``."""
        x = self.solve_linear(step.response.tangent, damping, step.residual)
        return self.evaluate(start.state, load, damping, step.displacement + x)

    def _shorten(self, start: Step, whole: Step, load: np.ndarray) -> tuple[Step | None, float]:
        """Halve a time step until the tangent predicts the forces well, and return the shorter step.

        The second returned value is the length of the shorter step as a fraction of the full step. The
        tangent predicts that the unbalanced forces change linearly during the full step. At the end of the
        full step, the damping balances these forces. The error of the prediction must be at most half of the
        unbalanced forces at the start. If the error is larger even for the shortest step, None and zero are
        returned.
        """
        enough = self.size(start.unbalanced) / 2
        predicted = whole.unbalanced - whole.residual
        share = 1.0
        for _ in range(self.settings.halvings):
            share /= 2
            part = self.evaluate(start.state, load, 0.0, share * whole.displacement)
            error = part.unbalanced - (1 - share) * start.unbalanced - share * predicted
            if self.size(error) <= enough:
                return part, share
        return None, 0.0

    def _solve(self, state: BlockState, load: np.ndarray, step: Step) -> Step | None:
        """Solve equilibrium, eq. (1) of the module docstring, by Newton's method with backtracking.

        The method starts from a given step. None is returned if the method fails.
        """
        negligible = self._negligible(load)
        size = self.size(step.residual)
        for _ in range(self.settings.newton_iterations):
            if size <= negligible:
                return step
            direction = self.solve_linear(step.response.tangent, 0.0, step.residual)
            length, last = 1.0, step
            for _ in range(self.settings.halvings + 1):
                step = self.evaluate(state, load, 0.0, last.displacement + length * direction)
                new_size = self.size(step.residual)
                if new_size < size or new_size <= negligible:
                    break
                length /= 2
            else:
                return None
            size = new_size
        return None

    def evaluate(
        self, state: BlockState, load: np.ndarray, damping: float = 0.0, d: np.ndarray | None = None
    ) -> Step:
        """Return the contact forces and the residuals that result from a displacement of the blocks.

        The displacement ``d`` starts from ``state`` and has shape (3b,). It is zero by default.
        """
        d = np.zeros(self.matrix.size) if d is None else d
        change = self.trial_change(d)
        response = self.law.respond(state.trial + change)
        residual = unbalanced = self.unbalanced(response, load)
        if damping:
            residual = unbalanced + damping * (self.matrix.B @ change.ravel())
        return Step(BlockState(response.remembered, state.d + d), response, d, unbalanced, residual)

"""Compute the exact state of a collapse, in which the blocks continue to move under a constant load.

After a large motion, contacts no longer deform elastically: they only slip or open. The size of the motion is
then prescribed, and the load factor is an unknown (displacement control, Batoz & Dhatt 1979). Let r be the
unbalanced forces, and c·d the component of d along the motion. Each iteration of Newton's method solves

    S x = r,    S y = f_L,    Δλ = -c·x / c·y,    Δd = x + Δλ y    so that c·Δd = 0.

After convergence y is the mechanism. In the plane one solve suffices. In space the directions of slip turn
towards the mechanism, and further solves continue from the last state.

If displacement control fails, two optimisation programs look for an exact state near the collapse: one finds
a mechanism for given slacks, the other finds forces for given rates (see
:mod:`~masonry_opt.methods.exact.refiner`).
"""

from dataclasses import dataclass

import numpy as np

from masonry_opt.effort import Effort
from masonry_opt.methods.exact.settings import SEARCH
from masonry_opt.methods.incremental.equilibrium import Collapse, EquilibriumSolver
from masonry_opt.solution.answer import Answer, certified


@dataclass(frozen=True)
class _FarState:
    """State of the blocks after a motion so large that contacts deform no further, but only slip or open."""

    load_factor: float
    #: Elastic trial forces after the motion, shape (3, m). Permanent slip is subtracted from the deformation
    #: that causes these forces.
    trial: np.ndarray
    forces: np.ndarray  #: contact forces after the motion, shape (3, m)
    d: np.ndarray  #: displacements of the blocks after the motion, shape (3b,)
    #: Direction in which the blocks continue to move, shape (3b,).
    mechanism: np.ndarray


def solve_collapse_state(solver: EquilibriumSolver, collapse: Collapse, load_factor: float) -> Answer | None:
    """Return the exact state of a collapse, computed by displacement control, or None if this fails."""
    trial, motion = collapse.state.trial, collapse.motion
    for _ in range(solver.settings.exact_solves):
        far = _solve_far_along(solver, trial, motion, load_factor)
        if far is None:
            return None
        answer = _certify(solver, far)
        if answer is not None and answer.exact:
            return answer
        trial, motion, load_factor = far.trial, far.mechanism, far.load_factor
    return None


def find_collapse_state(
    solver: EquilibriumSolver, collapse: Collapse, effort: Effort | None = None
) -> Answer | None:
    """Return an exact state near a collapse, computed by two optimisation programs, or None if this fails.

    The programs start from the forces at the collapse. In the plane they are solved by the simplex method, in
    space and on large scenes by an interior-point method.
    """
    problem, effort = solver.problem, effort or Effort()
    forces = solver.law.of_problem(solver.law.respond(collapse.state.trial).forces)
    # The imports are local: few collapses need them. One module imports HiGHS, and the other also a modelling
    # language, which takes seconds.
    if not problem.layout.round and problem.joints <= SEARCH.simplex_up_to:
        from masonry_opt.methods.exact.refiner import Refiner

        state = Refiner(problem, effort).first(forces)
        answer = None if state is None else state.answer
    else:
        from masonry_opt.methods.exact.alternation import Alternation

        answer = Alternation(problem, effort).state_near(forces, None)
    return answer if answer is not None and answer.exact else None


def _solve_far_along(
    solver: EquilibriumSolver, trial: np.ndarray, motion: np.ndarray, load_factor: float
) -> _FarState | None:
    """Return the state after the blocks have moved by the distance ``far`` in the direction of a motion.

    The motion has shape (3b,). None is returned if Newton's method fails.
    """
    problem = solver.problem
    if solver.moves_no_joint(motion):
        return _balance_rigid_motion(solver, trial, motion)
    load = problem.dead + load_factor * problem.live
    far = solver.far(load)
    negligible = solver.settings.rounding * max(1.0, solver.size(load)) * solver.mean_force
    d = motion * (far / solver.size_of_motion(motion))
    control = solver.matrix.B @ solver.trial_change(d).ravel()
    for _ in range(solver.settings.newton_iterations):
        response = solver.law.respond(trial + solver.trial_change(d))
        unbalanced = solver.unbalanced(response, problem.dead + load_factor * problem.live)
        both = solver.solve_linear(response.tangent, 0.0, np.column_stack([unbalanced, problem.live]))
        x, y = both.T
        if not np.isfinite(both).all() or control @ y == 0:
            return None
        if np.abs(unbalanced).max() <= negligible:
            return _FarState(load_factor, response.remembered, response.forces, d, y)
        change = -float(control @ x) / float(control @ y)
        d, load_factor = d + x + change * y, load_factor + change
    return None


def _balance_rigid_motion(
    solver: EquilibriumSolver, trial: np.ndarray, motion: np.ndarray
) -> _FarState | None:
    """Return the state at the λ for which the total work of all forces in a rigid motion is zero.

    The motion has shape (3b,). None is returned if the live load does no work in it.
    """
    problem, response = solver.problem, solver.law.respond(trial)
    work = float(problem.live @ motion)
    if work == 0:
        return None
    load_factor = -float(solver.unbalanced(response, problem.dead) @ motion) / work
    return _FarState(load_factor, response.remembered, response.forces, motion, motion)


def _certify(solver: EquilibriumSolver, far: _FarState) -> Answer | None:
    """Convert a state to an answer with a certificate, or return None if the live load does no work.

    The motion of the answer is the displacement or the mechanism, whichever has the smaller residuals.
    """
    problem, q = solver.problem, solver.law.of_problem(far.forces)
    answers = []
    for motion in (far.d, far.mechanism):
        work = float(problem.live @ motion)
        if work:
            velocities = motion * (problem.live_norm / work)
            answers.append(certified(problem.by_cone, far.load_factor, q, velocities))
    return min(answers, key=lambda answer: answer.certificate.worst, default=None)

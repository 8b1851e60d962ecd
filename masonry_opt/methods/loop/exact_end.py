"""The end of the loop: an exact state of statics on the mechanism it found."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from masonry_opt.answer.acceptance import LIMITS, MOST_ENERGY, SMALLEST, Kind
from masonry_opt.answer.certificate import certify
from masonry_opt.effort import Effort
from masonry_opt.models.cvxpy_at_yield import CvxpyAtYield
from masonry_opt.models.cvxpy_least_energy import CvxpyForcesFor, CvxpyMotionFor
from masonry_opt.problem.load_units import Scaled, in_units_of_load
from masonry_opt.problem.problem import Problem
from masonry_opt.problem.state import State
from masonry_opt.solvers.cvxpy_engine import has_optimum
from masonry_opt.solvers.registry import Solver, in_cvxpy

#: A face belongs to the mechanism if its rate exceeds this share of the largest: well above what the
#: solver's tolerance leaves of a zero. First the larger mechanism, then the surer one.
_SHARES = (1e-6, 1e-4)

#: Weight of that energy over λ where a mechanism is known roughly: λ must fall by more than so many times the
#: energy that it adds. On façades 10 leaves up to half as much energy again; 100 leaves λ up to 0.2 % higher.
_WEIGHT = 30.0

#: What a solver does here, as a result tells it.
_PURPOSE = "exact end"


@dataclass(frozen=True)
class ExactEnd:
    """Joint forces (3c,) that obey equilibrium and the true law, the block velocities (3b,) of a mechanism
    that moves where they are at yield (but for MOST_ENERGY), and the opening per unit slip that the forces
    allow the joints that can slide, shape (k,)."""

    load_factor: float
    q: np.ndarray
    d: np.ndarray
    slope: np.ndarray


def accurate_end(
    problem: Problem, state: State, near: float, solver: Solver, effort: Effort
) -> ExactEnd | None:
    """An exact state on the mechanism of an accurately solved sub-problem, if there is one: the one whose λ
    is nearest to ``near``."""
    for share in _SHARES:
        model = CvxpyAtYield(problem, state.p > share * state.p.max(), near)
        if has_optimum(model.program, in_cvxpy(solver), effort, _PURPOSE) and (
            end := _belonging(problem, *model.statics.forces(), state.d)
        ):
            return end
    return None


def rough_end(problem: Problem, state: State, solver: Solver, effort: Effort) -> ExactEnd | None:
    """Exact forces and a mechanism near that of a sub-problem solved roughly, whose rates are zero nowhere.

    First the forces that leave little energy z·p for its rates and have a low λ; then the mechanism of the
    true flow rule that leaves least for those forces (the sub-problem's own where the solver finds none).
    """
    scaled, solver = in_units_of_load(problem), in_cvxpy(solver)
    forces = CvxpyForcesFor(scaled.problem, state.p, _WEIGHT)
    if not has_optimum(forces.program, solver, effort, _PURPOSE):
        return None
    load_factor, q = forces.statics.forces()
    d = motion_for(scaled, q, solver, effort, _PURPOSE)
    whole = scaled.state(replace(state, load_factor=load_factor, q=q))
    return _belonging(problem, whole.load_factor, whole.q, state.d if d is None else d)


def motion_for(
    scaled: Scaled, q: np.ndarray, solver: Solver, effort: Effort, purpose: str
) -> np.ndarray | None:
    """Velocities (3b,) of the true flow rule that leave least energy for forces (3c,) of a problem in units
    of its load; None if the solver finds none."""
    problem = scaled.problem
    slope = problem.dilatancy_at(problem.normal_forces(q))
    motion = CvxpyMotionFor(problem, np.maximum(problem.slacks(q), 0.0), slope)
    if not has_optimum(motion.program, solver, effort, purpose):
        return None
    return np.asarray(motion.mechanism.d.value)


def belong_together(
    problem: Problem, load_factor: float, q: np.ndarray, d: np.ndarray, slope: np.ndarray
) -> bool:
    """Whether forces (3c,) and velocities (3b,) belong together under a flow rule, shape (k,)."""
    left = certify(problem, load_factor, q, d, slope)
    most = MOST_ENERGY * max(abs(load_factor), SMALLEST)
    return left.complementarity <= most and left.flow <= LIMITS[Kind.LOOP].flow


def _belonging(problem: Problem, load_factor: float, q: np.ndarray, d: np.ndarray) -> ExactEnd | None:
    slope = problem.dilatancy_at(problem.normal_forces(q))
    if belong_together(problem, load_factor, q, d, slope):
        return ExactEnd(load_factor, q, d, slope)
    return None

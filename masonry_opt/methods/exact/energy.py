"""Forces that leave least energy z·p for given rates, and a mechanism that leaves least for given forces; in
space by cones of friction, if the problem is."""

from __future__ import annotations

from collections.abc import Callable

import cvxpy as cp
import numpy as np

from masonry_opt.models.cvxpy_cone import cone_forces, cone_motion
from masonry_opt.models.cvxpy_exact import CvxpyForces, CvxpyMotion, energy_costs
from masonry_opt.models.cvxpy_terms import Statics
from masonry_opt.problem.load_units import Scaled

#: Weight of that energy over λ where a mechanism is known roughly: λ must fall by more than so many times the
#: energy that it adds. On façades 10 leaves up to half as much energy again; 100 leaves λ up to 0.2 % higher.
WEIGHT = 30.0


#: Solves a program; whether there is an optimum to read, as :func:`~.cvxpy_engine.has_optimum` of a solver.
Solves = Callable[[cp.Problem], bool]


def forces_for(
    scaled: Scaled, p: np.ndarray, solves: Solves, weight: float = WEIGHT
) -> tuple[float, np.ndarray] | None:
    """λ and forces (3c,) of a low λ that leave little energy for rates p (faces,) of a problem in units of
    its load; None if the solver finds none."""
    problem = scaled.problem
    statics: Statics
    if problem.by_friction.conic:
        statics, program = cone_forces(problem, p, weight)
    else:
        forces = CvxpyForces(problem, energy_costs(problem, p, weight))
        statics, program = forces.statics, forces.program
    return statics.forces() if solves(program) else None


def motion_for(scaled: Scaled, q: np.ndarray, solves: Solves) -> np.ndarray | None:
    """Velocities (3b,) of the true flow rule that leave least energy for forces (3c,) of a problem in units
    of its load; None if the solver finds none."""
    problem = scaled.problem
    slope = problem.dilatancy_at(problem.normal_forces(q))
    if problem.by_friction.conic:
        d, program = cone_motion(problem, q, slope)
    else:
        motion = CvxpyMotion(problem, np.maximum(problem.slacks(q), 0.0) / problem.steep, slope)
        d, program = motion.mechanism.d, motion.program
    return np.asarray(d.value) if solves(program) else None

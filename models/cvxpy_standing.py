"""Whether a scene stands under given forces alone, in CVXPY, and what moves if it does not."""

from __future__ import annotations

import cvxpy as cp
import numpy as np

from masonry_opt.models.cvxpy_terms import Mechanism, ShearParameters, Statics
from masonry_opt.problem.problem import Problem, ShearLimits


class CvxpyStanding:
    """Eq. (9) without a live load: any forces q with

    B q + f_D = 0,    z = C(slope) q + c ≥ 0
    """

    def __init__(self, problem: Problem, limits: ShearParameters | ShearLimits) -> None:
        self.statics = Statics(problem, limits, load_factor=cp.Constant(0.0))
        rows = [self.statics.equilibrium, self.statics.slacks >= 0]
        self.program = cp.Problem(cp.Minimize(0), rows)


class CvxpyFalling:
    """How blocks begin to fall: of all mechanisms that the dead load drives the one nearest to free fall.

        max  scale (f_D·d − c·p) − ½ Σ wᵢ |dᵢ|²    s.t.    Bᵀ d = D(slope) p,    p ≥ 0

    over the blocks i, with wᵢ = |f_D,i| in place of masses, and in |dᵢ| rotations times radii of gyration,
    shape (b,): Gauss's principle of least constraint. Blocks that can stay in touch do. Velocities are
    ``scale`` times those that go with free fall at 1: of what hardly falls they would be rounding.
    """

    def __init__(self, problem: Problem, limits: ShearLimits, gyration: np.ndarray, scale: float) -> None:
        mechanism = self.mechanism = Mechanism(problem, limits.slope)
        power = problem.dead @ mechanism.d - limits.cohesion @ mechanism.slip - mechanism.crushing
        # In the unit of force the median block's is one. Without weight there is no inertia: a little.
        size = np.maximum(problem.force_sizes(problem.dead), 1e-2)
        root = np.sqrt(size)[:, None] * np.column_stack([np.ones((len(size), 2)), gyration])
        inertia = cp.sum_squares(cp.multiply(root.ravel(), mechanism.d))
        self.program = cp.Problem(cp.Maximize(scale * power - inertia / 2), [mechanism.compatibility])


class CvxpyDriven:
    """The mechanism that a force drives, its velocities bounded: the dual ray of an infeasible eq. (9).

        max  force·d − c·p    s.t.    Bᵀ d = D(slope) p,    p ≥ 0,    −1 ≤ d ≤ 1

    Driven by the dead load it tells which blocks fall; driven by the live load, whether anything could move.
    """

    def __init__(self, problem: Problem, force: np.ndarray, limits: ShearLimits) -> None:
        mechanism = self.mechanism = Mechanism(problem, limits.slope)
        power = force @ mechanism.d - limits.cohesion @ mechanism.slip - mechanism.crushing
        rows = [mechanism.compatibility, mechanism.d <= 1, mechanism.d >= -1]
        self.program = cp.Problem(cp.Maximize(power), rows)

"""Stability of a scene under its dead load alone, in CVXPY, and the mechanism if it is unstable.

In space, the friction limits are cones.
"""

import cvxpy as cp
import numpy as np

from masonry_opt.models.cvxpy_cone import ConeMechanism, ConeStatics, Senses
from masonry_opt.models.cvxpy_terms import CvxpyMechanism, CvxpyShearParameters, CvxpyStatics
from masonry_opt.problem.problem import Problem, ShearLimits

#: Smallest weight of a block in the inertia term, relative to the median block weight. Smaller weights are
#: raised to this value, because the motion of weightless blocks would not be unique. A larger value would
#: reduce the motion of light blocks.
_LEAST_WEIGHT = 1e-2


def by_cones(problem: Problem) -> bool:
    """Return True if the friction limits of the problem are cones."""
    return problem.by_friction.conic and len(problem.sliding) > 0


class CvxpyStanding:
    """Static program, eq. (9), without live load: find forces that satisfy equilibrium and yield conditions.

    B q + f_D = 0,    z = C(slope) q + c ≥ 0;    in space n ≥ 0,    |(s, t)| ≤ c + slope · n
    """

    def __init__(self, problem: Problem, limits: ShearLimits) -> None:
        self.limits = CvxpyShearParameters(limits)
        terms = ConeStatics if by_cones(problem) else CvxpyStatics
        statics = self.statics = terms(problem, self.limits, load_factor=cp.Constant(0.0))
        self.program = cp.Problem(cp.Minimize(0), [statics.equilibrium, *statics.within_yield])


def _mechanism(problem: Problem, limits: ShearLimits, senses: Senses | None = None) -> CvxpyMechanism:
    """Return the variables and constraints of a mechanism, with friction cones if the problem has cones."""
    if by_cones(problem):
        return ConeMechanism(problem, limits.slope, senses)
    return CvxpyMechanism(problem, limits.slope)


class CvxpyFalling:
    """Program for the mechanism with which blocks begin to fall under the dead load.

        max  scale (f_D·d − c·p) − ½ Σ wᵢ |dᵢ|²    s.t.    Bᵀ d = D(slope) p,    p ≥ 0

    By Gauss's principle of least constraint, the solution is the mechanism nearest to free fall. The sum is
    over the blocks i, with the weights wᵢ = |f_D,i| as masses. In |dᵢ|, rotations are multiplied by the radii
    of gyration, shape (b, rotations).

    With ``scale`` 1, the velocities of free fall have magnitude 1. A larger scale multiplies all velocities,
    so that the velocities of blocks that hardly fall are not lost in rounding.
    """

    def __init__(self, problem: Problem, limits: ShearLimits, gyration: np.ndarray, scale: float) -> None:
        mechanism = self.mechanism = _mechanism(problem, limits)
        weight = np.maximum(problem.force_sizes(problem.dead), _LEAST_WEIGHT)
        of_translation = np.ones((len(weight), problem.layout.dimension))
        root = np.sqrt(weight)[:, None] * np.column_stack([of_translation, gyration])
        inertia = cp.sum_squares(cp.multiply(root.ravel(), mechanism.d))
        driven = scale * mechanism.power(limits.cohesion) - inertia / 2
        self.program = cp.Problem(cp.Maximize(driven), mechanism.rows)


class CvxpyDriven:
    """Program for the mechanism with velocities from −1 to 1 that has the largest net power of the dead load.

        max  f_D·d − c·p    s.t.    Bᵀ d = D(slope) p,    p ≥ 0,    −1 ≤ d ≤ 1
        min  Σ|B q + f_D|   s.t.    C(slope) q + c ≥ 0

    The second line is the dual program. It finds the forces that satisfy the yield conditions and
    are nearest to equilibrium. In space, the friction limits are cones, or polygons if ``senses`` is passed;
    see :class:`~.cvxpy_cone.ConeMechanism`.
    """

    def __init__(self, problem: Problem, limits: ShearLimits, senses: Senses | None = None) -> None:
        mechanism = self.mechanism = _mechanism(problem, limits, senses)
        power = mechanism.power(limits.cohesion)
        self.program = cp.Problem(cp.Maximize(power), [*mechanism.rows, mechanism.d <= 1, mechanism.d >= -1])

    def read(self) -> tuple[np.ndarray, np.ndarray] | None:
        """Return the velocities d and the forces q, or None if the solver found no solution.

        The forces are the negative of CVXPY's dual values of compatibility.
        """
        d, q = self.mechanism.d.value, self.mechanism.compatibility.dual_value
        return None if d is None or q is None else (d, -q)

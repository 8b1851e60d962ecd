"""Whether a scene stands under given forces alone, in CVXPY, and what moves if it does not; in space by cones
of friction."""

import cvxpy as cp
import numpy as np

from masonry_opt.models.cvxpy_cone import ConeMechanism, ConeStatics, Senses
from masonry_opt.models.cvxpy_terms import Mechanism, ShearParameters, Statics
from masonry_opt.problem.problem import Problem, ShearLimits


def by_cones(problem: Problem) -> bool:
    """Whether these programs have cones of friction."""
    return problem.by_friction.conic and len(problem.sliding) > 0


class CvxpyStanding:
    """Eq. (9) without a live load: any forces q with

    B q + f_D = 0,    z = C(slope) q + c ≥ 0;    in space n ≥ 0,    |(s, t)| ≤ c + slope · n
    """

    def __init__(self, problem: Problem, limits: ShearLimits) -> None:
        self.limits = ShearParameters(limits)
        terms = ConeStatics if by_cones(problem) else Statics
        statics = self.statics = terms(problem, self.limits, load_factor=cp.Constant(0.0))
        self.program = cp.Problem(cp.Minimize(0), [statics.equilibrium, *statics.within_yield])


def _mechanism(problem: Problem, limits: ShearLimits, senses: Senses | None = None) -> Mechanism:
    if by_cones(problem):
        return ConeMechanism(problem, limits.slope, senses)
    return Mechanism(problem, limits.slope)


class CvxpyFalling:
    """How blocks begin to fall: of all mechanisms that the dead load drives the one nearest to free fall.

        max  scale (f_D·d − c·p) − ½ Σ wᵢ |dᵢ|²    s.t.    Bᵀ d = D(slope) p,    p ≥ 0

    over the blocks i, with wᵢ = |f_D,i| in place of masses, and in |dᵢ| rotations times radii of gyration,
    shape (b, rotations): Gauss's principle of least constraint. Velocities are ``scale`` times those that go
    with free fall at 1: of what hardly falls they would be rounding.
    """

    def __init__(self, problem: Problem, limits: ShearLimits, gyration: np.ndarray, scale: float) -> None:
        mechanism = self.mechanism = _mechanism(problem, limits)
        # In the unit of force the median block's is one. Without weight there is a little inertia.
        size = np.maximum(problem.force_sizes(problem.dead), 1e-2)
        of_velocity = np.ones((len(size), problem.layout.dimension))
        root = np.sqrt(size)[:, None] * np.column_stack([of_velocity, gyration])
        inertia = cp.sum_squares(cp.multiply(root.ravel(), mechanism.d))
        driven = scale * mechanism.power(limits.cohesion) - inertia / 2
        self.program = cp.Problem(cp.Maximize(driven), mechanism.rows)


class CvxpyDriven:
    """The mechanism that the dead load drives, its velocities bounded, and its dual, the forces within yield
    that leave least out of balance:

        max  f_D·d − c·p    s.t.    Bᵀ d = D(slope) p,    p ≥ 0,    −1 ≤ d ≤ 1
        min  Σ|B q + f_D|   s.t.    C(slope) q + c ≥ 0

    In space by cones, or by senses of slips, as of :class:`~.cvxpy_cone.ConeMechanism`.
    """

    def __init__(self, problem: Problem, limits: ShearLimits, senses: Senses | None = None) -> None:
        mechanism = self.mechanism = _mechanism(problem, limits, senses)
        power = mechanism.power(limits.cohesion)
        self.program = cp.Problem(cp.Maximize(power), [*mechanism.rows, mechanism.d <= 1, mechanism.d >= -1])

    def read(self) -> tuple[np.ndarray, np.ndarray] | None:
        """Velocities d, and forces q as duals of compatibility (CVXPY's sign turned), if there are any."""
        d, q = self.mechanism.d.value, self.mechanism.compatibility.dual_value
        return None if d is None or q is None else (d, -q)

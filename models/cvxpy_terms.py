"""Statics and mechanisms in CVXPY, eqs (1) to (6): the terms of every CVXPY model."""

from functools import cached_property

import cvxpy as cp
import numpy as np

from masonry_opt.problem.problem import Problem, ShearLimits


class CvxpyShearParameters:
    """Slope and cohesion of the shear limits of k joints, as CVXPY parameters of shape (k,)."""

    def __init__(self, limits: ShearLimits) -> None:
        self.slope, self.cohesion = (cp.Parameter(limits.slope.size, name=name) for name in ("slope", "c"))
        self.set(limits)

    def set(self, limits: ShearLimits) -> None:
        """Set the values of the slope and cohesion parameters."""
        self.slope.value, self.cohesion.value = limits.slope, limits.cohesion


class CvxpyStatics:
    """CVXPY variables for the load factor λ and the joint forces q, with the equilibrium constraint, eq. (1).

        B q + λ f_L + f_D = 0,    z = C(slope) q + c

    ``slacks`` contains the slack z of each yield condition, eq. (4), as an expression. Shear limits are
    parameters or numbers. λ is a variable unless ``load_factor`` is passed.
    """

    def __init__(
        self,
        problem: Problem,
        limits: CvxpyShearParameters | ShearLimits,
        load_factor: cp.Expression | None = None,
    ) -> None:
        self.q = cp.Variable(problem.B.shape[1], name="q")
        self.load_factor = cp.Variable(name="load_factor") if load_factor is None else load_factor
        self.equilibrium = problem.B @ self.q + self.load_factor * problem.live + problem.dead == 0
        self._problem, self._limits = problem, limits

    @cached_property
    def slacks(self) -> cp.Expression:
        """Return the slacks z of all yield conditions, shape (faces,).

        The slacks are declared on first use, because models with friction cones do not need them.
        """
        problem, limits = self._problem, self._limits
        limit = limits.cohesion + cp.multiply(limits.slope, problem.N @ self.q)
        slacks = problem.C(np.zeros(limit.size)) @ self.q + problem.limit_factors @ limit
        return slacks + problem.face_constant if problem.face_constant.any() else slacks

    @cached_property
    def within_yield(self) -> list[cp.Constraint]:
        """Return the constraint z ≥ 0 for all yield conditions."""
        return [self.slacks >= 0]

    def rates(self, d: np.ndarray, slope: np.ndarray) -> np.ndarray:
        """Return the rates of the yield conditions at the optimum: the dual values of these conditions."""
        return np.asarray(self.within_yield[0].dual_value)

    def forces(self) -> tuple[float, np.ndarray]:
        """Return λ and the forces q of c joints and t limited forces, shape (3c + t,), at the optimum."""
        return float(self.load_factor.value), np.asarray(self.q.value)


class CvxpyMechanism:
    """CVXPY variables for the block velocities d and the rates p ≥ 0 of the yield conditions.

    The constraints are compatibility, eqs (2), (5) and (6), and the normalised work of the live load.

        Bᵀ d = D(slope) p,    f_L·d = Σ|f_L|

    The slope is the opening per unit slip, as a parameter or as numbers.
    """

    def __init__(self, problem: Problem, slope: cp.Parameter | np.ndarray) -> None:
        self._problem = problem
        self.d = cp.Variable(problem.B.shape[0], name="d")
        self.p = cp.Variable(problem.faces, nonneg=True, name="p")
        #: Slip of each of the k joints that can slide, shape (k,): the sum of the joint's rates in all
        #: directions of slip.
        self.slip = problem.limit_factors.T @ self.p
        constant = problem.face_constant
        #: Power that limited forces (such as tie forces) dissipate at their limits, plus the power that
        #: crushing dissipates, summed over the chords of the crushing curve.
        self.resisted = constant @ self.p if constant.any() else cp.Constant(0.0)
        flow = problem.D(np.zeros(slope.size)) @ self.p + problem.N.T @ cp.multiply(slope, self.slip)
        # Keep 0 on the right-hand side. Python may swap the two sides of == if both are expressions, which
        # would change the sign of the dual value.
        self.compatibility = problem.B.T @ self.d - flow == 0
        #: All conditions on the mechanism except ``live_work``, which scales the velocities.
        self.rows: list[cp.Constraint] = [self.compatibility]
        self.live_work = problem.live @ self.d == problem.live_norm

    def power(self, cohesion: cp.Parameter | np.ndarray) -> cp.Expression:
        """Return f_D·d − c·p, the power of the dead load minus the dissipated power.

        ``cohesion`` has shape (k,).
        """
        return self._problem.dead @ self.d - cohesion @ self.slip - self.resisted

    def rates(self, slope: np.ndarray) -> np.ndarray:
        """Return the rates p of the yield conditions at the optimum."""
        return np.asarray(self.p.value)

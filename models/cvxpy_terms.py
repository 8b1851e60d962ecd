"""Statics and mechanisms in CVXPY: eqs (1) to (6), from which every formulation is made."""

from functools import cached_property

import cvxpy as cp
import numpy as np

from masonry_opt.problem.problem import Problem, ShearLimits


class ShearParameters:
    """Shear limits as parameters ``slope`` and ``cohesion``, shape (k,) each."""

    def __init__(self, limits: ShearLimits) -> None:
        self.slope, self.cohesion = (cp.Parameter(limits.slope.size, name=name) for name in ("slope", "c"))
        self.set(limits)

    def set(self, limits: ShearLimits) -> None:
        """Change the shear limits."""
        self.slope.value, self.cohesion.value = limits.slope, limits.cohesion


class Statics:
    """Joint forces q, equilibrium, eq. (1), and the slack z of every face, eq. (4).

        B q + λ f_L + f_D = 0,    z = C(slope) q + c

    Shear limits are parameters or numbers; λ is a variable unless given.
    """

    def __init__(
        self,
        problem: Problem,
        limits: ShearParameters | ShearLimits,
        load_factor: cp.Expression | None = None,
    ) -> None:
        self.q = cp.Variable(problem.B.shape[1], name="q")
        self.load_factor = cp.Variable(name="load_factor") if load_factor is None else load_factor
        self.equilibrium = problem.B @ self.q + self.load_factor * problem.live + problem.dead == 0
        self._problem, self._limits = problem, limits

    @cached_property
    def slacks(self) -> cp.Expression:
        """z, made where it is asked for: cones have no use for it."""
        problem, limits = self._problem, self._limits
        limit = limits.cohesion + cp.multiply(limits.slope, problem.N @ self.q)
        slacks = problem.C(np.zeros(limit.size)) @ self.q + problem.limit_factors @ limit
        return slacks + problem.face_constant if problem.face_constant.any() else slacks

    @cached_property
    def within_yield(self) -> list[cp.Constraint]:
        """z ≥ 0."""
        return [self.slacks >= 0]

    def rates(self, d: np.ndarray, slope: np.ndarray) -> np.ndarray:
        """Rates of the faces, which are the duals of these conditions."""
        return np.asarray(self.within_yield[0].dual_value)

    def forces(self) -> tuple[float, np.ndarray]:
        """λ and joint forces, shape (3c,), at the optimum."""
        return float(self.load_factor.value), np.asarray(self.q.value)


class Mechanism:
    """Block velocities d and rates p ≥ 0 of the faces, eqs (2), (5), (6).

        Bᵀ d = D(slope) p

    The slope, opening per unit slip, is a parameter or numbers.
    """

    def __init__(self, problem: Problem, slope: cp.Parameter | np.ndarray) -> None:
        self._problem = problem
        self.d = cp.Variable(problem.B.shape[0], name="d")
        self.p = cp.Variable(problem.faces, nonneg=True, name="p")
        self.slip = problem.limit_factors.T @ self.p  #: sliding of either sense, shape (k,)
        constant = problem.face_constant
        #: Energy that the chords of crushing and limits of forces dissipate.
        self.resisted = constant @ self.p if constant.any() else cp.Constant(0.0)
        flow = problem.D(np.zeros(slope.size)) @ self.p + problem.N.T @ cp.multiply(slope, self.slip)
        # With 0 to the right: Python may swap the sides of == between expressions, and the dual's sign.
        self.compatibility = problem.B.T @ self.d - flow == 0
        #: Its conditions, but that the live load does work.
        self.rows: list[cp.Constraint] = [self.compatibility]
        self.live_work = problem.live @ self.d == problem.live_norm

    def power(self, cohesion: cp.Parameter | np.ndarray) -> cp.Expression:
        """Power of the dead load less what the mechanism dissipates, f_D·d − c·p, for cohesion (k,)."""
        return self._problem.dead @ self.d - cohesion @ self.slip - self.resisted

    def rates(self, slope: np.ndarray) -> np.ndarray:
        """Rates of the faces at the optimum."""
        return np.asarray(self.p.value)

"""Terms that the CVXPY formulations share: shear limits as parameters, and compatibility."""

from __future__ import annotations

import cvxpy as cp
import numpy as np

from masonry_opt.problem.problem import Problem, ShearLimits
from masonry_opt.problem.state import expect_same_terms


class ShearLimited:
    """A model whose shear limits are parameters: a slope, and a cohesion where one is declared."""

    def __init__(self, problem: Problem, limits: ShearLimits) -> None:
        self.problem = problem
        k = len(problem.sliding)
        self.slope = cp.Parameter(k, name="slope")
        self.cohesion = None if limits.cohesion is None else cp.Parameter(k, name="cohesion")
        self.set_shear_limits(limits)

    def set_shear_limits(self, limits: ShearLimits) -> None:
        """Change the shear limits, and nothing else.

        Raises ValueError if cohesion terms were declared and are not given, or the reverse.
        """
        expect_same_terms(self.cohesion is not None, limits)
        self.slope.value = limits.slope
        if self.cohesion is not None:
            self.cohesion.value = limits.cohesion


class Statics:
    """Joint forces and load factor, equilibrium, eq. (1), and the slack of every yield condition, eq. (4).

    Attributes
    ----------
    slacks: of sliding (+, −) of the joints that can slide and of rocking (+, −) of all.
    """

    def __init__(self, problem: Problem) -> None:
        c, k = problem.joints, problem.sliding
        n, s, m = (cp.Variable(c, name=name) for name in "nsm")
        self.load_factor = cp.Variable(name="load_factor")
        internal = problem.B_n @ n + problem.B_s @ s + problem.B_m @ m
        self.equilibrium = internal + self.load_factor * problem.live + problem.dead == 0
        limit = problem.cohesion[k] + cp.multiply(problem.friction[k], n[k])
        rocking = cp.multiply(problem.half_length, n)
        self.slacks = [limit - s[k], limit + s[k], rocking - m, rocking + m]
        self._forces = [n, s, m]

    def read(self) -> tuple[float, np.ndarray]:
        """λ and joint forces n, s, m in turn, shape (3c,), at the optimum."""
        forces = np.stack([force.value for force in self._forces], axis=1).ravel()
        return float(self.load_factor.value), forces


class Mechanism:
    """Block velocities d and rates p ≥ 0 of sliding (+, −) and rocking (+, −)."""

    def __init__(self, problem: Problem) -> None:
        c, k = problem.K.shape
        self.problem = problem
        self.d = cp.Variable(3 * problem.blocks, name="d")
        self.slide = [cp.Variable(k, nonneg=True, name=f"slide{sign}") for sign in "+-"] if k else []
        self.rock = [cp.Variable(c, nonneg=True, name=f"rock{sign}") for sign in "+-"]

    def compatibility(self, slope: cp.Expression) -> list[cp.Constraint]:
        """Bᵀ d = D p: opening, slip and rotation of each joint, sliding opening by ``slope``."""
        problem = self.problem
        opening = cp.multiply(problem.half_length, self.rock[0] + self.rock[1])
        slip = cp.Constant(0.0)
        if self.slide:
            opening = opening + problem.K @ cp.multiply(slope, self.slide[0] + self.slide[1])
            slip = problem.K @ (self.slide[1] - self.slide[0])
        rotation = self.rock[1] - self.rock[0]
        # With 0 to the right: Python may swap the sides of == between expressions (when the right
        # one's class is derived from the left one's), and with them the sign of the dual.
        return [
            problem.B_n.T @ self.d - opening == 0,
            problem.B_s.T @ self.d - slip == 0,
            problem.B_m.T @ self.d - rotation == 0,
        ]

    def dissipation(self, cohesion: cp.Expression | None) -> cp.Expression:
        """c·p, the power of the cohesion."""
        if cohesion is None or not self.slide:
            return cp.Constant(0.0)
        return cohesion @ (self.slide[0] + self.slide[1])

"""Terms that the CVXPY formulations share: shear limits as parameters, and compatibility."""

from __future__ import annotations

import cvxpy as cp

from masonry_opt.models.interface import expect_same_terms
from masonry_opt.problem.problem import Problem, ShearLimits


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

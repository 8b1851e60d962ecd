"""Statics and mechanisms with friction cones, in CVXPY, for contact points in space."""

from functools import cached_property
from typing import NamedTuple

import cvxpy as cp
import numpy as np

from masonry_opt.models.cvxpy_terms import CvxpyMechanism, CvxpyStatics
from masonry_opt.problem.faces import selection
from masonry_opt.problem.problem import Problem, ShearLimits

#: The objective of ConeMotion is multiplied by this factor. Solvers stop at an absolute duality gap, which a
#: larger factor makes smaller relative to the objective.
_ENERGY_SCALE = 100.0


class Senses(NamedTuple):
    """Slip directions that define polygons, which replace the friction circles in linear programs.

    Each contact point that can slide has several directions; m is their total number.
    """

    #: For each direction of slip, the index of its contact point among the points that can slide. The shape
    #: is (m,) for m directions.
    point: np.ndarray
    #: Unit vector e of each direction of slip, as two components in the plane of the contact. The shape is
    #: (2, m) for m directions.
    along: np.ndarray
    #: Kind of the polygons.
    #:
    #: - True: each polygon is inscribed in its friction circle. Its corners are the shear forces opposite to
    #:   the directions e. Every force within the polygon is inside the friction cone.
    #: - False: each polygon is circumscribed about its friction circle. It touches the circle at the shear
    #:   forces opposite to the directions e. Every mechanism satisfies the flow rule of the friction cone.
    inside: bool


class ConeStatics(CvxpyStatics):
    """CVXPY variables for contact forces q; the constraints are equilibrium, eq. (1), and friction cones.

    At each contact point

        n ≥ 0,    |(s, t)| ≤ c + slope · n,

    and limited forces are within their limits, L q + l ≥ 0.
    """

    @cached_property
    def within_yield(self) -> list[cp.Constraint]:
        """Return the yield conditions of contact forces and of limited forces, such as tie forces."""
        problem = self._problem
        table = problem.table
        normal, *shears = (self.q[columns] for columns in problem.columns_of_sliding)
        limit = self._limits.cohesion + cp.multiply(self._limits.slope, normal)
        linear_conditions = table.R @ self.q + problem.face_constant[table.non_sliding] >= 0
        return [linear_conditions, cp.SOC(limit, cp.vstack(shears), axis=0)]

    def rates(self, d: np.ndarray, slope: np.ndarray) -> np.ndarray:
        """Return the rates p of the yield conditions, shape (faces,), for block velocities d.

        ``slope`` is the slope of the flow rule: the opening per unit slip, shape (k,).
        """
        return self._problem.rates(d, slope)


class ConeMechanism(CvxpyMechanism):
    """Mechanism with friction cones, in which sliding contacts open in proportion to their slip speed.

    The unknowns are velocities d, openings u ≥ 0, slips w, slip speeds γ and rates v ≥ 0 of limited forces.

        Bᵀ d = (u + slope γ, w) + Lᵀ v,    γ ≥ |w|,    f_L·d = Σ|f_L|

    The slope is the opening per unit slip, as a parameter or as numbers. If ``senses`` is passed, linear
    conditions replace γ ≥ |w|:

    - inscribed polygons: γ ≥ e·w for each direction e;
    - circumscribed polygons: w = Σ e p, γ = Σ p and p ≥ 0.
    """

    def __init__(
        self, problem: Problem, slope: cp.Parameter | np.ndarray, senses: Senses | None = None
    ) -> None:
        self._problem = problem
        table = problem.table
        limits = problem.face_constant[table.limits]
        self.d = cp.Variable(problem.B.shape[0], name="d")
        self.opening = cp.Variable(problem.joints, nonneg=True, name="u")  #: opening of each contact point
        self.yielding = cp.Variable(limits.size, nonneg=True, name="v")  #: rate of each limit of a force
        self.sliding = cp.Variable((2, slope.size), name="w")  #: slip of each contact point that can slide
        self.slip = cp.Variable(slope.size, name="gamma")  #: slip speed of each contact point that can slide
        normal, *shears = (selection(columns, table.width).T for columns in problem.columns_of_sliding)
        flow = selection(np.arange(problem.joints), table.width).T @ self.opening
        flow += normal @ cp.multiply(slope, self.slip) + table.L.T @ self.yielding
        flow += sum(shear @ self.sliding[axis] for axis, shear in enumerate(shears))
        #: Power that limited forces, such as tie forces, dissipate at their limits.
        self.resisted = limits @ self.yielding
        self.compatibility = problem.B.T @ self.d - flow == 0
        self.live_work = problem.live @ self.d == problem.live_norm
        if senses is None:
            at_speed = cp.SOC(self.slip, self.sliding, axis=0)
        elif senses.inside:
            along = cp.sum(cp.multiply(senses.along, self.sliding[:, senses.point]), axis=0)
            at_speed = self.slip[senses.point] - along >= 0
        else:
            p = cp.Variable(len(senses.point), nonneg=True)
            sum_of_point = selection(senses.point, slope.size).T
            combined = [sum_of_point @ p, *(sum_of_point @ cp.multiply(along, p) for along in senses.along)]
            at_speed = cp.vstack([self.slip, self.sliding]) - cp.vstack(combined) == 0
        self.rows = [self.compatibility, at_speed]

    def rates(self, slope: np.ndarray) -> np.ndarray:
        """Return the rates p of the yield conditions, shape (faces,), for the optimal velocities.

        ``slope`` is the opening per unit slip, shape (k,).
        """
        return self._problem.rates(self.d.value, slope)


class ConeForces:
    """Program that computes joint forces: it minimises λ plus a multiple of the complementarity error.

        min  λ Σ|f_L| + weight (γ·(c + μ n) + w·(s, t) + u·n + v·(L q + l))    within statics, γ = |w|

    The complementarity error is that of the forces and a given mechanism, whose rates γ, w, u and v are
    constants. The objective omits the constants γ·c and v·l. The cost of the forces is a parameter, so the
    program can be solved again for other rates or weights.
    """

    def __init__(self, problem: Problem) -> None:
        self._problem = problem
        statics = self.statics = ConeStatics(problem, ShearLimits.true(problem))
        self._cost = cp.Parameter(problem.B.shape[1], name="cost")
        objective = problem.live_norm * statics.load_factor + self._cost @ statics.q
        self.program = cp.Problem(cp.Minimize(objective), [statics.equilibrium, *statics.within_yield])

    def set(self, p: np.ndarray, weight: float) -> None:
        """Set the objective for given rates p, shape (faces,), and a weight of the complementarity error."""
        problem = self._problem
        senses = problem.layout.senses
        slips = -senses.T @ p[problem.table.slides].reshape(len(senses), -1)
        cost = problem.table.R.T @ p[problem.table.non_sliding]
        normal, *shears = problem.columns_of_sliding
        cost[normal] += problem.friction * np.hypot(*slips)
        for columns, slip in zip(shears, slips, strict=True):
            cost[columns] += slip
        self._cost.value = weight * cost


class ConeMotion:
    """Program for the mechanism that has the least complementarity error with given forces.

        min  γ·(c + μ n) + w·(s, t) + u·n + v·(L q + l)    within kinematics

    The slope is the opening per unit slip, shape (k,). The costs, which depend on the forces, are parameters,
    so the program can be solved again for other forces.
    """

    def __init__(self, problem: Problem, slope: np.ndarray) -> None:
        self._problem = problem
        mechanism = self.mechanism = ConeMechanism(problem, slope)
        moving = mechanism.slip, mechanism.sliding, mechanism.opening, mechanism.yielding
        self._costs = [cp.Parameter(part.shape) for part in moving]
        pairs = zip(self._costs, moving, strict=True)
        energy = sum(cp.sum(cp.multiply(cost, part)) for cost, part in pairs if part.size)
        self.program = cp.Problem(cp.Minimize(energy), [*mechanism.rows, mechanism.live_work])

    def set(self, q: np.ndarray) -> None:
        """Set the costs in the objective for given joint forces q, shape (3c + t,).

        Here c is the number of contact points, and t the number of limited forces, such as tie forces.
        """
        problem = self._problem
        normal, *shears = (q[columns] for columns in problem.columns_of_sliding)
        limit = np.maximum(problem.cohesion + problem.friction * normal, np.hypot(*shears))
        pressing = np.maximum(q[: problem.joints], 0.0)
        slacks = np.maximum(problem.slacks(q)[problem.table.limits], 0.0)
        for cost, value in zip(self._costs, (limit, np.stack(shears), pressing, slacks), strict=True):
            cost.value = _ENERGY_SCALE * value

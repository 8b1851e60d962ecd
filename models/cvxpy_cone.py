"""Statics and mechanisms of contact points in space by cones of friction, in CVXPY."""

from functools import cached_property
from typing import NamedTuple

import cvxpy as cp
import numpy as np

from masonry_opt.models.cvxpy_terms import Mechanism, Statics
from masonry_opt.problem.faces import selection
from masonry_opt.problem.problem import Problem, ShearLimits

_ENERGY_SCALE = 100.0  #: Factor on the energy that a mechanism leaves: solvers end at an absolute gap.


class Senses(NamedTuple):
    """Polygons in place of the circles of cones, for linear programs: senses of slip of sliding points."""

    point: np.ndarray  #: the points, shape (m,)
    along: np.ndarray  #: unit vectors in their planes, shape (2, m)
    #: Whether opposite to corners of polygons inside the circle of shears (forces are within the cones), or
    #: to where sides of polygons round it touch it (mechanisms follow the cones).
    inside: bool


class ConeStatics(Statics):
    """Contact forces q, equilibrium, eq. (1), and at each contact point

    n ≥ 0,    |(s, t)| ≤ c + slope · n,

    and limits of the limited forces, L q + l ≥ 0.
    """

    @cached_property
    def within_yield(self) -> list[cp.Constraint]:
        """These conditions."""
        problem, table = self._problem, self._problem.table
        normal, *shears = (self.q[of_kind] for of_kind in problem.columns_of_sliding)
        limit = self._limits.cohesion + cp.multiply(self._limits.slope, normal)
        others = table.R @ self.q + problem.face_constant[table.rest] >= 0
        return [others, cp.SOC(limit, cp.vstack(shears), axis=0)]

    def rates(self, d: np.ndarray, slope: np.ndarray) -> np.ndarray:
        """Rates of the faces, which go with block velocities."""
        return self._problem.rates(d, slope)


class ConeMechanism(Mechanism):
    """Block velocities d, openings u ≥ 0, slips w and their speeds γ, and rates v ≥ 0 of limited forces:

        Bᵀ d = (u + slope γ, w) + Lᵀ v,    γ ≥ |w|,    f_L·d = Σ|f_L|

    The slope, opening per unit slip, is a parameter or numbers. With senses, in place of γ ≥ |w|: γ ≥ e·w for
    each sense e (inside), or w = Σ e p, γ = Σ p with p ≥ 0 (round).
    """

    def __init__(
        self, problem: Problem, slope: cp.Parameter | np.ndarray, senses: Senses | None = None
    ) -> None:
        self._problem = problem
        table, limits = problem.table, problem.face_constant[problem.table.limits]
        self.d = cp.Variable(problem.B.shape[0], name="d")
        self.opening = cp.Variable(problem.joints, nonneg=True, name="u")  #: of each point
        self.yielding = cp.Variable(limits.size, nonneg=True, name="v")  #: of each limit of a force
        self.sliding = cp.Variable((2, slope.size), name="w")  #: of each point that can slide
        self.slip = cp.Variable(slope.size, name="gamma")
        normal, *shears = (selection(of_kind, table.width).T for of_kind in problem.columns_of_sliding)
        flow = selection(np.arange(problem.joints), table.width).T @ self.opening
        flow += normal @ cp.multiply(slope, self.slip) + table.L.T @ self.yielding
        flow += sum(shear @ self.sliding[axis] for axis, shear in enumerate(shears))
        self.resisted = limits @ self.yielding
        self.compatibility = problem.B.T @ self.d - flow == 0
        self.live_work = problem.live @ self.d == problem.live_norm
        if senses is None:
            at_speed = cp.SOC(self.slip, self.sliding, axis=0)
        elif senses.inside:
            along = cp.sum(cp.multiply(senses.along, self.sliding[:, senses.point]), axis=0)
            at_speed = self.slip[senses.point] - along >= 0
        else:
            p, of_point = cp.Variable(len(senses.point), nonneg=True), selection(senses.point, slope.size).T
            made = [of_point @ p, *(of_point @ cp.multiply(along, p) for along in senses.along)]
            at_speed = cp.vstack([self.slip, self.sliding]) - cp.vstack(made) == 0
        self.rows = [self.compatibility, at_speed]

    def rates(self, slope: np.ndarray) -> np.ndarray:
        """Rates of the faces, which go with the velocities at the optimum."""
        return self._problem.rates(self.d.value, slope)


class ConeForces:
    """Forces of a low λ that leave little energy for the rates of a mechanism:

        min  λ Σ|f_L| + weight (γ·(c + μ n) + w·(s, t) + u·n + v·(L q + l))    within statics, γ = |w|

    The objective omits the constants γ·c and v·l. Its cost of forces is a parameter: other rates and other
    weights need no new program.
    """

    def __init__(self, problem: Problem) -> None:
        self._problem = problem
        statics = self.statics = ConeStatics(problem, ShearLimits.true(problem))
        self._cost = cp.Parameter(problem.B.shape[1], name="cost")
        objective = problem.live_norm * statics.load_factor + self._cost @ statics.q
        self.program = cp.Problem(cp.Minimize(objective), [statics.equilibrium, *statics.within_yield])

    def set(self, p: np.ndarray, weight: float) -> None:
        """Set the rates of the mechanism, shape (faces,), and the weight of the energy."""
        problem = self._problem
        slips = -problem.layout.senses.T @ p[problem.table.slides].reshape(len(problem.layout.senses), -1)
        cost = problem.table.R.T @ p[problem.table.rest]
        normal, *shears = problem.columns_of_sliding
        cost[normal] += problem.friction * np.hypot(*slips)
        for of_kind, slip in zip(shears, slips, strict=True):
            cost[of_kind] += slip
        self._cost.value = weight * cost


class ConeMotion:
    """A mechanism that leaves least energy for given forces:

        min  γ·(c + μ n) + w·(s, t) + u·n + v·(L q + l)    within kinematics

    The slope, opening per unit slip, has shape (k,). The forces are parameters: other forces need no new
    program.
    """

    def __init__(self, problem: Problem, slope: np.ndarray) -> None:
        self._problem = problem
        mechanism = self.mechanism = ConeMechanism(problem, slope)
        moving = mechanism.slip, mechanism.sliding, mechanism.opening, mechanism.yielding
        self._costs = [cp.Parameter(part.shape) for part in moving]
        weighed = zip(self._costs, moving, strict=True)
        energy = sum(cp.sum(cp.multiply(cost, part)) for cost, part in weighed if part.size)
        self.program = cp.Problem(cp.Minimize(energy), [*mechanism.rows, mechanism.live_work])

    def set(self, q: np.ndarray) -> None:
        """Set the forces, shape (3c + t,)."""
        problem = self._problem
        normal, *shears = (q[of_kind] for of_kind in problem.columns_of_sliding)
        limit = np.maximum(problem.cohesion + problem.friction * normal, np.hypot(*shears))
        pressing = np.maximum(q[: problem.joints], 0.0)
        left = np.maximum(problem.slacks(q)[problem.table.limits], 0.0)
        for cost, value in zip(self._costs, (limit, np.stack(shears), pressing, left), strict=True):
            cost.value = _ENERGY_SCALE * value

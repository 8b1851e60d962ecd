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


def cone_forces(problem: Problem, p: np.ndarray, weight: float) -> tuple[ConeStatics, cp.Problem]:
    """Forces of a low λ that leave little energy for the rates p, shape (faces,), of a mechanism:

    min  λ Σ|f_L| + weight (γ·(c + μ n) + w·(s, t) + u·n + v·(L q + l))    within statics, γ = |w|

    (without the constants γ·c and v·l).
    """
    statics = ConeStatics(problem, ShearLimits.true(problem))
    slips = -problem.layout.senses.T @ p[problem.table.slides].reshape(len(problem.layout.senses), -1)
    cost = problem.table.R.T @ p[problem.table.rest]
    normal, *shears = problem.columns_of_sliding
    cost[normal] += problem.friction * np.hypot(*slips)
    for of_kind, slip in zip(shears, slips, strict=True):
        cost[of_kind] += slip
    objective = problem.live_norm * statics.load_factor + weight * cost @ statics.q
    return statics, cp.Problem(cp.Minimize(objective), [statics.equilibrium, *statics.within_yield])


def cone_motion(problem: Problem, q: np.ndarray, slope: np.ndarray) -> tuple[cp.Variable, cp.Problem]:
    """Block velocities d of a mechanism that leaves least energy for forces q, shape (3c,), with opening per
    unit slip (k,):

    min  γ·(c + μ n) + w·(s, t) + u·n + v·(L q + l)    within kinematics
    """
    mechanism = ConeMechanism(problem, slope)
    normal, *shears = (q[of_kind] for of_kind in problem.columns_of_sliding)
    limit = np.maximum(problem.cohesion + problem.friction * normal, np.hypot(*shears))
    energy = limit @ mechanism.slip + cp.sum(cp.multiply(np.stack(shears), mechanism.sliding))
    energy += np.maximum(q[: problem.joints], 0.0) @ mechanism.opening
    energy += np.maximum(problem.slacks(q)[problem.table.limits], 0.0) @ mechanism.yielding
    rows = [*mechanism.rows, mechanism.live_work]
    return mechanism.d, cp.Problem(cp.Minimize(_ENERGY_SCALE * energy), rows)

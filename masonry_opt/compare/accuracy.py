"""Certified bounds of the associative load factor, from the matrices and no solver's word.

Every state of equilibrium within yield bounds λ from below, every mechanism with normal flow from above
(the two theorems of limit analysis: weak duality of eqs (9) and (10)). A solver's answer is nearly both.
It is made exactly both: projected on the equations, then mixed with a point well inside the inequalities.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp
from scipy.optimize import linprog
from scipy.sparse.linalg import splu

from masonry_opt.models.interface import State
from masonry_opt.problem.certificate import finite
from masonry_opt.problem.problem import Problem
from masonry_opt.solvers.driver import declare
from masonry_opt.solvers.registry import find_solver
from masonry_opt.timing import Stopwatch

#: (upper − lower) / |λ| that is asked for.
CERTIFIED = 1e-9

#: Load factors below this are compared as they are: near zero a relative difference says nothing.
SMALLEST = 1e-2

#: The solvers whose answers are made exact: a vertex and an interior point. The best of both counts.
_SOURCES = (("pyomo", "highs", 1e-10), ("cvxpy", "clarabel", 1e-11))

#: Largest residual left in the equations (forces in median block weights, velocities near 1).
_RESIDUAL = 1e-12

#: How scipy's linprog says that a program has no point, and that its optimum is unlimited.
_INFEASIBLE, _UNBOUNDED = 2, 3

#: A margin below this is none.
_MARGIN = 1e-9


@dataclass(frozen=True)
class Bounds:
    """lower ≤ λ ≤ upper; infinite where nothing feasible was found.

    Both −∞: the dead load alone has no state of equilibrium. Both +∞: λ is unlimited.
    """

    lower: float
    upper: float

    @property
    def middle(self) -> float:
        """The middle of the bracket."""
        return (self.lower + self.upper) / 2

    @property
    def width(self) -> float:
        """Width of the bracket, relative (to ``SMALLEST`` at least)."""
        return (self.upper - self.lower) / max(abs(self.middle), SMALLEST) if self.finite else np.inf

    @property
    def finite(self) -> bool:
        """Whether there are both bounds."""
        return bool(np.isfinite(self.lower) and np.isfinite(self.upper))

    @property
    def unstable(self) -> bool:
        """Whether the scene does not stand."""
        return self.upper == -np.inf

    @property
    def unlimited(self) -> bool:
        """Whether every λ has a state of equilibrium."""
        return self.lower == np.inf


@dataclass(frozen=True)
class _Polyhedron:
    """A x = b, G x + g ≥ 0, and the load factor λ = cost · x that its points bound."""

    A: sp.csr_array
    b: np.ndarray
    G: sp.csr_array
    g: np.ndarray
    cost: np.ndarray

    def inside(self, x: np.ndarray, interior: np.ndarray | None) -> float:
        """Bound of a feasible point next to x; NaN if there is none."""
        x = self._projected(x)
        slack = self.G @ x + self.g
        if slack.min() < 0:
            if interior is None:
                return np.nan
            room = self.G @ interior + self.g
            out = slack < 0
            share = float((slack[out] / (slack[out] - room[out])).max())
            x = x + min(1.0, 1.001 * share) * (interior - x)
        feasible = (self.G @ x + self.g).min() >= 0 and np.abs(self.A @ x - self.b).max() <= _RESIDUAL
        return float(self.cost @ x) if feasible else np.nan

    def interior(self) -> np.ndarray | None:
        """The point with the largest slack everywhere (at most 1); None if no point has any."""
        rows, columns = self.G.shape
        found = linprog(
            c=np.append(np.zeros(columns), -1.0),
            A_ub=sp.hstack([-self.G, np.ones((rows, 1))], format="csr"),
            b_ub=self.g,
            A_eq=sp.hstack([self.A, sp.csr_array((self.A.shape[0], 1))], format="csr"),
            b_eq=self.b,
            bounds=[(None, None)] * columns + [(0, 1)],
            method="highs-ipm",
        )
        return self._projected(found.x[:-1]) if found.x is not None and found.x[-1] > _MARGIN else None

    def extreme(self, fixed: bool) -> int:
        """How HiGHS ends that maximises the last unknown, or with that ``fixed`` at 0 looks for any point:
        scipy's number."""
        columns = self.A.shape[1]
        return int(
            linprog(
                c=np.zeros(columns) if fixed else -self.cost,
                A_ub=-self.G,
                b_ub=self.g,
                A_eq=self.A,
                b_eq=self.b,
                bounds=[(None, None)] * (columns - 1) + [(0, 0) if fixed else (None, None)],
                method="highs",
            ).status
        )

    def _projected(self, x: np.ndarray) -> np.ndarray:
        """The nearest point with A x = b, by least squares, refined."""
        normal = self.A @ self.A.T
        # Joints without sliding may repeat each other's equations.
        factor = splu(sp.csc_matrix(normal + 1e-12 * sp.eye_array(self.A.shape[0])))
        for _ in range(6):
            x = x - self.A.T @ factor.solve(self.A @ x - self.b)
        return x


def certified_bounds(problem: Problem) -> Bounds:
    """Bounds of λ from feasible points of eq. (9) and of eq. (10).

    Feasible: equations to 1e-12 in units of a median block weight and of the mean velocity, inequalities
    to the last bit. A scene that admits no point inside its inequalities may be left without a bound.
    That a scene does not stand, or that λ is unlimited, is the word of HiGHS on eq. (9) as posed here.
    """
    statics, kinematics = _statics(problem), _kinematics(problem)
    if statics.extreme(fixed=True) == _INFEASIBLE:
        return Bounds(-np.inf, -np.inf)
    within, opening = statics.interior(), kinematics.interior()
    lower, upper = [-np.inf], [np.inf]
    for language, name, tolerance in _SOURCES:
        state = declare(problem, "static", find_solver(language, name, tolerance), Stopwatch()).solve().state
        if state is None:
            continue
        lower.append(statics.inside(np.append(state.q, state.load_factor), within))
        upper.append(kinematics.inside(_mechanism(problem, state), opening))
    bounds = Bounds(float(np.nanmax(lower)), float(np.nanmin(upper)))
    if not bounds.finite and statics.extreme(fixed=False) == _UNBOUNDED:
        return Bounds(np.inf, np.inf)
    return bounds


def _mechanism(problem: Problem, state: State) -> np.ndarray:
    k = problem.sliding
    return np.concatenate([state.d, state.p[0][k], state.p[1][k], state.p[2], state.p[3]])


def _statics(problem: Problem) -> _Polyhedron:
    """Eq. (9) over (q, λ): equilibrium; sliding and rocking slacks as forces."""
    c, k = problem.joints, problem.sliding
    n, s, m = (_pick(3 * np.arange(c) + part, 3 * c) for part in range(3))
    slide = sp.diags_array(problem.friction[k]) @ n[k]
    rock = sp.diags_array(1 / problem.half_length) @ m
    G = sp.vstack([slide - s[k], slide + s[k], n - rock, n + rock])
    cohesion = problem.cohesion[k]
    return _Polyhedron(
        A=sp.hstack([problem.B, problem.live[:, None]], format="csr"),
        b=-problem.dead,
        G=sp.hstack([G, sp.csr_array((G.shape[0], 1))], format="csr"),
        g=np.concatenate([cohesion, cohesion, np.zeros(2 * c)]),
        cost=np.append(np.zeros(3 * c), 1.0),
    )


def _kinematics(problem: Problem) -> _Polyhedron:
    """Eq. (10) over (d, p): Bᵀd = D p, f_L·d = Σ|f_L|, p ≥ 0."""
    b, c, k = 3 * problem.blocks, problem.joints, problem.sliding
    opening, slip, rotation = (_pick(3 * np.arange(c) + part, 3 * c).T for part in range(3))
    dilates = opening[:, k] @ sp.diags_array(finite(problem.friction)[k])
    lifts = opening @ sp.diags_array(problem.half_length)
    D = sp.hstack([dilates - slip[:, k], dilates + slip[:, k], lifts - rotation, lifts + rotation])
    rates = D.shape[1]
    cohesion = problem.cohesion[k]
    work = np.concatenate([-problem.dead, cohesion, cohesion, np.zeros(2 * c)])
    live = np.append(problem.live, np.zeros(rates))
    return _Polyhedron(
        A=sp.vstack([sp.hstack([problem.B.T, -D]), live[None, :]], format="csr"),
        b=np.append(np.zeros(3 * c), problem.live_norm),
        G=sp.hstack([sp.csr_array((rates, b)), sp.eye_array(rates)], format="csr"),
        g=np.zeros(rates),
        cost=work / problem.live_norm,
    )


def _pick(columns: np.ndarray, width: int) -> sp.csr_array:
    """Matrix that picks entries of a vector."""
    count = len(columns)
    return sp.csr_array((np.ones(count), (np.arange(count), columns)), shape=(count, width))

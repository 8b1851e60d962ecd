"""Certified bounds of the associative load factor, checked with the matrices alone.

By weak duality of eqs (9) and (10) every state of equilibrium within yield bounds λ from below, and every
mechanism with normal flow from above. A solver's answer satisfies these conditions nearly. To satisfy them
exactly it is projected on the equations, then mixed with a point well inside the inequalities. In space these
are cones of friction, and of speeds of slip.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
import scipy.sparse as sp
from scipy.optimize import linprog
from scipy.sparse.linalg import SuperLU, splu

from masonry_opt.answer.acceptance import FEASIBLE, SMALLEST
from masonry_opt.effort import Effort
from masonry_opt.problem.faces import selection
from masonry_opt.problem.problem import Problem, in_units_of_load
from masonry_opt.solvers.driver import Driver
from masonry_opt.solvers.registry import find_solver

CLOSE = 1e-9  #: (upper − lower) / |λ| that is close enough: until then the next solver is asked.
#: Solvers whose answers are made exact, in turn until the bounds are close; the last: of small plane scenes.
_SOURCES = (("cvxpy", "clarabel", 1e-11), ("cvxpy", "clarabel", 1e-10), ("pyomo", "highs", 1e-10))
_SMALL = 1000  #: Scenes with fewer joints are small. For larger ones HiGHS takes minutes.
_UNBOUNDED = 3  #: Status of scipy's linprog: optimum unlimited.
_MARGIN = 1e-9  #: Least slack of an interior point.

#: Limits, shape (k, x), and what they limit of two components each, (2, k, x): limit · x + c ≥ |two · x|. In
#: the plane there are none.
_Cones = tuple[sp.csr_array, np.ndarray, tuple[sp.csr_array, sp.csr_array]]


@dataclass(frozen=True)
class CertifiedBounds:
    """lower ≤ λ ≤ upper; infinite where nothing feasible was found. Both −∞: the dead load alone has no state
    of equilibrium. Both +∞: λ is unlimited."""

    lower: float = -np.inf
    upper: float = np.inf

    @property
    def middle(self) -> float:
        return (self.lower + self.upper) / 2

    @property
    def width(self) -> float:
        """Width of the bracket relative to its middle (to ``SMALLEST`` at least); infinite unless finite."""
        return (self.upper - self.lower) / max(abs(self.middle), SMALLEST) if self.finite else np.inf

    @property
    def finite(self) -> bool:
        return bool(np.isfinite(self.lower) and np.isfinite(self.upper))

    @property
    def unstable(self) -> bool:
        return self.upper == -np.inf

    @property
    def unlimited(self) -> bool:
        return self.lower == np.inf


@dataclass(frozen=True)
class _Convex:
    """A x = b, G x + g ≥ 0 and cones, and the load factor λ = cost · x that its points bound."""

    A: sp.csr_array
    b: np.ndarray
    G: sp.csr_array
    g: np.ndarray
    cost: np.ndarray
    cones: _Cones

    def slack(self, x: np.ndarray) -> np.ndarray:
        """Of each inequality and cone, concave in x: at a mean of two points no less than the mean."""
        limit, constant, two = self.cones
        of_cones = limit @ x + constant - np.hypot(*(each @ x for each in two))
        return np.append(self.G @ x + self.g, of_cones)

    def dual(self, norm: float) -> "_Convex":
        """Of eq. (9) eq. (10), over (d, p): Aᵀd = Gᵀp + (0, norm), p ≥ 0, whose points bound λ from above; of
        cones with p = (…, γ, w): γ ≥ |w|."""
        limit, constant, two = self.cones
        equations, signed, k = len(self.b), len(self.g), len(constant)
        A = sp.hstack([self.A.T, *(-rates.T for rates in (self.G, limit, *two))], format="csr")
        at = equations + signed + np.arange(k)
        speed, first, second = (selection(at + number * k, A.shape[1]) for number in range(3))
        G = selection(equations + np.arange(signed), A.shape[1])
        cost = np.concatenate([self.b, self.g, constant, np.zeros(2 * k)]) / norm
        return _Convex(A, norm * self.cost, G, np.zeros(signed), cost, (speed, np.zeros(k), (first, second)))

    def inside(self, x: np.ndarray, interior: np.ndarray | None) -> float:
        """Bound of a feasible point next to x; NaN if there is none."""
        x = self._projected(x)
        slack = self.slack(x)
        if slack.min() >= 0:
            return self._bound(x)
        if interior is None:
            return np.nan
        room = self.slack(interior)
        out = slack < 0
        share = float((slack[out] / (slack[out] - room[out])).max())
        # A little further inside, against rounding.
        return self._bound(x + min(1.0, 1.001 * share) * (interior - x))

    def _bound(self, x: np.ndarray) -> float:
        """λ of a point; NaN unless it is feasible."""
        feasible = self.slack(x).min() >= 0 and np.abs(self.A @ x - self.b).max() <= FEASIBLE
        return float(self.cost @ x) if feasible else np.nan

    def interior(self) -> np.ndarray | None:
        """The point with the largest slack everywhere (at most 1); None if no point has any."""
        import cvxpy as cp  # which takes seconds

        x, margin = cp.Variable(self.G.shape[1]), cp.Variable()
        room = [self.A @ x == self.b, self.G @ x + self.g >= margin, margin <= 1]
        limit, constant, two = self.cones
        if len(constant):
            room.append(cp.SOC(limit @ x + constant - margin, cp.vstack([each @ x for each in two]), axis=0))
        program = cp.Problem(cp.Maximize(margin), room)
        program.solve(solver=cp.CLARABEL)
        if x.value is None or margin.value <= _MARGIN:
            return None
        return self._projected(np.asarray(x.value))

    def unlimited(self) -> bool:
        """Whether scipy's linprog finds λ, which it maximises, unbounded."""
        found = linprog(-self.cost, -self.G, self.g, self.A, self.b, (None, None), method="highs")
        return bool(found.status == _UNBOUNDED)

    def _projected(self, x: np.ndarray) -> np.ndarray:
        """The nearest point with A x = b, by least squares, refined."""
        for _ in range(6):
            x = x - self.A.T @ self._normal.solve(self.A @ x - self.b)
        return x

    @cached_property
    def _normal(self) -> SuperLU:
        """A Aᵀ, factorised. Joints without sliding may repeat each other's equations."""
        normal = self.A @ self.A.T + 1e-12 * sp.eye_array(self.A.shape[0])
        return splu(sp.csc_matrix(normal), permc_spec="MMD_AT_PLUS_A", options={"SymmetricMode": True})


def certified_bounds(problem: Problem) -> CertifiedBounds:
    """Bounds of λ from feasible points of eqs (9) and (10), in space of cones of friction: equations to 1e-11
    in units of the load and of the mean velocity, inequalities exactly. Where no point lies inside the
    inequalities there may be no bound. The analysis' own check decides whether a scene stands, HiGHS whether
    λ of a small one is limited: in space by the sides inside the cones, so that one which is not, by these,
    is by no law."""
    from masonry_opt.standing.diagnosis import falling_mechanism  # with modelling languages, as above

    scaled = in_units_of_load(problem)
    problem = scaled.problem.by_cone
    conic = problem.by_friction.conic
    small = problem.joints < _SMALL
    if falling_mechanism(problem, find_solver("cvxpy", None), Effort()) is not None:
        return CertifiedBounds(-np.inf, -np.inf)
    statics = _statics(problem, conic)
    kinematics = statics.dual(problem.live_norm)
    within, opening = statics.interior(), kinematics.interior()
    bounds = CertifiedBounds()
    for source in _SOURCES if small and not conic else _SOURCES[:-1]:
        driver = Driver(problem, "static", find_solver(*source), Effort(), of_load=True)
        state = driver.solve(nearly=conic).state
        if state is None:
            continue
        p = _speeds(problem, state.d) if conic else state.p
        lower = scaled.load_factor * statics.inside(np.append(state.q, state.load_factor), within)
        upper = scaled.load_factor * kinematics.inside(np.concatenate([state.d, p]), opening)
        bounds = CertifiedBounds(float(np.fmax(bounds.lower, lower)), float(np.fmin(bounds.upper, upper)))
        if bounds.width <= CLOSE:
            break
    if small and not bounds.finite and _statics(problem, conic=False).unlimited():
        return CertifiedBounds(np.inf, np.inf)
    return bounds


def _statics(problem: Problem, conic: bool) -> _Convex:
    """Eq. (9) over (q, λ): equilibrium; the slacks of the faces as forces, or in space by cones n ≥ 0,
    |(s, t)| ≤ c + μ n, and limits of forces."""
    A = sp.hstack([problem.B, problem.live[:, None]], format="csr")
    width = A.shape[1]
    cost = np.append(np.zeros(width - 1), 1.0)
    if not conic:
        G = sp.hstack([problem.true_yield, sp.csr_array((problem.faces, 1))], format="csr")
        none = sp.csr_array((0, width))
        return _Convex(A, -problem.dead, G, problem.face_cohesion, cost, (none, np.zeros(0), (none, none)))
    normal, first, second = (selection(of_kind, width) for of_kind in problem.columns_of_sliding)
    limit = (sp.diags_array(problem.friction) @ normal).tocsr()
    every, limits = selection(np.arange(problem.joints), width), problem.table.L
    beside = sp.hstack([limits, sp.csr_array((limits.shape[0], 1))])
    g = np.append(np.zeros(problem.joints), problem.face_constant[problem.table.limits])
    G = sp.vstack([every, beside], format="csr")
    return _Convex(A, -problem.dead, G, g, cost, (limit, problem.cohesion, (first, second)))


def _speeds(problem: Problem, d: np.ndarray) -> np.ndarray:
    """Rates of the kinematics by cones at velocities d (3b,): of opening, at limits of forces, and γ and w of
    slip."""
    opening, *slips = problem.by_kind(problem.motion(d))
    slips = [slip[problem.sliding] for slip in slips]
    speed = np.hypot(*slips)
    opening[problem.sliding] -= problem.friction * speed
    limits = problem.rates(d, problem.friction)[problem.table.limits]
    return np.concatenate([np.maximum(opening, 0.0), limits, speed, *slips])

"""Certified bounds on the associative load factor, checked with the matrices of the problem alone.

By weak duality of eqs (9) and (10), every admissible state of equilibrium implies a lower bound on λ, and
every mechanism with normal flow an upper bound. The answer of a solver satisfies the equations and
inequalities only nearly. To satisfy them exactly, the answer is projected onto the solutions of the
equations, and then moved towards a point that satisfies all inequalities strictly. In space the inequalities
are cones: of friction forces, and of slip velocities.
"""

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
import scipy.sparse as sp
from scipy.optimize import linprog
from scipy.sparse.linalg import SuperLU, splu

from masonry_opt.effort import Effort
from masonry_opt.problem.faces import selection
from masonry_opt.problem.load_factor_scale import LoadFactorScale
from masonry_opt.problem.problem import Problem, in_units_of_load
from masonry_opt.solution.acceptance import FEASIBILITY_TOLERANCE
from masonry_opt.solvers.driver import Driver
from masonry_opt.solvers.registry import find_solver

#: Bounds count as sufficiently accurate if their relative width (upper − lower) / |λ| is at most this value.
#: If the width is larger, the static program is solved again by the next solver.
LARGEST_BOUND_WIDTH = 1e-9
#: Model, solver and tolerance with which the static program is solved for certified bounds. The next entry is
#: used if the bounds from all entries before it are wider than ``LARGEST_BOUND_WIDTH``.
_SOURCES = (("cvxpy", "clarabel", 1e-11), ("cvxpy", "clarabel", 1e-10), ("pyomo", "highs", 1e-10))
#: Smallest number of joints for which HiGHS is not used to compute certified bounds, because HiGHS would take
#: minutes.
_LARGE_SCENE_JOINTS = 1000
_UNBOUNDED = 3  #: Status of scipy's linprog for an unbounded program.
#: Slack above which an inequality counts as satisfied with a margin: a point is interior if all its slacks
#: are larger.
_LEAST_SLACK = 1e-9
#: Number of times that a point is projected onto the solutions of A x = b. Each repetition reduces the errors
#: of the projection.
_PROJECTIONS = 6
#: The step towards the interior point is multiplied by this factor. Otherwise the point could violate
#: inequalities by rounding errors.
_STEP_EXCESS = 1.001
#: Value that is added to the diagonal of A Aᵀ. Without it, A Aᵀ is singular if two rows of A are equal, as
#: for joints that cannot slide.
_REGULARISATION = 1e-12

#: Type of friction cones limit · x + c ≥ |(first · x, second · x)|: the tuple (limit, c, (first, second)), in
#: which each cone has a row of the matrices and an entry of c. In the plane, all four arrays are empty.
_Cones = tuple[sp.csr_array, np.ndarray, tuple[sp.csr_array, sp.csr_array]]


@dataclass(frozen=True)
class CertifiedBounds:
    """Certified bounds on the associative load factor λ: lower ≤ λ ≤ upper.

    A bound is infinite if no feasible point was found. Both bounds are −∞ if no admissible joint forces are
    in equilibrium with the dead load alone. Both bounds are +∞ if λ is unlimited.
    """

    lower: float = -np.inf
    upper: float = np.inf
    unit: float = 1.0  #: unit of load factors, see :class:`LoadFactorScale`

    @property
    def middle(self) -> float:
        """Mean of both bounds."""
        return (self.lower + self.upper) / 2

    @property
    def width(self) -> float:
        """Width upper − lower of the bounds, relative to the load factor; infinite if a bound is infinite."""
        if not self.finite:
            return np.inf
        return (self.upper - self.lower) / LoadFactorScale(self.unit).divisor(self.middle)

    @property
    def finite(self) -> bool:
        """True if both bounds are finite."""
        return bool(np.isfinite(self.lower) and np.isfinite(self.upper))

    @property
    def unstable(self) -> bool:
        """True if no admissible joint forces are in equilibrium with the dead load."""
        return self.upper == -np.inf

    @property
    def unlimited(self) -> bool:
        """True if the load factor is proven to be unlimited."""
        return self.lower == np.inf


@dataclass(frozen=True)
class _Convex:
    """Convex program with equations A x = b, inequalities G x + g ≥ 0, and cones.

    For each feasible point x, the number cost · x is a bound on λ: a lower bound in the static program, and
    an upper bound in its dual program.
    """

    A: sp.csr_array
    b: np.ndarray
    G: sp.csr_array
    g: np.ndarray
    cost: np.ndarray
    cones: _Cones

    def slack(self, x: np.ndarray) -> np.ndarray:
        """Return the slacks of all inequalities and cones at the point x; each is a concave function of x."""
        limit, constant, two = self.cones
        of_cones = limit @ x + constant - np.hypot(*(component @ x for component in two))
        return np.append(self.G @ x + self.g, of_cones)

    def dual(self, norm: float) -> "_Convex":
        """Return the dual program, eq. (10), whose feasible points bound λ from above.

        Its variables are (d, p) with Aᵀd = Gᵀp + (0, norm) and p ≥ 0. Cones add variables (γ, w) to p, with
        γ ≥ |w|. ``norm`` is the size of the live load.
        """
        limit, constant, two = self.cones
        equations, signed, k = len(self.b), len(self.g), len(constant)
        A = sp.hstack([self.A.T, *(-rates.T for rates in (self.G, limit, *two))], format="csr")
        first_of_cones = equations + signed + np.arange(k)
        speed, first, second = (selection(first_of_cones + i * k, A.shape[1]) for i in range(3))
        G = selection(equations + np.arange(signed), A.shape[1])
        cost = np.concatenate([self.b, self.g, constant, np.zeros(2 * k)]) / norm
        return _Convex(A, norm * self.cost, G, np.zeros(signed), cost, (speed, np.zeros(k), (first, second)))

    def inside(self, x: np.ndarray, interior: np.ndarray | None) -> float:
        """Move the point x into the feasible set, and return the bound on λ that the moved point proves.

        The moved point is the projection of x on the equations, moved towards an interior point as far as the
        inequalities require. The result is NaN if no feasible point is found.
        """
        x = self._projected(x)
        slack = self.slack(x)
        if slack.min() >= 0:
            return self._bound(x)
        if interior is None:
            return np.nan
        interior_slack = self.slack(interior)
        violated = slack < 0
        share = float((slack[violated] / (slack[violated] - interior_slack[violated])).max())
        return self._bound(x + min(1.0, _STEP_EXCESS * share) * (interior - x))

    def _bound(self, x: np.ndarray) -> float:
        """Return cost · x, which is a bound on λ, if the point x is feasible; otherwise NaN."""
        feasible = self.slack(x).min() >= 0 and np.abs(self.A @ x - self.b).max() <= FEASIBILITY_TOLERANCE
        return float(self.cost @ x) if feasible else np.nan

    def interior(self) -> np.ndarray | None:
        """Return an interior point: a point whose smallest slack is as large as possible, but at most 1.

        The result is None if no interior point is found.
        """
        import cvxpy as cp  # imported here, because the import takes seconds

        x, margin = cp.Variable(self.G.shape[1]), cp.Variable()
        constraints = [self.A @ x == self.b, self.G @ x + self.g >= margin, margin <= 1]
        limit, constant, two = self.cones
        if len(constant):
            components = cp.vstack([component @ x for component in two])
            constraints.append(cp.SOC(limit @ x + constant - margin, components, axis=0))
        program = cp.Problem(cp.Maximize(margin), constraints)
        program.solve(solver=cp.CLARABEL)
        if x.value is None or margin.value <= _LEAST_SLACK:
            return None
        return self._projected(np.asarray(x.value))

    def unlimited(self) -> bool:
        """Return True if scipy's linprog reports that the maximum of cost · x is unbounded."""
        result = linprog(-self.cost, -self.G, self.g, self.A, self.b, (None, None), method="highs")
        return bool(result.status == _UNBOUNDED)

    def _projected(self, x: np.ndarray) -> np.ndarray:
        """Return the point with A x = b that is closest to x, by least squares with iterative refinement."""
        for _ in range(_PROJECTIONS):
            x = x - self.A.T @ self._normal.solve(self.A @ x - self.b)
        return x

    @cached_property
    def _normal(self) -> SuperLU:
        """Sparse factorisation of the normal equations, whose matrix is the regularised A Aᵀ."""
        normal = self.A @ self.A.T + _REGULARISATION * sp.eye_array(self.A.shape[0])
        return splu(sp.csc_matrix(normal), permc_spec="MMD_AT_PLUS_A", options={"SymmetricMode": True})


def certified_bounds(problem: Problem) -> CertifiedBounds:
    """Return bounds on the associative λ from feasible points of eqs (9) and (10).

    The points satisfy the equations to 1e-11 in units of the load and of the mean velocity, and the
    inequalities exactly. There may be no bound if the inequalities have no interior point.

    The package's own check of the dead load decides whether a scene is unstable. HiGHS decides whether λ of a
    small scene is unlimited. In space it uses polygons inside the friction cones: if λ is unlimited with
    polygons, it is unlimited with cones too.
    """
    from masonry_opt.stability.diagnosis import (
        falling_mechanism,  # imported here, because importing modelling languages takes seconds
    )

    unit, scaled = problem.load_factor_scale.unit, in_units_of_load(problem)
    problem = scaled.problem.by_cone
    conic = problem.by_friction.conic
    small = problem.joints < _LARGE_SCENE_JOINTS
    if falling_mechanism(problem, find_solver("cvxpy", None), Effort()) is not None:
        return CertifiedBounds(-np.inf, -np.inf)
    statics = _statics(problem, conic)
    kinematics = statics.dual(problem.live_norm)
    static_interior, kinematic_interior = statics.interior(), kinematics.interior()
    bounds = CertifiedBounds(unit=unit)
    # HiGHS, the last entry of _SOURCES, is used only for small linear programs.
    for source in _SOURCES if small and not conic else _SOURCES[:-1]:
        driver = Driver(problem, "static", find_solver(*source), Effort(), of_load=True)
        state = driver.solve(nearly=conic).state
        if state is None:
            continue
        p = _speeds(problem, state.d) if conic else state.p
        static_point, kinematic_point = np.append(state.q, state.load_factor), np.concatenate([state.d, p])
        lower = scaled.load_factor * statics.inside(static_point, static_interior)
        upper = scaled.load_factor * kinematics.inside(kinematic_point, kinematic_interior)
        lower, upper = float(np.fmax(bounds.lower, lower)), float(np.fmin(bounds.upper, upper))
        bounds = replace(bounds, lower=lower, upper=upper)
        if bounds.width <= LARGEST_BOUND_WIDTH:
            break
    if small and not bounds.finite and _statics(problem, conic=False).unlimited():
        return CertifiedBounds(np.inf, np.inf)
    return bounds


def _statics(problem: Problem, conic: bool) -> _Convex:
    """Return the static program of eq. (9) in the variables (q, λ): equilibrium and yield conditions.

    In space the yield conditions are n ≥ 0, the cones |(s, t)| ≤ c + μ n, and limits on forces.
    """
    A = sp.hstack([problem.B, problem.live[:, None]], format="csr")
    width = A.shape[1]
    cost = np.append(np.zeros(width - 1), 1.0)
    if not conic:
        G = sp.hstack([problem.true_yield, sp.csr_array((problem.faces, 1))], format="csr")
        none = sp.csr_array((0, width))
        return _Convex(A, -problem.dead, G, problem.face_cohesion, cost, (none, np.zeros(0), (none, none)))
    normal, first, second = (selection(columns, width) for columns in problem.columns_of_sliding)
    limit = (sp.diags_array(problem.friction) @ normal).tocsr()
    all_normals, limits = selection(np.arange(problem.joints), width), problem.table.L
    limits_of_q = sp.hstack([limits, sp.csr_array((limits.shape[0], 1))])
    g = np.append(np.zeros(problem.joints), problem.face_constant[problem.table.limits])
    G = sp.vstack([all_normals, limits_of_q], format="csr")
    return _Convex(A, -problem.dead, G, g, cost, (limit, problem.cohesion, (first, second)))


def _speeds(problem: Problem, d: np.ndarray) -> np.ndarray:
    """Convert block velocities d to joint rates p, the variables of the dual program with cones.

    ``d`` has the shape (3b,). The array contains the rates of opening, the rates of forces at their limits,
    and γ and w of slip.
    """
    opening, *slips = problem.by_kind(problem.motion(d))
    slips = [slip[problem.sliding] for slip in slips]
    speed = np.hypot(*slips)
    opening[problem.sliding] -= problem.friction * speed
    limits = problem.rates(d, problem.friction)[problem.table.limits]
    return np.concatenate([np.maximum(opening, 0.0), limits, speed, *slips])

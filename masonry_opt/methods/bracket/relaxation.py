"""Compute lower bounds on λ from products of statics and kinematics.

A sequence of programs raises the bound. Each program has more products than the last one, and products of
forces and rates that are close to each other are added first. The largest forces and rates of all states with
λ in an interval are computed too, because they limit the products.
"""

import time
from collections.abc import Iterator
from dataclasses import dataclass, replace
from math import inf
from typing import Any

import numpy as np
import scipy.sparse as sp

from masonry_opt.effort import Effort
from masonry_opt.methods.bounds.products import (
    ProductChain,
    a_little_above,
    closes_much,
    number_of_products,
    selections,
)
from masonry_opt.methods.bounds.settings import SETTINGS
from masonry_opt.models.cvxpy_exact import CvxpyForces, CvxpyMotion
from masonry_opt.models.pyomo_products import Pairs, PyomoProducts
from masonry_opt.problem.edges import EdgeFactors
from masonry_opt.problem.faces import selection
from masonry_opt.problem.problem import Problem, ShearLimits
from masonry_opt.solution.acceptance import BEYOND_LIMITS, PROVEN_GAP
from masonry_opt.solvers.highs import HighsSession, LinearProgram
from masonry_opt.solvers.registry import LpSize, Verdict, find_solver

#: If statics does not limit a joint force, method "global" assumes this limit, relative to the sum of all
#: loads. A smaller value may exclude states with large forces.
_TIMES_LOADS = 10.0

#: Largest rate or velocity of the mechanisms that an infeasibility proof must exclude, relative to the mean
#: velocity of the points at which the live load acts. Faster mechanisms are not considered.
_LARGEST_MOTION = 1e9

#: Tolerance of the interior-point methods that solve the programs of method "global".
_TOLERANCE = 1e-7

#: Number of rows up to which the older interior-point method of HiGHS is tried before HiPO. The older method
#: is two to three times as fast on small programs, but mostly ends without multipliers on larger programs.
_FEW_ROWS = 20_000

#: Tolerance of HiPO, an interior-point solver of HiGHS, as a fraction of the relative gap between the bounds
#: on λ. With a smaller tolerance, twice as many iterations would improve the bound by only 1 %.
_TOLERANCE_OVER_GAP = 0.05

#: Assumed limit on each rate and velocity, relative to the mean velocity of the points at which the live load
#: acts. It provides bounds for variables that otherwise have none, because solvers may stall or fail without
#: bounds. The proof of the lower bound does not use this number.
_LARGEST_RATE = 20.0

#: Motions below this value, relative to the mean velocity of the points at which the live load acts, count as
#: zero when forces are computed from products of forces and motions.
_NEGLIGIBLE_MOTION = 1e-3

#: Largest number of iterations of a solver for one program of method "global". After this number the next
#: solver is tried. If no solver finds an optimum, the bound follows from the last multipliers.
_MOST_PROGRAM_ITERATIONS = 500

#: Smallest time limit of one program of method "global", in seconds.
LEAST_TIME = 1.0

#: Largest number of products of a force and a motion in one program of method "global". Programs with more
#: products are skipped, because they would need too much memory.
_MOST_PRODUCTS = 400_000

#: If kinematics does not limit the sum of all slips and edge openings, method "global" assumes a limit. The
#: limit is at least this multiple of the mean velocity of the points at which the live load acts. A smaller
#: multiple may exclude states with large rates.
_LEAST_RATES = 100.0

#: If kinematics does not limit the sum of all slips and edge openings, method "global" assumes that the sum
#: is at most this multiple of its value in the lowest known state. The assumed limit is never below the limit
#: that ``_LEAST_RATES`` defines. A smaller multiple may exclude states with large rates.
_OVER_KNOWN = 10.0


@dataclass(frozen=True)
class StateBounds:
    """Upper bounds on the forces and the rates of all collapse states whose λ is in a given interval."""

    lowest: float  #: lower end of the interval of λ
    normal: np.ndarray  #: upper bound on the normal force of each joint, shape (c,)
    #: Upper bounds on the edge forces x₂ and x₃ and on the sliding slack z₀ of each joint, shape (3c,). The
    #: class :class:`.EdgeFactors` defines these symbols. In joints that cannot slide, the bound on the shear
    #: s replaces the bound on z₀.
    forces: np.ndarray
    rates: float  #: upper bound on the sum of all slips and edge openings
    #: True if statics implies the limits on the forces. If False, some limits are assumed, and bounds on λ
    #: are valid only for states within these limits.
    forces_derived: bool
    #: True if kinematics implies the limit on the sum of all slips and edge openings. If False, the limit is
    #: assumed.
    rates_derived: bool

    def allow(self, problem: Problem, q: np.ndarray, d: np.ndarray) -> bool:
        """Return True if forces q, shape (3c,), and velocities d, shape (3b,), are within all assumed bounds.

        The forces are not tested if all force limits follow from statics, and the rates are not tested if
        their limit follows from kinematics, because every state satisfies these limits.
        """
        first, second, shear = np.abs(q.reshape(3, -1))
        forces, limits = np.stack([first + second, shear]), np.stack([self.normal, self.forces[2::3]])
        is_within = self.forces_derived or bool((forces <= limits + BEYOND_LIMITS * (1 + limits)).all())
        return is_within and (self.rates_derived or sum_of_rates(problem, d) < self.rates)


def bounds_of(problem: Problem, highest: float, assumed_rates: float, effort: Effort) -> StateBounds:
    """Return upper bounds on the forces and rates of all states with 0 ≤ λ ≤ ``highest``.

    The forces are the largest that statics allow. The rates are the largest that kinematics allow for each
    face, if raising the blocks takes at most the work of the live load. When the rate of sliding in one sense
    is maximised, the rate in the other sense is zero.

    With this restriction no state is excluded if dilatancy is not negative: a joint at yield in both senses
    carries no force, and may open instead. A joint without friction and cohesion must not dilate.

    ``assumed_rates`` is the sum of rates that is used if kinematics imposes no limit.
    """
    normal, forces, derived = _force_limits(problem, (0.0, highest), effort)
    rates = _most_rates(problem, highest, effort)
    slips_either_way = (problem.dilatancy > 0) & (problem.friction == 0) & (problem.cohesion == 0)
    rates_derived = bool(np.isfinite(rates) and (problem.dilatancy >= 0).all() and not slips_either_way.any())
    rates = rates if rates_derived else assumed_rates
    return StateBounds(0.0, normal, forces, rates, derived, rates_derived)


def tightened(
    of: StateBounds, problem: Problem, lowest: float, highest: float, effort: Effort
) -> StateBounds:
    """Return bounds with tighter force limits, which are valid for states with ``lowest`` ≤ λ ≤ ``highest``.

    The argument ``of`` contains the bounds for a wider interval of λ. The force limits are smaller for a
    narrower interval, because less self-stress is possible at a higher λ. The limit on the sum of the rates
    stays the same.
    """
    normal, forces, derived = _force_limits(problem, (lowest, highest), effort)
    if not derived:
        # Keep the earlier force limits, because some of the new limits are only assumed.
        return replace(of, lowest=lowest)
    normal, forces = np.minimum(normal, of.normal), np.minimum(forces, of.forces)
    return replace(of, lowest=lowest, normal=normal, forces=forces)


def _force_limits(
    problem: Problem, within: tuple[float, float], effort: Effort
) -> tuple[np.ndarray, np.ndarray, bool]:
    """Return upper bounds on the joint forces, and True if statics proves all of them.

    The first array has the largest normal forces, shape (c,), the second the largest edge forces, shape
    (3c,). The flag is False if a limit is assumed. Linear programs maximise the forces that limit all others:
    n of every joint, and s of each joint that cannot slide.
    """
    forces = CvxpyForces(problem, within=within)
    session, q = HighsSession(forces.program, effort, "bounds"), forces.statics.q
    c, highest = problem.joints, within[1]
    cannot_slide = np.setdiff1d(np.arange(c), problem.sliding)
    of_shears = selection(2 * c + cannot_slide, problem.table.width)
    targets = sp.vstack([problem.table.normal_sums, of_shears]).toarray()
    steep = max(1.0, float(problem.friction.max(initial=0.0)))
    # Let S be the sum of all n of a state, plus the sum of |s| over the joints that cannot slide. No joint
    # force of this state exceeds ``share`` · (1 + S).
    share = steep + float(problem.cohesion.max(initial=0.0))
    values, short = np.zeros((2, len(targets)))
    columns = session.columns(q)
    for number, target in enumerate(targets):
        for sign in (1.0, -1.0) if number >= c else (1.0,):
            session.set_costs(q, -sign * target)
            if session.solve() is not Verdict.OPTIMAL:
                values[number] = np.inf
                break
            least, shortfall = session.least()
            of_other_columns = float(np.delete(shortfall, columns).sum()) * max(highest, 1.0)
            values[number] = max(values[number], -least + of_other_columns)
            short[number] = max(short[number], float(shortfall[columns].sum()) * share)
    assumed = _TIMES_LOADS * float(np.abs(problem.dead).sum() + highest * problem.live_norm)
    solved = np.isfinite(values)
    bounds = _with_shortfall(np.where(solved, values, assumed), np.where(solved, short, 0.0))
    proven = np.isfinite(bounds)
    bounds = np.where(proven, bounds, assumed)
    normal, shear = bounds[:c], np.zeros(c)
    shear[problem.sliding] = 2 * ShearLimits.true(problem).at(normal[problem.sliding])
    shear[cannot_slide] = bounds[c:]
    return normal, np.stack([normal, normal, shear], axis=1).ravel(), bool((solved & proven).all())


def _with_shortfall(values: np.ndarray, short: np.ndarray) -> np.ndarray:
    """Return upper bounds on numbers xⱼ ≥ 0 that satisfy xⱼ ≤ valuesⱼ + shortⱼ (1 + Σ x) for all j.

    If the sum of ``short`` is too large to bound Σ x, the bound is infinite for each j with shortⱼ > 0.
    """
    if short.sum() >= 0.5:
        return np.where(short == 0.0, values, np.inf)
    total = float((values.sum() + short.sum()) / (1 - short.sum()))
    return np.asarray(values + short * (1 + total))


def _most_rates(problem: Problem, highest: float, effort: Effort) -> float:
    """Return an upper bound on the sum of slips and edge openings in collapse states with λ ≤ ``highest``.

    In the mechanisms of these states, raising the blocks takes at most ``highest`` times the work of the live
    load. A linear program computes the largest rate of each face, which is zero if the face cannot move. The
    result is infinite if a program is undecided or unbounded, or if the multipliers are too inaccurate.
    """
    motion = CvxpyMotion(problem, raising=highest * problem.live_norm)
    session, mechanism = HighsSession(motion.program, effort, "bounds"), motion.mechanism
    slides, faces = problem.table.slides.stop, problem.faces
    of_rates, of_velocities = session.columns(mechanism.p), session.columns(mechanism.d)
    values, short, of_motion = np.zeros(faces), np.zeros(faces), np.zeros((faces, len(of_velocities)))
    for face in range(faces):
        most = np.full(faces, np.inf)
        if face < slides:
            most[(face + slides // 2) % slides] = 0.0
        session.set_most(mechanism.p, most)
        session.set_costs(mechanism.p, -np.eye(1, faces, face)[0])
        verdict = session.solve()
        if verdict is Verdict.INFEASIBLE:
            value, shortfall = session.contradiction()
            if value > _LARGEST_MOTION * shortfall.sum():
                continue  # no mechanism has a nonzero rate at this yield condition
        if verdict is not Verdict.OPTIMAL:
            return inf
        least, shortfall = session.least()
        values[face] = max(-least, 0.0)
        short[face], of_motion[face] = shortfall[of_rates].max(), shortfall[of_velocities]
    short += of_motion @ np.abs(velocities_by_rates(problem)).max(axis=1)
    return float(EdgeFactors(problem).in_edges(_with_shortfall(values, short)).sum())


def velocities_by_rates(problem: Problem) -> np.ndarray:
    """Return the matrix M, shape (3b, faces), for which d = M p for all admissible velocities and rates."""
    return np.asarray(np.linalg.pinv(problem.B.T.toarray()) @ problem.D(problem.dilatancy).toarray())


@dataclass(frozen=True)
class BoundStep:
    """Record of one linear relaxation, whose variables are products of forces and rates."""

    #: Lower bound on λ that the multipliers prove. It is valid for all states whose forces and rates are
    #: within the limits that the relaxation assumes.
    bound: float
    #: Lower bound on λ from earlier programs, which is also the smallest λ that this program admits.
    lowest: float
    load_factor: float  #: load factor λ of the best known state
    #: The relaxation has a variable for the product of a force and a rate only if their joints are at most
    #: this many blocks apart.
    rates_within: int
    #: The relaxation has a variable for the product of a force and a block velocity only if joint and block
    #: are at most this many blocks apart.
    velocities_within: int
    products: int  #: number of products
    seconds: float  #: time since the method began


def relaxed(
    problem: Problem, highest: float, of: StateBounds, selected: Pairs, seconds: float, effort: Effort
) -> tuple[float, list[np.ndarray], LpSize]:
    """Solve one relaxation. Return a lower bound on λ, joint forces and the size of the linear program.

    The bound is valid for all states with λ from ``of.lowest`` to ``highest`` whose forces and rates are
    within the bounds ``of``. It follows from the multipliers that the solver reaches within ``seconds``. A
    search can start from the forces, each of shape (3c,).
    """
    with effort.measure("build"):
        model = PyomoProducts(problem, (of.lowest, highest), of.normal, selected)
    with effort.measure("compile"):
        lp = LinearProgram.of_pyomo(model.program)
    # Each variable is a product of two factors. Collect the column number of each variable, and the indices
    # of both factors.
    column, (i, k) = np.concatenate(list(lp.columns.values())), np.array(list(model.product)).T
    of_statics, velocities = np.append(of.forces, [highest, 1.0])[i], model.factors.velocities
    fastest = np.full(model.factors.kinematic_unit + 1, _LARGEST_RATE)
    fastest[-1] = 1.0
    # Halve the limit for angular velocities. The unit of length is half the median joint length, so that an
    # angular velocity ω moves the two ends of a typical joint by 2 ω relative to each other.
    problem.moments(fastest[velocities.start : -1])[:] /= 2
    reach = np.empty(len(column))
    reach[column] = of_statics * fastest[k]
    point, multipliers = _solved(lp, reach, (of.lowest, highest), seconds, effort)
    # The multipliers are not exactly feasible. Reduce the bound by each infeasibility times the largest
    # possible value of the product variable to which it belongs.
    value, short = lp.least(multipliers)
    shortfall = np.bincount(k, of_statics * short[column], model.factors.kinematic_unit + 1)
    bound = max(of.lowest, value - shortfall[-1] - of.rates * _largest_per_rate(model, shortfall[:-1]))
    return bound, _forces(model, point[column]), lp.size


def _largest_per_rate(model: PyomoProducts, shortfall: np.ndarray) -> float:
    """Return the reduction of the lower bound on λ per unit of the sum of all rates.

    The bound is reduced because the multipliers of the relaxation are not exactly feasible. The argument
    ``shortfall`` has the infeasibility of the reduced costs per unit of each rate and of each velocity, shape
    (rates + velocities,). The velocities follow from the rates.
    """
    problem, factors, start = model.problem, model.factors, model.factors.velocities.start
    by_rates = np.abs(velocities_by_rates(problem)).T @ shortfall[start:]
    # Divide by 2, because a rocking rate is half of an edge opening, and by 2 again, because ``in_edges``
    # multiplies rocking rates by 2.
    by_rates[problem.table.rocks] /= 4
    return float((shortfall[:start] + factors.in_edges(by_rates)).max())


def _forces(model: PyomoProducts, of_products: np.ndarray) -> list[np.ndarray]:
    """Return candidate vectors of joint forces, shape (3c,) each, from a solution of the relaxation.

    The first array has the forces that are not multiplied by a rate or velocity. For each rate or velocity
    that is not zero, a further array has the products of the forces with this rate or velocity, divided by
    this rate or velocity. The further arrays may belong to different states, and the first array is between
    them.
    """
    factors, (i, k) = model.factors, np.array(list(model.product)).T
    static_unit, kinematic_unit = factors.static_unit, factors.kinematic_unit
    products = np.full((static_unit + 1, kinematic_unit + 1), np.nan)
    products[tuple(np.array(list(factors.at_rest)).T)] = 0.0
    products[i, k] = of_products
    motion, alone = products[static_unit, :kinematic_unit], products[factors.forces, kinematic_unit]
    moving = np.flatnonzero(np.abs(motion) > _NEGLIGIBLE_MOTION)
    divided = products[: len(alone), moving] / motion[moving]
    return [factors.joint_forces(y) for y in (alone, *np.where(np.isnan(divided.T), alone, divided.T))]


def _solved(
    lp: LinearProgram, reach: np.ndarray, within: tuple[float, float], seconds: float, effort: Effort
) -> tuple[np.ndarray, np.ndarray]:
    """Solve a linear program within a time limit. Return the primal point and the multipliers of the rows.

    The shapes are (columns,) and (rows,). Both arrays are zero if no solver ends with finite numbers.
    """
    lowest, highest = within
    coarse = max(_TOLERANCE_OVER_GAP * (1 - lowest / highest), _TOLERANCE)
    scaled = replace(lp, cost=lp.cost / highest)
    ends = time.perf_counter() + seconds
    free = np.isinf(lp.low)
    boxed = replace(scaled, low=np.where(free, -reach, lp.low), high=np.where(free, reach, lp.high))
    trials = (("highs-ipm", scaled), ("highs-ipm", boxed), ("highs-hipo", boxed))
    point, multipliers = np.zeros(len(lp.cost)), np.zeros(len(lp.row_lower))
    for name, program in trials[2 * (len(lp.row_lower) > _FEW_ROWS) :]:
        time_left = ends - time.perf_counter()
        if time_left < LEAST_TIME and multipliers.any():
            break
        options: dict[str, Any] = {"kkt_tolerance": coarse} if name == "highs-hipo" else {}
        options |= {
            # With presolve, no multipliers of the original program would be known at the time limit.
            "presolve": "off",
            # With the augmented system, HiPO stalls.
            "hipo_system": "normaleq",
            "ipm_iteration_limit": _MOST_PROGRAM_ITERATIONS,
        }
        solver = find_solver("cvxpy", name, _TOLERANCE)
        session = HighsSession(program, effort, "products", solver, **options)
        if name == "highs-hipo":
            session.stop_if_iterations_restart()
        verdict, last = session.run(max(time_left, LEAST_TIME)), (session.point(), session.multipliers())
        effort.lp_solves += 1
        if all(len(values) and np.isfinite(values).all() for values in last):
            point, multipliers = last
            if verdict is Verdict.OPTIMAL:
                break
    return point, highest * multipliers


class Rising:
    """Lower bound on λ, which is raised by relaxations of increasing size.

    Relaxations of moderate size are solved to a vertex, and their bound assumes no limit on forces or rates.
    Larger relaxations are solved less accurately. Their bound assumes limits if statics and kinematics imply
    none.
    """

    def __init__(self, problem: Problem, best: float, rates: float, effort: Effort) -> None:
        self._problem, self._effort, self._assumed_rates = problem, effort, rates
        self.best = best  #: lowest known load factor, λ > 0; callers may set a lower value
        self.bound = 0.0  #: lower bound on λ from all programs solved so far
        self.history: list[BoundStep] = []  #: records of all programs solved so far
        #: Relaxations solved to a vertex, and their bound.
        self.chain = ProductChain(problem, effort, SETTINGS)
        self._limits: StateBounds | None = None
        self._vertices_are_found = True  # False after a relaxation that could not be solved to a vertex

    @property
    def limits(self) -> StateBounds | None:
        """Limits on forces and rates that the lower bound assumes, or None if it needs no assumption."""
        return None if self.chain.steps and self.chain.bound >= self.bound else self._limits

    def programs(
        self, ends: float = inf, began: float = 0.0
    ) -> Iterator[tuple[BoundStep, LpSize, list[np.ndarray]]]:
        """Solve relaxations of increasing size, and yield the record, size and joint forces of each.

        Each relaxation is a linear program. The size consists of its numbers of rows, columns and nonzeros.
        The sequence ends when the bracket is closed, after the largest relaxation, or when the time is over.
        The joint forces, each of shape (3c,), may lead to states with a lower λ than the lowest known state.

        Unless a program is repeated, the next program contains more products of static and kinematic
        variables. A program includes only states above the last bound. The forces of these states have
        smaller limits, so that an equal number of products proves a higher bound. A program is therefore
        repeated as long as each repetition closes a large fraction of the gap.
        """
        for radii, selected in selections(self._problem, _MOST_PRODUCTS):
            gains = True
            while gains:
                if self.history and ends - time.perf_counter() < LEAST_TIME:
                    return
                last = self.bound
                step, forces, size = self._solved(selected, ends)
                self.bound, seconds = max(last, min(step.bound, self.best)), time.perf_counter() - began
                step = replace(step, rates_within=radii[0], velocities_within=radii[1], seconds=seconds)
                self.history.append(step)
                yield step, size, [] if closed(self._problem, self.bound, self.best) else forces
                if closed(self._problem, self.bound, self.best):
                    return
                gains = closes_much(last, self.bound, self.best, SETTINGS)

    def _solved(self, selected: Pairs, ends: float) -> tuple[BoundStep, list[np.ndarray], LpSize]:
        """Solve a relaxation before the time ``ends``, to a vertex if possible.

        Return the record of the relaxation without its distances and its time, joint forces of shape (3c,)
        each, and the size of the program.
        """
        products = number_of_products(selected)
        step = BoundStep(0.0, self.chain.bound, self.best, 0, 0, products, 0.0)
        largest = max(map(number_of_products, self.chain.selections), default=0)
        if self._vertices_are_found and products <= largest:
            # If the relaxation cannot be solved to a vertex in half of the time, the other half remains for a
            # less accurate solution.
            half = (ends - time.perf_counter()) / 2
            solved = self.chain.raise_bound(self.best, selected, max(half, LEAST_TIME))
            if solved is not None:
                forces = _forces(solved.model, solved.point)
                return replace(step, bound=solved.bound), forces, solved.size
            self._vertices_are_found = False
        highest = a_little_above(self.best)
        if self._limits is None:
            self._limits = bounds_of(self._problem, highest, self._assumed_rates, self._effort)
        if self.bound > self._limits.lowest:
            self._limits = tightened(self._limits, self._problem, self.bound, highest, self._effort)
        time_left = max(ends - time.perf_counter(), LEAST_TIME)
        solution = relaxed(self._problem, highest, self._limits, selected, time_left, self._effort)
        bound, forces, size = solution
        return replace(step, bound=bound, lowest=self._limits.lowest), forces, size


def assumed_rates(problem: Problem, d: np.ndarray | None) -> float:
    """Return the limit on the sum of slips and edge openings that is assumed if kinematics imposes no limit.

    The limit is a multiple of the sum in the state with the lowest λ, whose velocities d have shape (3b,),
    and has a minimum. ``d`` is None if no state is known.
    """
    return max(_LEAST_RATES, _OVER_KNOWN * (0.0 if d is None else sum_of_rates(problem, d)))


def sum_of_rates(problem: Problem, d: np.ndarray) -> float:
    """Return the sum of all slips and edge openings for block velocities d, shape (3b,)."""
    return float(EdgeFactors(problem).in_edges(problem.rates(d, problem.dilatancy)).sum())


def closed(problem: Problem, bound: float, load_factor: float) -> bool:
    """Return True if the relative gap between a lower bound and a load factor is at most ``PROVEN_GAP``."""
    return load_factor - bound <= PROVEN_GAP * problem.load_factor_scale.divisor(load_factor)

"""Lower bounds of λ from products of statics and kinematics, raised by programs of more and more of them,
near ones first; and the largest forces and rates of all states with λ in an interval."""

import time
from collections.abc import Iterator
from dataclasses import dataclass, replace
from math import inf
from typing import Any

import numpy as np
import scipy.sparse as sp
from scipy.sparse.csgraph import shortest_path

from masonry_opt.answer.acceptance import BEYOND_LIMITS, CLOSED, SMALLEST
from masonry_opt.effort import Effort
from masonry_opt.models.cvxpy_exact import CvxpyForces, CvxpyMotion
from masonry_opt.models.pyomo_products import Pairs, PyomoProducts
from masonry_opt.problem.edges import EdgeFactors
from masonry_opt.problem.faces import selection
from masonry_opt.problem.problem import Problem, ShearLimits
from masonry_opt.solvers.highs import HighsSession, LinearProgram
from masonry_opt.solvers.registry import LpSize, Verdict, find_solver

_TIMES_LOADS = 10.0  #: Where statics set no limit, forces are assumed to be at most so many times all loads.
_BEYOND = 1e9  #: A mechanism that only rates and velocities this large could make is none.

#: Tolerance of the interior points, and the rows up to which HiGHS's older one is tried first: it is two to
#: three times as fast there and nearer the optimum; above it mostly breaks off without multipliers.
_TOLERANCE, _FEW_ROWS = 1e-7, 20_000

#: Tolerance asked of HiPO, over the share of λ that is open: half of its iterations would go into the last
#: hundredth of a proof, where more products prove half as much again.
_COARSE = 0.05

#: Largest velocity for the solver where there is no bound, in units of the live load's mean velocity: with
#: free columns HiPO stalls or breaks off, the older one on few scenes. The proof does not use it.
_FASTEST = 20.0

_MOVES = 1e-3  #: Rates and velocities below this are taken for none.
_MOST_STEPS = 500  #: Iterations at most, for programs that no time ends.
LEAST_TIME = 1.0  #: Seconds that a program is given at least.

#: Largest distances, in blocks, of the factors of products: forces with rates, forces with velocities. The
#: next pair follows where the last leaves a gap and time.
RADII = ((0, 1), (0, 2), (0, 3), (1, 3), (2, 3), (2, 4), (3, 5))

_ABOVE = 1e-4  #: The programs take this share more than the best λ known, so that they have an interior.

#: A program that closes more than this share of the gap is repeated with the limits of forces that it leaves,
#: else followed by one of more products, which takes three to ten times as long.
_WORTH_REPEATING = 0.5
_MOST_PRODUCTS = 400_000  #: No program keeps more products than this (memory).

#: What rates are assumed to sum to, at least, and over those of the state known (on walls 30 to 140).
_LEAST_RATES, _OVER_KNOWN = 100.0, 10.0


@dataclass(frozen=True)
class StateBounds:
    """Largest forces and rates of all states with lowest ≤ λ ≤ Λ."""

    lowest: float
    normal: np.ndarray  #: normal force of each joint, shape (c,)
    forces: np.ndarray  #: magnitudes of x₂, x₃ and z₀ (or s) of each joint, flat, shape (3c,)
    rates: float  #: sum of all slips and edge openings
    #: Whether statics and kinematics imply them; else some are assumed, and what follows holds below only.
    forces_derived: bool
    rates_derived: bool

    def allow(self, problem: Problem, q: np.ndarray, d: np.ndarray) -> bool:
        """Whether a state's forces (3c,) and the sum of its rates stay below what is assumed."""
        first, second, shear = np.abs(q.reshape(3, -1))
        forces, most = np.stack([first + second, shear]), np.stack([self.normal, self.forces[2::3]])
        within = self.forces_derived or bool((forces <= most + BEYOND_LIMITS * (1 + most)).all())
        return within and (self.rates_derived or sum_of_rates(problem, d) < self.rates)


def bounds_of(problem: Problem, highest: float, assumed_rates: float, effort: Effort) -> StateBounds:
    """Bounds over all states with 0 ≤ λ ≤ ``highest``: the largest forces that statics allow, and the largest
    rates that kinematics allow each face while raising the blocks takes no more than the live load gives, the
    other sense of sliding at rest. Nothing is lost where dilatancy is not negative: at yield in both senses a
    joint carries nothing and may open instead (without friction and cohesion it must not dilate)."""
    normal, forces, derived = _force_limits(problem, (0.0, highest), effort)
    rates = _most_rates(problem, highest, effort)
    slips_either_way = (problem.dilatancy > 0) & (problem.friction == 0) & (problem.cohesion == 0)
    rates_derived = bool(np.isfinite(rates) and (problem.dilatancy >= 0).all() and not slips_either_way.any())
    rates = rates if rates_derived else assumed_rates
    return StateBounds(0.0, normal, forces, rates, derived, rates_derived)


def tightened(
    of: StateBounds, problem: Problem, lowest: float, highest: float, effort: Effort
) -> StateBounds:
    """The same of states with ``lowest`` ≤ λ ≤ ``highest``: the higher λ, the less self-stress."""
    normal, forces, derived = _force_limits(problem, (lowest, highest), effort)
    if not derived:
        return replace(of, lowest=lowest)  # what is proven of more states goes before an assumption
    normal, forces = np.minimum(normal, of.normal), np.minimum(forces, of.forces)
    return replace(of, lowest=lowest, normal=normal, forces=forces)


def _force_limits(
    problem: Problem, within: tuple[float, float], effort: Effort
) -> tuple[np.ndarray, np.ndarray, bool]:
    """Largest normal forces, the magnitudes of all edge forces, and whether none of them is assumed. Programs
    find the largest of those that limit all others: n of every joint, and s where a joint cannot slide."""
    forces = CvxpyForces(problem, within=within)
    session, q = HighsSession(forces.program, effort, "bounds"), forces.statics.q
    c, highest = problem.joints, within[1]
    cannot_slide = np.setdiff1d(np.arange(c), problem.sliding)
    of_shears = selection(2 * c + cannot_slide, problem.table.width)
    targets = sp.vstack([problem.table.normal_sums, of_shears]).toarray()
    steep = max(1.0, float(problem.friction.max(initial=0.0)))
    # Every force is at most so many times 1 + the sum of the targets.
    share = steep + float(problem.cohesion.max(initial=0.0))
    values, short = np.zeros((2, len(targets)))
    columns = session.columns(q)
    for number, target in enumerate(targets):
        for sign in (1.0, -1.0) if number >= c else (1.0,):
            session.set_costs(q, -sign * target)
            if session.solve() is not Verdict.OPTIMAL:
                values[number] = np.inf
                break
            least, lacks = session.least()
            elsewhere = float(np.delete(lacks, columns).sum()) * max(highest, 1.0)
            values[number] = max(values[number], -least + elsewhere)
            short[number] = max(short[number], float(lacks[columns].sum()) * share)
    assumed = _TIMES_LOADS * float(np.abs(problem.dead).sum() + highest * problem.live_norm)
    found = np.isfinite(values)
    bounds = _with_what_is_short(np.where(found, values, assumed), np.where(found, short, 0.0))
    proven = np.isfinite(bounds)
    bounds = np.where(proven, bounds, assumed)
    normal, shear = bounds[:c], np.zeros(c)
    shear[problem.sliding] = 2 * ShearLimits.true(problem).at(normal[problem.sliding])
    shear[cannot_slide] = bounds[c:]
    return normal, np.stack([normal, normal, shear], axis=1).ravel(), bool((found & proven).all())


def _with_what_is_short(values: np.ndarray, short: np.ndarray) -> np.ndarray:
    """Bounds of x ≥ 0 from xⱼ ≤ valuesⱼ + shortⱼ (1 + Σ x); ``inf`` where Σ x cannot pay what is short."""
    if short.sum() >= 0.5:
        return np.where(short == 0.0, values, np.inf)
    total = float((values.sum() + short.sum()) / (1 - short.sum()))
    return np.asarray(values + short * (1 + total))


def _most_rates(problem: Problem, highest: float, effort: Effort) -> float:
    """Largest sum of slips and edge openings over the mechanisms on which raising the blocks takes at most
    ``highest`` times the live load's work; ``inf`` where the solver finds no largest of some face."""
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
            value, lacks = session.contradiction()
            if value > _BEYOND * lacks.sum():
                continue  # at rest in every such mechanism: there is none
        if verdict is not Verdict.OPTIMAL:
            return inf
        least, lacks = session.least()
        values[face] = max(-least, 0.0)
        short[face], of_motion[face] = lacks[of_rates].max(), lacks[of_velocities]
    short += of_motion @ np.abs(velocities_by_rates(problem)).max(axis=1)
    return float(EdgeFactors(problem).in_edges(_with_what_is_short(values, short)).sum())


def velocities_by_rates(problem: Problem) -> np.ndarray:
    """d = M p for all velocities d and face rates p that kinematics allow, shape (3b, faces)."""
    return np.asarray(np.linalg.pinv(problem.B.T.toarray()) @ problem.D(problem.dilatancy).toarray())


@dataclass(frozen=True)
class BoundStep:
    """One program of products."""

    bound: float  #: lower bound of λ that its multipliers prove, below the rates assumed
    lowest: float  #: bound that the programs before it prove; this one is of states from there on
    load_factor: float  #: λ of the best state known
    rates_within: int  #: largest distance, in blocks, of forces and rates whose products are kept
    velocities_within: int  #: that of forces and velocities
    products: int
    seconds: float  #: since the method began


def distances(problem: Problem) -> Pairs:
    """Between joints, shape (c, c), and from joints to blocks, shape (c, b), in blocks that touch."""
    touches = problem.matrices.ends.toarray()
    between = shortest_path(touches @ touches.T, directed=False, unweighted=True)
    of_joint = [np.flatnonzero(column) for column in touches.T]
    to_blocks = np.array([between[blocks].min(axis=0) for blocks in of_joint])
    to_joints = np.array([to_blocks[:, blocks].min(axis=1) for blocks in of_joint]).T
    return to_joints, to_blocks


def relaxed(
    problem: Problem, highest: float, of: StateBounds, kept: Pairs, seconds: float, effort: Effort
) -> tuple[float, list[np.ndarray], LpSize]:
    """A lower bound of all λ from ``of.lowest`` to ``highest`` within the limits, as the solver's multipliers
    prove it after so many ``seconds``, joint forces (3c,) that may be next to low states, and the size."""
    with effort.measure("build"):
        model = PyomoProducts(problem, (of.lowest, highest), of.normal, kept)
    with effort.measure("compile"):
        lp = LinearProgram.of_pyomo(model.program)
    # Every variable is a product, in their order: its column, and the numbers of its two factors.
    column, (i, k) = np.concatenate(list(lp.columns.values())), np.array(list(model.product)).T
    of_statics, velocities = np.append(of.forces, [highest, 1.0])[i], model.factors.velocities
    fastest = np.full(model.factors.unit + 1, _FASTEST)
    fastest[-1] = 1.0
    # How large columns may be for the solver; rotations over the usual length of a joint, two.
    problem.moments(fastest[velocities.start : -1])[:] /= 2
    reach = np.empty(len(column))
    reach[column] = of_statics * fastest[k]
    point, multipliers = _solved(lp, reach, (of.lowest, highest), seconds, effort)
    # What reduced costs lack is paid with the largest that each product can be.
    value, short = lp.least(multipliers)
    lacks = np.bincount(k, of_statics * short[column], model.factors.unit + 1)
    bound = max(of.lowest, value - lacks[-1] - of.rates * _for_each_rate(model, lacks[:-1]))
    return bound, _forces(model, point[column]), lp.size


def _for_each_rate(model: PyomoProducts, lacks: np.ndarray) -> float:
    """The most that a unit of the sum of all rates pays of what rates, and velocities that follow, lack."""
    problem, factors, start = model.problem, model.factors, model.factors.velocities.start
    by_rates = np.abs(velocities_by_rates(problem)).T @ lacks[start:]
    # in_edges doubles rocking rates into openings, so what is paid for each unit of opening is divided twice.
    by_rates[problem.table.rocks] /= 4
    return float((lacks[:start] + factors.in_edges(by_rates)).max())


def _forces(model: PyomoProducts, of_products: np.ndarray) -> list[np.ndarray]:
    """Joint forces at values of the products: alone, then in products with each rate and velocity, over it:
    they may be of different states, and the first between them."""
    factors, (i, k) = model.factors, np.array(list(model.product)).T
    one, unit = factors.one, factors.unit
    products = np.full((one + 1, unit + 1), np.nan)
    products[tuple(np.array(list(factors.at_rest)).T)] = 0.0
    products[i, k] = of_products
    motion, alone = products[one, :unit], products[factors.forces, unit]
    moving = np.flatnonzero(np.abs(motion) > _MOVES)
    given = products[: len(alone), moving] / motion[moving]
    return [factors.joint_forces(y) for y in (alone, *np.where(np.isnan(given.T), alone, given.T))]


def _solved(
    lp: LinearProgram, reach: np.ndarray, within: tuple[float, float], seconds: float, effort: Effort
) -> tuple[np.ndarray, np.ndarray]:
    """The point (columns,) that the solvers reach in that time, and multipliers (rows,); zeros for none."""
    lowest, highest = within
    coarse = max(_COARSE * (1 - lowest / highest), _TOLERANCE)
    scaled = replace(lp, cost=lp.cost / highest)
    ends = time.perf_counter() + seconds
    free = np.isinf(lp.low)
    boxed = replace(scaled, low=np.where(free, -reach, lp.low), high=np.where(free, reach, lp.high))
    ways = (("highs-ipm", scaled), ("highs-ipm", boxed), ("highs-hipo", boxed))
    point, found = np.zeros(len(lp.cost)), np.zeros(len(lp.row_lower))
    for name, program in ways[2 * (len(lp.row_lower) > _FEW_ROWS) :]:
        left = ends - time.perf_counter()
        if left < LEAST_TIME and found.any():
            break
        # Presolved they would have no multipliers of the program itself where time ends them; and with the
        # augmented system, which HiPO may choose, it stalls.
        options: dict[str, Any] = {"kkt_tolerance": coarse} if name == "highs-hipo" else {}
        options |= {"presolve": "off", "hipo_system": "normaleq", "ipm_iteration_limit": _MOST_STEPS}
        solver = find_solver("cvxpy", name, _TOLERANCE)
        session = HighsSession(program, effort, "products", solver, **options)
        if name == "highs-hipo":
            session.stop_if_iterations_restart()
        verdict, last = session.run(max(left, LEAST_TIME)), (session.point(), session.multipliers())
        effort.lp_solves += 1
        if all(len(each) and np.isfinite(each).all() for each in last):
            point, found = last
            if verdict is Verdict.OPTIMAL:
                break
    return point, highest * found


class Rising:
    """A lower bound of λ that rises towards the best λ known."""

    def __init__(self, problem: Problem, best: float, rates: float, effort: Effort) -> None:
        self._problem, self._effort = problem, effort
        self.best = best  #: λ > 0 of the lowest state known; whoever finds a lower one puts it here
        self.bound = 0.0  #: what is proven by now
        self.history: list[BoundStep] = []  #: of the programs by now
        #: Largest forces and rates of all states from there up to the best, which the bound assumes in part.
        self.of = bounds_of(problem, a_little_above(best), rates, effort)

    def programs(
        self, ends: float = inf, began: float = 0.0
    ) -> Iterator[tuple[BoundStep, LpSize, list[np.ndarray]]]:
        """Programs of more and more products, until the bracket is closed or time is up: what each proved,
        its size, and joint forces (3c,) that may lead to states lower than the best. Each looks only above
        what the last proved, where forces have less room: the same products prove more, while that pays."""
        (to_joints, to_blocks), before = distances(self._problem), 0
        for radii in RADII:
            kept = to_joints <= radii[0], to_blocks <= radii[1]
            products = 12 * int(kept[0].sum()) + 9 * int(kept[1].sum())
            if products == before or products > _MOST_PRODUCTS:
                continue
            gains = True
            while gains:
                if before and ends - time.perf_counter() < LEAST_TIME:
                    return
                highest, last = a_little_above(self.best), self.bound
                if last > self.of.lowest:
                    self.of = tightened(self.of, self._problem, last, highest, self._effort)
                before, left = products, ends - time.perf_counter()
                proven, forces, size = relaxed(self._problem, highest, self.of, kept, left, self._effort)
                self.bound, seconds = max(last, min(proven, self.best)), time.perf_counter() - began
                step = BoundStep(proven, self.of.lowest, self.best, *radii, products, seconds)
                self.history.append(step)
                yield step, size, [] if closed(self.bound, self.best) else forces
                if closed(self.bound, self.best):
                    return
                gains = self.bound - last > _WORTH_REPEATING * (self.best - last)


def a_little_above(best: float) -> float:
    """Λ of the programs, from the best λ known."""
    return best + _ABOVE * max(abs(best), 1e-3)


def assumed_rates(problem: Problem, d: np.ndarray | None) -> float:
    """What slips and edge openings are assumed to sum to, from the velocities (3b,) of the lowest state."""
    return max(_LEAST_RATES, _OVER_KNOWN * (0.0 if d is None else sum_of_rates(problem, d)))


def sum_of_rates(problem: Problem, d: np.ndarray) -> float:
    """The sum of slips and edge openings under block velocities (3b,)."""
    return float(EdgeFactors(problem).in_edges(problem.rates(d, problem.dilatancy)).sum())


def closed(bound: float, load_factor: float) -> bool:
    """Whether a bracket from a bound to a load factor is closed."""
    return load_factor - bound <= CLOSED * max(abs(load_factor), SMALLEST)

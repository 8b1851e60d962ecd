"""Lower bounds of λ from products of statics and kinematics, near ones first."""

import time
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from scipy.sparse.csgraph import shortest_path

from masonry_opt.effort import Effort
from masonry_opt.methods.bracket.bounds import StateBounds, velocities_by_rates
from masonry_opt.models.pyomo_products import PyomoProducts
from masonry_opt.problem.problem import Problem
from masonry_opt.solvers.highs import HighsSession, LinearProgram
from masonry_opt.solvers.registry import LpSize, Verdict, find_solver

_PURPOSE = "products"  #: What HiGHS does here, as a result tells it.

#: Tolerance asked of the interior points, and the rows up to which HiGHS's older one is tried first: it is
#: two to three times as fast there and nearer the optimum; above it mostly breaks off without multipliers.
_TOLERANCE, _FEW_ROWS = 1e-7, 20_000

#: Tolerance asked of HiPO, over the share of λ that is still open: half of its iterations would go into the
#: last hundredth of a proof, where a program of more products proves half as much again.
_COARSE = 0.05

#: Largest velocity for the solver where there is no bound, in units of the live load's mean velocity: with
#: free columns HiPO stalls or breaks off, the older interior point on few scenes. The proof from the
#: multipliers does not use it.
_FASTEST = 20.0

_MOVES = 1e-3  #: Rates and velocities below this are taken for none.
_MOST_STEPS = 500  #: Iterations at most, for programs that no time ends.
LEAST_TIME = 1.0  #: Seconds that a program is given at least.

#: Largest distances, in blocks, of the factors of products: forces with rates, forces with velocities. The
#: next are taken where the last leave a gap and time.
RADII = ((0, 1), (0, 2), (0, 3), (1, 3), (2, 3), (2, 4), (3, 5))


@dataclass(frozen=True)
class BoundStep:
    """One program of products.

    Attributes
    ----------
    bound: lower bound of λ that its multipliers prove, below the rates assumed.
    lowest: bound that the programs before it prove; this one is of states from there on.
    load_factor: λ of the best state known.
    rates_within, velocities_within: largest distance, in blocks, of the joints whose products of forces and
        rates are kept, and of the joints and blocks whose products of forces and velocities are.
    seconds: since the method began.
    """

    bound: float
    lowest: float
    load_factor: float
    rates_within: int
    velocities_within: int
    products: int
    seconds: float


class Distances:
    """Between joints, shape (c, c), and from joints to blocks, shape (c, b), in blocks that touch."""

    def __init__(self, problem: Problem) -> None:
        touches = problem.matrices.ends.toarray()
        between = shortest_path(touches @ touches.T, directed=False, unweighted=True)
        of_joint = [np.flatnonzero(column) for column in touches.T]
        self.to_blocks = np.array([between[blocks].min(axis=0) for blocks in of_joint])
        self.to_joints = np.array([self.to_blocks[:, blocks].min(axis=1) for blocks in of_joint]).T

    def within(self, radii: tuple[int, int]) -> tuple[np.ndarray, np.ndarray]:
        """Whether joints, and joints and blocks, are no further apart than the first and second radius."""
        return self.to_joints <= radii[0], self.to_blocks <= radii[1]


def relaxed(
    problem: Problem,
    highest: float,
    of: StateBounds,
    near: np.ndarray,
    moves: np.ndarray,
    seconds: float,
    effort: Effort,
) -> tuple[float, list[np.ndarray], LpSize]:
    """A lower bound of all λ from ``of.lowest`` to ``highest`` within the limits, joint forces (3c,) that may
    be next to low states, and its program's size.

    ``near`` and ``moves`` are the joints and joints, joints and blocks, whose products are kept. The bound is
    what the solver's multipliers prove, however far it came in its ``seconds``.
    """
    with effort.measure("build"):
        model = PyomoProducts(problem, (of.lowest, highest), of.normal, near, moves)
    with effort.measure("compile"):
        lp = LinearProgram.of_pyomo(model.program)
    point, multipliers = _solved(lp, _reach(model, lp, highest, of), (of.lowest, highest), seconds, effort)
    return _proven(model, lp, multipliers, highest, of), _forces(model, lp, point), lp.size


def _forces(model: PyomoProducts, lp: LinearProgram, point: np.ndarray) -> list[np.ndarray]:
    """Joint forces at a point (columns,) of the program: those alone, then those in the products with each
    rate and velocity, over it. They may be of different states, and the first between them."""
    factors, (i, k) = model.factors, np.array(list(model.product)).T
    one, unit = factors.load_factor + 1, factors.velocities.stop
    products = np.full((one + 1, unit + 1), np.nan)
    products[tuple(np.array(list(factors.at_rest)).T)] = 0.0
    products[i, k] = point[np.concatenate(list(lp.columns.values()))]
    motion, alone = products[one, :unit], products[factors.forces, unit]
    moving = np.flatnonzero(np.abs(motion) > _MOVES)
    given = products[: len(alone), moving] / motion[moving]
    return [factors.joint_forces(y) for y in (alone, *np.where(np.isnan(given.T), alone, given.T))]


def _reach(model: PyomoProducts, lp: LinearProgram, highest: float, of: StateBounds) -> np.ndarray:
    """How large each column may be for the solver, shape (columns,): limits of statics times velocities."""
    problem, factors = model.problem, model.factors
    of_motion = np.ones(factors.velocities.stop + 1)
    of_motion[:-1] = _FASTEST
    # Rotations over the usual length of a joint, which is two.
    problem.moments(of_motion[factors.velocities.start : -1])[:] /= 2
    column, of_statics, k = _columns(model, lp, highest, of)
    reach = np.empty(len(lp.cost))
    reach[column] = of_statics * of_motion[k]
    return reach


def _columns(
    model: PyomoProducts, lp: LinearProgram, highest: float, of: StateBounds
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Column of each product, largest value of its factor of statics, number of its factor of kinematics,
    shape (products,) each."""
    # Every variable is a product, in their order.
    column = np.concatenate(list(lp.columns.values()))
    i, k = np.array(list(model.product)).T
    return column, np.append(of.forces, [highest, 1.0])[i], k


def _solved(
    lp: LinearProgram, reach: np.ndarray, within: tuple[float, float], seconds: float, effort: Effort
) -> tuple[np.ndarray, np.ndarray]:
    """The point (columns,) that the solvers reach in that time, and multipliers of the rows, shape (rows,);
    zeros where they have none."""
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
        verdict, *last = _run(program, name, coarse, max(left, LEAST_TIME), effort)
        if all(len(each) and np.isfinite(each).all() for each in last):
            point, found = last
            if verdict is Verdict.OPTIMAL:
                break
    return point, highest * found


def _run(
    lp: LinearProgram, name: str, coarse: float, seconds: float, effort: Effort
) -> tuple[Verdict, np.ndarray, np.ndarray]:
    # Presolved they would have no multipliers of the program itself where time ends them; and with the
    # augmented system, which HiPO may choose, it stalls.
    options: dict[str, Any] = {
        "presolve": "off",
        "hipo_system": "normaleq",
        "ipm_iteration_limit": _MOST_STEPS,
    }
    if name == "highs-hipo":
        options["kkt_tolerance"] = coarse
    solver = find_solver("cvxpy", name, _TOLERANCE)
    session = HighsSession(lp, effort, _PURPOSE, solver, **options)
    if name == "highs-hipo":
        session.stop_if_iterations_restart()
    verdict = session.run(seconds)
    effort.lp_solves += 1
    return verdict, session.point(), session.multipliers()


def _proven(
    model: PyomoProducts, lp: LinearProgram, multipliers: np.ndarray, highest: float, of: StateBounds
) -> float:
    """What the multipliers prove of λ ≥ ``of.lowest``: what reduced costs lack is paid with the largest that
    each product can be, by the limits of forces and of the sum of all rates."""
    problem, factors = model.problem, model.factors
    value, short = lp.least(multipliers)
    column, of_statics, k = _columns(model, lp, highest, of)
    of_motion = np.bincount(k, of_statics * short[column], factors.velocities.stop + 1)
    rates, velocities = of_motion[: factors.velocities.start], of_motion[factors.velocities.start : -1]
    by_rates = np.abs(velocities_by_rates(problem)).T @ velocities
    # in_edges doubles rocking rates into openings, so what is paid for each unit of opening is divided twice.
    by_rates[problem.table.rocks] /= 4
    by_edges = factors.in_edges(by_rates)
    return max(of.lowest, value - of_motion[-1] - of.rates * float((rates + by_edges).max()))

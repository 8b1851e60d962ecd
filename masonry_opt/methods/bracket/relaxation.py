"""Lower bounds of λ from products of statics and kinematics, near ones first."""

from __future__ import annotations

import time
from dataclasses import dataclass, replace

import highspy
import numpy as np
from scipy.sparse.csgraph import shortest_path

from masonry_opt.effort import Effort
from masonry_opt.methods.bracket.limits import Limits, velocities_by_rates
from masonry_opt.models.pyomo_products import PyomoProducts
from masonry_opt.problem.edges import EdgeFactors
from masonry_opt.problem.problem import Problem
from masonry_opt.solvers.highs_lp import LinearProgram
from masonry_opt.solvers.lp import LpSize
from masonry_opt.solvers.registry import find_solver

#: What HiGHS does here, as a result tells it.
_PURPOSE = "products"

#: Tolerances of the interior point, the second where the first ends in nothing. Programs of more rows get the
#: second at once: there it hardly ever reaches the first, and HiGHS keeps no multipliers of a run that fails.
_TOLERANCE, _ROUGH, _MANY_ROWS = 1e-7, 3e-2, 20_000

#: Bound that the solver alone sees of columns that have none: with free columns its interior point takes
#: minutes for a first basis, or breaks down. What the multipliers prove is computed without it.
_BOX = 1e3

#: How far apart, in blocks, the factors of the products kept are: of forces with rates, of forces with
#: velocities. The next where the last leaves a gap and time; the second is left out of scenes of many joints.
RADII, MANY_JOINTS = ((0, 1), (0, 2), (1, 2), (1, 3), (2, 3), (2, 4), (3, 5)), 60


@dataclass(frozen=True)
class Relaxation:
    """One program of products.

    Attributes
    ----------
    bound: lower bound of λ that its multipliers prove, below the rates assumed.
    load_factor: λ of the best state known.
    rates_within, velocities_within: how far apart, in blocks, joints are whose products of forces and rates
        are kept, and joints and blocks whose products of forces and velocities are.
    products: how many.
    seconds: of declaring and solving.
    """

    bound: float
    load_factor: float
    rates_within: int
    velocities_within: int
    products: int
    seconds: float


class Distances:
    """Between joints, shape (c, c), and from joints to blocks, shape (c, b), in blocks that touch."""

    def __init__(self, problem: Problem) -> None:
        touches = EdgeFactors(problem).touches.astype(float)
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
    of: Limits,
    near: np.ndarray,
    moves: np.ndarray,
    seconds: float,
    effort: Effort,
) -> tuple[float, LpSize]:
    """A lower bound of all λ ≤ ``highest`` within the limits, and the size of its program.

    Parameters
    ----------
    near, moves: joints and joints, joints and blocks, whose products are kept.
    seconds: for the solver; the bound is what its multipliers prove, however far it came.
    """
    with effort.measure("build"):
        model = PyomoProducts(problem, highest, of.normal, near, moves)
    with effort.measure("compile"):
        lp = LinearProgram.of(model.program)
    return _proven(model, lp, _multipliers(lp, highest, seconds, effort), highest, of), lp.size


def _multipliers(lp: LinearProgram, highest: float, seconds: float, effort: Effort) -> np.ndarray:
    """Multipliers of the rows, shape (rows,), zeros where the solver has none in that time."""
    ends = time.perf_counter() + seconds
    free = np.isinf(lp.low)
    low, high = np.where(free, -_BOX, lp.low), np.where(free, _BOX, lp.high)
    boxed = replace(lp, cost=lp.cost / highest, low=low, high=high).highs()
    for tolerance in (_TOLERANCE, _ROUGH) if len(lp.row_lower) <= _MANY_ROWS else (_ROUGH,):
        found = _run(boxed, tolerance, max(ends - time.perf_counter(), 1.0), effort)
        if found.any():
            return highest * found
    return np.zeros(len(lp.row_lower))


def _run(lp: highspy.HighsLp, tolerance: float, seconds: float, effort: Effort) -> np.ndarray:
    solver = find_solver("pyomo", "highs-ipm", _TOLERANCE)
    effort.uses(solver.name, _PURPOSE)
    effort.lp_solves += 1
    highs = highspy.Highs()
    highs.silent()
    for name, value in solver.options.items():
        highs.setOptionValue(name, value)
    highs.setOptionValue("ipm_optimality_tolerance", tolerance)
    highs.setOptionValue("time_limit", seconds)
    highs.passModel(lp)
    with effort.measure("solve"):
        highs.run()
    effort.iterations += max(highs.getInfo().ipm_iteration_count, 0)
    found = np.array(highs.getSolution().row_dual)
    return found if found.size and np.isfinite(found).all() else np.zeros(lp.num_row_)


def _proven(
    model: PyomoProducts, lp: LinearProgram, multipliers: np.ndarray, highest: float, of: Limits
) -> float:
    """What the multipliers prove of λ ≥ 0: what reduced costs lack is paid with the largest that each product
    can be, by the limits of forces and of the sum of all rates."""
    problem, factors = model.problem, model.factors
    value, short = lp.least(multipliers)
    of_statics = np.append(of.forces, [highest, 1.0])
    of_motion = np.zeros(factors.velocities.stop + 1)
    for (i, k), variable in model.product.items():
        of_motion[k] += of_statics[i] * short[lp.column[id(variable)]]
    rates, velocities = of_motion[: factors.velocities.start], of_motion[factors.velocities.start : -1]
    by_rates = np.abs(velocities_by_rates(problem)).T @ velocities
    # in_edges turns rates into openings, so what is paid for each unit of opening is divided twice.
    by_edges = factors.in_edges(by_rates / edge_lengths(problem) ** 2)
    return max(0.0, value - of_motion[-1] - of.rates * float((rates + by_edges).max()))


def edge_lengths(problem: Problem) -> np.ndarray:
    """What a face's rate is multiplied by to be a slip or an edge's opening, shape (faces,)."""
    rocking = 2 * problem.half_length
    return np.concatenate([np.ones(2 * len(problem.sliding)), rocking, rocking])

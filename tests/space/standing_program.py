"""Stability of blocks in space, also near their limit, by linear programs with refined friction polygons.

The equilibrium matrix is that of `second_program`. Its fixed polygons cannot decide scenes near the limit.
"""

import numpy as np
import scipy.sparse as sp
from scipy.optimize import linprog
from second_program import Points

#: Number of sides of the first polygons.
SIDES = 96
#: Largest number of refinements.
MOST = 20
#: Smallest tolerances that HiGHS accepts.
TIGHT = {"primal_feasibility_tolerance": 1e-10, "dual_feasibility_tolerance": 1e-10}
SMALL_ENTRY = 1e-8


def out_of_balance(
    wall: Points, friction: float, enough: float, too_much: float, most: float
) -> tuple[float, float]:
    """Return a lower and an upper bound on the least Σ|B q + dead| over all forces q within friction.

    The upper bound uses polygons inside the circles of friction, and normal forces up to ``most``. The lower
    bound uses polygons outside the circles, and any normal forces. The polygons are refined in the directions
    of the shears until the upper bound is at most ``enough`` or the lower bound is at least ``too_much``.
    """
    point = np.repeat(np.arange(len(wall.share)), SIDES)
    angle = np.tile(2 * np.pi * np.arange(SIDES) / SIDES, len(wall.share))
    for _ in range(MOST):
        upper, inner = _least(wall, friction, point, angle, most, inside=True)
        lower, outer = (
            (0.0, inner) if upper <= enough else _least(wall, friction, point, angle, np.inf, inside=False)
        )
        if upper <= enough or lower >= too_much:
            break
        for _, s, t in (inner.T, outer.T):
            some = np.flatnonzero((s != 0) | (t != 0))
            point, angle = np.append(point, some), np.append(angle, np.arctan2(t[some], s[some]))
    return lower, upper


def _least(
    wall: Points, friction: float, point: np.ndarray, angle: np.ndarray, most: float, inside: bool
) -> tuple[float, np.ndarray]:
    """Return the least Σ|B q + dead| and its forces, shape (points, 3), for polygons at the given angles.

    The angles are those of the corners of inside polygons, or of the sides of outside polygons.
    """
    points, rows, sides = len(wall.share), len(wall.dead), len(point)
    along, of_point = np.stack([np.cos(angle), np.sin(angle)]), np.arange(points)
    # HiGHS does not solve programs with very small entries. Setting them to zero makes no direction longer.
    along[np.abs(along) < SMALL_ENTRY] = 0.0
    at_side = sp.csr_array((np.ones(sides), (np.arange(sides), point)), shape=(sides, points))
    normal, *shears = (
        sp.csr_array((np.ones(points), (of_point, 3 * of_point + kind)), shape=(points, 3 * points))
        for kind in range(3)
    )
    balance = sp.hstack([wall.B, sp.eye_array(rows), -sp.eye_array(rows)])
    bounds = [(0, most), (None, None), (None, None)] * points + [(0, None)] * (2 * rows)
    if inside:  # shears are combinations of the corners, with weights whose sum is at most μ n
        made = [
            sp.hstack([shear, sp.csr_array((points, 2 * rows)), -at_side.T @ sp.diags_array(e)])
            for shear, e in zip(shears, along, strict=True)
        ]
        balance = sp.vstack([sp.hstack([balance, sp.csr_array((rows, sides))]), *made])
        limits = sp.hstack([-friction * normal, sp.csr_array((points, 2 * rows)), at_side.T])
        bounds += [(0, None)] * sides
    else:
        slopes = sum(sp.diags_array(e) @ at_side @ shear for shear, e in zip(shears, along, strict=True))
        limits = sp.hstack([slopes - friction * at_side @ normal, sp.csr_array((sides, 2 * rows))])
    cost = np.zeros(balance.shape[1])
    cost[3 * points : 3 * points + 2 * rows] = 1.0
    loads = np.zeros(balance.shape[0])
    loads[:rows] = -wall.dead
    for presolve in (True, False):  # presolve wrongly reports some of these programs as unbounded
        options = TIGHT | {"presolve": presolve}
        found = linprog(cost, limits, np.zeros(limits.shape[0]), balance, loads, bounds, options=options)
        if found.status == 0:
            break
    if found.status != 0:
        raise ArithmeticError(found.message)
    return float(found.fun), found.x[: 3 * points].reshape(points, 3)

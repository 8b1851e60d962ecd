"""Do blocks in space stand, however near their limit? By linear programs with polygons for circles.

What acts where is `second_program`'s, whose polygons leave open what stands by less than their corners.
"""

import numpy as np
import scipy.sparse as sp
from scipy.optimize import linprog
from second_program import Points

#: Sides round each cone to begin with, and programs with ever more of them.
SIDES, MOST = 96, 20
#: The least that HiGHS takes.
TIGHT = {"primal_feasibility_tolerance": 1e-10, "dual_feasibility_tolerance": 1e-10}
SMALL_ENTRY = 1e-8


def out_of_balance(
    wall: Points, friction: float, enough: float, too_much: float, most: float
) -> tuple[float, float]:
    """Bounds of the least Σ|B q + dead| of forces within friction, until the upper one is ``enough`` or the
    lower one ``too_much``: by polygons inside the circles of friction, with normal forces up to ``most``, and
    round them, with any, which get a corner, and a side, more where the shears of either point to."""
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
    """The least, and forces (points, 3) that leave it; corners or sides of the polygons at these angles."""
    points, rows, sides = len(wall.share), len(wall.dead), len(point)
    along, of_point = np.stack([np.cos(angle), np.sin(angle)]), np.arange(points)
    # HiGHS leaves programs with entries so small unsolved; without them directions are no longer than before.
    along[np.abs(along) < SMALL_ENTRY] = 0.0
    at_side = sp.csr_array((np.ones(sides), (np.arange(sides), point)), shape=(sides, points))
    normal, *shears = (
        sp.csr_array((np.ones(points), (of_point, 3 * of_point + kind)), shape=(points, 3 * points))
        for kind in range(3)
    )
    balance = sp.hstack([wall.B, sp.eye_array(rows), -sp.eye_array(rows)])
    bounds = [(0, most), (None, None), (None, None)] * points + [(0, None)] * (2 * rows)
    if inside:  # shears are sums of corners, their shares at most μ n
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
    for presolve in (True, False):  # which calls some of these, of costs that are sums of sizes, unbounded
        options = TIGHT | {"presolve": presolve}
        found = linprog(cost, limits, np.zeros(limits.shape[0]), balance, loads, bounds, options=options)
        if found.status == 0:
            break
    if found.status != 0:
        raise ArithmeticError(found.message)
    return float(found.fun), found.x[: 3 * points].reshape(points, 3)

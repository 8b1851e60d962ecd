"""Do blocks in space stand? By faces that touch, and by linear programs with polygons for circles.

Nothing of the package is used but the corners and faces that a scene gives.
"""

import itertools

import numpy as np
import scipy.sparse as sp
from scipy.optimize import linprog
from space.boxes import Contacts, Pushed, pushed

import masonry_opt as mo

#: Sides round each cone to begin with, and programs with ever more of them.
SIDES, MOST = 96, 20
#: The least that HiGHS takes.
TIGHT = {"primal_feasibility_tolerance": 1e-10, "dual_feasibility_tolerance": 1e-10}
SMALL_ENTRY = 1e-8
#: Distance at which points are one, over lengths near one.
NEAR = 1e-9


def shapes_of(scene: mo.Scene) -> list[tuple[np.ndarray, list[list[int]]]]:
    """Corners and faces, counter-clockwise seen from outside, of convex blocks."""
    shapes = []
    for block in scene.blocks:
        if block.box is None:
            shapes.append((np.array(block.vertices), block.faces))
        else:
            corners = np.array(list(itertools.product(*block.box)))
            faces = [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]]
            shapes.append((corners, faces))
    return shapes


def dead_load(scene: mo.Scene) -> Pushed:
    """Statics of the blocks under their weights alone, of unit weight per volume as blocks give it."""
    shapes = shapes_of(scene)
    volume, centroid = zip(*(_solid(*shape) for shape in shapes), strict=True)
    down = np.array(scene.gravity) / np.linalg.norm(scene.gravity)
    weight = np.array(volume) * [block.unit_weight or 0.0 for block in scene.blocks]
    dead = np.column_stack([np.outer(weight, down), np.zeros((len(shapes), 3))])
    fixed = np.array([block.fixed for block in scene.blocks])
    return pushed(_contacts(shapes, fixed), np.array(centroid), fixed, dead, 0 * dead)


def out_of_balance(
    wall: Pushed, friction: float, enough: float, too_much: float, most: float
) -> tuple[float, float]:
    """Bounds of the least Σ|B q + dead| of forces within friction, until the upper one is ``enough`` or the
    lower one ``too_much``: by polygons inside the circles of friction, with normal forces up to ``most``, and
    round them, with any, which get a corner, and a side, more where the shears of either point to."""
    point = np.repeat(np.arange(len(wall.area)), SIDES)
    angle = np.tile(2 * np.pi * np.arange(SIDES) / SIDES, len(wall.area))
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
    wall: Pushed, friction: float, point: np.ndarray, angle: np.ndarray, most: float, inside: bool
) -> tuple[float, np.ndarray]:
    """The least, and forces (points, 3) that leave it; corners or sides of the polygons at these angles."""
    points, rows, sides = len(wall.area), len(wall.dead), len(point)
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


def _solid(corners: np.ndarray, faces: list[list[int]]) -> tuple[float, np.ndarray]:
    """Volume and centroid, from tetrahedra between the middle and triangles of the faces."""
    middle, volume, moment = corners.mean(axis=0), 0.0, np.zeros(3)
    for face in faces:
        for one, other in itertools.pairwise(face[1:]):
            tetrahedron = corners[[face[0], one, other]]
            size = np.linalg.det(tetrahedron - middle) / 6
            volume += size
            moment += size * (tetrahedron.sum(axis=0) + middle) / 4
    return volume, moment / volume


def _contacts(shapes: list[tuple[np.ndarray, list[list[int]]]], fixed: np.ndarray) -> Contacts:
    """The corners of each polygon that faces of two blocks, one of which can move, share."""
    first, second, at, frame = [], [], [], []
    for one, other in itertools.combinations(range(len(shapes)), 2):
        if fixed[one] and fixed[other]:
            continue
        for mine, theirs in itertools.product(_faces(*shapes[one]), _faces(*shapes[other])):
            normal = _normal(mine)
            if normal @ _normal(theirs) > -1 + NEAR or np.abs((theirs - mine[0]) @ normal).max() > NEAR:
                continue
            shared = _clipped(theirs[::-1], mine, normal)
            if len(shared) > 2:
                along = np.cross(normal, np.eye(3)[np.abs(normal).argmin()])
                along /= np.linalg.norm(along)
                for point in shared:
                    first.append(one)
                    second.append(other)
                    at.append(point)
                    frame.append([normal, along, np.cross(normal, along)])
    return Contacts(np.array(first), np.array(second), np.array(at), np.array(frame), np.ones(len(at)))


def _faces(corners: np.ndarray, faces: list[list[int]]) -> list[np.ndarray]:
    return [corners[face] for face in faces]


def _normal(polygon: np.ndarray) -> np.ndarray:
    """Unit normal of a plane convex polygon, by Newell's sum."""
    area = np.cross(polygon - polygon[0], np.roll(polygon, -1, axis=0) - polygon[0]).sum(axis=0)
    return area / np.linalg.norm(area)


def _clipped(polygon: np.ndarray, by: np.ndarray, normal: np.ndarray) -> list[np.ndarray]:
    """What of a convex polygon lies within another in its plane (Sutherland & Hodgman), each corner once."""
    points = list(polygon)
    for start, end in zip(by, np.roll(by, -1, axis=0), strict=True):
        inward = np.cross(normal, end - start)
        inward /= np.linalg.norm(inward)
        height = [float((point - start) @ inward) for point in points]
        kept = []
        for index, (point, level) in enumerate(zip(points, height, strict=True)):
            before = height[index - 1]
            if min(level, before) < -NEAR and max(level, before) > NEAR:
                kept.append(points[index - 1] + (point - points[index - 1]) * before / (before - level))
            if level >= -NEAR:
                kept.append(point)
        points = kept
    return [p for i, p in enumerate(points) if np.linalg.norm(p - points[i - 1]) > NEAR] if points else []

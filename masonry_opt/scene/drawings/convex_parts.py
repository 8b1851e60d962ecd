"""Polyhedra with notches and holes, cut into convex parts."""

from typing import NamedTuple

import numpy as np
import shapely
from scipy.spatial import ConvexHull, QhullError

from masonry_opt.scene.drawings.meshes import Mesh, MeshSolid, Side, across, first_near, polyhedron
from masonry_opt.scene.outlines import convex_pieces
from masonry_opt.scene.rows import bounds, dots
from masonry_opt.scene.space.faces import place

_MOST_PARTS = 1000  #: Of one block: more are of a curved surface, whose contacts nobody could solve for.
_EXACT = 1e-3  #: Share of the tolerance within which triangles of a hull are of one plane for certain.
_THIN_PARTS = 1e-3  #: Share of a block's volume that thin parts may leave out: 0.03 % of a curved one.
_SQUARE = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]])
_UNIT_BOX = [np.insert(_SQUARE, axis, at, axis=1) for axis in range(3) for at in (0, 1)]


class _Pieces(NamedTuple):
    """Convex pieces of sides in a cell: corners of each, shape (corners, 3), and the numbers of the sides."""

    rings: list[np.ndarray]
    side: np.ndarray

    def heights(self, base: np.ndarray, normal: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Least and largest height of each piece over planes, shape (pieces, planes) each."""
        over = np.concatenate(self.rings) @ normal.T - dots(base, normal)
        piece = np.repeat(np.arange(len(self.rings)), list(map(len, self.rings)))
        return bounds(piece, over, len(self.rings))


def convex_parts(block: MeshSolid, tolerance: float) -> list[MeshSolid]:
    """Convex polyhedra that make up a closed one.

    Space is cut along the planes of sides, each cell along those of the sides in it, until no cell has a side
    inside: it is then full or empty (binary space partition: Fuchs, Kedem and Naylor 1980). Sides that cut
    off empty space alone come first, then those that cut fewest others. Parts thinner than the tolerance are
    left out. Of several closed surfaces, which may touch, there are those of all.

    Raises ValueError if the sides do not close or cross, or there are too many parts, or none.
    """
    sides = [side for side in block.sides if side.width > tolerance]
    base, normal = np.array([(side.base, side.normal) for side in sides]).reshape(-1, 2, 3).swapaxes(0, 1)
    corners = block.points[np.unique([one for side in sides for ring in side.rings for one in ring])]
    low, high = corners.min(axis=0), corners.max(axis=0)
    low, high = low - (high - low), high + (high - low)
    cell = [low + face * (high - low) for face in _UNIT_BOX]
    waiting = [(_pieces(block.points, sides, tolerance), cell)]
    found: list[MeshSolid] = []
    while waiting:
        pieces, cell = waiting.pop()
        number = _best(pieces, base, normal, tolerance)
        halves = _divided(pieces, base[number], normal[number], tolerance)
        # Sides in the plane that look the other way: where closed surfaces touch, both halves are full.
        within = np.setdiff1d(pieces.side, np.concatenate([half.side for half in halves]))
        ahead = (base[within] - base[number]) @ normal[number] > -_EXACT * tolerance
        touching = bool((ahead & (normal[within] @ normal[number] < 0)).any())
        for half, sign, full in zip(halves, (-1.0, 1.0), (touching, True), strict=True):
            own = _clipped(cell, base[number], sign * normal[number]) if half.rings or full else []
            if half.rings:
                waiting.append((half, own))
            elif part := _part(own, tolerance):
                found.append(part)
        if len(found) + len(waiting) > _MOST_PARTS:
            raise ValueError(f"is not convex, and needs more than {_MOST_PARTS} convex parts: simplify it")
    if not found:
        raise ValueError("has no volume: give the faces of a solid, all outwards")
    off, edge = abs(sum(part.volume for part in found) - block.volume), block.unclosed()
    rounding = tolerance * sum(side.area for side in block.sides)
    if edge is not None and off > rounding:
        one, other = map(place, edge)
        raise ValueError(f"is not closed at its edge from {one} to {other}: give each edge in two faces")
    if off > _THIN_PARTS * abs(block.volume) + rounding:
        raise ValueError("has faces that cross or lie in one another: make one closed surface of them")
    return found


def _pieces(points: np.ndarray, sides: list[Side], tolerance: float) -> _Pieces:
    rings: list[np.ndarray] = []
    numbers: list[int] = []
    for number, side in enumerate(sides):
        outer, *holes = side.flat(points)
        try:
            convex = convex_pieces(shapely.Polygon(outer, holes), tolerance)
        except shapely.errors.GEOSException:
            raise ValueError("has a face that crosses itself: give its corners in order round it") from None
        rings += [side.base + piece @ across(side.normal) for piece in convex]
        numbers += [number] * len(convex)
    return _Pieces(rings, np.array(numbers, dtype=int))


def _best(pieces: _Pieces, base: np.ndarray, normal: np.ndarray, tolerance: float) -> int:
    """The side to cut along."""
    planes = np.unique(pieces.side)
    low, high = pieces.heights(base[planes], normal[planes])
    ahead, behind = high > tolerance, low < -tolerance
    cut, within = (ahead & behind).sum(axis=0), (~ahead & ~behind).sum(axis=0)
    return int(planes[np.lexsort((-within, cut, ahead.any(axis=0)))[0]])


def _divided(pieces: _Pieces, base: np.ndarray, normal: np.ndarray, tolerance: float) -> list[_Pieces]:
    """The pieces in front of a plane and behind it, without those in it."""
    low, high = (bound[:, 0] for bound in pieces.heights(base[None], normal[None]))
    ahead, behind = high > tolerance, low < -tolerance

    def half(within: np.ndarray, beyond: np.ndarray, normal: np.ndarray) -> _Pieces:
        own = ((pieces.rings[number], beyond[number]) for number in np.flatnonzero(within))
        rings = [_cut(ring, base, normal)[0] if crosses else ring for ring, crosses in own]
        return _Pieces(rings, pieces.side[within])

    return [half(ahead, behind, -normal), half(behind, ahead, normal)]


def _cut(ring: np.ndarray, base: np.ndarray, normal: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """A convex polygon behind a plane, and those of its corners that lie in the plane."""
    height = (ring - base) @ normal
    after, height_after = np.roll(ring, -1, axis=0), np.roll(height, -1)
    crosses = (height > 0) != (height_after > 0)
    share = np.divide(height, height - height_after, out=np.zeros_like(height), where=crosses)
    kept = np.column_stack([height <= 0, crosses]).ravel()
    every = np.stack([ring, ring + share[:, None] * (after - ring)], axis=1).reshape(-1, 3)
    in_plane = np.column_stack([height == 0, crosses]).ravel()
    return every[kept], every[in_plane]


def _clipped(cell: list[np.ndarray], base: np.ndarray, normal: np.ndarray) -> list[np.ndarray]:
    """Faces of a convex polyhedron behind a plane."""
    cuts = [_cut(ring, base, normal) for ring in cell]
    faces = [ring for ring, _ in cuts if len(ring) > 2]
    lid = np.concatenate([corners for _, corners in cuts])
    if len(lid) > 2 and len(faces) > 1:
        u, v = across(normal)
        around = lid - lid.mean(axis=0)
        faces.append(lid[np.argsort(np.arctan2(around @ v, around @ u))])
    return faces


def _part(cell: list[np.ndarray], tolerance: float) -> MeshSolid | None:
    """A cell as a polyhedron; None if it is thinner than the tolerance."""
    every = np.concatenate(cell) if cell else np.zeros((0, 3))
    corners = every[np.unique(first_near(every, tolerance / 4))]
    try:
        # Of corners that were joined: closed whatever they were rounded to.
        hull = ConvexHull(corners)
        mesh = Mesh("", corners, hull.simplices.tolist())
        shape = polyhedron(mesh, tolerance / 4)
        if not shape.convex(tolerance):  # narrow sides of several triangles, whose plane leans
            shape = polyhedron(mesh, _EXACT * tolerance)
    except (QhullError, ValueError):
        return None
    return shape if 2 * hull.volume > tolerance * hull.area else None

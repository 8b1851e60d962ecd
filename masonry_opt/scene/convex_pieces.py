"""Polygons with notches and holes, cut into convex pieces."""

from __future__ import annotations

import numpy as np
import shapely

from masonry_opt.scene.rows import steps_round

#: Sine of the angle by which a corner of a convex piece may turn inwards: rounding.
_STRAIGHT = 1e-9


def convex_pieces(polygon: shapely.Geometry, tolerance: float) -> list[np.ndarray]:
    """Convex polygons that make up a polygon or multipolygon, and have no other corners than it has.

    A constrained Delaunay triangulation, from which sides are left out, the longest first, where what they
    divide is convex without them (Hertel and Mehlhorn 1983: at most four times the fewest pieces). Pieces
    thinner than ``tolerance`` are dropped.

    Returns
    -------
    Corners of each, counter-clockwise, shape (corners, 2); neighbours share whole sides.
    """
    triangles = shapely.get_parts(shapely.constrained_delaunay_triangles(polygon))
    coordinates = shapely.get_coordinates(shapely.orient_polygons(triangles)).reshape(-1, 4, 2)[:, :3]
    corners, index = np.unique(coordinates.reshape(-1, 2), axis=0, return_inverse=True)
    rings = dict(enumerate(index.reshape(-1, 3).tolist()))
    piece_at = {side: piece for piece, ring in rings.items() for side in steps_round(ring)}
    inner = [(a, b) for a, b in piece_at if a < b and (b, a) in piece_at]
    for a, b in sorted(inner, key=lambda side: -np.hypot(*(corners[side[1]] - corners[side[0]]))):
        one, other = piece_at[a, b], piece_at[b, a]
        if one == other:
            continue
        left, right = _from(rings[one], b), _from(rings[other], a)
        # b ... a of the one piece, then what the other has between a and b.
        whole = left + right[1:-1]
        if not all(_convex(corners, whole, corner) for corner in (a, b)):
            continue
        rings[one] = whole
        piece_at |= dict.fromkeys(steps_round(rings.pop(other)), one)
    pieces = [corners[ring] for ring in rings.values()]
    drawn = ((piece, shapely.Polygon(piece)) for piece in pieces)
    return [piece for piece, polygon in drawn if 2 * polygon.area > tolerance * polygon.length]


def _from(ring: list[int], corner: int) -> list[int]:
    at = ring.index(corner)
    return ring[at:] + ring[:at]


def _convex(corners: np.ndarray, ring: list[int], corner: int) -> bool:
    """Whether a ring turns left at a corner, or goes straight on."""
    at = ring.index(corner)
    before, here, after = corners[[ring[at - 1], corner, ring[(at + 1) % len(ring)]]]
    (x0, y0), (x1, y1) = here - before, after - here
    size = np.hypot(x0, y0) * np.hypot(x1, y1)
    turn, ahead = x0 * y1 - y0 * x1, x0 * x1 + y0 * y1
    return bool(turn > _STRAIGHT * size or (turn >= -_STRAIGHT * size and ahead > 0))

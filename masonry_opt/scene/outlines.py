"""Polygons in a plane: sides, straight corners, slivers, what they have in common, and convex pieces."""

from collections.abc import Callable

import numpy as np
import shapely

from masonry_opt.scene.rows import steps_round

_MITRE = 100.0  #: Offsets beyond which mitres of offset outlines are cut off: no corner is sharper than 1°.
_STRAIGHT = 1e-9  #: Sine of the angle by which a corner of a convex piece may turn inwards: rounding.
GRID = 1e-3  #: Grid on which overlays that fail in floating point are done again, in tolerances.


def sides_of(polygons: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Sides of all outlines and holes of polygons: ends, shape (sides, 2) each, and polygons, rising."""
    rings, polygon = shapely.get_rings(polygons, return_index=True)
    corners, ring = shapely.get_coordinates(rings, return_index=True)
    inside = ring[:-1] == ring[1:]
    return corners[:-1][inside], corners[1:][inside], polygon[ring[:-1][inside]]


def without_straight_corners(polygons: np.ndarray, tolerance: float) -> np.ndarray:
    """The polygons, counter-clockwise, without corners within the tolerance of the outline without them."""
    return shapely.orient_polygons(shapely.simplify(polygons, tolerance, preserve_topology=False))


def without_slivers(polygons: np.ndarray, width: float) -> np.ndarray:
    """Polygons without what is narrower than a width; of a negative one, with gaps as narrow closed."""
    return _offset(_offset(polygons, -width / 2), width / 2)


def _offset(polygons: np.ndarray, by: float) -> np.ndarray:
    return shapely.buffer(polygons, by, join_style="mitre", mitre_limit=_MITRE)


def wide(pieces: np.ndarray, width: float) -> np.ndarray:
    """Which polygons have a place as wide as that, shape (pieces,)."""
    return ~shapely.is_empty(_offset(pieces, -width / 2))


def sound(operation: Callable[..., np.ndarray], *polygons: np.ndarray, grid: float) -> np.ndarray:
    """An overlay, on a grid where floating point fails, as it may in silence on nearly coincident sides."""
    polygons = tuple(map(valid, polygons))
    safe = operation(*polygons, grid_size=grid)
    try:
        exact = operation(*polygons)
    except shapely.errors.GEOSException:
        return safe
    around = sum(shapely.length(own) for own in (*polygons, safe))
    return np.where(np.abs(shapely.area(exact) - shapely.area(safe)) <= grid * around, exact, safe)


def valid(polygons: np.ndarray) -> np.ndarray:
    """The polygons, mended where outlines cross themselves, as offsets leave them by rounding."""
    crossed, mended = ~shapely.is_valid(polygons), polygons.copy()
    mended[crossed] = shapely.orient_polygons(shapely.buffer(polygons[crossed], 0))
    return mended


def common_to(one: np.ndarray, other: np.ndarray, tolerance: float) -> tuple[np.ndarray, np.ndarray]:
    """What pairs of polygons have in common, in pieces, and the pairs, rising."""
    low1, high1, low2, high2 = (at for own in (one, other) for at in np.split(shapely.bounds(own), 2, axis=1))
    near = np.flatnonzero((np.minimum(high1, high2) - np.maximum(low1, low2)).min(axis=1) > tolerance)
    whole = sound(shapely.intersection, one[near], other[near], grid=GRID * tolerance)
    pieces, number = shapely.get_parts(whole, return_index=True)
    solid = shapely.get_type_id(pieces) == shapely.GeometryType.POLYGON
    return pieces[solid], near[number[solid]]


def convex_pieces(polygon: shapely.Geometry, tolerance: float) -> list[np.ndarray]:
    """Convex polygons that make up a polygon or multipolygon, and have no other corners than it has: corners
    of each, counter-clockwise, shape (corners, 2); neighbours share whole sides.

    A constrained Delaunay triangulation, from which sides are left out, the longest first, where what they
    divide is convex without them (Hertel and Mehlhorn 1983: at most four times the fewest pieces). Pieces
    thinner than ``tolerance`` are dropped.
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
    pieces = [shapely.Polygon(corners[ring]) for ring in rings.values()]
    thick = (piece for piece in pieces if 2 * piece.area > tolerance * piece.length)
    return [shapely.get_coordinates(piece)[:-1] for piece in thick]


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

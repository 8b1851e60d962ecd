"""Operate on polygons: sides, straight corners, slivers, intersections and convex pieces."""

from collections.abc import Callable

import numpy as np
import shapely

from masonry_opt.scene.rows import steps_round

#: Largest length of a mitre at an offset corner, relative to the offset. Longer mitres, at corners sharper
#: than about 1°, are cut off.
_MITRE_LIMIT = 100.0

#: Sine of the largest angle by which a convex piece may turn inwards at a corner because of rounding.
_INWARD_TOLERANCE = 1e-9

#: Grid size, relative to the tolerance, to which corners are rounded if an intersection or union of polygons
#: fails in floating-point arithmetic. A coarser grid moves corners further.
GRID = 1e-3


def sides_of(polygons: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return the sides of all outlines and holes of polygons.

    The results are the start and the end of each side, shape (sides, 2) each, and the index of the polygon of
    each side, in ascending order.
    """
    rings, polygon = shapely.get_rings(polygons, return_index=True)
    corners, ring = shapely.get_coordinates(rings, return_index=True)
    is_side = ring[:-1] == ring[1:]
    return corners[:-1][is_side], corners[1:][is_side], polygon[ring[:-1][is_side]]


def without_straight_corners(polygons: np.ndarray, tolerance: float) -> np.ndarray:
    """Return the polygons counter-clockwise, without corners in the middle of straight sides.

    A corner is removed if it lies within the tolerance of the outline without this corner.
    """
    return shapely.orient_polygons(shapely.simplify(polygons, tolerance, preserve_topology=False))


def without_slivers(polygons: np.ndarray, width: float) -> np.ndarray:
    """Return the polygons without parts that are narrower than a given width.

    A negative width closes gaps that are narrower than its absolute value.
    """
    return _offset(_offset(polygons, -width / 2), width / 2)


def _offset(polygons: np.ndarray, distance: float) -> np.ndarray:
    """Return the polygons with their outlines offset (moved outwards) by a distance."""
    return shapely.buffer(polygons, distance, join_style="mitre", mitre_limit=_MITRE_LIMIT)


def wide(pieces: np.ndarray, width: float) -> np.ndarray:
    """Return a mask of the polygons that are somewhere at least ``width`` wide, shape (polygons,)."""
    return ~shapely.is_empty(_offset(pieces, -width / 2))


def sound(operation: Callable[..., np.ndarray], *polygons: np.ndarray, grid: float) -> np.ndarray:
    """Return the result of an operation on polygons, rounded to a grid if the exact operation fails.

    Floating-point arithmetic can fail silently at nearly coincident sides. Such a failure is detected if the
    area differs from the area of the result on the grid.
    """
    polygons = tuple(map(valid, polygons))
    rounded_result = operation(*polygons, grid_size=grid)
    try:
        exact_result = operation(*polygons)
    except shapely.errors.GEOSException:
        return rounded_result
    perimeter = sum(shapely.length(polygon) for polygon in (*polygons, rounded_result))
    return np.where(
        np.abs(shapely.area(exact_result) - shapely.area(rounded_result)) <= grid * perimeter,
        exact_result,
        rounded_result,
    )


def valid(polygons: np.ndarray) -> np.ndarray:
    """Return the polygons, repaired if their outlines cross themselves.

    Offsets may produce outlines that cross themselves.
    """
    is_crossed = ~shapely.is_valid(polygons)
    repaired = polygons.copy()
    repaired[is_crossed] = shapely.orient_polygons(shapely.buffer(polygons[is_crossed], 0))
    return repaired


def common_to(first: np.ndarray, second: np.ndarray, tolerance: float) -> tuple[np.ndarray, np.ndarray]:
    """Intersect pairs of polygons; return all pieces, and for each piece the index of its pair.

    The indices are in ascending order.
    """
    low1, high1 = np.split(shapely.bounds(first), 2, axis=1)
    low2, high2 = np.split(shapely.bounds(second), 2, axis=1)
    near_pairs = np.flatnonzero((np.minimum(high1, high2) - np.maximum(low1, low2)).min(axis=1) > tolerance)
    intersections = sound(shapely.intersection, first[near_pairs], second[near_pairs], grid=GRID * tolerance)
    pieces, number = shapely.get_parts(intersections, return_index=True)
    is_polygon = shapely.get_type_id(pieces) == shapely.GeometryType.POLYGON
    return pieces[is_polygon], near_pairs[number[is_polygon]]


def convex_pieces(polygon: shapely.Geometry, tolerance: float) -> list[np.ndarray]:
    """Divide a polygon or multipolygon into convex polygons without adding corners.

    The corners of each piece are counter-clockwise, shape (corners, 2). Neighbours share whole sides. Pieces
    thinner than ``tolerance`` are dropped.

    The algorithm of Hertel and Mehlhorn (1983) starts from a constrained Delaunay triangulation. It removes
    each side whose removal leaves a convex piece, the longest side first. The result has at most four times
    the least number of pieces.
    """
    triangles = shapely.get_parts(shapely.constrained_delaunay_triangles(polygon))
    coordinates = shapely.get_coordinates(shapely.orient_polygons(triangles)).reshape(-1, 4, 2)[:, :3]
    corners, index = np.unique(coordinates.reshape(-1, 2), axis=0, return_inverse=True)
    rings = dict(enumerate(index.reshape(-1, 3).tolist()))
    piece_at = {side: piece for piece, ring in rings.items() for side in steps_round(ring)}
    inner_sides = [(start, end) for start, end in piece_at if start < end and (end, start) in piece_at]
    for start, end in sorted(inner_sides, key=lambda side: -np.hypot(*(corners[side[1]] - corners[side[0]]))):
        first, second = piece_at[start, end], piece_at[end, start]
        if first == second:
            continue
        # The merged ring follows the first ring from `end` to `start`, then the second ring back to `end`.
        merged_ring = _rotate(rings[first], end) + _rotate(rings[second], start)[1:-1]
        if not all(_is_convex(corners, merged_ring, corner) for corner in (start, end)):
            continue
        rings[first] = merged_ring
        piece_at |= dict.fromkeys(steps_round(rings.pop(second)), first)
    pieces = [shapely.Polygon(corners[ring]) for ring in rings.values()]
    thick_pieces = (piece for piece in pieces if 2 * piece.area > tolerance * piece.length)
    return [shapely.get_coordinates(piece)[:-1] for piece in thick_pieces]


def _rotate(ring: list[int], corner: int) -> list[int]:
    """Return the corners of a ring in order, rotated cyclically to start at a given corner."""
    position = ring.index(corner)
    return ring[position:] + ring[:position]


def _is_convex(corners: np.ndarray, ring: list[int], corner: int) -> bool:
    """Return True if a counter-clockwise ring turns left or goes straight on at the given corner."""
    position = ring.index(corner)
    previous_point, point, next_point = corners[
        [ring[position - 1], corner, ring[(position + 1) % len(ring)]]
    ]
    (x0, y0), (x1, y1) = point - previous_point, next_point - point
    size = np.hypot(x0, y0) * np.hypot(x1, y1)
    turn, advance = x0 * y1 - y0 * x1, x0 * x1 + y0 * y1
    turns_left = turn > _INWARD_TOLERANCE * size
    goes_straight_on = turn >= -_INWARD_TOLERANCE * size and advance > 0
    return bool(turns_left or goes_straight_on)

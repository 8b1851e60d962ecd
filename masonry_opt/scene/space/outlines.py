"""Polygons in a plane: corners that make no difference, cracks and slivers, what polygons have in common."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import shapely

#: Mitres of offset outlines are cut off beyond so many offsets: sharper corners than 1° are none.
_MITRE = 100.0

#: Grid on which overlays that fail in floating point are done again, in tolerances.
GRID = 1e-3


def without_straight_corners(polygons: np.ndarray, tolerance: float) -> np.ndarray:
    """The polygons, counter-clockwise, holes clockwise, without corners that lie within the tolerance of the
    outline without them; empty ones where nothing is left."""
    return shapely.orient_polygons(shapely.simplify(polygons, tolerance, preserve_topology=False))


def without_cracks(polygons: np.ndarray, width: float) -> np.ndarray:
    """Polygons with gaps narrower than a width closed."""
    return _offset(_offset(polygons, width / 2), -width / 2)


def without_slivers(polygons: np.ndarray, width: float) -> np.ndarray:
    """Polygons without what is narrower than a width."""
    return _offset(_offset(polygons, -width / 2), width / 2)


def _offset(polygons: np.ndarray, by: float) -> np.ndarray:
    return shapely.buffer(polygons, by, join_style="mitre", mitre_limit=_MITRE)


def wide(pieces: np.ndarray, width: float) -> np.ndarray:
    """Which polygons have a place as wide as that, shape (pieces,)."""
    area, around = shapely.area(pieces), shapely.length(pieces)
    # The largest circle inside a convex piece has a radius from area / perimeter to twice that, and none is
    # larger than twice that.
    mean = np.divide(2 * area, around, out=np.zeros_like(area), where=around > 0)
    found = mean >= width
    doubtful = ~found & (2 * mean >= width)
    found[doubtful] = ~shapely.is_empty(_offset(pieces[doubtful], -width / 2))
    return found


def sound(operation: Callable[..., np.ndarray], *polygons: np.ndarray, grid: float) -> np.ndarray:
    """An overlay of polygons, on a grid where floating point fails: nearly coincident sides may leave nothing
    of the whole without an error."""
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
    mended = shapely.orient_polygons(shapely.buffer(polygons, 0))
    return np.where(shapely.is_valid(polygons), polygons, mended)


def common_to(
    one: np.ndarray, other: np.ndarray, convex: np.ndarray, tolerance: float
) -> tuple[np.ndarray, np.ndarray]:
    """The polygons that pairs of polygons have in common, in pieces, and the number of the pair of each,
    rising; ``convex`` says of which pairs both are, shape (pairs,)."""
    whole = np.full(len(one), shapely.Polygon())
    whole[~convex] = sound(shapely.intersection, one[~convex], other[~convex], grid=GRID * tolerance)
    corners = np.maximum(shapely.get_num_coordinates(one), shapely.get_num_coordinates(other))
    # So many at a time as need arrays of one size.
    size = np.ceil(np.log2(np.maximum(corners, 1))).astype(int)
    for most in np.unique(size[convex]):
        some = np.flatnonzero(convex & (size == most))
        whole[some] = _clipped(one[some], other[some])
    pieces, number = shapely.get_parts(whole, return_index=True)
    solid = shapely.get_type_id(pieces) == shapely.GeometryType.POLYGON
    return pieces[solid], number[solid]


def _clipped(one: np.ndarray, other: np.ndarray) -> np.ndarray:
    """Convex polygons, each cut along the sides of another (Sutherland and Hodgman 1974), which coincident
    sides do not disturb; empty where nothing is left."""
    (points, count), (cutting, sides) = _padded(one), _padded(other)
    rows = np.arange(len(one))
    for side in range(cutting.shape[1]):
        cuts = side < sides
        start = cutting[rows, np.minimum(side, sides - 1)]
        along = cutting[rows, (side + 1) % sides] - start
        beside = points - start[:, None]
        left = along[:, None, 0] * beside[..., 1] - along[:, None, 1] * beside[..., 0]
        slots = np.arange(points.shape[1])
        valid = slots < count[:, None]
        inside = (left >= 0) | ~cuts[:, None]
        after = np.where(slots + 1 < count[:, None], slots + 1, 0)
        left_after, inside_after = (np.take_along_axis(own, after, axis=1) for own in (left, inside))
        crossing = valid & (inside != inside_after)
        way = np.take_along_axis(points, after[..., None], axis=1) - points
        share = np.divide(left, left - left_after, out=np.zeros_like(left), where=crossing)
        # Each corner that stays, then the point where the side from it to the next is cut.
        kept = np.stack([valid & inside, crossing], axis=2).reshape(len(one), -1)
        every = np.stack([points, points + share[..., None] * way], axis=2).reshape(len(one), -1, 2)
        count = kept.sum(axis=1)
        first = np.argsort(~kept, axis=1, kind="stable")[:, : max(int(count.max(initial=0)), 1)]
        points = np.take_along_axis(every, first[..., None], axis=1)
    left_over = np.flatnonzero(count >= 3)
    valid = np.arange(points.shape[1]) < count[left_over, None]
    found = np.full(len(one), shapely.Polygon())
    owner = np.repeat(np.arange(len(left_over)), count[left_over])
    found[left_over] = shapely.polygons(shapely.linearrings(points[left_over][valid], indices=owner))
    return found


def _padded(polygons: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Corners of polygons without holes, counter-clockwise, shape (polygons, most corners, 2), and their
    number."""
    points, polygon = shapely.get_coordinates(shapely.orient_polygons(polygons), return_index=True)
    count = np.bincount(polygon, minlength=len(polygons)) - 1  # rings are closed
    slot = np.arange(len(polygon)) - np.repeat(np.cumsum(count + 1) - count - 1, count + 1)
    kept = slot < count[polygon]
    padded = np.zeros((len(polygons), int(count.max(initial=0)), 2))
    padded[polygon[kept], slot[kept]] = points[kept]
    return padded, count

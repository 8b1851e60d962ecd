"""Polygons in a plane: corners that make no difference, cracks between pieces, slivers."""

from __future__ import annotations

import numpy as np
import shapely

from masonry_opt.scene.combinations import ranges
from masonry_opt.scene.rows import sums

#: Mitres of offset outlines are cut off beyond so many offsets: sharper corners than 1° are none.
_MITRE = 100.0


def without_straight_corners(polygons: np.ndarray, tolerance: float) -> np.ndarray:
    """The polygons, counter-clockwise, holes clockwise, without corners that lie within the tolerance of the
    outline without them; empty ones where nothing is left."""
    rings, polygon = shapely.get_rings(polygons, return_index=True)
    points, ring = shapely.get_coordinates(rings, return_index=True)
    closing = np.diff(ring, append=ring[-1:] + 1) != 0
    points, ring = points[~closing], ring[~closing]
    count = np.bincount(ring, minlength=len(rings))
    # A ring's corner farthest from its middle is surely one that no straight side runs through.
    middle = sums(ring, points, len(rings)) / count[:, None]
    far = np.hypot(*(points - middle[ring]).T)
    first = np.cumsum(count) - count
    most = np.maximum.reduceat(far, first)
    candidates = np.flatnonzero(far >= most[ring] * (1 - 1e-9))
    starts = candidates[np.unique(ring[candidates], return_index=True)[1]]
    at = rolled(count, starts - first, closed=True)
    lines = shapely.linestrings(points[at], indices=np.repeat(np.arange(len(rings)), count + 1))
    lines = shapely.simplify(lines, tolerance, preserve_topology=False)
    kept = shapely.get_num_coordinates(lines) >= 4
    is_hole = np.diff(polygon, prepend=-1) == 0
    shells = np.zeros(len(polygons), dtype=bool)
    shells[polygon[kept & ~is_hole]] = True
    kept &= shells[polygon]
    found = np.full(len(polygons), shapely.Polygon())
    points, ring = shapely.get_coordinates(lines[kept], return_index=True)
    if len(points):
        number, of_ring = np.unique(polygon[kept], return_inverse=True)
        found[number] = shapely.polygons(shapely.linearrings(points, indices=ring), indices=of_ring)
    return shapely.orient_polygons(found)


def rolled(count: np.ndarray, by: np.ndarray, *, closed: bool = False) -> np.ndarray:
    """Numbers of the corners of rings of so many corners, one ring after the other, each from its corner no.
    ``by`` on; ``closed`` ones end with the corner that they begin with."""
    first = np.cumsum(count) - count
    length = count + closed
    step = ranges(np.zeros_like(count), length)
    return np.repeat(first, length) + (step + np.repeat(by, length)) % np.repeat(count, length)


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

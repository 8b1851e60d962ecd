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
    found, wrong = polygons.copy(), ~shapely.is_valid(polygons)
    found[wrong] = shapely.orient_polygons(shapely.buffer(polygons[wrong], 0))
    return found


def common_to(one: np.ndarray, other: np.ndarray, tolerance: float) -> tuple[np.ndarray, np.ndarray]:
    """The polygons that pairs of polygons have in common, in pieces, and the number of the pair of each,
    rising."""
    whole = sound(shapely.intersection, one, other, grid=GRID * tolerance)
    pieces, number = shapely.get_parts(whole, return_index=True)
    solid = shapely.get_type_id(pieces) == shapely.GeometryType.POLYGON
    return pieces[solid], number[solid]

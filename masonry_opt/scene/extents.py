"""Corners of blocks, boxes and hulls round them, in the plane and in space."""

from __future__ import annotations

import numpy as np
import shapely
from scipy.optimize import nnls

from masonry_opt.scene.geometry import Geometry
from masonry_opt.scene.space.shapes import Shapes

#: Weight of the condition that the corners' shares in the nearest point of their hull sum to one.
_WHOLE = 1e6


def corners(shapes: Geometry | Shapes) -> tuple[np.ndarray, np.ndarray]:
    """Corners of all blocks, relative to the shapes' origin, shape (corners, 2) or (corners, 3), and the
    block of each, rising."""
    if isinstance(shapes, Geometry):
        points, block = shapely.get_coordinates(shapes.polygons, return_index=True)
        return points, block
    return shapes.parts.points, shapes.parts.block[shapes.parts.of_point]


def boxes(shapes: Geometry | Shapes) -> tuple[np.ndarray, np.ndarray]:
    """Least and largest coordinates of each block, shape (blocks, 2) or (blocks, 3) each."""
    points, block = corners(shapes)
    first = np.searchsorted(block, np.arange(len(shapes.centroid)))
    return np.minimum.reduceat(points, first), np.maximum.reduceat(points, first)


def outside(shapes: Geometry | Shapes, blocks: np.ndarray, points: np.ndarray) -> np.ndarray:
    """How far points, relative to the shapes' origin, lie outside of the convex hulls of blocks, one each."""
    if isinstance(shapes, Geometry):
        hulls = shapely.convex_hull(shapes.polygons[blocks])
        distance: np.ndarray = shapely.distance(hulls, shapely.points(points))
        return distance
    every, block = corners(shapes)
    return np.array(
        [_from_hull(every[block == one] - at) for one, at in zip(blocks, points, strict=True)], dtype=float
    )


def _from_hull(beside: np.ndarray) -> float:
    """Distance of the origin from the convex hull of points: of the shares of each that come nearest."""
    size = float(np.abs(beside).max()) or 1.0
    rows = np.vstack([beside.T / size, np.full(len(beside), _WHOLE)])
    share, _ = nnls(rows, np.append(np.zeros(beside.shape[1]), _WHOLE))
    return float(np.hypot.reduce(share @ beside))

"""Winding numbers: decide whether points are inside a closed surface."""

import numpy as np

from masonry_opt.scene.drawings.meshes import MeshSolid
from masonry_opt.scene.rows import dots, lengths


def fan_triangles(block: MeshSolid) -> np.ndarray:
    """Return triangles that cover the surface of a block, shape (triangles, 3 corners, 3 coordinates).

    Each edge of a side forms one triangle with the base point of the side. Triangles outside a side, and in
    the holes of a side, cancel each other.
    """
    return np.concatenate([fan(side.base, block.points[ring]) for side in block.sides for ring in side.rings])


def fan(apex: np.ndarray, ring: np.ndarray) -> np.ndarray:
    """Return the triangles between a point and the edges of a polygon, shape (corners, 3, 3)."""
    return np.stack([np.broadcast_to(apex, ring.shape), ring, np.roll(ring, -1, axis=0)], axis=1)


def winding_number(point: np.ndarray, triangles: np.ndarray) -> float:
    """Return the winding number of a closed surface of triangles around a point: 1 inside, 0 outside.

    The winding number is the solid angle of the surface divided by 4π (Jacobson, Kavan and Sorkine-Hornung
    2013). The solid angle of a triangle is computed by the formula of van Oosterom and Strackee (1983).
    """
    a, b, c = np.moveaxis(triangles - point, 1, 0)
    length_a, length_b, length_c = lengths(a), lengths(b), lengths(c)
    determinant = dots(a, np.cross(b, c))
    denominator = length_a * length_b * length_c
    denominator += dots(a, b) * length_c + dots(b, c) * length_a + dots(c, a) * length_b
    return float(np.arctan2(determinant, denominator).sum() / (2 * np.pi))

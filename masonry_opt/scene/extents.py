"""Corners of blocks, boxes and hulls round them, and middles of joints, in the plane and in space."""

from __future__ import annotations

import numpy as np
import shapely
from scipy.optimize import nnls

from masonry_opt.scene.contact import Joints
from masonry_opt.scene.geometry import Geometry
from masonry_opt.scene.space.contacts import Contacts
from masonry_opt.scene.space.frames import dots
from masonry_opt.scene.space.shapes import Shapes
from masonry_opt.scene.space.surfaces import following, sums

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


def middles(joints: Joints | Contacts) -> np.ndarray:
    """Middle of each joint, in space the centroid of its area, relative to the shapes' origin."""
    if isinstance(joints, Joints):
        return joints.middle
    rings = [ring for outline in joints.outline for ring in outline]
    owner = np.repeat(np.arange(len(joints.outline)), [len(outline) for outline in joints.outline])
    count = np.array([len(ring) for ring in rings])
    points, ring = np.concatenate(rings), np.repeat(np.arange(len(rings)), count)
    joint, joined = owner[ring], len(joints.outline)
    mean = sums(joint, points, joined) / np.bincount(joint)[:, None]
    # Triangles from the mean of the corners; holes count against the outline, however they turn.
    one, other = points - mean[joint], points[following(count)] - mean[joint]
    twice = dots(joints.normal[joint], np.cross(one, other))
    hole = np.append(False, owner[1:] == owner[:-1])
    twice *= (np.where(hole, -1.0, 1.0) * np.sign(np.bincount(ring, twice)))[ring]
    off = sums(joint, twice[:, None] * (one + other) / 3, joined)
    area = np.where(joints.area > 0, np.bincount(joint, twice), np.inf)
    return mean + off / area[:, None]

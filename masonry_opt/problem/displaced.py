"""Positions of points, forces and shapes after finite displacements of rigid blocks."""

from dataclasses import replace
from typing import Any

import numpy as np
import shapely

from masonry_opt.problem.loads import Forces
from masonry_opt.scene.geometry import Geometry
from masonry_opt.scene.rows import dots


def placed(points: np.ndarray, poses: np.ndarray) -> np.ndarray:
    """Return the displaced positions of points.

    Each pose is a rotation about the origin, followed by a translation.

    Parameters
    ----------
    points: Positions at rest, shape (..., 2), in space (..., 3).
    poses: (x, y, θ), shape (..., 3); in space a translation and a rotation vector, shape (..., 6).
    """
    return turned(points, poses) + poses[..., : points.shape[-1]]


def turned(vectors: np.ndarray, poses: np.ndarray) -> np.ndarray:
    """Rotate vectors by the rotation of each pose; the translation of the pose is not applied.

    Arrays have the shapes of ``placed``. In space, the rotation is computed by Rodrigues' formula.
    """
    if vectors.shape[-1] == 3:
        angle = np.linalg.norm(poses[..., 3:], axis=-1, keepdims=True)
        axis = poses[..., 3:] / np.where(angle > 0, angle, 1.0)
        across, along = np.cross(axis, vectors), (axis * vectors).sum(axis=-1, keepdims=True) * axis
        return np.asarray(along + np.cos(angle) * (vectors - along) + np.sin(angle) * across)
    cos, sin = np.cos(poses[..., 2]), np.sin(poses[..., 2])
    x, y = vectors[..., 0], vectors[..., 1]
    return np.stack([cos * x - sin * y, sin * x + cos * y], axis=-1)


def moved(forces: Forces, poses: np.ndarray) -> Forces:
    """Move the points of action of forces with the displaced blocks, and return the forces.

    The directions and sizes of the forces do not change. ``poses`` are the poses of the movable blocks, shape
    (b, 3), in space (b, 6).
    """
    return replace(forces, point=placed(forces.point, poses[forces.block]))


def displaced(shapes: Any, poses: np.ndarray) -> Any:
    """Return the displaced shapes of the blocks, in the plane or in space.

    ``poses`` has one pose for each block.
    """
    centroid = placed(shapes.centroid, poses)
    if isinstance(shapes, Geometry):
        corners, block = shapes.corners
        polygons = shapely.set_coordinates(shapes.polygons.copy(), placed(corners, poses[block]))
        return replace(shapes, polygons=polygons, centroid=centroid)
    parts, faces, frame = shapes.parts, shapes.faces, shapes.faces.frame
    blocks = parts.block[parts.of_point], parts.block[parts.of_plane], faces.block
    of_point, of_plane, of_face = (poses[own] for own in blocks)
    normal = turned(parts.normal, of_plane)
    offset = parts.offset + dots(normal, of_plane[:, :3])
    axes = {name: turned(getattr(frame, name), of_face) for name in ("u", "v", "normal")}
    frame = replace(frame, base=placed(frame.base, of_face), **axes)
    parts = replace(parts, points=placed(parts.points, of_point), normal=normal, offset=offset)
    return replace(shapes, parts=parts, faces=replace(faces, frame=frame), centroid=centroid)

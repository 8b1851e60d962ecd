"""Contact points in space as matrices: each joint's forces act at the corners of its polygon."""

from __future__ import annotations

import numpy as np
import scipy.sparse as sp

from masonry_opt.problem.faces import space
from masonry_opt.problem.matrices import Matrices
from masonry_opt.scene.contacts.joints import Joints
from masonry_opt.scene.space.shapes import Shapes

#: Sides of the polygon inside the cone of friction: associative load factors of corner walls are some .2 %
#: lower than by cones, loads to expect as much. (With 12 sides 1 %, with 16 .5 %; steps are as many.)
SIDES = 24


def matrices(joints: Joints, shapes: Shapes, movable: np.ndarray, length_unit: float) -> Matrices:
    """B with lengths in ``length_unit``: rows fx, fy, fz and moments about the centroid of each movable
    block; columns n of all contact points, then s along the joint's tangent, then t along normal × tangent.
    Forces act on the first block as they are, on the second reversed.

    Parameters
    ----------
    movable: indices into the scene's blocks, shape (b,).
    """
    joint, count = joints.joint, len(joints.joint)
    normal, tangent = joints.normal[joint], joints.tangent[joint]
    row_of = np.full(len(shapes.size), -1)
    row_of[movable] = np.arange(len(movable))
    rows, columns, values = [], [], []
    for of_joint, sign in ((joints.first, 1.0), (joints.second, -1.0)):
        block = of_joint[joint]
        arm = (joints.point - shapes.centroid[block]) / length_unit
        for kind, force in enumerate((normal, tangent, np.cross(normal, tangent))):
            entries = sign * np.concatenate([force, np.cross(arm, force)], axis=1)
            rows.append(6 * row_of[block][:, None] + np.arange(6))
            columns.append(np.broadcast_to((kind * count + np.arange(count))[:, None], entries.shape))
            values.append(entries)
    row, column, value = (np.concatenate(parts).ravel() for parts in (rows, columns, values))
    kept = (row >= 0) & (value != 0)
    B = sp.csr_array((value[kept], (row[kept], column[kept])), shape=(6 * len(movable), 3 * count))
    share = shares(joints, joint)
    usual = float(np.median(share[share > 0])) if share.any() else 1.0
    return Matrices(B, np.ones(count), length_unit, space(SIDES), np.where(share > 0, share / usual, 1.0))


def shares(joints: Joints, joint: np.ndarray) -> np.ndarray:
    """Length or area that each of the problem's joints stands for, an equal share of its joint's."""
    share: np.ndarray = (joints.extent / np.bincount(joint, minlength=len(joints.extent)))[joint]
    return share

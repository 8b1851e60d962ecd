"""Joints as matrices: their forces act about their middles, in space at the corners of their polygons."""

from __future__ import annotations

import numpy as np
import scipy.sparse as sp

from masonry_opt.problem.faces import space
from masonry_opt.problem.loads import moment_of
from masonry_opt.problem.matrices import Matrices
from masonry_opt.scene.contacts.joints import Joints
from masonry_opt.scene.extents import Extents

#: Sides of the polygon inside the cone of friction: associative load factors of corner walls are some .2 %
#: lower than by cones, loads to expect as much. (With 12 sides 1 %, with 16 .5 %; steps are as many.)
SIDES = 24


def joint_of(joints: Joints) -> np.ndarray:
    """Joint that each of the problem's joints is part of: itself, in space that of a contact point."""
    return np.arange(len(joints.first)) if joints.normal.shape[1] == 2 else joints.joint


def matrices(joints: Joints, shapes: Extents, movable: np.ndarray, length_unit: float) -> Matrices:
    """B with lengths in ``length_unit``: rows forces, then moments about the centroid of each movable block.
    Columns in the plane n and s of all joints, then m, which those without length do not carry; in space n of
    all contact points, then s along the joint's tangent, then t along normal × tangent. They act on the first
    block as they are, on the second reversed.

    Parameters
    ----------
    movable: indices into the scene's blocks, shape (b,).
    """
    joint = joint_of(joints)
    count, dimension = len(joint), joints.normal.shape[1]
    normal, tangent = joints.normal[joint], joints.tangent[joint]
    long = joints.extent > 0
    if dimension == 2:
        place, third, couple = joints.middle, np.zeros_like(normal), long.astype(float)
    else:
        place, third, couple = joints.point, np.cross(normal, tangent), np.zeros(3)
    of_block = 3 * (dimension - 1)
    row_of = np.full(len(shapes.size), -1)
    row_of[movable] = np.arange(len(movable))
    rows, columns, values = [], [], []
    for of_joint, sign in ((joints.first, 1.0), (joints.second, -1.0)):
        block = of_joint[joint]
        arm = (place - shapes.centroid[block]) / length_unit
        for kind, force in enumerate((normal, tangent, third)):
            moment = moment_of(arm, force) + (couple if kind == 2 else 0.0)
            entries = sign * np.column_stack([force, moment])
            rows.append(of_block * row_of[block][:, None] + np.arange(of_block))
            columns.append(np.broadcast_to((kind * count + np.arange(count))[:, None], entries.shape))
            values.append(entries)
    row, column, value = (np.concatenate(parts).ravel() for parts in (rows, columns, values))
    # Fixed blocks have no rows; exact zeros (axis-aligned joints) stay out of the pattern.
    kept = (row >= 0) & (value != 0)
    B = sp.csr_array((value[kept], (row[kept], column[kept])), shape=(of_block * len(movable), 3 * count))
    if dimension == 2:
        return Matrices(B, np.where(long, joints.extent / 2 / length_unit, 1.0), length_unit)
    share = shares(joints, joint)
    usual = float(np.median(share[share > 0])) if share.any() else 1.0
    return Matrices(B, np.ones(count), length_unit, space(SIDES), np.where(share > 0, share / usual, 1.0))


def shares(joints: Joints, joint: np.ndarray) -> np.ndarray:
    """Length or area that each of the problem's joints stands for, an equal share of its joint's."""
    share: np.ndarray = (joints.extent / np.bincount(joint, minlength=len(joints.extent)))[joint]
    return share

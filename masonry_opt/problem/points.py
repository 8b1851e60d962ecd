"""Joints as matrices: where they press, and along what they slide."""

from __future__ import annotations

import numpy as np
import scipy.sparse as sp

from masonry_opt.problem.faces import KINDS, PLANE, space
from masonry_opt.problem.loads import moment_of
from masonry_opt.problem.matrices import Matrices
from masonry_opt.scene.contacts.joints import Joints
from masonry_opt.scene.extents import Extents

#: Sides of the polygon inside the cone of friction: associative load factors of corner walls are some .2 %
#: lower than by cones, loads to expect as much. (With 12 sides 1 %, with 16 .5 %; steps are as many.)
SIDES = 24

#: Layouts by dimension.
_LAYOUTS = {2: lambda: PLANE, 3: lambda: space(SIDES)}


def matrices(joints: Joints, shapes: Extents, movable: np.ndarray, length_unit: float) -> Matrices:
    """B with lengths in ``length_unit``: rows forces, then moments about the centroid of each movable block.
    Columns are wrenches of unit forces: n₁ at the start of all joints, n₂ at their end, then s along their
    tangent; in space n at all contact points, then s along the joint's tangent, then t along normal ×
    tangent. They act on the first block as they are, on the second reversed.

    Parameters
    ----------
    movable: indices into the scene's blocks, shape (b,).
    """
    layout = _LAYOUTS[joints.point.shape[1]]()
    joint, at = layout.joint_of(joints), joints.point[layout.pressed(joints)]
    count, (normal, *tangents) = len(joint), joints.axes[:, joint]
    forces = [*((place, normal) for place in at), *((at.mean(axis=0), along) for along in tangents)]
    row_of = np.full(len(shapes.size), -1)
    row_of[movable] = np.arange(len(movable))
    rows, columns, values = [], [], []
    for of_joint, sign in ((joints.first, 1.0), (joints.second, -1.0)):
        block = of_joint[joint]
        for kind, (place, force) in enumerate(forces):
            arm = (place - shapes.centroid[block]) / length_unit
            entries = sign * np.column_stack([force, moment_of(arm, force)])
            rows.append(layout.rows * row_of[block][:, None] + np.arange(layout.rows))
            columns.append(np.broadcast_to((kind * count + np.arange(count))[:, None], entries.shape))
            values.append(entries)
    row, column, value = (np.concatenate(parts).ravel() for parts in (rows, columns, values))
    # Fixed blocks have no rows; exact zeros (axis-aligned joints) stay out of the pattern.
    kept = (row >= 0) & (value != 0)
    shape = layout.rows * len(movable), KINDS * count
    B = sp.csr_array((value[kept], (row[kept], column[kept])), shape=shape)
    share = shares(joints, joint)
    usual = float(np.median(share[share > 0])) if share.any() else 1.0
    return Matrices(B, np.where(share > 0, share / usual, 1.0), length_unit, layout)


def shares(joints: Joints, joint: np.ndarray) -> np.ndarray:
    """Length or area that each of the problem's joints stands for, an equal share of its joint's."""
    share: np.ndarray = (joints.extent / np.bincount(joint, minlength=len(joints.extent)))[joint]
    return share

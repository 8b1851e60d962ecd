"""Joints and contact points as they are drawn, and the planes on which the contact points lie."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from masonry_opt.scene.rows import combine, following, lengths


@dataclass(frozen=True)
class DrawnContacts:
    """Joints and contact points as drawn, before alignment, and the accuracy of the drawing."""

    ends: np.ndarray  #: indices of the two blocks of each joint, shape (joints, 2)
    normal: np.ndarray  #: unit normal of each joint, shape (joints, 2) or (joints, 3)
    #: Uncertainty of each normal's direction in the drawing, in radians, shape (joints,).
    accuracy: np.ndarray
    point: np.ndarray  #: contact points, shape (points, 2) or (points, 3)
    #: Index of the joint to which each contact point belongs, in ascending order, shape (points,).
    joint: np.ndarray
    #: Index of the outline ring to which each contact point belongs, in ascending order, shape (points,).
    ring: np.ndarray
    tolerance: float  #: uncertainty of the position of a point in the drawing (length)
    rounding: float  #: largest difference of coordinates that may be due to rounding alone

    @cached_property
    def joints_of_block(self) -> "Lists":
        """Return the indices of the joints of each block."""
        blocks, joints = self.ends.T.ravel(), np.tile(np.arange(len(self.ends)), 2)
        return Lists.of(blocks, joints, int(blocks.max(initial=-1)) + 1)

    def planes(self) -> "ContactPlanes":
        """Return the planes of all joints, then the planes that are perpendicular to each joint at its ends.

        In space, the perpendicular planes contain the sides of the joints.
        """
        points = np.arange(len(self.point))
        normal = self.normal[self.joint]
        if self.point.shape[1] == 2:
            direction = np.column_stack([normal[:, 1], -normal[:, 0]])
            accuracy, other_end = self.accuracy[self.joint], points
        else:
            other_end = following(np.bincount(self.ring))
            direction = np.cross(normal, self.point[other_end] - self.point)
            length = lengths(direction)
            # The side of a contact at a single point has no length, so the uncertainty of its direction is
            # infinite.
            accuracy = np.divide(self.tolerance, length, out=np.full(len(length), np.inf), where=length > 0)
            direction = direction / np.where(length > 0, length, 1.0)[:, None]
        sides = np.flatnonzero(np.isfinite(accuracy))
        of_side = len(self.normal) + np.arange(len(sides))
        own_end, far_end = (np.column_stack([of_side, end]) for end in (points[sides], other_end[sides]))
        points_on_sides = np.concatenate([own_end, far_end[own_end[:, 1] != far_end[:, 1]]])
        return ContactPlanes(
            direction=np.concatenate([self.normal, direction[sides]]),
            accuracy=np.concatenate([self.accuracy, accuracy[sides]]),
            joint=np.concatenate([np.arange(len(self.normal)), self.joint[sides]]),
            plane=np.concatenate([self.joint, points_on_sides[:, 0]]),
            point=np.concatenate([points, points_on_sides[:, 1]]),
        )


@dataclass(frozen=True)
class ContactPlanes:
    """Planes through contact points, and a table that lists the contact points on each plane."""

    direction: np.ndarray  #: unit normal of each plane, shape (planes, dim)
    #: Uncertainty of each normal's direction in the drawing, in radians, shape (planes,).
    accuracy: np.ndarray
    joint: np.ndarray  #: index of the joint to which each plane belongs, shape (planes,)
    #: For each entry of the table of contact points on planes, the index of the plane, shape (entries,).
    plane: np.ndarray
    #: For each entry of the table of contact points on planes, the index of the point, shape (entries,).
    point: np.ndarray

    @cached_property
    def by_plane(self) -> "Lists":
        """Return the indices of the contact points on each plane."""
        return Lists.of(self.plane, self.point, len(self.direction))

    @cached_property
    def by_joint(self) -> "Lists":
        """Return the indices of the planes of each joint."""
        return Lists.of(self.joint, np.arange(len(self.joint)), int(self.joint.max(initial=-1)) + 1)


@dataclass(frozen=True)
class Lists:
    """Several lists of indices, stored one after another in one array."""

    #: Entries of all lists, one list after another, shape (sum of ``count``,). Each entry is an index, for
    #: example the index of a joint in a list of the joints of a block.
    item: np.ndarray
    first: np.ndarray  #: position in ``item`` of the first entry of each list, shape (lists,)
    count: np.ndarray  #: number of entries of each list, shape (lists,)

    @classmethod
    def of(cls, owner: np.ndarray, item: np.ndarray, lists: int) -> "Lists":
        """Group items by their owners, such as points by planes, and return one list of items for each owner.

        ``owner`` has the index of the owner of each item, from 0 to ``lists - 1``.
        """
        count = np.bincount(owner, minlength=lists)
        return cls(item[np.argsort(owner, kind="stable")], np.cumsum(count) - count, count)

    def where(self, chosen: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return the items of the chosen lists as two arrays: the list number and the value of each item.

        A list number is the index in ``chosen`` of the list that contains the item.
        """
        numbers = np.arange(len(chosen))
        number, _, position = combine(numbers, np.ones_like(numbers), self.first[chosen], self.count[chosen])
        return number, self.item[position]

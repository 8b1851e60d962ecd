"""Joints and contact points as they are drawn, and the planes on which the contact points lie."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from masonry_opt.scene.rows import combine, following, lengths


@dataclass(frozen=True)
class DrawnContacts:
    """Joints and contact points as they are drawn."""

    ends: np.ndarray  #: indices of the two blocks of each joint, shape (joints, 2)
    normal: np.ndarray  #: unit normal of each joint, shape (joints, 2) or (joints, 3)
    accuracy: np.ndarray  #: angle in radians within which the drawing fixes each normal, shape (joints,)
    point: np.ndarray  #: contact points, shape (points, 2) or (points, 3)
    joint: np.ndarray  #: joint of each contact point, rising, shape (points,)
    ring: np.ndarray  #: ring of each contact point, rising, shape (points,)
    tolerance: float  #: length within which the drawing fixes a point
    rounding: float  #: length below which coordinates differ by rounding alone

    @cached_property
    def joints_of_block(self) -> "Lists":
        """Return the joints of each block."""
        blocks, joints = self.ends.T.ravel(), np.tile(np.arange(len(self.ends)), 2)
        return Lists.of(blocks, joints, int(blocks.max(initial=-1)) + 1)

    def planes(self) -> "Planes":
        """Return the planes of all joints, then the planes of their ends or sides."""
        points = np.arange(len(self.point))
        own = self.normal[self.joint]
        if self.point.shape[1] == 2:
            across = np.column_stack([own[:, 1], -own[:, 0]])
            accuracy, other_end = self.accuracy[self.joint], points
        else:
            other_end = following(np.bincount(self.ring))
            across = np.cross(own, self.point[other_end] - self.point)
            length = lengths(across)
            # A single point of contact has no sides.
            accuracy = np.divide(self.tolerance, length, out=np.full(len(length), np.inf), where=length > 0)
            across = across / np.where(length > 0, length, 1.0)[:, None]
        sides = np.flatnonzero(np.isfinite(accuracy))
        of_side = len(self.normal) + np.arange(len(sides))
        own_end, far_end = (np.column_stack([of_side, end]) for end in (points[sides], other_end[sides]))
        on_sides = np.concatenate([own_end, far_end[own_end[:, 1] != far_end[:, 1]]])
        return Planes(
            direction=np.concatenate([self.normal, across[sides]]),
            accuracy=np.concatenate([self.accuracy, accuracy[sides]]),
            joint=np.concatenate([np.arange(len(self.normal)), self.joint[sides]]),
            plane=np.concatenate([self.joint, on_sides[:, 0]]),
            point=np.concatenate([points, on_sides[:, 1]]),
        )


@dataclass(frozen=True)
class Planes:
    """Planes through contact points, and a table of which points lie on which plane."""

    direction: np.ndarray  #: unit normal of each plane, shape (planes, dim)
    accuracy: np.ndarray  #: angle in radians within which the drawing fixes each normal, shape (planes,)
    joint: np.ndarray  #: joint of each plane, shape (planes,)
    plane: np.ndarray  #: plane of each entry of the table, shape (entries,)
    point: np.ndarray  #: point of each entry of the table, shape (entries,)

    @cached_property
    def by_plane(self) -> "Lists":
        """Return the points of each plane."""
        return Lists.of(self.plane, self.point, len(self.direction))

    @cached_property
    def by_joint(self) -> "Lists":
        """Return the planes of each joint."""
        return Lists.of(self.joint, np.arange(len(self.joint)), int(self.joint.max(initial=-1)) + 1)


@dataclass(frozen=True)
class Lists:
    """Lists of numbers, stored one after the other in one array."""

    item: np.ndarray  #: all numbers
    first: np.ndarray  #: position of the first number of each list, shape (lists,)
    count: np.ndarray  #: length of each list, shape (lists,)

    @classmethod
    def of(cls, owner: np.ndarray, item: np.ndarray, lists: int) -> "Lists":
        """Return the lists of the items of each owner; ``owner`` has one entry for each item."""
        count = np.bincount(owner, minlength=lists)
        return cls(item[np.argsort(owner, kind="stable")], np.cumsum(count) - count, count)

    def where(self, chosen: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return the items of the chosen lists, concatenated, with the position of the list of each item.

        The position is that in ``chosen`` and comes first.
        """
        numbers = np.arange(len(chosen))
        number, _, position = combine(numbers, np.ones_like(numbers), self.first[chosen], self.count[chosen])
        return number, self.item[position]

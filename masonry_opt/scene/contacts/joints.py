"""The joints of a scene in one table, and the properties that it gives them."""

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from masonry_opt.errors import CaseError
from masonry_opt.scene.joints import JointDefaults
from masonry_opt.scene.rows import following
from masonry_opt.scene.scene import Scene


@dataclass(frozen=True)
class Joints:
    """Arrays over the joints of a scene, ordered by (first, second) block, and over their contact points,
    ordered by joint. Points and vectors have two components in the plane, three in space."""

    first: np.ndarray  #: index into the scene's blocks, shape (joints,)
    second: np.ndarray  #: index of the other block, first < second
    normal: np.ndarray  #: unit normal from the second block into the first, shape (joints, 2) or (joints, 3)
    #: Unit vector square to it, in the plane a quarter turn clockwise of it. In space along the longest side
    #: of the joint or along the edge that touches; of a contact at a point along a side of the face, or one
    #: of the two edges. Shape (joints, 2) or (joints, 3).
    tangent: np.ndarray
    #: Length of each joint, in space its area; 0 where a corner stands on an edge, in space along an edge or
    #: at a point; shape (joints,).
    extent: np.ndarray
    #: Of each joint, of a polygon its centroid, relative to the shapes' origin, shape as of the normals.
    middle: np.ndarray
    #: Contact points, relative to the shapes' origin: the two ends of an edge, the corners of a polygon and
    #: its holes, or one point, shape (points, 2) or (points, 3).
    point: np.ndarray
    joint: np.ndarray  #: joint of each contact point, rising, shape (points,)
    ring: np.ndarray  #: ring of each contact point, rising, shape (points,): a joint's outer one, then holes
    friction: np.ndarray  #: shape (joints,)
    cohesion: np.ndarray  #: per unit of extent, shape (joints,)
    dilatancy: np.ndarray  #: shape (joints,)
    #: Mean normal stresses up to which dilatancy is whole and from which there is none, ``inf`` where it does
    #: not depend on them, shape (joints, 2).
    dilatancy_stress: np.ndarray
    strength: np.ndarray  #: compressive, per unit of extent, ``inf`` where unlimited, shape (joints,)
    fixed_pairs: int  #: how many touching pairs were left out because both blocks are fixed
    #: By pairs of blocks (indices) that face each other across a small gap beside what they share, its
    #: largest width: the least 'tolerance' at which they share that edge or polygon.
    gaps: dict[tuple[int, int], float]
    facing: np.ndarray  #: lines along such gaps, in space round them, shape (lines, 2, 2) or (lines, 2, 3)
    #: Pairs of blocks (indices) that meet corner on corner, in space also corner on edge or edge along edge,
    #: which has no normal and is no joint, where not both have a joint there, and that face each other across
    #: no small gap.
    without_normal: list[tuple[int, int]]
    meets: np.ndarray  #: points where they do, shape (points, 2) or (points, 3)

    @cached_property
    def first_point(self) -> np.ndarray:
        """Number of the first contact point of each joint, shape (joints,)."""
        return np.searchsorted(self.joint, np.arange(len(self.first)))

    @property
    def last_point(self) -> np.ndarray:
        """Number of the last contact point of each joint, shape (joints,)."""
        return np.searchsorted(self.joint, np.arange(len(self.first)), side="right") - 1

    @property
    def parts(self) -> tuple[np.ndarray, np.ndarray]:
        """The problem's joints, in the plane these, in space their contact points: the joint that each is
        part of, rising, and the contact points at which it presses, shape (points, parts): start and end, the
        same where a corner stands on an edge, or itself."""
        if self.point.shape[1] == 2:
            return np.arange(len(self.first)), np.stack([self.first_point, self.last_point])
        return self.joint, np.arange(len(self.joint))[None]

    def most(self, values: np.ndarray) -> np.ndarray:
        """Of values of the contact points the largest of each joint, shape (joints,)."""
        return np.maximum.reduceat(values, self.first_point)

    @property
    def start(self) -> np.ndarray:
        """First contact point of each joint, shape (joints, 2) or (joints, 3)."""
        return self.point[self.first_point]

    @property
    def end(self) -> np.ndarray:
        """Last contact point of each joint, shape (joints, 2) or (joints, 3)."""
        return self.point[self.last_point]

    @property
    def axes(self) -> np.ndarray:
        """Normal and tangent of each joint, in space also their product, shape (dim, joints, dim)."""
        axes = [self.normal, self.tangent]
        if self.normal.shape[1] > 2:
            axes.append(np.cross(self.normal, self.tangent))
        return np.stack(axes)

    def lines(self) -> tuple[np.ndarray, np.ndarray]:
        """Sides of the outlines of all joints, in the plane the joints themselves: both ends of each, shape
        (lines, 2, 2) or (lines, 2, 3), and the joint of each, rising. What has no length has equal ends."""
        lines, corner = outline_sides(np.bincount(self.ring), self.point)
        return lines, self.joint[corner]


def outline_sides(count: np.ndarray, points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Sides of rings of so many corners, one after the other: both ends, shape (sides, 2, 2) or (sides, 2,
    3), and the number of the corner that each begins at. Two corners have one side."""
    after = following(count)
    back = (np.repeat(count, count) == 2) & (after < np.arange(len(after)))
    return np.stack([points, points[after]], axis=1)[~back], np.flatnonzero(~back)


def joint_properties(scene: Scene, first: np.ndarray, second: np.ndarray) -> dict[str, Any]:
    """Properties of joints by name, as :class:`Joints` has them. Raises CaseError if an exception names two
    blocks that do not touch."""
    found = {name: np.tile(value, (len(first), 1)) for name, value in _values(scene.joints).items()}
    index = {block.name: number for number, block in enumerate(scene.blocks)}
    for exception in scene.exceptions:
        one, other = sorted(index[name] for name in exception.between)
        of_both = (first == one) & (second == other)
        if not of_both.any():
            both_fixed = scene.blocks[one].fixed and scene.blocks[other].fixed
            why = "are both fixed" if both_fixed else "do not touch"
            where = f"joint between {list(exception.between)}"
            raise CaseError(f"{scene.origin}: {where}: these blocks {why}, so there is no joint to describe")
        for name, value in _values(exception.over(scene.joints)).items():
            found[name][of_both] = value
    return {name: values if name == "dilatancy_stress" else values[:, 0] for name, values in found.items()}


def _values(joint: JointDefaults) -> dict[str, float | tuple[float, float]]:
    """Properties of a joint, ``inf`` for what does not limit. With unlimited friction it never slides:
    cohesion and dilatancy say nothing there."""
    slides = np.isfinite(joint.friction)
    return {
        "friction": joint.friction,
        "cohesion": joint.cohesion if slides else 0.0,
        "dilatancy": joint.dilatancy if slides else 0.0,
        # Stresses up to which dilatancy is whole and from which there is none.
        "dilatancy_stress": joint.dilatancy_stress or (np.inf, np.inf),
        "strength": joint.strength or np.inf,
    }

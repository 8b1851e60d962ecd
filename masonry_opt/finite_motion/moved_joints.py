"""Joints as they touch after blocks have moved: wholly, in one corner, or not at all."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
import shapely

from masonry_opt.finite_motion.point_forces import placed, turned
from masonry_opt.problem.assembly import Assembly
from masonry_opt.scene.rows import linked

#: Share of the fastest corner's speed below which a corner of a joint stays.
STAYS = 1e-6


@dataclass(frozen=True)
class MovedJoints:
    """The joints of a scene in the plane, in the problem's units, by the movable block they belong to; all
    fixed blocks are one more, the last.

    Attributes
    ----------
    ends: of the blocks of each joint, shape (joints, 2).
    corner: start and end of each joint at rest, which both blocks keep, shape (joints, 2, 2).
    centroid: of the blocks at rest, the ground's the origin, shape (blocks + 1, 2).
    normal: into the first block at rest, shape (joints, 2).
    friction: ``inf`` where a joint cannot slide, shape (joints,).
    cohesion: as a force while the joint is closed, shape (joints,).
    faces: whose edge a joint's corner touches, first and second block's: both where two corners meet, shape
        (joints, 2, 2), joint, corner, block.
    polygons: of all blocks, and of each its row here, shape (blocks,) each.
    """

    ends: np.ndarray
    corner: np.ndarray
    centroid: np.ndarray
    normal: np.ndarray
    friction: np.ndarray
    cohesion: np.ndarray
    faces: np.ndarray
    polygons: np.ndarray
    row: np.ndarray
    tolerance: float

    @classmethod
    def of(cls, assembly: Assembly, force: float) -> MovedJoints:
        """The joints of an assembly, with forces in such a unit, in the problem's."""
        problem, joints, geometry = assembly.problem, assembly.joints, assembly.geometry
        row = np.full(len(assembly.scene.blocks), len(assembly.movable))
        row[assembly.movable] = np.arange(len(assembly.movable))
        cohesion = np.zeros(problem.joints)
        cohesion[problem.sliding] = problem.cohesion / force
        places = np.stack([joints.start, joints.end], axis=1)
        points = shapely.points(places)
        outer = [shapely.multipoints(shapely.get_coordinates(each)) for each in geometry.polygons]
        corners = np.array(outer, dtype=object)
        of_first, of_second = (
            shapely.distance(points, corners[block][:, None]) <= 2 * geometry.tolerance
            for block in (joints.first, joints.second)
        )
        # A corner of the second block alone touches the first one's edge.
        faces = np.stack([of_second | ~of_first, of_first | ~of_second], axis=-1)
        return cls(
            ends=np.stack([row[joints.first], row[joints.second]], axis=1),
            corner=places / problem.length_unit,
            centroid=np.vstack([geometry.centroid[assembly.movable], [0, 0]]) / problem.length_unit,
            normal=joints.normal,
            friction=joints.friction,
            cohesion=cohesion,
            faces=faces,
            polygons=geometry.polygons,
            row=row,
            tolerance=geometry.tolerance,
        )

    @cached_property
    def tangent(self) -> np.ndarray:
        """A quarter turn clockwise of the normals, shape (joints, 2)."""
        return np.column_stack([self.normal[:, 1], -self.normal[:, 0]])

    @property
    def at_rest(self) -> np.ndarray:
        """Which corners of the joints touch at rest, shape (joints, 2): of a corner on an edge the first."""
        in_a_point = (self.corner[:, 0] == self.corner[:, 1]).all(axis=1)
        return np.stack([np.ones_like(in_a_point), ~in_a_point], axis=1)

    def bodies(self, touch: np.ndarray, blocks: int) -> np.ndarray:
        """Number of the rigid body that each block, and the ground, belongs to, shape (blocks + 1,): blocks
        whose joints are closed move as one. The ground's is the last."""
        body = linked(blocks + 1, *self.ends[touch.all(axis=1)].T)
        ground, last = body[-1], body.max()
        return np.where(body == ground, last, np.where(body == last, ground, body))

    def opening_angle(self, touch: np.ndarray, poses: np.ndarray) -> np.ndarray:
        """Angle by which hinged joints are open, shape (joints,); 0 of all others."""
        i, j = self.ends.T
        rotation = poses[i, 2] - poses[j, 2]
        return np.where(self.hinged(touch), np.where(touch[:, 0], rotation, -rotation), 0.0)

    def hinged(self, touch: np.ndarray) -> np.ndarray:
        """Joints that have a length and touch in one corner, shape (joints,)."""
        return self.at_rest.all(axis=1) & (touch.sum(axis=1) == 1)

    def overlap(self, poses: np.ndarray, length_unit: float) -> tuple[int, int] | None:
        """Two blocks that lie over one another, deeper than the scene's tolerance; None if none do."""
        of_blocks = poses[self.row] * [length_unit, length_unit, 1.0]
        corners, block = shapely.get_coordinates(self.polygons, return_index=True)
        moved = shapely.set_coordinates(self.polygons.copy(), placed(corners, of_blocks[block]))
        one, other = shapely.STRtree(moved).query(moved, predicate="intersects")
        kept = (one < other) & (np.minimum(self.row[one], self.row[other]) < len(poses) - 1)
        one, other = one[kept], other[kept]
        common = shapely.intersection(moved[one], moved[other])
        area, length = shapely.area(common), shapely.length(common)
        depth = np.divide(2 * area, length, out=np.zeros_like(area), where=area > 0)
        if not (depth > self.tolerance).any():
            return None
        return int(one[depth.argmax()]), int(other[depth.argmax()])

    def velocities(self, poses: np.ndarray, motion: np.ndarray, side: int) -> np.ndarray:
        """Velocities of the joints' corners with their first (0) or second block, shape (joints, 2, 2), as
        these poses change."""
        block = self.ends[:, side]
        arm = turned(self.corner, poses[block][:, None])
        quarter = np.stack([-arm[..., 1], arm[..., 0]], axis=-1)
        return motion[block, None, :2] + motion[block, 2][:, None, None] * quarter

    def fastest(self, poses: np.ndarray, motion: np.ndarray) -> float:
        """Speed of the fastest corner of a joint."""
        both = np.stack([self.velocities(poses, motion, side) for side in range(2)])
        return float(np.hypot(both[..., 0], both[..., 1]).max(initial=0.0))

    def relative(self, poses: np.ndarray, motion: np.ndarray) -> np.ndarray:
        """Rates at which the joints' corners open, and slip, shape (2, joints, 2)."""
        first, second = (self.velocities(poses, motion, side) for side in range(2))
        along = np.stack([self.normal, self.tangent])[:, :, None]
        frame = turned(along, poses[self.ends[:, 0]][:, None])
        return ((first - second) * frame).sum(axis=-1)

    def after(
        self, touch: np.ndarray, poses: np.ndarray, motion: np.ndarray, pressed: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray]:
        """Which corners still touch in a motion, shape (joints, 2), and which joints slide in it, shape
        (joints,): under pressure, or without opening.

        Parameters
        ----------
        touch: which corners touch, shape (joints, 2).
        motion: rates of the poses, shape (blocks + 1, 3).
        pressed: joints that carry a normal force, shape (joints,).
        """
        relative, least = self.relative(poses, motion), STAYS * (self.fastest(poses, motion) or 1.0)
        stays = touch & (np.hypot(*relative) <= least)
        slips, opens = touch & ~stays, relative[0] > least
        slides = (slips & ~opens).any(axis=1) | (slips.any(axis=1) & ~stays.any(axis=1) & pressed)
        return stays, slides

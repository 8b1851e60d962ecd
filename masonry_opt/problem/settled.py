"""State of a scene after a settlement of given size: displaced blocks, their contacts and their preload.

The records of a scene with a settled state still describe the blocks at rest. Loads are computed for the
blocks at rest and then move with the blocks: forces keep their direction, and their points of action are
fixed to the blocks. Fill moves with the blocks below it, and its stress on each edge does not change. A road
keeps its height above the blocks below it.
"""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from masonry_opt.errors import CaseError
from masonry_opt.problem.displaced import displaced, placed, turned
from masonry_opt.problem.limited_forces import LimitedForce, Role
from masonry_opt.scene.contacts.joints import Joints
from masonry_opt.scene.geometry import Geometry, profile_below
from masonry_opt.scene.scene import Scene

#: Movement of each support by name, such as ``{"pier": (0, -0.02)}``, or pairs of names and movements.
Movements = Mapping[str, Sequence[float]] | Iterable[tuple[str, Sequence[float]]]

#: To find the displaced blocks below a road, the road is raised by their largest rise plus this clearance, in
#: multiples of the scene's tolerance. A road may cut into a block to a depth of twice the tolerance. If the
#: clearance is smaller than this depth, the raised road may still cut into a displaced block.
_CLEARANCE = 4.0

#: Attributes of joints that do not depend on the positions of the blocks.
_JOINT_PROPERTIES = ("friction", "cohesion", "dilatancy", "dilatancy_stress", "strength")


@dataclass(frozen=True, eq=False)
class SettledState:
    """Displaced blocks of a plane scene after supports have moved by given amounts.

    Attributes
    ----------
    movements: Movement of each support by name: (x, y) in the unit of length, and a rotation in radians.
    poses: Poses (x, y, θ) of all blocks, shape (blocks, 3): a rotation about the origin of the geometry, then
        a translation.
    remaining: Indices, at rest, of the joints that do not separate, shape (joints,).
    joints: The joints that do not separate, between the displaced blocks. An opened joint is on the bisector
        of its edges, and can close again under pressure.
    count: Number of joints at rest.
    forces: Joint forces after the settlement, in units of the problem, shape (3c,).
    limited: Forces of ties, props and fill after the settlement, in units of the problem, shape (t,).
    dead: Dead load of the problem under which the supports moved, shape (3b,).
    """

    movements: Mapping[str, tuple[float, ...]]
    poses: np.ndarray = field(repr=False)
    remaining: np.ndarray = field(repr=False)
    joints: Joints = field(repr=False)
    count: int = field(repr=False)
    forces: np.ndarray = field(repr=False)
    limited: np.ndarray = field(repr=False)
    dead: np.ndarray = field(repr=False)

    def __str__(self) -> str:
        """Return the movements as text, such as "'pier' by (0, -0.02)"."""
        moved = (
            f"'{name}' by ({', '.join(f'{part:.6g}' for part in movement)})"
            for name, movement in self.movements.items()
        )
        return ", ".join(moved)

    def at_rest(self, block: int, point: np.ndarray) -> np.ndarray:
        """Return the position at rest of a point that is fixed to a displaced block."""
        back = np.array([0.0, 0.0, -self.poses[block, 2]])
        return turned(point - self.poses[block, :2], back)

    def geometry(self, at_rest: Any) -> Any:
        """Return the shapes of the displaced blocks."""
        return displaced(at_rest, self.poses)

    def joints_of(self, scene: Scene, at_rest: Joints) -> Joints:
        """Return the displaced joints, with the friction and other properties of the joints at rest.

        Raises CaseError if the scene has other joints than the scene whose supports moved.
        """
        if len(at_rest.first) != self.count or len(scene.blocks) != len(self.poses):
            raise CaseError(
                f"{scene.origin}: after supports have settled, the blocks of a scene cannot change: first "
                "change the blocks of the original scene, and then settle its supports"
            )
        properties = {name: getattr(at_rest, name)[self.remaining] for name in _JOINT_PROPERTIES}
        return replace(self.joints, **properties)

    def pieces(self, at_rest: Sequence[Any]) -> tuple[Any, ...]:
        """Return the displaced positions of pieces of edges that carry a load or touch a fill."""
        return tuple(replace(piece, ends=placed(piece.ends, self.poses[piece.block])) for piece in at_rest)

    def road(self, scene: Scene, at_rest: Geometry, line: np.ndarray, called: str = "the road") -> np.ndarray:
        """Return the points of a road that keeps its height above the blocks below it as they move.

        Abscissae do not change. Where two blocks meet, the road has the greater of the heights above both.
        Over empty space the road stays as drawn.

        Parameters
        ----------
        scene: The scene.
        at_rest: Shapes of the blocks at rest.
        line: Points of the road from left to right, relative to the origin, shape (points, 2).
        called: Name of the road in errors.
        """
        shapes = self.geometry(at_rest)
        before = profile_below(scene, at_rest, line, called)
        below = np.unique(before.block[before.block >= 0])
        corners, block = at_rest.corners
        rises = (placed(corners, self.poses[block]) - corners)[np.isin(block, below), 1]
        # Raise the road, so that it does not run through blocks that have moved upwards.
        rise = max(0.0, rises.max(initial=0.0)) + _CLEARANCE * at_rest.tolerance
        after = profile_below(scene, shapes, line + np.array([0.0, rise]), called)
        x, owner = after.x.ravel(), np.repeat(after.block, 2)
        has_block = owner >= 0
        height = np.interp(x, *line.T)
        foot = np.column_stack([x, after.y.ravel()])[has_block]
        poses = self.poses[owner[has_block]]
        back = np.column_stack([np.zeros((len(poses), 2)), -poses[:, 2]])
        foot_at_rest = turned(foot - poses[:, :2], back)
        cover = np.maximum(np.interp(foot_at_rest[:, 0], *line.T) - foot_at_rest[:, 1], 0.0)
        height[has_block] = foot[:, 1] + cover
        points = np.unique(x)
        return np.column_stack([points, [height[x == point].max() for point in points]])

    def struts(self, at_rest: Sequence[LimitedForce]) -> tuple[LimitedForce, ...]:
        """Return the ties and props between the displaced positions of their end points."""
        return tuple(self._strut(force) for force in at_rest if force.role in (Role.TIE, Role.PROP))

    def _strut(self, force: LimitedForce) -> LimitedForce:
        """Return a tie or prop along the line between its displaced ends."""
        poses = np.vstack([self.poses, np.zeros(3)])  # the ground has the index −1
        first, second = (placed(action.point, poses[action.block]) for action in force.actions)
        along = second - first
        if force.role is Role.PROP:
            along = -along
        along = along / np.linalg.norm(along)
        ends = zip(force.actions, (first, second), (along, -along), strict=True)
        actions = tuple(replace(action, point=point, force=unit) for action, point, unit in ends)
        return replace(force, actions=actions)

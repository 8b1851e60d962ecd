"""How blocks and joints move in a result's mechanism."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import shapely

from masonry_opt.answer.result import Result

#: Rates below this share of the fastest corner's velocity are nothing.
_STILL = 2e-3


@dataclass(frozen=True)
class JointMotion:
    """How the joints move in a mechanism.

    Attributes
    ----------
    slides: joints that slip while they touch, shape (c,).
    hinges: joints that open about one edge, shape (c,).
    hinge: that edge, or corner, where ``hinges``, shape (c, 2).
    separates: joints that open along their whole length, shape (c,).
    crushes: joints whose edges come nearer, shape (c,).
    """

    slides: np.ndarray
    hinges: np.ndarray
    hinge: np.ndarray
    separates: np.ndarray
    crushes: np.ndarray


def joint_motion(result: Result) -> JointMotion:
    """Which joints slide, hinge, separate and crush, from a result that has a mechanism."""
    frame, joints = result.joints, result.assembly.joints
    # A corner on an edge turns about itself: by how much is measured on a joint of usual length.
    half = np.where(joints.length > 0, joints.length / 2, result.assembly.problem.length_unit)
    in_a_point = joints.length == 0
    opening, turning = frame["opening"].to_numpy(), frame["rotation"].to_numpy() * half
    still = _STILL * fastest(result)
    # Opening at the joint's start and end: the first block's edge runs from start to end.
    nearer = opening - np.where(in_a_point, 0.0, np.abs(turning))
    touches = nearer <= still
    hinge = np.where((turning > 0)[:, None], joints.start, joints.end)
    return JointMotion(
        slides=touches & (np.abs(frame["slip"].to_numpy()) > still),
        hinges=touches & (np.abs(turning) > still),
        hinge=hinge,
        separates=~touches,
        crushes=nearer < -still,
    )


class Velocities:
    """Velocities of points of the scene's blocks, fixed ones included."""

    def __init__(self, result: Result) -> None:
        assembly = result.assembly
        self.centroid = assembly.geometry.centroid
        self.motion = np.zeros((len(self.centroid), 3))
        self.motion[assembly.movable] = result.blocks[["vx", "vy", "omega"]]

    def at(self, block: int, points: np.ndarray) -> np.ndarray:
        """Velocity of points, relative to the geometry's origin, of a block; shape (points, 2)."""
        vx, vy, omega = self.motion[block]
        arm = points - self.centroid[block]
        return np.array([vx, vy]) + omega * np.column_stack([-arm[:, 1], arm[:, 0]])


def fastest(result: Result) -> float:
    """Speed of the fastest corner; 1 where nothing moves."""
    polygons, motion = result.assembly.geometry.polygons, Velocities(result)
    speeds = [
        np.hypot(*motion.at(block, shapely.get_coordinates(polygons[block])).T).max()
        for block in result.assembly.movable
    ]
    return float(max(speeds)) or 1.0

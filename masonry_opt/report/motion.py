"""How blocks and joints move in a mechanism."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import shapely

from masonry_opt.answer.result import Result
from masonry_opt.answer.solution import Solution
from masonry_opt.problem.assembly import Assembly

#: Rates below this share of the fastest corner's velocity are nothing.
_STILL = 2e-3

#: Normal forces below this share of the largest are nothing, as for ``utilisation``.
_NOTHING = 1e-6


@dataclass(frozen=True)
class JointMotion:
    """How the joints move in a mechanism.

    Attributes
    ----------
    slides: joints that slip while they touch, and do not crush, shape (c,).
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


def joint_motion(assembly: Assembly, solution: Solution) -> JointMotion:
    """Which joints slide, hinge, separate and crush, in a solution that has a mechanism.

    The opening that the flow rule of the answer gives to sliding (associative flow: the friction) makes it
    neither hinge nor separation. What opens in the middle and carries nothing separates if it slips: that an
    edge then keeps its distance is chance. If it does not slip, it turns about that edge, a hinge.
    """
    assert solution.d is not None
    problem, joints = assembly.problem, assembly.joints
    slope = np.zeros(problem.joints)
    # Blocks that fall under their dead load do so by associative flow.
    own = problem.friction if solution.load_factor is None else problem.dilatancy
    slope[problem.sliding] = own if solution.slope is None else solution.slope
    opening, slip, _ = (problem.B.T @ solution.d).reshape(3, -1)
    slip = np.abs(slip)
    omega = np.zeros(len(assembly.scene.blocks))
    omega[assembly.movable] = solution.d[2::3] / problem.length_unit
    # A corner on an edge turns about itself: by how much is measured on a joint of usual length.
    in_a_point = joints.length == 0
    half = np.where(in_a_point, problem.length_unit, joints.length / 2)
    turning = (omega[joints.first] - omega[joints.second]) * half
    still = _STILL * _fastest(assembly, solution.d)
    # Opening of the edge that opens less: the first block's edge runs from start to end.
    apart = opening - slope * slip
    nearer = apart - np.where(in_a_point, 0.0, np.abs(turning))
    touches, crushes = nearer <= still, nearer < -still
    if solution.q is not None:
        n = solution.q[: problem.joints]
        pressed = n > _NOTHING * np.abs(n).max(initial=0.0)
        touches &= pressed | (apart <= still) | (slip <= still)
    return JointMotion(
        slides=touches & (slip > still) & ~crushes,
        hinges=touches & (np.abs(turning) > still),
        hinge=np.where((turning > 0)[:, None], joints.start, joints.end),
        separates=~touches,
        crushes=crushes,
    )


def has_mechanism(result: Result) -> bool:
    """Whether there is a motion to show."""
    return bool(result.blocks["vx"].notna().all())


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
    """Speed of the fastest corner of a result that has a mechanism; 1 where nothing moves."""
    assert result.solution.d is not None
    return _fastest(result.assembly, result.solution.d)


def moving_blocks(result: Result) -> np.ndarray:
    """Which of the movable blocks take part in the mechanism, shape (b,)."""
    assert result.solution.d is not None
    speeds = _corner_speeds(result.assembly, result.solution.d)
    return speeds > _STILL * _largest(speeds)


def _corner_speeds(assembly: Assembly, d: np.ndarray) -> np.ndarray:
    """Speed of the fastest corner of each movable block, shape (b,), under block velocities (3b,)."""
    movable, shapes = assembly.movable, assembly.geometry
    corners, block = shapely.get_coordinates(shapes.polygons[movable], return_index=True)
    vx, vy, omega = d.reshape(-1, 3)[block].T
    x, y = (corners - shapes.centroid[movable[block]]).T / assembly.problem.length_unit
    speeds = np.zeros(len(movable))
    np.maximum.at(speeds, block, np.hypot(vx - omega * y, vy + omega * x))
    return speeds


def _fastest(assembly: Assembly, d: np.ndarray) -> float:
    return _largest(_corner_speeds(assembly, d))


def _largest(speeds: np.ndarray) -> float:
    return float(speeds.max()) or 1.0

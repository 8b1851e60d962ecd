"""How blocks and joints move in a mechanism."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import shapely

from masonry_opt.answer.solution import Solution
from masonry_opt.answer.thresholds import CRUSHES, HINGES, IDLE, MOVES, SEPARATES, SLIDES
from masonry_opt.problem.assembly import Assembly


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

    What contacts give elastically, where they do, is no such motion.
    Opening by the answer's flow rule counts neither as hinging nor as separating. A joint without force that
    opens in the middle while one edge stays separates if it slips, else it hinges about that edge.
    """
    assert solution.d is not None
    problem, joints = assembly.problem, assembly.joints
    slope = np.zeros(problem.joints)
    # Blocks that fall under their dead load do so by associative flow.
    own = problem.friction if solution.load_factor is None else problem.dilatancy
    slope[problem.sliding] = own if solution.found.slope is None else solution.found.slope
    opening, slip, rotation = problem.by_kind(problem.motion(solution.d, solution.q))
    slip = np.abs(slip)
    omega = np.zeros(len(assembly.scene.blocks))
    omega[assembly.movable] = problem.moments(solution.d)[:, 0] / problem.length_unit
    # Turning of a corner on an edge is measured on a joint of usual length.
    in_a_point = joints.length == 0
    of_corners = (omega[joints.first] - omega[joints.second]) * problem.length_unit
    turning = np.where(in_a_point, of_corners, rotation * problem.half_length)
    speed = fastest(assembly, solution.d)
    # Opening of the edge that opens less: the first block's edge runs from start to end.
    apart = opening - slope * slip
    nearer = apart - np.where(in_a_point, 0.0, np.abs(turning))
    touches, crushes = nearer <= SEPARATES * speed, nearer < -CRUSHES * speed
    slips = slip > SLIDES * speed
    if solution.q is not None:
        n = problem.normal_forces(solution.q)
        pressed = n > IDLE * np.abs(n).max(initial=0.0)
        touches &= pressed | (apart <= SEPARATES * speed) | ~slips
    return JointMotion(
        slides=touches & slips & ~crushes,
        hinges=touches & (np.abs(turning) > HINGES * speed),
        hinge=np.where((turning > 0)[:, None], joints.start, joints.end),
        separates=~touches,
        crushes=crushes,
    )


def moving_blocks(assembly: Assembly, d: np.ndarray) -> np.ndarray:
    """Indices of the movable blocks that take part in a mechanism (3b,), fastest first."""
    speeds = _corner_speeds(assembly, d)
    order = np.argsort(-speeds, kind="stable")
    return order[speeds[order] > MOVES * (speeds.max() or 1.0)]


def moving_names(assembly: Assembly, d: np.ndarray) -> list[str]:
    """Names of the blocks that take part in a mechanism (3b,), fastest first."""
    return assembly.names(assembly.movable[moving_blocks(assembly, d)])


def fastest(assembly: Assembly, d: np.ndarray) -> float:
    """Speed of the fastest corner in a mechanism (3b,); 1 where nothing moves."""
    return float(_corner_speeds(assembly, d).max()) or 1.0


def _corner_speeds(assembly: Assembly, d: np.ndarray) -> np.ndarray:
    """Speed of the fastest corner of each movable block, shape (b,), under block velocities (3b,)."""
    movable, shapes = assembly.movable, assembly.geometry
    corners, block = shapely.get_coordinates(shapes.polygons[movable], return_index=True)
    vx, vy, omega = assembly.problem.by_block(d)[block].T
    x, y = (corners - shapes.centroid[movable[block]]).T / assembly.problem.length_unit
    speeds = np.zeros(len(movable))
    np.maximum.at(speeds, block, np.hypot(vx - omega * y, vy + omega * x))
    return speeds

"""How blocks and joints move in a mechanism."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from masonry_opt.answer.solution import Solution
from masonry_opt.answer.thresholds import CRUSHES, HINGES, IDLE, MOVES, SEPARATES, SLIDES
from masonry_opt.problem.assembly import Assembly, SpaceAssembly
from masonry_opt.scene.space.frames import dots, lengths
from masonry_opt.scene.space.surfaces import sums


@dataclass(frozen=True)
class JointMotion:
    """How the joints move in a mechanism.

    Attributes
    ----------
    slides: joints that slip while they touch, and do not crush, shape (joints,).
    hinges: joints that open about one edge, or about what touches of them, shape (joints,).
    hinge: that edge, or corner, where ``hinges``; in space the middle of the contact points that touch; shape
        (joints, 2) or (joints, 3).
    separates: joints that open along their whole length, or at all points, shape (joints,).
    crushes: joints whose edges come nearer, shape (joints,).
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

    In space a joint slides if one of its contact points slips while it touches, hinges if it opens more at
    some points than at others that touch, and separates if none touches; none crushes.
    """
    assert solution.d is not None
    problem = assembly.problem
    # Blocks that fall under their dead load do so by associative flow.
    own = problem.friction if solution.load_factor is None else problem.dilatancy
    slope = own if solution.found.slope is None else solution.found.slope
    curved = solution.found.curved
    explained = np.zeros(problem.joints)
    # By sides a point that slides between two of their senses opens by less than by the cone.
    rates = problem.rates(solution.d, slope, solution.q, curved)
    explained[problem.sliding] = slope * problem.slip(rates, curved)
    opening, *tangential = problem.by_kind(problem.motion(solution.d, solution.q))
    slips = np.stack(tangential[: problem.layout.dimension - 1])
    slip = np.hypot.reduce(np.abs(slips), axis=0)
    moves = _Moves(opening - explained, slip, fastest(assembly, solution.d))
    n = None if solution.q is None else problem.normal_forces(solution.q)
    pressed = None if n is None else n > IDLE * np.abs(n).max(initial=0.0)
    if isinstance(assembly, SpaceAssembly):
        return _of_contacts(assembly, solution.d, moves, pressed)
    return _of_lengths(assembly, solution.d, moves, tangential[-1], pressed)


class _Moves(NamedTuple):
    """Opening beside what the flow rule demands, and slip, of the problem's joints, shape (c,), and the speed
    of the fastest corner."""

    apart: np.ndarray
    slip: np.ndarray
    speed: float


def _of_lengths(
    assembly: Assembly, d: np.ndarray, moves: _Moves, rotation: np.ndarray, pressed: np.ndarray | None
) -> JointMotion:
    problem, joints = assembly.problem, assembly.joints
    apart, slip, speed = moves
    omega = np.zeros(len(assembly.scene.blocks))
    omega[assembly.movable] = problem.moments(d)[:, 0] / problem.length_unit
    # Turning of a corner on an edge is measured on a joint of usual length.
    in_a_point = joints.extent == 0
    of_corners = (omega[joints.first] - omega[joints.second]) * problem.length_unit
    turning = np.where(in_a_point, of_corners, rotation * problem.half_length)
    # Opening of the edge that opens less: the first block's edge runs from start to end.
    nearer = apart - np.where(in_a_point, 0.0, np.abs(turning))
    touches, crushes = nearer <= SEPARATES * speed, nearer < -CRUSHES * speed
    slips = slip > SLIDES * speed
    if pressed is not None:
        touches &= pressed | (apart <= SEPARATES * speed) | ~slips
    return JointMotion(
        slides=touches & slips & ~crushes,
        hinges=touches & (np.abs(turning) > HINGES * speed),
        hinge=np.where((turning > 0)[:, None], joints.start, joints.end),
        separates=~touches,
        crushes=crushes,
    )


def _of_contacts(
    assembly: SpaceAssembly, d: np.ndarray, moves: _Moves, pressed: np.ndarray | None
) -> JointMotion:
    contacts, most = assembly.joints, assembly.most_of_joints
    apart, slip, speed = moves
    farthest, nearest = most(apart), -most(-apart)
    # Turning of an edge or a point on a face is measured on a joint of usual length.
    turned = relative_rotation(assembly, d)
    tilted = lengths(turned - dots(turned, contacts.normal)[:, None] * contacts.normal)
    turning = np.maximum((farthest - nearest) / 2, np.where(contacts.extent > 0, 0.0, tilted))
    touching = apart <= np.maximum(SEPARATES * speed, nearest[contacts.joint])
    touches, slips = nearest <= SEPARATES * speed, most(touching * slip) > SLIDES * speed
    if pressed is not None:
        touches &= most(pressed) | ((farthest + nearest) / 2 <= SEPARATES * speed) | ~slips
    share = touching / np.bincount(contacts.joint, touching)[contacts.joint]
    return JointMotion(
        slides=touches & slips,
        hinges=touches & (turning > HINGES * speed),
        hinge=sums(contacts.joint, share[:, None] * contacts.point, len(contacts.first)),
        separates=~touches,
        crushes=np.zeros_like(touches),
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


def velocities(assembly: Assembly, d: np.ndarray, block: np.ndarray, at: np.ndarray) -> np.ndarray:
    """Velocities v + ω × r, shape (points, 2) or (points, 3), of points of the scene's blocks, one each, at
    places relative to the geometry's origin, under block velocities (3b,)."""
    problem, dimension = assembly.problem, assembly.problem.layout.dimension
    arm = np.zeros((len(at), 3))
    arm[:, :dimension] = (at - assembly.geometry.centroid[block]) / problem.length_unit
    v = np.zeros((len(assembly.scene.blocks), dimension))
    v[assembly.movable] = problem.forces(d)
    moved: np.ndarray = v[block] + np.cross(_rotations(assembly, d)[block], arm)[:, :dimension]
    return moved


def relative_rotation(assembly: Assembly, d: np.ndarray) -> np.ndarray:
    """Rotation of the first block of each joint against the second, shape (joints, 3)."""
    of_block, joints = _rotations(assembly, d), assembly.joints
    turned: np.ndarray = of_block[joints.first] - of_block[joints.second]
    return turned


def _rotations(assembly: Assembly, d: np.ndarray) -> np.ndarray:
    """Rotations of all blocks, in the plane about z, shape (blocks, 3)."""
    turned, moments = np.zeros((len(assembly.scene.blocks), 3)), assembly.problem.moments(d)
    turned[assembly.movable, 3 - moments.shape[1] :] = moments
    return turned


def _corner_speeds(assembly: Assembly, d: np.ndarray) -> np.ndarray:
    """Speed of the fastest corner of each movable block, shape (b,), under block velocities (3b,)."""
    at, block = assembly.geometry.corners
    speeds = np.zeros(len(assembly.scene.blocks))
    np.maximum.at(speeds, block, np.hypot.reduce(velocities(assembly, d, block, at), axis=1))
    return speeds[assembly.movable]

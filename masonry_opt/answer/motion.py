"""How blocks and joints move in a mechanism."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from masonry_opt.answer.load_history import LoadStep
from masonry_opt.answer.solution import Solution
from masonry_opt.answer.thresholds import CRUSHES, DRIVES, HINGES, IDLE, MOVES, SEPARATES, SLIDES, ZERO
from masonry_opt.problem.assembly import Assembly
from masonry_opt.problem.problem import Problem
from masonry_opt.scene.rows import dots, lengths, sums


@dataclass(frozen=True)
class JointMotion:
    """How the joints move in a mechanism."""

    slides: np.ndarray  #: joints that slip while they touch, and do not crush, shape (joints,)
    hinges: np.ndarray  #: joints that open about one edge, or about what touches of them, shape (joints,)
    #: That edge, or corner; in space the middle of the points that touch; shape (joints, 2) or (joints, 3).
    hinge: np.ndarray
    separates: np.ndarray  #: joints that open along their whole length, or at all points, shape (joints,)
    crushes: np.ndarray  #: joints of limited strength whose edges come nearer, shape (joints,)


def joint_motion(assembly: Assembly, solution: Solution, speed: float | None = None) -> JointMotion:
    """Which joints slide, hinge, separate and crush, in a solution that has a mechanism.

    Opening by the flow rule of the answer does not count. Motions are relative to a
    speed, by default that of the mechanism's fastest corner. Without force a joint that opens in the middle
    while an edge stays hinges about it, or separates if it slips. In space a joint slides if a contact point
    slips while it touches, hinges if it opens more at some points than at others that touch.
    """
    assert solution.d is not None
    problem, joints = assembly.problem.by(solution.found.forms), assembly.joints
    # Blocks that fall under their dead load do so by associative flow.
    own = problem.friction if solution.load_factor is None else problem.dilatancy
    slope = own if solution.found.slope is None else solution.found.slope
    explained = np.zeros(problem.joints)
    # By sides a point that slides between two of their senses opens by less than by the cone.
    rates = problem.rates(solution.d, slope)
    explained[problem.sliding] = slope * problem.slip(rates)
    dimension, of_point = problem.layout.dimension, assembly.of_point
    motion = problem.motion(solution.d)
    slip = np.hypot.reduce(np.abs(problem.shears(motion)), axis=0)[of_point]
    speed = speed or fastest(assembly, solution.d)
    # Opening of each contact point beside what the flow rule demands.
    apart = np.empty(len(of_point))
    apart[assembly.pressed] = problem.at_points(motion) - explained
    farthest, nearest = joints.most(apart), -joints.most(-apart)
    # Turning of what has no extent is measured on a joint of usual length.
    turned = relative_rotation(assembly, solution.d)
    normal = np.pad(joints.normal, ((0, 0), (0, 3 - dimension)))
    tilted = lengths(turned - dots(turned, normal)[:, None] * normal)
    turning = np.maximum((farthest - nearest) / 2, np.where(joints.extent > 0, 0.0, tilted))
    touches = nearest <= SEPARATES * speed
    crushes = (nearest < -CRUSHES * speed) & np.isfinite(joints.strength)
    touching = apart <= np.where(crushes, nearest, np.maximum(SEPARATES * speed, nearest))[joints.joint]
    slips = joints.most(touching * slip) > SLIDES * speed
    if solution.q is not None:
        n = problem.normal_forces(solution.q)
        pressed = joints.most((n > IDLE * np.abs(n).max(initial=0.0))[of_point])
        touches &= pressed | ((farthest + nearest) / 2 <= SEPARATES * speed) | ~slips
    share = touching / np.bincount(joints.joint, touching)[joints.joint]
    return JointMotion(
        slides=touches & slips & ~crushes,
        hinges=touches & (turning > HINGES * speed),
        hinge=sums(joints.joint, share[:, None] * joints.point, len(joints.first)),
        separates=~touches,
        crushes=crushes,
    )


def joints_that_move(assembly: Assembly, steps: Sequence[LoadStep]) -> tuple[np.ndarray, np.ndarray]:
    """Return which joints slide, and which are open, after each load step, shape (steps, joints) each.

    In space a joint slides if one of its contacts does, and is open if one of its contacts is.
    """
    sliding = np.stack([assembly.most_of_joints(step.sliding) for step in steps])
    are_open = np.stack([assembly.most_of_joints(step.open) for step in steps])
    return sliding.astype(bool), are_open.astype(bool)


def moving_blocks(assembly: Assembly, d: np.ndarray) -> np.ndarray:
    """Indices of the movable blocks that take part in a mechanism (3b,), fastest first."""
    speeds = _corner_speeds(assembly, d)
    order = np.argsort(-speeds, kind="stable")
    return order[speeds[order] > MOVES * (speeds.max() or 1.0)]


def moving_names(assembly: Assembly, d: np.ndarray) -> list[str]:
    """Names of the blocks that take part in a mechanism (3b,), fastest first."""
    return assembly.names(assembly.movable[moving_blocks(assembly, d)])


def fastest(assembly: Assembly, d: np.ndarray) -> float:
    """Speed of the fastest corner in a mechanism (3b,); 1 where nothing moves, as far as is known."""
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
    np.fmax.at(speeds, block, np.hypot.reduce(velocities(assembly, d, block, at), axis=1))  # NaN is none
    return speeds[assembly.movable]


def weightless(problem: Problem, load_factor: float, d: np.ndarray) -> bool:
    """Whether the blocks that a mechanism (3b,) moves carry no load at a load factor below zero, as all those
    whose live load is along their weight do at some: any of them can move there, whatever carries them."""
    if load_factor >= -ZERO:
        return False
    speeds = np.abs(problem.by_block(d)).max(axis=1)
    dead, live = problem.by_block(problem.dead), load_factor * problem.by_block(problem.live)
    left, sizes = np.abs(dead + live).max(axis=1), np.abs(dead).max(axis=1) + np.abs(live).max(axis=1)
    moving = speeds > MOVES * speeds.max()
    return bool((left[moving] <= DRIVES * sizes[moving]).all())

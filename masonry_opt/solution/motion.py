"""Motions of blocks and joints in a mechanism."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from masonry_opt.problem.assembly import Assembly
from masonry_opt.problem.problem import Problem
from masonry_opt.scene.rows import dots, lengths, sums
from masonry_opt.solution.load_history import LoadStep
from masonry_opt.solution.solution import Solution
from masonry_opt.solution.thresholds import (
    CRUSHES,
    HINGES,
    MOVES,
    NEGLIGIBLE_SHARE,
    SEPARATES,
    SLIDES,
)

#: A block counts as free of load if its net load is at most this fraction of the sum of its dead load and its
#: live load. At a negative λ, a mechanism that moves only blocks free of load is no collapse (see
#: ``weightless``). With a larger value, blocks with a small net load also count as free of load.
_BALANCED_SHARE = 1e-7


@dataclass(frozen=True)
class JointMotion:
    """Joints that slide, hinge, separate or crush in a mechanism."""

    #: True if a joint slips while its sides touch and are not crushed, shape (joints,).
    slides: np.ndarray
    #: True if a joint opens by rotation, shape (joints,). In the plane, the rotation is about one end of the
    #: joint. In space, the rotation is about the points that still touch.
    hinges: np.ndarray
    #: Point about which each joint hinges. In the plane, the point is one end of the joint, shape (joints,
    #: 2). In space, it is the mean of the points that still touch, shape (joints, 3).
    hinge: np.ndarray
    #: True if a joint opens along its whole length (in space, at all its contact points), shape (joints,).
    separates: np.ndarray
    #: True if a joint of limited strength closes at an edge, so that stone is crushed, shape (joints,).
    crushes: np.ndarray


def joint_motion(assembly: Assembly, solution: Solution, speed: float | None = None) -> JointMotion:
    """Return which joints slide, hinge, separate and crush in the mechanism of a solution.

    - Opening due to dilatancy, by the flow rule of the answer, is subtracted.
    - Thresholds are relative to ``speed``, by default the speed of the mechanism's fastest corner.
    - A joint without force hinges about an edge if its middle opens while the edge still touches. If the
      joint also slips, it separates.
    - In space a joint slides if a contact point slips while it touches. It hinges if some points open while
      others still touch.
    """
    assert solution.d is not None
    problem, joints = assembly.problem.by(solution.state.forms), assembly.joints
    # A scene that is unstable under its dead load has no load factor, and its mechanism follows the
    # associative flow rule.
    own = problem.friction if solution.load_factor is None else problem.dilatancy
    slope = own if solution.state.slope is None else solution.state.slope
    explained = np.zeros(problem.joints)
    # Compute the opening due to sliding from the rates of the yield conditions. The slip velocity is not
    # sufficient: at the same slip, a joint with a friction polygon can open less than a joint with a cone.
    rates = problem.rates(solution.d, slope)
    explained[problem.sliding] = slope * problem.slip(rates)
    dimension, of_point = problem.layout.dimension, assembly.of_point
    motion = problem.motion(solution.d)
    slip = np.hypot.reduce(np.abs(problem.shears(motion)), axis=0)[of_point]
    speed = speed or fastest(assembly, solution.d)
    # Opening of each contact point minus the opening that the flow rule requires.
    apart = np.empty(len(of_point))
    apart[assembly.pressed] = problem.at_points(motion) - explained
    farthest, nearest = joints.most(apart), -joints.most(-apart)
    # A joint without extent, such as a corner on an edge, does not open when it rotates. For such a joint,
    # the rotation times the unit of length replaces the opening.
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
        pressed = joints.most((n > NEGLIGIBLE_SHARE * np.abs(n).max(initial=0.0))[of_point])
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
    """Return two masks for the end of each load step: joints that slide, and joints that are open.

    Both masks have the shape (steps, joints). An entry is True if the joint slides, or is open, at the end of
    the load step. In space, one sliding or open contact of the joint is enough.
    """
    sliding = np.stack([assembly.most_of_joints(step.sliding) for step in steps])
    are_open = np.stack([assembly.most_of_joints(step.open) for step in steps])
    return sliding.astype(bool), are_open.astype(bool)


def moving_blocks(assembly: Assembly, d: np.ndarray) -> np.ndarray:
    """Return the indices of the movable blocks that move in a mechanism, fastest first.

    The mechanism ``d`` consists of block velocities, shape (3b,).
    """
    speeds = _corner_speeds(assembly, d)
    order = np.argsort(-speeds, kind="stable")
    return order[speeds[order] > MOVES * (speeds.max() or 1.0)]


def moving_names(assembly: Assembly, d: np.ndarray) -> list[str]:
    """Return the names of the blocks that move in a mechanism, fastest first.

    The mechanism ``d`` consists of block velocities, shape (3b,).
    """
    return assembly.names(assembly.movable[moving_blocks(assembly, d)])


def fastest(assembly: Assembly, d: np.ndarray) -> float:
    """Return the speed of the fastest block corner in a mechanism.

    The mechanism ``d`` consists of block velocities, shape (3b,). The result is 1 if no corner is known to
    move.
    """
    return float(_corner_speeds(assembly, d).max()) or 1.0


def velocities(assembly: Assembly, d: np.ndarray, block: np.ndarray, at: np.ndarray) -> np.ndarray:
    """Return the velocities v + ω × r of points on blocks, shape (points, 2) or (points, 3).

    ``block`` has the index of each point's block in the scene, shape (points,). ``at`` has the positions of
    the points relative to the geometry's origin. The block velocities d have shape (3b,).
    """
    problem, dimension = assembly.problem, assembly.problem.layout.dimension
    arm = np.zeros((len(at), 3))
    arm[:, :dimension] = (at - assembly.geometry.centroid[block]) / problem.length_unit
    v = np.zeros((len(assembly.scene.blocks), dimension))
    v[assembly.movable] = problem.forces(d)
    velocity: np.ndarray = v[block] + np.cross(_rotations(assembly, d)[block], arm)[:, :dimension]
    return velocity


def relative_rotation(assembly: Assembly, d: np.ndarray) -> np.ndarray:
    """Return, for each joint, the rotation of its first block relative to its second, shape (joints, 3)."""
    rotations, joints = _rotations(assembly, d), assembly.joints
    relative: np.ndarray = rotations[joints.first] - rotations[joints.second]
    return relative


def _rotations(assembly: Assembly, d: np.ndarray) -> np.ndarray:
    """Return the rotation vectors of all blocks, shape (blocks, 3); in the plane they point along z."""
    rotations = np.zeros((len(assembly.scene.blocks), 3))
    of_movable = assembly.problem.moments(d)
    rotations[assembly.movable, 3 - of_movable.shape[1] :] = of_movable
    return rotations


def _corner_speeds(assembly: Assembly, d: np.ndarray) -> np.ndarray:
    """Return the speed of the fastest corner of each movable block, shape (b,).

    The block velocities d have shape (3b,).
    """
    at, block = assembly.geometry.corners
    speeds = np.zeros(len(assembly.scene.blocks))
    # ``fmax`` ignores velocities that are NaN.
    np.fmax.at(speeds, block, np.hypot.reduce(velocities(assembly, d, block, at), axis=1))
    return speeds[assembly.movable]


def weightless(problem: Problem, load_factor: float, d: np.ndarray) -> bool:
    """Return True if λ is negative and the mechanism moves only blocks whose net load is zero.

    The mechanism ``d`` consists of block velocities, shape (3b,). A live load parallel to a block's weight
    cancels the weight at some negative load factor. Then the block can move regardless of its joints, so the
    mechanism is not a collapse.
    """
    if load_factor >= -problem.load_factor_scale.zero:
        return False
    speeds = np.abs(problem.by_block(d)).max(axis=1)
    dead, live = problem.by_block(problem.dead), load_factor * problem.by_block(problem.live)
    net = np.abs(dead + live).max(axis=1)
    sizes = np.abs(dead).max(axis=1) + np.abs(live).max(axis=1)
    moving = speeds > MOVES * speeds.max()
    return bool((net[moving] <= _BALANCED_SHARE * sizes[moving]).all())

"""Warn about joints that are nearly parallel: wedges and uneven sides that may be errors of the drawing."""

from collections.abc import Iterator

import numpy as np

from masonry_opt.problem.assembly import Assembly
from masonry_opt.scene.geometry import TOLERANCE_OVER_ERROR
from masonry_opt.scene.rows import combine, lengths
from masonry_opt.solution.acceptance import Kind
from masonry_opt.solution.motion import joint_motion
from masonry_opt.solution.reasons import Code, Reason, reason
from masonry_opt.solution.solution import Solution
from masonry_opt.solution.thresholds import NEGLIGIBLE_SHARE

#: Angle, in radians, below which two joints count as nearly parallel. With a larger value, warnings would
#: name the joints of fine arches: in a ring of 200 voussoirs the angle is 0.016. A smaller value would miss
#: the errors of rough drawings.
_NEARLY_PARALLEL_ANGLE = 0.01

#: Angle, in radians, below which two joints count as exactly parallel. A larger value would miss slight
#: wedges.
_PARALLEL_ANGLE = 1e-9

#: A warning names a joint that alignment rotates by more than this angle, in radians. The value is one
#: millimetre per metre, the accuracy of cut stones. With a larger value, wedges that are meant as wedges may
#: become parallel without a warning.
_NAMED_TURN = 1e-3

#: A joint counts as about to slide if its shear exceeds this fraction of the friction limit. A larger value
#: would miss joints at the limit, because answers of interior-point solvers are inexact.
_SHARE_OF_FRICTION_LIMIT = 0.999

#: Largest number of joints of a block for which all pairs of joints are compared. To limit the memory, blocks
#: with more joints, such as a wide block under many others, are not checked for wedges.
_MOST_JOINTS_COMPARED = 300

#: Angle, in radians, below which two joints of the same two blocks count as parts of one uneven side. If two
#: joints differ by a larger angle, the side counts as curved on purpose or as a corner. With a larger value,
#: warnings would name curved sides. With a smaller value, warnings would miss surveyed blocks whose
#: coordinates have large errors.
_UNEVEN_ANGLE = 0.05

#: Sides are uneven if two blocks touch in several joints that are nearly, but not exactly, parallel. A
#: warning names uneven sides only if at least this fraction of all pairs of touching blocks has them. With a
#: larger value, some surveyed scenes with uneven sides would get no warning. With a smaller value, more
#: correct scenes would get a warning, such as arches of several rings that touch along curves. Some of these
#: arches get a warning even with this value (see ``benchmarks/README.md``).
_UNEVEN_SHARE = 0.5


def wedges(assembly: Assembly, solution: Solution | None) -> Iterator[Reason]:
    """Generate warnings about wedges: blocks with nearly parallel sliding joints.

    The first warning names the joints that the alignment rotated by more than ``_NAMED_TURN``. The second
    warning names pairs of nearly parallel joints of the aligned scene, if at least one joint of the pair
    slides or is at its friction limit. There is no second warning for associative flow.
    """
    able = _slides_without_lifting(assembly)
    joints = assembly.joints
    turned = np.where(able, joints.turn, 0.0)
    if turned.max(initial=0.0) > _NAMED_TURN:
        worst = np.flatnonzero(turned > _NAMED_TURN)
        worst = worst[np.argsort(-turned[worst], kind="stable")]
        values = {"turn": float(turned[worst[0]]), "tolerance": assembly.geometry.tolerance}
        yield reason(Code.ALIGNED, pairs=assembly.pairs_of(worst), **values)
    if solution is None or solution.d is None or solution.kind is Kind.ASSOCIATIVE:
        return
    first, second, angle = _nearly_parallel(assembly, able)
    slides = joint_motion(assembly, solution).slides | _at_friction_limit(assembly, solution)
    matters = np.flatnonzero(slides[first] | slides[second])
    matters = matters[np.argsort(-angle[matters], kind="stable")]
    first, second, angle = first[matters], second[matters], angle[matters]
    if not len(first):
        return
    error = _errors(assembly, first, second, angle)
    closing = joints.closing.tolerance if joints.closing.option == "tolerance" else 0.0
    tolerance = max(TOLERANCE_OVER_ERROR * float(error.max()), closing)
    named = list(dict.fromkeys(np.column_stack([first, second]).ravel().tolist()))
    lower, upper = np.quantile(angle, [0.25, 0.75])
    values = {"angle": float(angle[0]), "tolerance": tolerance, "scatter": float(upper / lower)}
    yield reason(Code.NEARLY_PARALLEL, pairs=assembly.pairs_of(np.array(named)), **values)


def uneven_sides(assembly: Assembly) -> Iterator[Reason]:
    """Generate a warning if many pairs of blocks touch in several joints that are nearly parallel.

    The sides of surveyed blocks are not flat, because their coordinates have errors. Two blocks then touch in
    several joints instead of one.
    """
    joints = assembly.joints
    rows = np.flatnonzero(joints.extent > 0)
    touching = joints.first[rows] * len(assembly.scene.blocks) + joints.second[rows]
    _, first_row, pair = np.unique(touching, return_index=True, return_inverse=True)
    number, first, second = _pairs_in_groups(pair, rows)
    angle = _angles(assembly, first, second)
    is_flat = np.bincount(number, angle >= _UNEVEN_ANGLE, len(first_row)) == 0
    is_uneven = is_flat[number] & (angle > _PARALLEL_ANGLE)
    uneven = np.unique(number[is_uneven])
    if not len(uneven) or len(uneven) < _UNEVEN_SHARE * len(first_row):
        return
    tolerance = TOLERANCE_OVER_ERROR * float(np.median(_errors(assembly, first, second, angle)[is_uneven]))
    values = {"angle": float(angle[is_uneven].max()), "tolerance": tolerance}
    yield reason(Code.UNEVEN_SIDES, pairs=assembly.pairs_of(rows[first_row[uneven]]), **values)


def _errors(assembly: Assembly, first: np.ndarray, second: np.ndarray, angle: np.ndarray) -> np.ndarray:
    """Return the position errors of corners that would explain the angles of pairs of joints, shape (pairs,).

    The joints of each pair, ``first`` and ``second``, are assumed to be parallel in reality. The position
    error is the displacement of a corner of the shorter joint.
    """
    accuracy = assembly.joints.accuracy
    return np.asarray(angle * assembly.geometry.tolerance / np.maximum(accuracy[first], accuracy[second]))


def _angles(assembly: Assembly, first: np.ndarray, second: np.ndarray) -> np.ndarray:
    """Return the angles between the normals of nearly parallel joints, in radians, shape (pairs,)."""
    normal = assembly.joints.normal
    along = (normal[first] * normal[second]).sum(axis=1)
    return np.asarray(lengths(normal[first] - along[:, None] * normal[second]))


def _slides_without_lifting(assembly: Assembly) -> np.ndarray:
    """Return a mask of the joints that can slide and have a dilatancy smaller than their friction."""
    problem = assembly.problem
    able = np.zeros(problem.joints, dtype=bool)
    able[problem.sliding] = problem.dilatancy < problem.friction
    return assembly.most_of_joints(able).astype(bool)


def _at_friction_limit(assembly: Assembly, solution: Solution) -> np.ndarray:
    """Return a mask of the joints that are pressed and whose shear is at the friction limit."""
    problem = assembly.problem
    limited = np.zeros(problem.joints, dtype=bool)
    if solution.q is not None:
        sliding, n = problem.sliding, problem.normal_forces(solution.q)
        shear = np.hypot.reduce(np.abs(problem.shears(solution.q)), axis=0)[sliding]
        pressed = n[sliding] > NEGLIGIBLE_SHARE * np.abs(n).max(initial=0.0)
        limit = problem.friction * n[sliding] + problem.cohesion
        limited[sliding] = pressed & (shear >= _SHARE_OF_FRICTION_LIMIT * limit)
    return assembly.most_of_joints(limited).astype(bool)


def _nearly_parallel(assembly: Assembly, able: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return pairs of nearly parallel joints of one movable block, and the angles between them."""
    joints, chosen = assembly.joints, np.flatnonzero(able)
    block, joint = np.concatenate([joints.first[chosen], joints.second[chosen]]), np.tile(chosen, 2)
    moves = np.isin(block, assembly.movable)
    _, first, second = _pairs_in_groups(block[moves], joint[moves])
    first, second = np.unique(np.column_stack([first, second]), axis=0).reshape(-1, 2).T
    angle = _angles(assembly, first, second)
    near = (angle > _PARALLEL_ANGLE) & (angle < _NEARLY_PARALLEL_ANGLE)
    return first[near], second[near], angle[near]


def _pairs_in_groups(group: np.ndarray, joint: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Pair the joints of each group; return the group, first joint and second joint of every pair.

    The three arrays have the shape (pairs,). Joint ``joint[i]`` belongs to group ``group[i]``; both arrays
    have the shape (n,), and groups are numbered from 0. Groups of more than ``_MOST_JOINTS_COMPARED`` joints
    have no pairs.
    """
    joint, count = joint[np.argsort(group, kind="stable")], np.bincount(group)
    start = np.cumsum(count) - count
    compared = np.flatnonzero(count <= _MOST_JOINTS_COMPARED)
    number, first, second = combine(start[compared], count[compared], start[compared], count[compared])
    first, second = joint[first], joint[second]
    once = first < second
    return compared[number[once]], first[once], second[once]

"""Warn about supports that overlap at a joint: a block that rests on both has two joints at one place."""

from collections.abc import Iterator
from itertools import combinations

import numpy as np
import shapely

from masonry_opt.problem.assembly import Assembly
from masonry_opt.problem.limited_forces import Role
from masonry_opt.scene.contacts.joints import Joints
from masonry_opt.solution.reasons import Code, Reason, reason

#: Two joints are at one place if they share more than this fraction of the larger joint. A smaller value
#: would name supports side by side that overlap by an error of the drawing.
_SHARED_PART = 0.01

#: Largest angle, in radians, between the faces of two joints at one place. A larger value would name joints
#: on the two sides of a corner.
_FACES_PARALLEL = 1e-3


def doubled_joints(assembly: Assembly) -> list[Reason]:
    """Return a list with a warning that names the supports that overlap at joints, or an empty list.

    Forces at such joints are limited by the sum of both joints, so cohesion and strength count twice.
    """
    found = [*_doubled(assembly)]
    if not found:
        return []
    pairs = [*dict.fromkeys(pair for pair, _ in found)]
    touched = np.unique([block for _, block in found])
    named = [assembly.names(np.array(pair)) for pair in pairs]
    return [reason(Code.DOUBLED_JOINTS, pairs=named, blocks=assembly.names(touched))]


def _doubled(assembly: Assembly) -> Iterator[tuple[tuple[int, int], int]]:
    """Iterate over the pairs of supports with joints at one place, and the movable block at these joints."""
    joints, tolerance = assembly.joints, assembly.geometry.contact_tolerance
    ends = np.array([joints.first, joints.second])
    guides = [force for force in assembly.limited if force.role is Role.SUPPORT]
    settling = [action.block for guide in guides for action in guide.actions]
    is_support = ~np.isin(ends, assembly.movable) | np.isin(ends, settling)
    at_support = np.flatnonzero((is_support.sum(axis=0) == 1) & (joints.extent > 0))
    support = np.where(is_support[0], *ends)[at_support]
    block = np.where(is_support[0], *ends[::-1])[at_support]
    for own in np.unique(block):
        rows = np.flatnonzero(block == own)
        for one, other in combinations(rows[np.argsort(support[rows], kind="stable")], 2):
            if support[one] != support[other] and _share(joints, at_support[[one, other]], tolerance):
                yield (int(support[one]), int(support[other])), int(own)


def _share(joints: Joints, pair: np.ndarray, tolerance: float) -> bool:
    """Return True if two joints lie in one line (in space in one plane) and overlap there."""
    one, other = pair
    normal = joints.normal[one]
    is_parallel = abs(normal @ joints.normal[other]) > np.cos(_FACES_PARALLEL)
    distance = abs((joints.middle[other] - joints.middle[one]) @ normal)
    if not is_parallel or distance > tolerance:
        return False
    axes = [joints.tangent[one]]
    if len(normal) == 3:
        axes.append(np.cross(normal, axes[0]))
    shapes = [_shape(joints, joint, np.array(axes)) for joint in pair]
    shared = shapely.intersection(*shapes)
    size = shared.area if len(axes) == 2 else shared.length
    return bool(size > _SHARED_PART * joints.extent[pair].max())


def _shape(joints: Joints, joint: int, axes: np.ndarray) -> shapely.Geometry:
    """Return a joint as a segment along its tangent, or in space as a polygon in its plane.

    The rows of ``axes`` are one unit vector along the joint, or in space two.
    """
    own = joints.joint == joint
    points, ring = joints.point[own] @ axes.T, joints.ring[own]
    if len(axes) == 1:
        return shapely.LineString(np.column_stack([points, np.zeros(len(points))]))
    shell, *holes = (points[ring == number] for number in np.unique(ring))
    return shapely.make_valid(shapely.Polygon(shell, holes))

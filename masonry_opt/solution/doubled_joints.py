"""Warn about supports that overlap at a joint: a block that rests on both has two joints at one place."""

import numpy as np
import shapely

from masonry_opt.problem.assembly import Assembly
from masonry_opt.problem.limited_forces import Role
from masonry_opt.scene.contacts.joints import Joints
from masonry_opt.scene.rows import bounds, dots
from masonry_opt.solution.reasons import Code, Reason, reason

#: Two joints are at one place if they share more than this fraction of the larger joint. With a smaller
#: value, the warning would also name adjacent supports that overlap only because of an error of the drawing.
_SHARED_PART = 0.01


def doubled_joints(assembly: Assembly) -> list[Reason]:
    """Return a list with a warning that names the supports that overlap at joints, or an empty list.

    Forces at such joints are limited by the sum of both joints, so cohesion and strength count twice.
    """
    doubled = _doubled(assembly)
    if not len(doubled):
        return []
    pairs = [*dict.fromkeys((first, second) for _, first, second in doubled.tolist())]
    named = [assembly.names(np.array(pair)) for pair in pairs]
    return [reason(Code.DOUBLED_JOINTS, pairs=named, blocks=assembly.names(np.unique(doubled[:, 0])))]


def _doubled(assembly: Assembly) -> np.ndarray:
    """Return the movable blocks with two joints at one place, and the two supports of these joints.

    The result has a row for each block and pair of supports, in ascending order, shape (rows, 3).
    """
    joints, tolerance = assembly.joints, assembly.geometry.contact_tolerance
    ends = np.array([joints.first, joints.second])
    guides = [force for force in assembly.limited if force.role is Role.SUPPORT]
    settling = [action.block for guide in guides for action in guide.actions]
    is_support = ~np.isin(ends, assembly.movable) | np.isin(ends, settling)
    support, block = np.where(is_support[0], ends, ends[::-1])
    at_support = np.flatnonzero((is_support.sum(axis=0) == 1) & (joints.extent > 0))
    first, second = _near_joints(joints, at_support, tolerance)
    asked = (block[first] == block[second]) & (support[first] < support[second])
    first, second = first[asked], second[asked]
    # Sides of a block do not cross, so two joints whose middles are in one line are on one side of the block.
    distance = np.abs(dots(joints.normal[first], joints.middle[second] - joints.middle[first]))
    in_line = distance <= tolerance
    first, second = first[in_line], second[in_line]
    is_shared = _shared_part(joints, first, second) > _SHARED_PART
    rows = np.column_stack([block[first], support[first], support[second]])[is_shared]
    return np.unique(rows, axis=0)


def _near_joints(joints: Joints, asked: np.ndarray, tolerance: float) -> tuple[np.ndarray, np.ndarray]:
    """Return the pairs of the given joints whose bounding boxes are within the tolerance of each other.

    Each pair is returned in both orders.
    """
    low, high = (corner[asked] for corner in bounds(joints.joint, joints.point, len(joints.first)))
    low, high = low - tolerance, high + tolerance
    # The search tree has two axes. In space, choose the two axes along which the joints extend farthest.
    axes = np.argsort(np.ptp(low, axis=0))[-2:] if len(asked) else np.arange(2)
    boxes = shapely.box(*low[:, axes].T, *high[:, axes].T)
    first, second = shapely.STRtree(boxes).query(boxes)
    near = ((low[first] <= high[second]) & (low[second] <= high[first])).all(axis=1)
    return asked[first[near]], asked[second[near]]


def _shared_part(joints: Joints, first: np.ndarray, second: np.ndarray) -> np.ndarray:
    """Return the fraction of the larger joint that two joints share, for pairs of joints, shape (pairs,).

    The joints of each pair lie in one line, in space in one plane.
    """
    # Project both joints along the coordinate axis nearest to their normal. The projection scales all lengths
    # (in space: areas) of the pair by the same factor.
    axis = np.abs(joints.normal[first]).argmax(axis=1)
    projected, number = np.unique(
        np.column_stack([np.append(first, second), np.append(axis, axis)]), axis=0, return_inverse=True
    )
    end = np.append(joints.first_point, len(joints.point))
    shapes = np.empty(len(projected), dtype=object)
    for row, (joint, along) in enumerate(projected.tolist()):
        shapes[row] = _shape(joints, slice(end[joint], end[joint + 1]), along)
    first_shape, second_shape = shapes[number].reshape(2, -1)
    size = shapely.length if joints.point.shape[1] == 2 else shapely.area
    larger = np.maximum(size(first_shape), size(second_shape))
    shared: np.ndarray = size(shapely.intersection(first_shape, second_shape)) / larger
    return shared


def _shape(joints: Joints, own: slice, axis: int) -> shapely.Geometry:
    """Return a joint projected along the coordinate ``axis``: a segment, or in space a polygon.

    ``own`` selects the contact points of the joint.
    """
    points, ring = np.delete(joints.point[own], axis, axis=1), joints.ring[own]
    if points.shape[1] == 1:
        return shapely.LineString(np.column_stack([points, np.zeros(len(points))]))
    shell, *holes = (points[ring == number] for number in np.unique(ring))
    return shapely.make_valid(shapely.Polygon(shell, holes))

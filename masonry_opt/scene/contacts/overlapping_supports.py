"""Count joints on overlapping supports once: where a block rests on two supports, it has one joint.

Supports may overlap, unlike blocks that can move. Without this module, a block would have two joints where it
rests on both supports, and cohesion and strength would count twice.
"""

import numpy as np
import shapely

from masonry_opt.scene.contacts.sides import Facing
from masonry_opt.scene.geometry import Extents
from masonry_opt.scene.rows import bounds, dots
from masonry_opt.scene.scene import Scene


def count_once(
    scene: Scene, shapes: Extents, pairs: np.ndarray, shared_sides: Facing
) -> tuple[Facing, np.ndarray, np.ndarray]:
    """Remove the overlap of two supports from one of the two joints that a block has with the supports.

    The whole overlap belongs to the joint with one of the two supports:

    - the support nearer to the block,
    - if both touch the block, the support with the larger joint,
    - if both joints are equally large, the first support in the scene.

    Supports that overlap by at most the contact tolerance do not count as overlapping.

    Parameters
    ----------
    scene : Scene
        The scene.
    shapes : Extents
        Shapes of the blocks of the scene.
    pairs : ndarray, shape (pairs, 2)
        Pairs of blocks that are near each other.
    shared_sides : Facing
        Lengths or polygons that the pairs share. At least one block of each pair can move.

    Returns
    -------
    shared_sides : Facing
        Lengths or polygons without the parts that would count twice.
    overlaps : ndarray, shape (k, 3)
        Blocks that rest on the overlap of two supports: the block, the support that has the joint on the
        overlap, and the other support. The rows are in ascending order.
    overlap_ratio : ndarray, shape (k,)
        Length (in space: area) of each overlap. It is relative to the smaller of two joints: the block of
        the row with its first support, and with its second support. The length of each joint includes the
        overlap.
    """
    ends = pairs[shared_sides.pair]
    is_fixed = scene.fixed[ends]
    at_support = np.flatnonzero(is_fixed.any(axis=1))
    support = np.where(is_fixed[:, 0], *ends.T)
    block = ends.sum(axis=1) - support
    nearer_joints, farther_joints = _near_rows(shared_sides, at_support, shapes.contact_tolerance)
    # Gaps within the tolerance count as zero, so that rounding errors do not choose between two supports.
    gap = np.where(shared_sides.largest_gap <= shapes.tolerance, 0.0, shared_sides.largest_gap)
    rank = np.argsort(np.lexsort((support, -_size_class(shared_sides.width, shapes.tolerance), gap)))
    is_candidate = (
        (block[nearer_joints] == block[farther_joints])
        & (support[nearer_joints] != support[farther_joints])
        & (rank[nearer_joints] < rank[farther_joints])
    )
    nearer_joints, farther_joints = nearer_joints[is_candidate], farther_joints[is_candidate]
    # Two joints can overlap only if they are in one line (in space: plane). Sides of a block do not cross, so
    # it suffices to test the midpoint of one joint.
    distance = np.abs(
        dots(
            shared_sides.normal[nearer_joints],
            shared_sides.middle[farther_joints] - shared_sides.middle[nearer_joints],
        )
    )
    is_in_line = distance <= shapes.contact_tolerance
    # Exclude two joints on opposite sides of a thin block, whose normals into the block point in opposite
    # directions.
    inwards = np.where(is_fixed[:, :1], -1.0, 1.0) * shared_sides.normal
    is_in_line &= dots(inwards[nearer_joints], inwards[farther_joints]) > 0
    nearer_joints, farther_joints = nearer_joints[is_in_line], farther_joints[is_in_line]
    extent, breadth = shared_sides.overlap(nearer_joints, farther_joints)
    has_overlap = breadth > shapes.contact_tolerance
    nearer_joints, farther_joints, extent = (
        nearer_joints[has_overlap],
        farther_joints[has_overlap],
        extent[has_overlap],
    )
    if not len(nearer_joints):
        return shared_sides, np.zeros((0, 3), dtype=int), np.zeros(0)
    doubled_joints = np.unique(farther_joints)
    uncovered_parts = [
        shared_sides.uncovered(row, nearer_joints[farther_joints == row], shapes.tolerance)
        for row in doubled_joints.tolist()
    ]
    joints = shared_sides.where(np.delete(np.arange(len(shared_sides.pair)), doubled_joints)).then(
        *uncovered_parts
    )
    rows = np.column_stack([block[nearer_joints], support[nearer_joints], support[farther_joints]])
    overlaps, number = np.unique(rows, axis=0, return_inverse=True)
    ratio = np.zeros(len(overlaps))
    smaller_extent = np.minimum(shared_sides.extent[nearer_joints], shared_sides.extent[farther_joints])
    np.maximum.at(ratio, number.ravel(), extent / smaller_extent)
    return joints.where(np.argsort(joints.pair, kind="stable")), overlaps, ratio


def _size_class(width: np.ndarray, tolerance: float) -> np.ndarray:
    """Group nearly equal widths of joints in classes, and return each joint's class, shape (rows,).

    A class is a number, which is higher for wider joints. In ascending order of the widths, a new class
    begins where a width exceeds the previous width by more than the tolerance. Rounding errors then do not
    choose between two supports.
    """
    order = np.argsort(width)
    size_class = np.zeros(len(width), dtype=int)
    size_class[order[1:]] = np.cumsum(np.diff(width[order]) > tolerance)
    return size_class


def _near_rows(shared_sides: Facing, joints: np.ndarray, tolerance: float) -> tuple[np.ndarray, np.ndarray]:
    """Return the pairs of joints whose bounding boxes are near each other, each pair in both orders.

    Two boxes are near if they touch after both are enlarged by the tolerance. ``joints`` has the indices of
    the joints to compare, and a joint is a row of ``shared_sides``.
    """
    if len(joints) < 2:
        return joints[:0], joints[:0]
    _, row, count, corners = shared_sides.where(joints).outlines()
    low, high = bounds(np.repeat(row, count), corners, len(joints))
    low, high = low - tolerance, high + tolerance
    # The search tree has two axes. In space, choose the two axes along which the joints extend farthest.
    axes = np.argsort(np.ptp(low, axis=0))[-2:]
    boxes = shapely.box(*low[:, axes].T, *high[:, axes].T)
    first, second = shapely.STRtree(boxes).query(boxes)
    is_near = ((low[first] <= high[second]) & (low[second] <= high[first])).all(axis=1)
    return joints[first[is_near]], joints[second[is_near]]

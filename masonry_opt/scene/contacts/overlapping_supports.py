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
    scene: Scene, shapes: Extents, pairs: np.ndarray, shared: Facing
) -> tuple[Facing, np.ndarray, np.ndarray]:
    """Where a block has joints with two overlapping supports, remove the overlap from one of them.

    Of two supports that overlap, one has the whole overlap:

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
    shared : Facing
        Lengths or polygons that the pairs share. At least one block of each pair can move.

    Returns
    -------
    shared : Facing
        Lengths or polygons without the parts that would count twice.
    overlaps : ndarray, shape (k, 3)
        Blocks that rest on two supports where these overlap: the block, the support with the joint, and the
        support without it. The rows are in ascending order.
    overlap_ratio : ndarray, shape (k,)
        Length (in space: area) of each overlap, relative to the smaller of its two joints.
    """
    ends = pairs[shared.pair]
    is_fixed = scene.fixed[ends]
    at_support = np.flatnonzero(is_fixed.any(axis=1))
    support = np.where(is_fixed[:, 0], *ends.T)
    block = ends.sum(axis=1) - support
    nearer, farther = _near_rows(shared, at_support, shapes.contact_tolerance)
    # Gaps within the tolerance count as zero, so that rounding errors do not choose between two supports.
    gap = np.where(shared.most <= shapes.tolerance, 0.0, shared.most)
    rank = np.argsort(np.lexsort((support, -_size_class(shared.width, shapes.tolerance), gap)))
    asked = (
        (block[nearer] == block[farther])
        & (support[nearer] != support[farther])
        & (rank[nearer] < rank[farther])
    )
    nearer, farther = nearer[asked], farther[asked]
    # Sides of a block do not cross, so two joints whose middles are in one line are on one side of the block.
    distance = np.abs(dots(shared.normal[nearer], shared.middle[farther] - shared.middle[nearer]))
    in_line = distance <= shapes.contact_tolerance
    # Joints on opposite sides of a thin block have normals into the block that point in opposite directions.
    inwards = np.where(is_fixed[:, :1], -1.0, 1.0) * shared.normal
    in_line &= dots(inwards[nearer], inwards[farther]) > 0
    nearer, farther = nearer[in_line], farther[in_line]
    extent, breadth = shared.overlap(nearer, farther)
    overlap = breadth > shapes.contact_tolerance
    nearer, farther, extent = nearer[overlap], farther[overlap], extent[overlap]
    if not len(nearer):
        return shared, np.zeros((0, 3), dtype=int), np.zeros(0)
    doubled = np.unique(farther)
    uncovered = [shared.uncovered(row, nearer[farther == row], shapes.tolerance) for row in doubled.tolist()]
    once = shared.where(np.delete(np.arange(len(shared.pair)), doubled)).then(*uncovered)
    rows = np.column_stack([block[nearer], support[nearer], support[farther]])
    overlaps, number = np.unique(rows, axis=0, return_inverse=True)
    ratio = np.zeros(len(overlaps))
    smaller = np.minimum(shared.extent[nearer], shared.extent[farther])
    np.maximum.at(ratio, number.ravel(), extent / smaller)
    return once.where(np.argsort(once.pair, kind="stable")), overlaps, ratio


def _size_class(width: np.ndarray, tolerance: float) -> np.ndarray:
    """Return the number of the class of each width, shape (rows,); wider joints have higher numbers.

    In ascending order, a width begins a new class if it exceeds the width before it by more than the
    tolerance. Rounding errors then do not choose between two supports.
    """
    order = np.argsort(width)
    size_class = np.zeros(len(width), dtype=int)
    size_class[order[1:]] = np.cumsum(np.diff(width[order]) > tolerance)
    return size_class


def _near_rows(shared: Facing, asked: np.ndarray, tolerance: float) -> tuple[np.ndarray, np.ndarray]:
    """Return the pairs of rows whose bounding boxes are within the tolerance of each other, in both orders.

    ``asked`` has the indices of the rows to compare.
    """
    if len(asked) < 2:
        return asked[:0], asked[:0]
    _, row, count, corners = shared.where(asked).outlines()
    low, high = bounds(np.repeat(row, count), corners, len(asked))
    low, high = low - tolerance, high + tolerance
    # The search tree has two axes. In space, choose the two axes along which the joints extend farthest.
    axes = np.argsort(np.ptp(low, axis=0))[-2:]
    boxes = shapely.box(*low[:, axes].T, *high[:, axes].T)
    first, second = shapely.STRtree(boxes).query(boxes)
    near = ((low[first] <= high[second]) & (low[second] <= high[first])).all(axis=1)
    return asked[first[near]], asked[second[near]]

"""Find pairs of blocks that are near each other, and the sides of each pair that face each other."""

from collections.abc import Callable

import numpy as np
import shapely

from masonry_opt.errors import CaseError
from masonry_opt.scene.contacts import edges, faces
from masonry_opt.scene.contacts.sides import BlockCorners, Facing, has_nearly_opposite_normals
from masonry_opt.scene.geometry import Extents, geometry
from masonry_opt.scene.rows import dots
from masonry_opt.scene.scene import Scene
from masonry_opt.scene.space.shapes import shapes as shapes_in_space

#: For each dimension (2 or 3): functions that compute the shapes of blocks, find facing sides, and find
#: contacts at corners.
CONTACT_FUNCTIONS: dict[
    int, tuple[Callable[[Scene], Extents], Callable[..., Facing], Callable[..., BlockCorners]]
] = {
    2: (geometry, edges.facing, edges.PlaneCorners),
    3: (shapes_in_space, faces.facing, faces.SolidCorners),
}

#: For each dimension (2 or 3): function that returns a point on each side of a block, and its normal.
_SIDES_OF_BLOCK: dict[int, Callable[..., tuple[np.ndarray, np.ndarray]]] = {
    2: edges.sides_of_block,
    3: faces.sides_of_block,
}

#: A scene raises an error if it has more pairs of neighbouring blocks than this number plus
#: ``_MOST_PAIRS_PER_BLOCK`` for each block. A larger value needs more time and memory for coincident blocks.
_MOST_PAIRS = 1_000_000

#: Number of pairs of neighbouring blocks that a scene may have for each block, see ``_MOST_PAIRS``. In a
#: wall, a block has about six neighbours.
_MOST_PAIRS_PER_BLOCK = 40

#: A gap counts as blocked, and gets no joint, if at least this many of its three test points are inside other
#: blocks. With a smaller value, a block in a small part of a gap blocks the whole gap.
_POINTS_BETWEEN = 2

#: Number of blocks whose neighbours are searched for at a time. A larger value needs more memory.
_BLOCKS_AT_A_TIME = 100


def near_pairs(scene: Scene, shapes: Extents, far: np.ndarray) -> np.ndarray:
    """Return the pairs of blocks whose bounding boxes are near each other, as sorted indices i < j.

    The shape is (pairs, 2). Two boxes are near if their distance is at most ``far`` of both blocks, shape
    (blocks,). Raises CaseError if there are too many pairs.
    """
    low, high = shapes.boxes
    axes = _search_axes(shapes)
    tree = shapely.STRtree(shapely.box(*low[:, axes].T, *high[:, axes].T))
    enlarged_boxes = shapely.box(*(low[:, axes] - far[:, None]).T, *(high[:, axes] + far[:, None]).T)
    count = len(low)
    pairs: list[np.ndarray] = []
    number_of_pairs = 0
    for first in range(0, count, _BLOCKS_AT_A_TIME):
        last = first + _BLOCKS_AT_A_TIME
        i, j = tree.query(enlarged_boxes[first:last])
        i += first
        distance = np.maximum(low[i] - high[j], low[j] - high[i]).max(axis=1)
        is_near = (i < j) & (distance <= np.minimum(far[i], far[j]))
        pairs.append(np.column_stack([i[is_near], j[is_near]]))
        number_of_pairs += len(pairs[-1])
        if number_of_pairs > _MOST_PAIRS + _MOST_PAIRS_PER_BLOCK * count:
            raise CaseError(
                f"{scene.origin}: too many blocks overlap or coincide "
                f"(the first {min(last, count)} blocks have {number_of_pairs} neighbours): "
                "check the coordinates of the blocks"
            )
    return np.unique(np.concatenate(pairs), axis=0)


def facing_sides(scene: Scene, shapes: Extents, pairs: np.ndarray, far: np.ndarray) -> Facing:
    """Return the pairs of sides that touch, or that face each other with no third block between them.

    Where a block touches two supports, the nearer support does not count as a block between the block and
    the farther support. :func:`~.overlapping_supports.count_once` divides the joint between the supports.

    Parameters
    ----------
    scene : Scene
        The scene.
    shapes : Extents
        Shapes of the blocks of the scene.
    pairs : ndarray, shape (pairs, 2)
        Pairs of blocks that are near each other.
    far : ndarray, shape (pairs,)
        Largest distance between sides that face each other, for each pair.
    """
    facing = CONTACT_FUNCTIONS[scene.dimension][1](scene, shapes, pairs, far)
    gap_rows = np.flatnonzero(facing.largest_gap > shapes.tolerance)
    ends = pairs[facing.pair[gap_rows]]
    touches_support = (scene.fixed[ends].sum(axis=1) == 1) & (
        facing.largest_gap[gap_rows] <= shapes.contact_tolerance
    )
    is_blocked = _has_block_between(
        shapes, ends, facing.inner_points[gap_rows], (touches_support, scene.fixed)
    )
    return facing.where(np.delete(np.arange(len(facing.pair)), gap_rows[is_blocked]))


def has_sides_at_small_angle(scene: Scene, shapes: Extents, first: int, second: int) -> bool:
    """Return True if sides of two blocks are nearly parallel, and each block is in front of the other's side.

    Unlike the sides in :func:`facing_sides`, these sides need not be opposite each other.
    """
    points, owner = shapes.corners
    normals = []
    for block, opposite_block in ((first, second), (second, first)):
        base, normal = _SIDES_OF_BLOCK[scene.dimension](shapes, block)
        height = normal @ points[owner == opposite_block].T - dots(normal, base)[:, None]
        normals.append(normal[height.max(axis=1) > shapes.tolerance])
    return has_nearly_opposite_normals(*normals)


def _has_block_between(
    shapes: Extents, ends: np.ndarray, inner_points: np.ndarray, ignored_masks: tuple[np.ndarray, np.ndarray]
) -> np.ndarray:
    """Return a mask of the gaps that contain a third block, shape (gaps,).

    At least two of the three points of a gap must be inside other blocks, because the remaining point may lie
    in a joint between these blocks.

    Parameters
    ----------
    shapes : Extents
        Shapes of the blocks of the scene.
    ends : ndarray, shape (gaps, 2)
        The two blocks of each gap.
    inner : ndarray, shape (gaps, 3, 2) or (gaps, 3, 3)
        Three points in the middle of each gap.
    ignored : tuple of ndarray
        Masks of gaps, shape (gaps,), and of blocks, shape (blocks,). The chosen blocks do not count as third
        blocks in the chosen gaps.
    """
    low, high = shapes.boxes
    axes = _search_axes(shapes)
    tree = shapely.STRtree(shapely.box(*low[:, axes].T, *high[:, axes].T))
    points, owner = (
        inner_points.reshape(-1, inner_points.shape[-1]),
        np.repeat(np.arange(len(ends)), inner_points.shape[1]),
    )
    point, block = tree.query(shapely.points(points[:, axes]))
    is_in_box = ((low[block] <= points[point]) & (points[point] <= high[block])).all(axis=1)
    is_third = is_in_box & (ends[owner[point]] != block[:, None]).all(axis=1)
    is_third &= ~(ignored_masks[0][owner[point]] & ignored_masks[1][block])
    is_inside = np.zeros(len(points), dtype=bool)
    for number, third_block in zip(point[is_third].tolist(), block[is_third].tolist(), strict=True):
        is_inside[number] |= shapes.away(third_block, points[number]) <= 0
    return np.bincount(owner, is_inside, len(ends)) >= _POINTS_BETWEEN


def _search_axes(shapes: Extents) -> np.ndarray:
    """Return the two coordinate axes along which the blocks extend farthest, for search trees."""
    return np.argsort(np.ptp(shapes.boxes[0], axis=0))[-2:]

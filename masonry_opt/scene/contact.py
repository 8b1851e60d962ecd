"""Joints from geometry: every pair of blocks that share a length of edge gets one."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp
import shapely
from scipy.sparse.csgraph import connected_components

from masonry_opt.errors import CaseError
from masonry_opt.scene.geometry import Geometry, raise_for
from masonry_opt.scene.scene import Scene

#: Stresses up to which dilatancy is whole and from which there is none, where it does not depend on them.
_ANY_STRESS = (np.inf, np.inf)

#: Edges that touch along a length are parallel up to this angle (radians).
_PARALLEL = 1e-3

#: Facing edges nearer than this, over the root of the smaller block's area, were perhaps meant to touch, and
#: overlaps no deeper come of rounded coordinates.
_NEAR_MISS = 1e-3

#: Pairs of blocks near each other: this many, and so many more for each block. Side by side a block has
#: some six neighbours; blocks that lie on one another are all each other's.
_MOST_PAIRS, _MOST_PAIRS_PER_BLOCK = 1_000_000, 40

#: Pairs of edges compared (of blocks that are near each other, in each other's box).
_MOST_EDGES = 20_000_000


@dataclass(frozen=True)
class Joints:
    """Arrays over the joints of a scene, ordered by (first, second) block.

    Attributes
    ----------
    first, second: indices into the scene's blocks, first < second, shape (joints,).
    start, end: the two ends, relative to the geometry's origin, shape (joints, 2).
    normal: unit normal pointing from the second block into the first, shape (joints, 2).
    length: of each joint, shape (joints,).
    friction, cohesion, dilatancy: properties; cohesion per unit length, shape (joints,).
    dilatancy_stress: mean normal stresses up to which dilatancy is whole and from which there is none,
        ``inf`` where it does not depend on them, shape (joints, 2).
    fixed_pairs: how many touching pairs were left out because both blocks are fixed.
    near_misses: pairs of blocks (indices) whose edges face each other across a small gap.
    """

    first: np.ndarray
    second: np.ndarray
    start: np.ndarray
    end: np.ndarray
    normal: np.ndarray
    length: np.ndarray
    friction: np.ndarray
    cohesion: np.ndarray
    dilatancy: np.ndarray
    dilatancy_stress: np.ndarray
    fixed_pairs: int
    near_misses: list[tuple[int, int]]

    @property
    def middle(self) -> np.ndarray:
        """Middle of each joint, shape (joints, 2)."""
        return (self.start + self.end) / 2


def find_joints(scene: Scene, geometry: Geometry) -> Joints:
    """Find the joints of a scene.

    Two blocks share a joint where their edges run within the geometry's tolerance of each other
    along more than that tolerance. Touching in a point makes no joint, nor do two fixed blocks.

    Raises
    ------
    CaseError
        If blocks overlap, a movable block touches nothing, an exception names two blocks that do not
        touch, or there are more pairs to compare than memory holds.
    """
    fixed = np.array([block.fixed for block in scene.blocks])
    pairs = _near_pairs(scene, geometry)
    both_fixed = fixed[pairs].all(axis=1)
    _refuse_overlaps(scene, geometry, pairs[~both_fixed])
    touching, start, end, near = _shared_edges(scene, geometry, pairs)
    joined, near = ~both_fixed[touching], near[~both_fixed[near]]
    fixed_pairs = int((~joined).sum())
    touching, start, end = touching[joined], start[joined], end[joined]
    first, second = pairs[touching, 0], pairs[touching, 1]
    _refuse_floating(scene, fixed, first, second)
    edge = end - start
    length = np.hypot(edge[:, 0], edge[:, 1])
    along = edge / length[:, None]
    friction, cohesion, dilatancy, dilatancy_stress = _properties(scene, first, second)
    return Joints(
        first=first,
        second=second,
        start=start,
        end=end,
        # Counter-clockwise round the first block its interior lies to the left.
        normal=np.column_stack([-along[:, 1], along[:, 0]]),
        length=length,
        friction=friction,
        cohesion=cohesion,
        dilatancy=dilatancy,
        dilatancy_stress=dilatancy_stress,
        fixed_pairs=fixed_pairs,
        near_misses=[(int(i), int(j)) for i, j in pairs[near]],
    )


def _near_pairs(scene: Scene, geometry: Geometry) -> np.ndarray:
    """Index pairs (i < j) of blocks that touch or nearly do, sorted, shape (pairs, 2)."""
    tree = shapely.STRtree(geometry.polygons)
    reach = np.maximum(geometry.tolerance, _NEAR_MISS * np.sqrt(geometry.area))
    count = len(geometry.polygons)
    found: list[np.ndarray] = []
    pairs = 0
    for first in range(0, count, 100):
        some = slice(first, first + 100)
        near = tree.query(geometry.polygons[some], predicate="dwithin", distance=reach[some]).T
        found.append(near + np.array([first, 0]))
        pairs += len(near)
        if pairs > _MOST_PAIRS + _MOST_PAIRS_PER_BLOCK * count:
            raise CaseError(
                f"{scene.origin}: blocks lie on one another: the first {min(first + 100, count)} have "
                f"{pairs} neighbours; give each block a place of its own"
            )
    both_ways = np.concatenate(found)
    return np.unique(np.sort(both_ways[both_ways[:, 0] != both_ways[:, 1]], axis=1), axis=0)


def _refuse_floating(scene: Scene, fixed: np.ndarray, first: np.ndarray, second: np.ndarray) -> None:
    """Refuse blocks that touch nothing, and groups of blocks that reach no support."""
    count = len(fixed)
    touched = np.zeros(count, dtype=bool)
    touched[first] = touched[second] = True
    raise_for(
        np.flatnonzero(~touched & ~fixed),
        scene,
        "touches no other block along an edge: close the gap (or raise 'tolerance'), or take the block away",
    )
    links = sp.coo_array((np.ones(len(first)), (first, second)), shape=(count, count))
    _, group = connected_components(links, directed=False)
    supported = np.isin(group, group[fixed])
    raise_for(
        np.flatnonzero(~supported),
        scene,
        "reaches no fixed block, neither itself nor through others: support it",
    )


def _refuse_overlaps(scene: Scene, geometry: Geometry, pairs: np.ndarray) -> None:
    common = shapely.intersection(geometry.polygons[pairs[:, 0]], geometry.polygons[pairs[:, 1]])
    area, perimeter = shapely.area(common), shapely.length(common)
    # Mean width of a sliver: area over half its perimeter.
    depth = np.divide(2 * area, perimeter, out=np.zeros_like(area), where=area > 0)
    deep = np.flatnonzero(depth > geometry.tolerance)
    if len(deep):
        worst = deep[np.argmax(area[deep])]
        one, other = (repr(scene.blocks[index].name) for index in pairs[worst])
        middle = shapely.get_coordinates(shapely.centroid(common[worst]))[0] + geometry.origin
        x, y = (f"{0.0 if abs(value) <= geometry.tolerance else value:.6g}" for value in middle)
        # Rounding leaves slivers; what is deeper is no matter of tolerance.
        shallow = depth[worst] <= _NEAR_MISS * np.sqrt(geometry.area[pairs[worst]].min())
        rounded = ", or raise 'tolerance' if their coordinates were rounded" if shallow else ""
        more = f" ({len(deep) - 1} more pairs overlap)" if len(deep) > 1 else ""
        raise CaseError(
            f"{scene.origin}: blocks {one} and {other} overlap over an area of {area[worst]:.6g} round "
            f"({x}, {y}): move them apart{rounded}{more}"
        )


def _shared_edges(
    scene: Scene, geometry: Geometry, pairs: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Which pairs share a length of edge, its two ends along the first block's edge, and which
    pairs face each other across a small gap only."""
    corners, owner = shapely.get_coordinates(shapely.get_exterior_ring(geometry.polygons), return_index=True)
    inside = owner[:-1] == owner[1:]
    edges = _Edges(corners[:-1][inside], corners[1:][inside], owner[:-1][inside])
    reach = np.maximum(
        geometry.tolerance, _NEAR_MISS * np.sqrt(geometry.area[pairs].min(axis=1, initial=np.inf))
    )
    corners_of = np.bincount(edges.owner, minlength=len(geometry.polygons))
    if corners_of[pairs].sum() > _MOST_EDGES:
        raise _too_fine(scene, corners_of)
    near_edges = edges.combinations(pairs, reach, shapely.bounds(geometry.polygons))
    if near_edges is None:
        raise _too_fine(scene, corners_of)
    pair, i, j = near_edges

    edge = edges.tip[i] - edges.tail[i]
    length = np.hypot(edge[:, 0], edge[:, 1])
    along = edge / length[:, None]
    normal = np.column_stack([-along[:, 1], along[:, 0]])
    other = edges.tip[j] - edges.tail[j]
    facing = (other * along).sum(axis=1) < 0
    sine = np.abs((other * normal).sum(axis=1)) / np.hypot(other[:, 0], other[:, 1])
    # Positions of the other edge's ends along and across this edge.
    from_tail, from_tip = edges.tail[j] - edges.tail[i], edges.tip[j] - edges.tail[i]
    x0, x1 = (from_tip * along).sum(axis=1), (from_tail * along).sum(axis=1)
    y0, y1 = (from_tip * normal).sum(axis=1), (from_tail * normal).sum(axis=1)
    low, high = np.maximum(x0, 0.0), np.minimum(x1, length)
    slope = np.divide(y1 - y0, x1 - x0, out=np.zeros_like(y0), where=x1 > x0)
    gap = np.maximum(np.abs(y0 + slope * (low - x0)), np.abs(y0 + slope * (high - x0)))
    opposite = facing & (sine <= _PARALLEL) & (high - low > geometry.tolerance)
    shared = opposite & (gap <= geometry.tolerance)
    near = np.setdiff1d(pair[opposite & (gap <= reach[pair])], pair[shared])

    # Convex blocks meet along one line; of edges broken within the tolerance keep the longest.
    shared_at = np.flatnonzero(shared)
    longest_first = np.lexsort((-(high - low)[shared_at], pair[shared_at]))
    shared_at = shared_at[longest_first]
    touching, position = np.unique(pair[shared_at], return_index=True)
    chosen = shared_at[position]
    base = edges.tail[i[chosen]]
    start = base + low[chosen, None] * along[chosen]
    end = base + high[chosen, None] * along[chosen]
    return touching, start, end, near


def _too_fine(scene: Scene, corners: np.ndarray) -> CaseError:
    finest = int(corners.argmax())
    return CaseError(
        f"{scene.origin}: outlines are too fine to find joints (block {scene.blocks[finest].name!r} has "
        f"{corners[finest]} corners): raise 'tolerance', or give fewer corners"
    )


@dataclass(frozen=True)
class _Edges:
    """Edges of all blocks in turn: their ends, shape (edges, 2), and their blocks, shape (edges,)."""

    tail: np.ndarray
    tip: np.ndarray
    owner: np.ndarray

    def combinations(
        self, pairs: np.ndarray, reach: np.ndarray, bounds: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray] | None:
        """Pair, edge of its first and edge of its second block, of all that could touch: an edge
        that stays out of the other block's box cannot. None if they are too many."""
        pair1, i = self._beside(pairs[:, 0], bounds[pairs[:, 1]], reach)
        pair2, j = self._beside(pairs[:, 1], bounds[pairs[:, 0]], reach)
        count2 = np.bincount(pair2, minlength=len(pairs))
        first2 = np.cumsum(count2) - count2
        repeat = count2[pair1]
        if repeat.sum() > _MOST_EDGES:
            return None
        position = np.arange(repeat.sum()) - np.repeat(np.cumsum(repeat) - repeat, repeat)
        pair = np.repeat(pair1, repeat)
        return pair, np.repeat(i, repeat), j[first2[pair] + position]

    def _beside(
        self, blocks: np.ndarray, boxes: np.ndarray, reach: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray]:
        """Pair and edge, for the edges of each pair's block that come near a box, pair by pair."""
        count = np.bincount(self.owner, minlength=blocks.max(initial=-1) + 1)
        first = np.cumsum(count) - count
        pair = np.repeat(np.arange(len(blocks)), count[blocks])
        offset = np.arange(len(pair)) - np.repeat(np.cumsum(count[blocks]) - count[blocks], count[blocks])
        edge = first[blocks[pair]] + offset
        low = np.minimum(self.tail[edge], self.tip[edge]) - reach[pair, None]
        high = np.maximum(self.tail[edge], self.tip[edge]) + reach[pair, None]
        near = (low <= boxes[pair, 2:]).all(axis=1) & (high >= boxes[pair, :2]).all(axis=1)
        return pair[near], edge[near]


def _properties(
    scene: Scene, first: np.ndarray, second: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    defaults = scene.joints
    friction = np.full(len(first), defaults.friction)
    cohesion = np.full(len(first), defaults.cohesion)
    dilatancy = np.full(len(first), defaults.dilatancy)
    stress = np.tile(defaults.dilatancy_stress or _ANY_STRESS, (len(first), 1))
    if scene.exceptions:
        index = {block.name: number for number, block in enumerate(scene.blocks)}
        joint_of = {pair: joint for joint, pair in enumerate(zip(first, second, strict=True))}
        for exception in scene.exceptions:
            one, other = sorted(index[name] for name in exception.between)
            joint = joint_of.get((one, other))
            if joint is None:
                why = (
                    "are both fixed"
                    if scene.blocks[one].fixed and scene.blocks[other].fixed
                    else "do not touch"
                )
                raise CaseError(
                    f"{scene.origin}: joint between {list(exception.between)}: these blocks {why}, "
                    "so there is no joint to describe"
                )
            own = exception.over(defaults)
            friction[joint], cohesion[joint], dilatancy[joint] = (
                own.friction,
                own.cohesion,
                own.dilatancy,
            )
            stress[joint] = own.dilatancy_stress or _ANY_STRESS
    # A joint with unlimited friction never slides: cohesion and dilatancy say nothing there.
    unlimited = np.isinf(friction)
    cohesion[unlimited] = 0.0
    dilatancy[unlimited] = 0.0
    return friction, cohesion, dilatancy, stress

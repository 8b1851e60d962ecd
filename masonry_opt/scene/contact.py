"""Joints from geometry: every length of edge that two blocks share, and every corner on an edge."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp
import shapely
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree

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
    length: of each joint, 0 where a corner stands on an edge, shape (joints,).
    friction, cohesion, dilatancy: properties; cohesion per unit length, shape (joints,).
    dilatancy_stress: mean normal stresses up to which dilatancy is whole and from which there is none,
        ``inf`` where it does not depend on them, shape (joints, 2).
    strength: compressive, per unit length, ``inf`` where joints carry any pressure, shape (joints,).
    fixed_pairs: how many touching pairs were left out because both blocks are fixed.
    near_misses: pairs of blocks (indices) whose edges face each other across a small gap.
    corners: pairs of blocks (indices) that meet corner on corner, which has no normal and is no joint,
        where not both have a joint that ends there.
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
    strength: np.ndarray
    fixed_pairs: int
    near_misses: list[tuple[int, int]]
    corners: list[tuple[int, int]]

    @property
    def middle(self) -> np.ndarray:
        """Middle of each joint, shape (joints, 2)."""
        return (self.start + self.end) / 2


def find_joints(scene: Scene, geometry: Geometry) -> Joints:
    """Find the joints of a scene.

    Two blocks share a joint wherever their edges run within the geometry's tolerance of each other along more
    than that tolerance. Where a corner of one stands on an edge of the other, away from such a length, is a
    joint without length, normal to the edge. Two fixed blocks share no joint.

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
    edges = _Edges.of(scene, geometry, pairs)
    along, near = _shared_edges(scene, edges, geometry, pairs)
    joined, near = ~both_fixed[along.pair], near[~both_fixed[near]]
    fixed_pairs = len(np.unique(along.pair[~joined]))
    along = along.where(joined)
    points, corners = _points(edges, geometry, pairs, along, np.flatnonzero(~both_fixed))
    found = along.with_points(points)
    first, second = pairs[found.pair, 0], pairs[found.pair, 1]
    _refuse_floating(scene, fixed, first, second)
    edge = found.end - found.start
    return Joints(
        first=first,
        second=second,
        start=found.start,
        end=found.end,
        normal=found.normal,
        length=np.hypot(edge[:, 0], edge[:, 1]),
        **_properties(scene, first, second),
        fixed_pairs=fixed_pairs,
        near_misses=[(int(i), int(j)) for i, j in pairs[near]],
        corners=[(int(i), int(j)) for i, j in pairs[corners]],
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
        "touches no other block, neither along an edge nor with a corner on one: close the gap (or raise "
        "'tolerance'), or take the block away",
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


@dataclass(frozen=True)
class _Contacts:
    """Where blocks touch: which pair, from where to where, and the normal into its first block."""

    pair: np.ndarray
    start: np.ndarray
    end: np.ndarray
    normal: np.ndarray

    def where(self, kept: np.ndarray) -> _Contacts:
        return _Contacts(self.pair[kept], self.start[kept], self.end[kept], self.normal[kept])

    def with_points(self, points: _Contacts) -> _Contacts:
        """Both, by pairs, along edges first."""
        order = np.argsort(np.concatenate([self.pair, points.pair]), kind="stable")
        stacked = (
            np.concatenate([getattr(self, name), getattr(points, name)])[order]
            for name in ("pair", "start", "end", "normal")
        )
        return _Contacts(*stacked)


def _shared_edges(
    scene: Scene, edges: _Edges, geometry: Geometry, pairs: np.ndarray
) -> tuple[_Contacts, np.ndarray]:
    """The lengths of edge that pairs share, and which pairs face each other across a small gap only."""
    reach = np.maximum(
        geometry.tolerance, _NEAR_MISS * np.sqrt(geometry.area[pairs].min(axis=1, initial=np.inf))
    )
    near_edges = edges.combinations(pairs, reach, shapely.bounds(geometry.polygons))
    if near_edges is None:
        raise _too_fine(scene, edges.of_each(len(geometry.polygons)))
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
    longest = np.append(True, pair[shared_at][1:] != pair[shared_at][:-1])[: len(shared_at)]
    notched = ~geometry.convex[pairs].all(axis=1)
    chosen = shared_at[longest | notched[pair[shared_at]]]
    base = edges.tail[i[chosen]]
    start = base + low[chosen, None] * along[chosen]
    end = base + high[chosen, None] * along[chosen]
    # Counter-clockwise round the first block its interior lies to the left.
    inwards = (end - start) / np.hypot(*(end - start).T)[:, None]
    normal = np.column_stack([-inwards[:, 1], inwards[:, 0]])
    return _Contacts(pair[chosen], start, end, normal), near


def _points(
    edges: _Edges, geometry: Geometry, pairs: np.ndarray, along: _Contacts, joined: np.ndarray
) -> tuple[_Contacts, np.ndarray]:
    """Corners on edges, away from what their pair shares along edges, and which pairs meet corner on corner
    where not both blocks have such a length that ends there.

    Parameters
    ----------
    along: the lengths of edge that pairs share.
    joined: pairs that can have joints.
    """
    tolerance = geometry.tolerance
    # Two convex blocks that share a length of edge meet nowhere else.
    alone = np.ones(len(pairs), dtype=bool)
    alone[along.pair] = ~geometry.convex[pairs[along.pair]].all(axis=1)
    asked = joined[alone[joined]]
    reach = np.full(len(asked), tolerance)
    near_edges = edges.combinations(pairs[asked], reach, shapely.bounds(geometry.polygons))
    assert near_edges is not None  # they are fewer than those of the shared edges
    number, i, j = near_edges
    found, on_corners = [], []
    for corner_of, edge_of, sign in ((i, j, -1.0), (j, i, 1.0)):
        point, tail = edges.tail[corner_of], edges.tail[edge_of]
        edge = edges.tip[edge_of] - tail
        length = np.hypot(edge[:, 0], edge[:, 1])
        direction = edge / length[:, None]
        normal = np.column_stack([-direction[:, 1], direction[:, 0]])
        at, across = ((point - tail) * direction).sum(axis=1), ((point - tail) * normal).sum(axis=1)
        within = (np.abs(across) <= tolerance) & (at > tolerance) & (at < length - tolerance)
        # The normal of an edge points into its own block.
        contact = _Contacts(asked[number[within]], point[within], point[within], sign * normal[within])
        found.append(contact.where(_apart(contact.pair, contact.start, along, tolerance)))
        meets = np.hypot(*(point - tail).T) <= tolerance
        on_corners.append((asked[number[meets]], point[meets]))
    pair, point = (np.concatenate(parts) for parts in zip(*on_corners, strict=True))
    apart = _apart(pair, point, along, tolerance)
    pair, point = pair[apart], point[apart]
    held = [_ends_at(pairs[pair, side], point, pairs, along, tolerance) for side in (0, 1)]
    points = found[0].with_points(found[1])
    loose = np.setdiff1d(pair[~(held[0] & held[1])], points.pair)
    return points, loose


def _apart(pair: np.ndarray, point: np.ndarray, along: _Contacts, tolerance: float) -> np.ndarray:
    """Whether points lie off every length of edge that their pair shares."""
    apart = np.ones(len(pair), dtype=bool)
    for number in np.flatnonzero(np.isin(pair, along.pair)):
        own = along.pair == pair[number]
        lines = shapely.linestrings(np.stack([along.start[own], along.end[own]], axis=1))
        apart[number] = (shapely.distance(lines, shapely.Point(point[number])) > 2 * tolerance).all()
    return apart


def _ends_at(
    blocks: np.ndarray, points: np.ndarray, pairs: np.ndarray, along: _Contacts, tolerance: float
) -> np.ndarray:
    """Whether each of these blocks shares a length of edge with any other that ends at its point."""
    ends = np.concatenate([along.start, along.end])
    of_ends = np.concatenate([pairs[along.pair]] * 2)
    if not len(points) or not len(ends):
        return np.zeros(len(points), dtype=bool)
    near = cKDTree(ends).query_ball_point(points, 2 * tolerance)
    return np.array([(of_ends[at] == block).any() for block, at in zip(blocks, near, strict=True)])


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

    @classmethod
    def of(cls, scene: Scene, geometry: Geometry, pairs: np.ndarray) -> _Edges:
        """Those of all blocks, refused if they are too many to compare."""
        edges = cls(*geometry.edges())
        corners_of = edges.of_each(len(geometry.polygons))
        if corners_of[pairs].sum() > _MOST_EDGES:
            raise _too_fine(scene, corners_of)
        return edges

    def of_each(self, blocks: int) -> np.ndarray:
        """Number of edges of each block, shape (blocks,)."""
        return np.bincount(self.owner, minlength=blocks)

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


def _properties(scene: Scene, first: np.ndarray, second: np.ndarray) -> dict[str, np.ndarray]:
    """Properties of joints by name, as :class:`Joints` has them."""
    defaults = scene.joints
    friction = np.full(len(first), defaults.friction)
    cohesion = np.full(len(first), defaults.cohesion)
    dilatancy = np.full(len(first), defaults.dilatancy)
    stress = np.tile(defaults.dilatancy_stress or _ANY_STRESS, (len(first), 1))
    strength = np.full(len(first), defaults.strength or np.inf)
    index = {block.name: number for number, block in enumerate(scene.blocks)}
    key = first * np.int64(len(index)) + second  # rising: joints are sorted
    for exception in scene.exceptions:
        one, other = sorted(index[name] for name in exception.between)
        own_key = one * len(index) + other
        of_both = slice(np.searchsorted(key, own_key), np.searchsorted(key, own_key, side="right"))
        if of_both.start == of_both.stop:
            both_fixed = scene.blocks[one].fixed and scene.blocks[other].fixed
            why = "are both fixed" if both_fixed else "do not touch"
            raise CaseError(
                f"{scene.origin}: joint between {list(exception.between)}: these blocks {why}, "
                "so there is no joint to describe"
            )
        own = exception.over(defaults)
        friction[of_both], cohesion[of_both], dilatancy[of_both] = own.friction, own.cohesion, own.dilatancy
        stress[of_both] = own.dilatancy_stress or _ANY_STRESS
        strength[of_both] = own.strength or np.inf
    # A joint with unlimited friction never slides: cohesion and dilatancy say nothing there.
    unlimited = np.isinf(friction)
    cohesion[unlimited] = 0.0
    dilatancy[unlimited] = 0.0
    return {
        "friction": friction,
        "cohesion": cohesion,
        "dilatancy": dilatancy,
        "dilatancy_stress": stress,
        "strength": strength,
    }

"""Where the outlines of blocks touch: lengths of edge that two share, and corners on edges."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Self

import numpy as np
import shapely

from masonry_opt.errors import CaseError
from masonry_opt.scene.combinations import ranges
from masonry_opt.scene.geometry import Geometry
from masonry_opt.scene.scene import Scene

#: Edges touch along a length if they are nowhere farther apart than this share of it (and the tolerance).
#: From ten tolerances on they may lean by any angle that the tolerance allows, shorter ones by this share.
LEAN = 0.1

#: Share of the tolerance that is rounding.
_ROUNDING = 1e-3

#: Most pairs of edges that are compared.
_MOST_EDGES = 20_000_000


@dataclass(frozen=True)
class _Parts:
    """Lines by pair of blocks: which pair, from where to where."""

    pair: np.ndarray
    start: np.ndarray
    end: np.ndarray

    @property
    def length(self) -> np.ndarray:
        """Length of each, shape (parts,)."""
        return np.hypot(*(self.end - self.start).T)

    def where(self, kept: np.ndarray) -> Self:
        """Those of a mask, or with these numbers in this order."""
        return type(self)(*(column[kept] for column in vars(self).values()))

    def by_pair(self, *more: Self) -> Self:
        """These and more, ordered by pair; within a pair as given."""
        stacked = zip(*(vars(parts).values() for parts in (self, *more)), strict=True)
        whole = type(self)(*map(np.concatenate, stacked))
        return whole.where(np.argsort(whole.pair, kind="stable"))


@dataclass(frozen=True)
class Contacts(_Parts):
    """Joints of pairs, in the sense of their first block's edges, with the normal into the first block."""

    normal: np.ndarray


@dataclass(frozen=True)
class _Facing(_Parts):
    """Parts of the bisectors of facing edges onto which both edges project, in the sense of the first block's
    edge, with the largest distance of the edges there."""

    largest: np.ndarray

    @classmethod
    def of(cls, edges: Edges, pair: np.ndarray, i: np.ndarray, j: np.ndarray, shortest: float) -> _Facing:
        """Those of edges i of the pairs' first and j of their second blocks that are longer than that."""
        one, other = edges.tip[i] - edges.tail[i], edges.tail[j] - edges.tip[j]
        one, other = (edge / np.hypot(*edge.T)[:, None] for edge in (one, other))
        kept = (one * other).sum(axis=1) > 0
        pair, i, j, along = pair[kept], i[kept], j[kept], (one + other)[kept]
        along /= np.hypot(*along.T)[:, None]
        # Both edges run along the bisector; each end of what they share is a corner of the one or the other.
        lines = (edges.tail[i], edges.tip[i]), (edges.tip[j], edges.tail[j])
        x = np.array([[((end - edges.tail[i]) * along).sum(axis=1) for end in line] for line in lines])
        at = np.maximum(x[0, 0], x[1, 0]), np.minimum(x[0, 1], x[1, 1])
        ends, apart = [], []
        for end, to in enumerate(at):
            of_first = (x[0, end] == to)[:, None]
            corner = np.where(of_first, lines[0][end], lines[1][end])
            start, tip = (np.where(of_first, lines[1][e], lines[0][e]) for e in (0, 1))
            x0, x1 = (np.where(of_first[:, 0], x[1, e], x[0, e]) for e in (0, 1))
            across = start + ((to - x0) / (x1 - x0))[:, None] * (tip - start) - corner
            width = np.hypot(*across.T)
            # Rounding moves no corner: what touches has the coordinates that were given.
            ends.append(corner + np.where(width > _ROUNDING * shortest, 0.5, 0.0)[:, None] * across)
            apart.append(width)
        return cls(pair, ends[0], ends[1], np.maximum(*apart)).where(at[1] - at[0] > shortest)


def shared_edges(edges: Edges, pairs: np.ndarray) -> tuple[Contacts, np.ndarray]:
    """The lengths of edge that pairs share; and of each pair the width of a small gap across which its blocks
    face each other beside them, shape (pairs,): the tolerance at which they touch there; ``inf`` without one.

    Edges share the part of their bisector onto which both project, if their largest distance there is within
    the tolerance. Parts that follow one another (an edge drawn in chords) are one length, or several where it
    bends by more than the tolerance.
    """
    tolerance = edges.shapes.tolerance
    far = edges.shapes.reach[pairs].min(axis=1, initial=np.inf)
    facing = _Facing.of(edges, *edges.combinations(pairs, far), shortest=tolerance)
    shared = _joined(facing.where(facing.largest <= tolerance), tolerance)
    leaning = (facing.largest > tolerance) & (facing.largest <= LEAN * facing.length)
    near = facing.where(leaning & (facing.largest <= far[facing.pair]))
    # Beside all that the pair shares, and no mere chamfer of it: a tenth as long.
    off = _distance(near.pair, (near.start + near.end) / 2, shared) > 2 * near.largest
    of_pair = np.bincount(shared.pair, shared.length, len(pairs))
    near = near.where(off & (near.length > LEAN * of_pair[near.pair]))
    width = np.full(len(pairs), np.inf)
    np.minimum.at(width, near.pair, near.largest)
    # Counter-clockwise round the first block its interior lies to the left.
    inwards = (shared.end - shared.start) / shared.length[:, None]
    normal = np.column_stack([-inwards[:, 1], inwards[:, 0]])
    return Contacts(shared.pair, shared.start, shared.end, normal), width


def _joined(parts: _Facing, tolerance: float) -> _Facing:
    """Parts, those that follow one another joined where their line is straight within the tolerance; without
    those that are too short for their width."""
    pairs, number, count = np.unique(parts.pair, return_inverse=True, return_counts=True)
    found = [
        _simplified(chain, tolerance)
        for pair in pairs[count > 1]
        for chain in _chains(parts.where(parts.pair == pair), tolerance)
    ]
    whole = parts.where(count[number] == 1).by_pair(*found)
    return whole.where(whole.largest <= LEAN * whole.length)


def _chains(parts: _Facing, tolerance: float) -> Iterator[_Facing]:
    """Chains of parts of one pair, each of which begins where the one before ends: within two tolerances, as
    a piece too short to be a part may lie between."""
    apart = np.hypot(*np.moveaxis(parts.end[:, None] - parts.start[None], 2, 0))
    np.fill_diagonal(apart, np.inf)
    after = {int(k): int(apart[k].argmin()) for k in np.flatnonzero(apart.min(axis=1) <= 2 * tolerance)}
    left = set(range(len(parts.pair)))
    # Begin with those that follow none; what is left then is a ring.
    for first in [*sorted(left - set(after.values())), *sorted(left)]:
        chain, at = [], first
        while at in left:
            left.remove(at)
            chain.append(at)
            at = after.get(at, -1)
        if chain:
            yield parts.where(np.array(chain))


def _simplified(chain: _Facing, tolerance: float) -> _Facing:
    """A chain's line without the corners that lie within half the tolerance of the line without them."""
    inner = (chain.end[:-1] + chain.start[1:]) / 2
    line = shapely.LineString(np.concatenate([chain.start[:1], inner, chain.end[-1:]]))
    corners = shapely.get_coordinates(shapely.simplify(line, tolerance / 2, preserve_topology=False))
    count = len(corners) - 1
    largest = np.full(count, chain.largest.max())
    return _Facing(np.full(count, chain.pair[0]), corners[:-1], corners[1:], largest)


def corners_on_edges(
    edges: Edges, pairs: np.ndarray, along: Contacts, joined: np.ndarray
) -> tuple[Contacts, np.ndarray]:
    """Corners on edges, away from what their pair shares along edges, and which pairs meet corner on corner
    where not both blocks have such a length that ends there.

    Parameters
    ----------
    along: the lengths of edge that pairs share.
    joined: pairs that can have joints.
    """
    tolerance = edges.shapes.tolerance
    # Two convex blocks that share a length of edge meet nowhere else.
    alone = np.ones(len(pairs), dtype=bool)
    alone[along.pair] = ~edges.shapes.convex[pairs[along.pair]].all(axis=1)
    asked = joined[alone[joined]]
    number, i, j = edges.combinations(pairs[asked], np.full(len(asked), tolerance))
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
        contact = Contacts(asked[number[within]], point[within], point[within], sign * normal[within])
        found.append(contact.where(_distance(contact.pair, contact.start, along) > 2 * tolerance))
        meets = np.hypot(*(point - tail).T) <= tolerance
        on_corners.append((asked[number[meets]], point[meets]))
    pair, point = (np.concatenate(parts) for parts in zip(*on_corners, strict=True))
    apart = _distance(pair, point, along) > 2 * tolerance
    pair, point = pair[apart], point[apart]
    held = [_ends_at(pairs[pair, side], point, pairs, along, tolerance) for side in (0, 1)]
    points = found[0].by_pair(found[1])
    loose = np.setdiff1d(pair[~(held[0] & held[1])], points.pair)
    return points, loose


def _distance(pair: np.ndarray, point: np.ndarray, shared: Contacts | _Facing) -> np.ndarray:
    """Distance of points from what their pair shares along edges, ``inf`` where that is nothing."""
    distance = np.full(len(pair), np.inf)
    for number in np.flatnonzero(np.isin(pair, shared.pair)):
        own = shared.pair == pair[number]
        lines = shapely.linestrings(np.stack([shared.start[own], shared.end[own]], axis=1))
        distance[number] = shapely.distance(lines, shapely.Point(point[number])).min()
    return distance


def _ends_at(
    blocks: np.ndarray, points: np.ndarray, pairs: np.ndarray, along: Contacts, tolerance: float
) -> np.ndarray:
    """Whether each of these blocks shares a length of edge with any other that ends at its point."""
    if not len(points):
        return np.zeros(0, dtype=bool)
    ends = np.concatenate([along.start, along.end])
    of_ends = np.concatenate([pairs[along.pair]] * 2)
    tree = shapely.STRtree(shapely.points(ends))
    at, near = tree.query(shapely.points(points), predicate="dwithin", distance=2 * tolerance)
    found = np.zeros(len(points), dtype=bool)
    found[at[(of_ends[near] == blocks[at][:, None]).any(axis=1)]] = True
    return found


@dataclass(frozen=True)
class Edges:
    """Edges of all blocks in turn: their ends, shape (edges, 2), and their blocks, shape (edges,)."""

    tail: np.ndarray
    tip: np.ndarray
    owner: np.ndarray
    scene: Scene
    shapes: Geometry

    @property
    def of_each(self) -> np.ndarray:
        """Number of edges of each block, shape (blocks,)."""
        return np.bincount(self.owner, minlength=len(self.scene.blocks))

    def _refuse_more(self, compared: int) -> None:
        if compared > _MOST_EDGES:
            finest = int(self.of_each.argmax())
            raise CaseError(
                f"{self.scene.origin}: outlines are too fine to find joints (block "
                f"{self.scene.blocks[finest].name!r} has {self.of_each[finest]} corners): raise 'tolerance', "
                "or give fewer corners"
            )

    def combinations(self, pairs: np.ndarray, reach: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Pair, edge of its first and edge of its second block, of all edges that could touch: one that stays
        out of the other block's box cannot. Raises CaseError if they are too many."""
        self._refuse_more(int(self.of_each[pairs].sum()))
        (pair1, i), (pair2, j) = (self._beside(pairs, side, reach) for side in (0, 1))
        count2 = np.bincount(pair2, minlength=len(pairs))
        repeat = count2[pair1]
        self._refuse_more(int(repeat.sum()))
        numbers2 = ranges((np.cumsum(count2) - count2)[pair1], repeat)
        return np.repeat(pair1, repeat), np.repeat(i, repeat), j[numbers2]

    def _beside(self, pairs: np.ndarray, side: int, reach: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Pair and edge, of the edges of each pair's block on a side that come near the other's box."""
        count, blocks = self.of_each, pairs[:, side]
        pair = np.repeat(np.arange(len(blocks)), count[blocks])
        edge = ranges((np.cumsum(count) - count)[blocks], count[blocks])
        boxes = shapely.bounds(self.shapes.polygons)[pairs[:, 1 - side]][pair]
        low = np.minimum(self.tail[edge], self.tip[edge]) - reach[pair, None]
        high = np.maximum(self.tail[edge], self.tip[edge]) + reach[pair, None]
        near = (low <= boxes[:, 2:]).all(axis=1) & (high >= boxes[:, :2]).all(axis=1)
        return pair[near], edge[near]

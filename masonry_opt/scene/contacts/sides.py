"""Sides of blocks that come near each other: what they share, and where blocks touch or meet beside that."""

from abc import ABC, abstractmethod
from collections import defaultdict
from dataclasses import dataclass, replace
from itertools import chain

import numpy as np

from masonry_opt.scene.geometry import Extents
from masonry_opt.scene.rows import Rows, chunks, combine, dots, lengths, ranges

#: Edges touch along a length if they are nowhere farther apart than this share of it (and the tolerance).
#: From ten tolerances on they may lean by any angle that the tolerance allows, shorter ones by this share.
LEAN = 0.1


@dataclass(frozen=True)
class Items:
    """Faces, edges or corners of the blocks in turn: the block of each, rising, and the boxes round them."""

    block: np.ndarray
    low: np.ndarray
    high: np.ndarray

    def beside(self, shapes: Extents, pairs: np.ndarray, far: np.ndarray) -> tuple[np.ndarray, ...]:
        """Pair, rising, and item of its first block that is as near as ``far`` to its second's box."""
        (low, high), (block, other) = shapes.boxes, pairs.T
        count = np.bincount(self.block, minlength=len(low))
        pair = np.repeat(np.arange(len(pairs)), count[block])
        item = ranges((np.cumsum(count) - count)[block], count[block])
        off = np.maximum(self.low[item] - high[other[pair]], low[other[pair]] - self.high[item]).max(axis=1)
        near = off <= far[pair]
        return pair[near], item[near]


def near_items(
    shapes: Extents, pairs: np.ndarray, far: np.ndarray | float, kinds: tuple[Items, Items]
) -> tuple[np.ndarray, ...]:
    """Pair, rising, item of its first and of its second block, of boxes as near as ``far``."""
    (one, other), far = kinds, np.broadcast_to(far, len(pairs))
    pair1, item1 = one.beside(shapes, pairs, far)
    pair2, item2 = other.beside(shapes, pairs[:, ::-1], far)
    count1, count2 = (np.bincount(pair, minlength=len(pairs)) for pair in (pair1, pair2))
    first1, first2 = np.cumsum(count1) - count1, np.cumsum(count2) - count2
    found = [np.zeros((3, 0), dtype=int)]
    for some in chunks(count1 * count2):
        number, i, j = combine(first1[some], count1[some], first2[some], count2[some])
        pair, i, j = number + some.start, item1[i], item2[j]
        off = np.maximum(one.low[i] - other.high[j], other.low[j] - one.high[i]).max(axis=1)
        near = off <= far[pair]
        found.append(np.stack([pair, i, j])[:, near])
    return tuple(np.concatenate(found, axis=1))


@dataclass(frozen=True)
class Facing(Rows, ABC):
    """Lengths or polygons onto which two blocks' sides that face each other project, halfway between them."""

    pair: np.ndarray  #: number of each one's pair of blocks, rising, shape (facing,)
    most: np.ndarray  #: how far at most the second block's side lies outside the first's, shape (facing,)
    extent: np.ndarray  #: length, or area, shape (facing,)
    middle: np.ndarray  #: or centroid, shape (facing, 2) or (facing, 3)
    normal: np.ndarray  #: unit normal into the first block, of the same shape
    accuracy: np.ndarray  #: angle within which the drawing fixes each normal, in radians, shape (facing,)
    angle: np.ndarray  #: angle between the two sides, in radians, shape (facing,)
    shorter: np.ndarray  #: length of the shorter side, in space of the narrower face, shape (facing,)

    @abstractmethod
    def outlines(self) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
        """First tangents; of all rings the number of what they bound, the number of corners, and these, one
        ring after the other. Outer rings begin with the side along the tangent."""

    @abstractmethod
    def distance(self, points: np.ndarray, number: np.ndarray) -> np.ndarray:
        """Distances of points from those with these numbers, shape (points,)."""


@dataclass(frozen=True)
class Touches(Rows):
    """Contacts of pairs of blocks at points, in space also along lines."""

    pair: np.ndarray  #: number of each one's pair, shape (touches,)
    start: np.ndarray  #: one end, shape (touches, 2) or (touches, 3)
    end: np.ndarray  #: the other one, the same at a point
    normal: np.ndarray  #: unit normal into the first block, of the same shape
    #: Square to it: in the plane a quarter turn clockwise, in space of the edge, or of a side of the face.
    along: np.ndarray
    accuracy: np.ndarray  #: angle within which the drawing fixes each normal, in radians, shape (touches,)

    def outlines(self, first: int) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
        """As of :class:`Facing`, numbers from the first one on: of each one ring, of its end or ends."""
        long = lengths(self.end - self.start) > 0
        ends = np.stack([self.start, self.end], axis=1)[np.column_stack([np.ones_like(long), long])]
        return self.along, first + np.arange(len(long)), 1 + long, ends

    def distance(self, points: np.ndarray, number: np.ndarray) -> np.ndarray:
        """Distances of points from touches with these numbers, shape (points,)."""
        return to_line(points, self.start[number], self.end[number])


class BlockCorners(ABC):
    """Corners of blocks, what they meet without a normal, and where blocks touch at them."""

    shapes: Extents
    point: np.ndarray  #: corners, shape (corners, 2) or (corners, 3)
    corners: Items  #: the same as items
    met: Items  #: what corners meet without a normal: corners, in space edges
    start: np.ndarray  #: and its ends
    end: np.ndarray
    apart: float  #: how far, in tolerances, from what its pair shares is another place

    @abstractmethod
    def kinds(self, pairs: np.ndarray) -> list[Touches]:
        """Where pairs of blocks touch, those of each kind; ``pair`` is the number in these pairs."""

    def touches(self, pairs: np.ndarray, asked: np.ndarray, shared: Facing) -> Touches:
        """Where pairs touch away from what they share, and from each other, by pair, kind, then length."""
        every = self.kinds(pairs[asked])
        kind = np.repeat(np.arange(len(every)), [len(one.pair) for one in every])
        found = every[0].then(*every[1:])
        found = replace(found, pair=asked[found.pair])
        near = self.apart * self.shapes.tolerance
        off = np.zeros(len(found.pair), dtype=bool)
        for share in (0.0, 0.5, 1.0):
            points = found.start + share * (found.end - found.start)
            off |= nearest(found.pair, points, shared, shared.pair) > near
        found, kind = found.where(off), kind[off]
        length = lengths(found.end - found.start)
        rank = np.round(length / max(float(length.max(initial=0.0)), near), 6)
        order = np.lexsort((-rank, kind, found.pair))
        accepted: defaultdict[int, list[int]] = defaultdict(list)
        for number in order.tolist():
            own = accepted[found.pair[number]]
            ends = np.repeat([found.start[number], found.end[number]], len(own), axis=0)
            away = found.distance(ends, np.array(2 * own, dtype=int)).reshape(2, -1)
            if away.min(axis=1, initial=np.inf).max() > near:
                own.append(number)
        return found.where(np.array([*chain.from_iterable(accepted.values())], dtype=int))

    def without_normal(
        self, pairs: np.ndarray, asked: np.ndarray, found: tuple[Facing, Touches]
    ) -> tuple[np.ndarray, np.ndarray]:
        """Numbers, rising, of pairs that meet without a normal where not both have a joint; and where."""
        tolerance, kinds = self.shapes.tolerance, (self.corners, self.met)
        both = (pairs[asked], pairs[asked, ::-1])
        meet = [near_items(self.shapes, way, tolerance, kinds) for way in both]
        pair, i, j = np.concatenate(meet, axis=1)
        kept = to_line(self.point[i], self.start[j], self.end[j]) <= tolerance
        pair, point = asked[pair[kept]], self.point[i[kept]]
        for own in found:
            off = nearest(pair, point, own, own.pair) > self.apart * tolerance
            pair, point = pair[off], point[off]
        places = np.column_stack([pair, np.round(point / tolerance)])
        _, once = np.unique(places, axis=0, return_index=True)
        pair, point = pair[once], point[once]
        held = np.ones(len(pair), dtype=bool)
        for block in pairs[pair].T:
            away = [nearest(block, point, own, either) for own in found for either in pairs[own.pair].T]
            held &= np.min(away, axis=0) <= 2 * tolerance
        return pair[~held], point[~held]


def to_line(points: np.ndarray, start: np.ndarray, end: np.ndarray) -> np.ndarray:
    """Distances of points from the straight lines between two points each, shape (points,)."""
    line, beside = end - start, points - start
    square = dots(line, line)
    at = np.divide(dots(beside, line), square, out=np.zeros_like(square), where=square > 0)
    return lengths(beside - np.clip(at, 0, 1)[:, None] * line)


def nearest(key: np.ndarray, points: np.ndarray, found: Facing | Touches, of_found: np.ndarray) -> np.ndarray:
    """Distances of points from the lengths, polygons or touches of their key, ``inf`` without one."""
    order = np.argsort(of_found, kind="stable")
    first = np.searchsorted(of_found[order], key)
    count = np.searchsorted(of_found[order], key, side="right") - first
    number, point, at = combine(np.arange(len(key)), np.ones_like(first), first, count)
    distance = np.full(len(key), np.inf)
    np.minimum.at(distance, number, found.distance(points[point], order[at]))
    return distance

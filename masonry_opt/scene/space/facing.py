"""Polygons that outer faces of two blocks share, or across which they face each other."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Self

import numpy as np
import shapely

from masonry_opt.scene.combinations import chunks, combine, ranges
from masonry_opt.scene.space.clipping import common_to
from masonry_opt.scene.space.frames import Frames, dots, lengths
from masonry_opt.scene.space.outlines import plain, wide, without_slivers
from masonry_opt.scene.space.shapes import Shapes

#: Polygons narrower than so many tolerances are nothing.
NARROWEST = 10

#: Cosine of the angle beyond which faces share nothing: within a tolerance along ten they lean by a tenth.
_FACING = 0.99

#: Sine of an angle that is rounding.
_ROUNDING = 1e-7


@dataclass(frozen=True)
class Facing:
    """Polygons onto which two faces project, in the planes that bisect them.

    Attributes
    ----------
    pair: number of each one's pair of blocks, rising, shape (polygons,).
    frame: bisecting planes; normals point out of the first block, first axes are those of its face.
    polygon: connected, without straight corners, shape (polygons,).
    least, most: how far the face of the second block lies outside that of the first, negative inside, where
        that is least and most, shape (polygons,) each.
    """

    pair: np.ndarray
    frame: Frames
    polygon: np.ndarray
    least: np.ndarray
    most: np.ndarray

    def where(self, chosen: np.ndarray) -> Self:
        """Those of a mask, or with these numbers in this order."""
        pair, frame, *rest = vars(self).values()
        return type(self)(pair[chosen], frame.where(chosen), *(column[chosen] for column in rest))

    @property
    def area(self) -> np.ndarray:
        """Area of each, shape (polygons,)."""
        return shapely.area(self.polygon)

    def distance(self, points: np.ndarray, number: np.ndarray) -> np.ndarray:
        """Distances of points in space from polygons with these numbers, shape (points,)."""
        flat = shapely.points(self.frame.down(points, number))
        return np.hypot(shapely.distance(flat, self.polygon[number]), self.frame.above(points, number))


@dataclass(frozen=True)
class Items:
    """Faces, edges or corners of the blocks in turn: the block of each, rising, shape (items,), and the boxes
    round them, shape (items, 3) each."""

    block: np.ndarray
    low: np.ndarray
    high: np.ndarray

    def beside(self, shapes: Shapes, pairs: np.ndarray, side: int, far: np.ndarray) -> tuple[np.ndarray, ...]:
        """Pair, rising, and item, of the items of each pair's block on a side that come as near as ``far``,
        shape (pairs,), to the box round the other block."""
        low, high = shapes.boxes
        count = np.bincount(self.block, minlength=len(low))
        block, other = pairs[:, side], pairs[:, 1 - side]
        pair = np.repeat(np.arange(len(pairs)), count[block])
        item = ranges((np.cumsum(count) - count)[block], count[block])
        off = np.maximum(self.low[item] - high[other[pair]], low[other[pair]] - self.high[item]).max(axis=1)
        near = off <= far[pair]
        return pair[near], item[near]


def near_items(
    shapes: Shapes, pairs: np.ndarray, far: np.ndarray, kinds: tuple[Items, Items], side: int = 0
) -> Iterator[tuple[np.ndarray, np.ndarray, np.ndarray]]:
    """Pair, item of the first kind of its block on a side, and item of the second kind of the other block, of
    all whose boxes are as near as ``far``, shape (pairs,); so many at a time as memory holds."""
    one, other = kinds
    (pair1, item1), (pair2, item2) = (
        kind.beside(shapes, pairs, at, far) for kind, at in ((one, side), (other, 1 - side))
    )
    count1, count2 = (np.bincount(pair, minlength=len(pairs)) for pair in (pair1, pair2))
    first1, first2 = np.cumsum(count1) - count1, np.cumsum(count2) - count2
    for some in chunks(count1 * count2):
        number, i, j = combine(first1[some], count1[some], first2[some], count2[some])
        pair, i, j = number + some.start, item1[i], item2[j]
        off = np.maximum(one.low[i] - other.high[j], other.low[j] - one.high[i]).max(axis=1)
        near = off <= far[pair]
        yield pair[near], i[near], j[near]


def facing(shapes: Shapes, pairs: np.ndarray, far: np.ndarray) -> Facing:
    """The polygons that faces of pairs of blocks share, nowhere farther apart than ``far``, shape (pairs,).

    Each connected piece is one polygon; pieces, and ends of them, narrower than ten tolerances are left out.
    """
    faces, frame = Items(shapes.faces.block, *shapes.faces.boxes), shapes.faces.frame
    size = lengths(faces.high - faces.low)
    found = []
    for pair, i, j in near_items(shapes, pairs, far, (faces, faces)):
        cosine = -dots(frame.normal[i], frame.normal[j])
        # Where they come near each other is no farther from a point of the other face than that is wide.
        lean = np.sqrt(np.maximum(1 - cosine**2, 0)) + _ROUNDING
        near = (cosine > _FACING) & (
            np.abs(frame.above(frame.base[j], i)) <= far[pair] / _FACING + lean * size[j]
        )
        found.append((pair[near], i[near], j[near]))
    pair, i, j = stacked(found)
    return _shared(shapes, pair, i, j, far[pair])


def stacked(found: Sequence[tuple[np.ndarray, ...]]) -> tuple[np.ndarray, ...]:
    """Columns put together, of numbers where there are none."""
    return tuple(map(np.concatenate, zip(*found, strict=True))) if found else (np.zeros(0, dtype=int),) * 3


def _shared(shapes: Shapes, pair: np.ndarray, i: np.ndarray, j: np.ndarray, far: np.ndarray) -> Facing:
    """What face i of the first and j of the second block of each pair share, nowhere farther apart than
    ``far``."""
    faces, narrowest = shapes.faces, NARROWEST * shapes.tolerance
    one, other = faces.frame.where(i), faces.frame.where(j)
    frame = Frames.of(one.base, one.normal - other.normal, one.u)
    # Halfway: over the bisecting plane the two faces' heights are opposite everywhere.
    every = np.arange(len(i))
    half = _height(frame, other, np.zeros((len(i), 2)), every) / 2
    frame = replace(frame, base=frame.base + half[:, None] * frame.normal)
    flat = [_projected(faces.polygon[face], frame, own) for face, own in ((i, one), (j, other))]
    low1, high1, low2, high2 = (corner for own in flat for corner in np.split(shapely.bounds(own), 2, axis=1))
    wide_enough = (np.minimum(high1, high2) - np.maximum(low1, low2)).min(axis=1) > shapes.tolerance
    at = np.flatnonzero(wide_enough)
    convex = faces.convex[i[at]] & faces.convex[j[at]]
    pieces, number = common_to(flat[0][at], flat[1][at], convex, shapes.tolerance)
    number = at[number]
    kept = wide(pieces, narrowest)
    pieces, number = _without_tails(pieces[kept], number[kept], narrowest)
    pieces = plain(pieces, shapes.tolerance / 2)
    points, piece = shapely.get_coordinates(pieces, return_index=True)
    height = _height(frame, other, points, number[piece]) - _height(frame, one, points, number[piece])
    start = np.searchsorted(piece, np.arange(len(pieces)))
    least, most = (bound.reduceat(height, start) for bound in (np.minimum, np.maximum))
    found = Facing(pair[number], frame.where(number), pieces, least, most)
    return found.where((least >= -shapes.contact_tolerance) & (most <= far[number]))


def _projected(polygons: np.ndarray, frame: Frames, own: Frames) -> np.ndarray:
    """Polygons in planes of their own, seen along the normals of other planes."""
    flat, number = shapely.get_coordinates(polygons, return_index=True)
    seen = frame.down(own.up(flat, number), number)
    # A copy: setting coordinates changes those of the array given.
    return shapely.set_coordinates(polygons.copy(), seen)


def _height(frame: Frames, plane: Frames, points: np.ndarray, number: np.ndarray) -> np.ndarray:
    """Height over their frames of planes at points in the frames."""
    across = dots(frame.normal[number], plane.normal[number])
    return -plane.above(frame.up(points, number), number) / across


def _without_tails(pieces: np.ndarray, number: np.ndarray, narrowest: float) -> tuple[np.ndarray, np.ndarray]:
    """Pieces with their numbers, those that are not convex without what is narrower than so."""
    hollow = shapely.area(shapely.convex_hull(pieces)) - shapely.area(pieces)
    suspect = np.flatnonzero(hollow > narrowest**2)
    wholes = [number[:0]]
    cut, found = np.zeros(len(pieces), dtype=bool), [pieces[:0]]
    for index in suspect:
        parts = shapely.get_parts(without_slivers(pieces[index], narrowest))
        # Tails may have no area, but they have length; offsets there and back change nothing else.
        if len(parts) != 1 or pieces[index].length - parts[0].length > narrowest:
            cut[index] = True
            found.append(parts)
            wholes.append(np.full(len(found[-1]), number[index]))
    pieces, number = np.concatenate([pieces[~cut], *found]), np.concatenate([number[~cut], *wholes])
    order = np.argsort(number, kind="stable")
    return pieces[order], number[order]

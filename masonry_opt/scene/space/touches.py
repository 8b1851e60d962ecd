"""Where blocks touch beside the polygons they share: edges and corners on faces, and edges that cross."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from functools import cached_property
from typing import Self

import numpy as np
import shapely

from masonry_opt.scene.combinations import combine
from masonry_opt.scene.space.facing import NARROWEST, Facing, Items, near_items, stacked
from masonry_opt.scene.space.frames import dots, lengths, unit
from masonry_opt.scene.space.shapes import Shapes
from masonry_opt.scene.space.surfaces import first_alike, sums

#: Sine of the angle between faces below which they lie in one plane.
_FLAT = 1e-3


@dataclass(frozen=True)
class Touches:
    """Contacts of pairs of blocks along lines or at points.

    Attributes
    ----------
    pair: number of each one's pair, shape (touches,).
    start, end: the two ends, the same at a point, shape (touches, 3) each.
    normal: unit normal into the first block, shape (touches, 3).
    along: unit vector square to it: of the edge, or of a side of the face, shape (touches, 3).
    """

    pair: np.ndarray
    start: np.ndarray
    end: np.ndarray
    normal: np.ndarray
    along: np.ndarray

    def where(self, chosen: np.ndarray) -> Self:
        """Those of a mask, or with these numbers in this order."""
        return type(self)(*(column[chosen] for column in vars(self).values()))

    @classmethod
    def of(cls, found: Iterable[Self]) -> Self:
        """All of these."""
        nothing = np.zeros(0, dtype=int), *4 * [np.zeros((0, 3))]
        return cls(*map(np.concatenate, zip(nothing, *(vars(one).values() for one in found), strict=True)))

    def distance(self, points: np.ndarray, number: np.ndarray) -> np.ndarray:
        """Distances of points in space from touches with these numbers, shape (points,)."""
        return to_line(points, self.start[number], self.end[number])


class Corners:
    """Edges and corners of the outer faces of some blocks.

    Attributes
    ----------
    tail, tip: ends of each edge, shape (edges, 3) each.
    direction: unit vectors along them, shape (edges, 3).
    inwards: sum of the unit vectors from each edge into its faces, shape (edges, 3).
    point: corners, shape (corners, 3).
    edges, corners, faces: the same and the blocks' faces, as items.
    """

    def __init__(self, shapes: Shapes, blocks: np.ndarray) -> None:
        self.shapes, outer = shapes, shapes.faces
        tail, tip, face = outer.sides()
        block = outer.block[face]
        asked = np.isin(block, blocks)
        tail, tip, face, block = tail[asked], tip[asked], face[asked], block[asked]
        # An edge is in two faces, a corner in three or more.
        grid, other = (np.round(ends / shapes.tolerance) for ends in (tail, tip))
        ends = np.column_stack([block, np.minimum(grid, other), np.maximum(grid, other)])
        own = first_alike(ends)
        one, number = np.unique(own, return_inverse=True)
        self.tail, self.tip = tail[one], tip[one]
        self.direction = unit(self.tip - self.tail)
        self.inwards = sums(number, np.cross(outer.frame.normal[face], unit(tip - tail)), len(one))
        self.edges = Items(block[one], np.minimum(self.tail, self.tip), np.maximum(self.tail, self.tip))
        one = np.unique(first_alike(np.column_stack([block, grid])))
        self.point = tail[one]
        self.corners = Items(block[one], self.point, self.point)
        self.faces = Items(outer.block, *outer.boxes)

    @cached_property
    def flat(self) -> np.ndarray:
        """Boxes round the faces in their frames, shape (faces, 4)."""
        return shapely.bounds(self.shapes.faces.polygon)


def to_line(points: np.ndarray, start: np.ndarray, end: np.ndarray) -> np.ndarray:
    """Distances of points from the straight lines between two points each, shape (points,)."""
    line, beside = end - start, points - start
    square = dots(line, line)
    at = np.divide(dots(beside, line), square, out=np.zeros_like(square), where=square > 0)
    return lengths(beside - np.clip(at, 0, 1)[:, None] * line)


def nearest(key: np.ndarray, points: np.ndarray, found: Facing | Touches, of_found: np.ndarray) -> np.ndarray:
    """Distances of points from those of the polygons or touches that have their key, ``inf`` without one."""
    order = np.argsort(of_found, kind="stable")
    first = np.searchsorted(of_found[order], key)
    count = np.searchsorted(of_found[order], key, side="right") - first
    number, point, at = combine(np.arange(len(key)), np.ones_like(first), first, count)
    distance = np.full(len(key), np.inf)
    np.minimum.at(distance, number, found.distance(points[point], order[at]))
    return distance


def touches(corners: Corners, pairs: np.ndarray, asked: np.ndarray, shared: Facing) -> Touches:
    """Edges in faces, corners on faces and crossing edges of the pairs asked for, away from the polygons that
    their pair shares and from each other; ordered by pair."""
    every = [
        Touches.of(kind(corners, pairs[asked])) for kind in (_edges_in_faces, _corners_on_faces, _crossings)
    ]
    kind = np.repeat(np.arange(len(every)), [len(one.pair) for one in every])
    found = Touches.of(every)
    found = Touches(asked[found.pair], found.start, found.end, found.normal, found.along)
    near = NARROWEST * corners.shapes.tolerance
    off = np.zeros(len(found.pair), dtype=bool)
    for share in (0.0, 0.5, 1.0):
        points = found.start + share * (found.end - found.start)
        off |= nearest(found.pair, points, shared, shared.pair) > near
    found, kind = found.where(off), kind[off]
    length = lengths(found.end - found.start)
    rank = np.round(length / max(float(length.max(initial=0.0)), near), 6)
    order = np.lexsort((np.arange(len(rank)), -rank, kind, found.pair))
    accepted: list[int] = []
    own: list[int] = []
    for number in order:
        if own and found.pair[own[0]] != found.pair[number]:
            own = []
        ends = np.repeat([found.start[number], found.end[number]], len(own), axis=0)
        apart = found.distance(ends, np.array(2 * own, dtype=int)).reshape(2, -1).min(axis=1, initial=np.inf)
        if apart.max() > near:
            own.append(int(number))
            accepted.append(int(number))
    return found.where(np.array(accepted, dtype=int))


def _edges_in_faces(corners: Corners, pairs: np.ndarray) -> Iterator[Touches]:
    """Where edges lie in faces of the other block and not along their outline."""
    tolerance, faces = corners.shapes.tolerance, corners.shapes.faces
    narrowest = NARROWEST * tolerance
    far = np.full(len(pairs), tolerance)
    for side in (0, 1):
        for pair, i, j in near_items(corners.shapes, pairs, far, (corners.edges, corners.faces), side):
            height = [faces.frame.above(ends[i], j) for ends in (corners.tail, corners.tip)]
            flat = [faces.frame.down(ends[i], j) for ends in (corners.tail, corners.tip)]
            kept = (np.minimum(*height) <= tolerance) & (np.maximum(*height) >= -tolerance)
            kept &= np.hypot(*(flat[1] - flat[0]).T) > narrowest
            kept &= _inside(np.minimum(*flat), np.maximum(*flat), corners.flat[j], narrowest)
            pair, j, start, end, low, high = (column[kept] for column in (pair, j, *flat, *height))
            lines = shapely.linestrings(np.stack([start, end], axis=1))
            pieces, number = shapely.get_parts(
                shapely.intersection(lines, faces.polygon[j]), return_index=True
            )
            kept = shapely.length(pieces) > narrowest
            pieces, number = pieces[kept], number[kept]
            border = shapely.boundary(faces.polygon[j[number]])
            deep = np.zeros(len(pieces), dtype=bool)
            for share in (0.25, 0.5, 0.75):
                at = shapely.line_interpolate_point(pieces, share, normalized=True)
                deep |= shapely.distance(border, at) > narrowest
            points = []
            for end_no in (0, -1):
                at = shapely.get_coordinates(shapely.get_point(pieces, end_no))
                way = (end - start)[number]
                t = ((at - start[number]) * way).sum(axis=1) / (way**2).sum(axis=1)
                over = low[number] + t * (high - low)[number]
                deep &= np.abs(over) <= tolerance
                lift = over[:, None] / 2 * faces.frame.normal[j[number]]
                points.append(faces.frame.up(at, j[number]) + lift)
            one, other = points[0][deep], points[1][deep]
            number = number[deep]
            # Normals of faces point out of their block.
            normal = (1 if side == 0 else -1) * faces.frame.normal[j[number]]
            # Square to the normal, also where the edge leans within the tolerance.
            along = other - one
            yield Touches(
                pair[number], one, other, normal, unit(along - dots(along, normal)[:, None] * normal)
            )


def _corners_on_faces(corners: Corners, pairs: np.ndarray) -> Iterator[Touches]:
    """Where corners stand on faces of the other block and not on their outline."""
    tolerance, faces = corners.shapes.tolerance, corners.shapes.faces
    far = np.full(len(pairs), tolerance)
    for side in (0, 1):
        for pair, i, j in near_items(corners.shapes, pairs, far, (corners.corners, corners.faces), side):
            flat, height = faces.frame.down(corners.point[i], j), faces.frame.above(corners.point[i], j)
            kept = (np.abs(height) <= tolerance) & _inside(flat, flat, corners.flat[j], tolerance)
            pair, j, flat, height = pair[kept], j[kept], flat[kept], height[kept]
            at = shapely.points(flat)
            kept = shapely.contains(faces.polygon[j], at)
            kept &= shapely.distance(shapely.boundary(faces.polygon[j]), at) > tolerance
            pair, j, flat, height = pair[kept], j[kept], flat[kept], height[kept]
            point = faces.frame.up(flat, j) + height[:, None] / 2 * faces.frame.normal[j]
            normal = (1 if side == 0 else -1) * faces.frame.normal[j]
            yield Touches(pair, point, point, normal, faces.frame.u[j])


def _crossings(corners: Corners, pairs: np.ndarray) -> Iterator[Touches]:
    """Where edges cross between their ends."""
    tolerance = corners.shapes.tolerance
    far = np.full(len(pairs), tolerance)
    for pair, i, j in near_items(corners.shapes, pairs, far, (corners.edges, corners.edges)):
        long = [lengths(corners.tip[edge] - corners.tail[edge]) for edge in (i, j)]
        one, other = corners.direction[i], corners.direction[j]
        across = np.cross(one, other)
        sine = lengths(across)
        # Else they run along each other: moved by the tolerance, they would turn their normal.
        kept = sine * np.minimum(*long) > NARROWEST * tolerance
        pair, i, j, one, other, across, sine = (
            column[kept] for column in (pair, i, j, one, other, across, sine)
        )
        normal = across / sine[:, None]
        between = corners.tail[j] - corners.tail[i]
        at = [dots(np.cross(between, edge), normal) / sine for edge in (other, one)]
        gap = dots(between, normal)
        kept = np.abs(gap) <= tolerance
        for own, edge in zip(at, (i, j), strict=True):
            length = lengths(corners.tip[edge] - corners.tail[edge])
            kept &= (own > tolerance) & (own < length - tolerance)
        # Both blocks' faces there lie on their own sides of the plane of the edges.
        towards = dots(normal, corners.inwards[i] - corners.inwards[j])
        kept &= np.abs(towards) > _FLAT
        point = corners.tail[i] + at[0][:, None] * one + gap[:, None] / 2 * normal
        sign = np.sign(towards)[:, None]
        yield Touches(pair[kept], point[kept], point[kept], (sign * normal)[kept], one[kept])


def without_normal(
    corners: Corners, pairs: np.ndarray, asked: np.ndarray, found: tuple[Facing, Touches]
) -> np.ndarray:
    """Numbers of the pairs asked for that meet at a corner of either, on an edge or a corner of the other,
    away from what they share, where not both blocks have a joint with any other."""
    tolerance, kinds = corners.shapes.tolerance, (corners.corners, corners.edges)
    far = np.full(len(asked), tolerance)
    meet = []
    for side in (0, 1):
        for pair, i, j in near_items(corners.shapes, pairs[asked], far, kinds, side):
            kept = to_line(corners.point[i], corners.tail[j], corners.tip[j]) <= tolerance
            meet.append((asked[pair[kept]], i[kept], j[kept]))
    pair, i, _ = stacked(meet)
    once = np.unique(first_alike(np.column_stack([pair, i])))
    pair, i = pair[once], i[once]
    for own in found:
        off = nearest(pair, corners.point[i], own, own.pair) > NARROWEST * tolerance
        pair, i = pair[off], i[off]
    held = np.ones(len(pair), dtype=bool)
    at = np.round(corners.point[i] / tolerance)
    for side in (0, 1):
        block = pairs[pair, side]
        one, number = np.unique(first_alike(np.column_stack([block, at])), return_inverse=True)
        apart = np.full(len(one), np.inf)
        for own in found:
            # Once for either block.
            doubled = own.where(np.tile(np.arange(len(own.pair)), 2)), pairs[own.pair].T.ravel()
            apart = np.minimum(apart, nearest(block[one], corners.point[i[one]], *doubled))
        held &= (apart <= 2 * tolerance)[number]
    return np.unique(pair[~held])


def _inside(low: np.ndarray, high: np.ndarray, box: np.ndarray, margin: float) -> np.ndarray:
    """Which boxes in a plane come farther than a margin inside other boxes."""
    return np.all((high > box[:, :2] + margin) & (low < box[:, 2:] - margin), axis=1)

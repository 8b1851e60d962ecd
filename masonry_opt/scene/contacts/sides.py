"""Find where two blocks share a side, and where they touch or meet elsewhere.

A *side* is an edge of a block in the plane, or an outer face of a block in space. Tables of this module have
one row for each shared length or polygon (:class:`Facing`), or for each contact at a point or along a line
(:class:`Touches`).
"""

from abc import ABC, abstractmethod
from collections import defaultdict
from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import chain
from typing import Self

import numpy as np

from masonry_opt.scene.geometry import Extents
from masonry_opt.scene.rows import Rows, chunks, combine, dots, lengths, ranges

#: A length is small relative to another length if their ratio is at most this value. For example, two edges
#: form a joint only if the gap between them is small relative to the length of their shared segment. The gap
#: must also be at most the geometric tolerance, so the ratio matters only for segments shorter than ten
#: tolerances. With a larger value, edges at a larger angle to each other form joints.
SMALL_LENGTH_RATIO = 0.1

#: Sine of the largest angle between two sides that face each other across a gap, such as undrawn mortar. A
#: larger value also joins sides that meet at a corner.
_MOST_ANGLE_ACROSS = 0.34


def faces_across(sine: np.ndarray, gap: np.ndarray, width: np.ndarray) -> np.ndarray:
    """Return a mask of the pairs of sides that face each other across a gap, shape (rows,).

    The sides must be nearly parallel. Their shared width must be larger than a tenth of the gap, and larger
    than the gap times the sine of the angle between them. A smaller shared width may belong to a corner, and
    would depend on the choice of the bisector.
    """
    is_facing: np.ndarray = (sine <= _MOST_ANGLE_ACROSS) & (
        width > np.maximum(sine, SMALL_LENGTH_RATIO) * gap
    )
    return is_facing


def has_nearly_opposite_normals(first: np.ndarray, second: np.ndarray) -> bool:
    """Return True if sides of two blocks have nearly opposite normals, so that they can face each other.

    ``first`` and ``second`` are the outward unit normals of sides of the two blocks, shape (sides, 2) or
    (sides, 3).
    """
    cosine = -(first @ second.T)
    return bool((cosine >= np.sqrt(1 - _MOST_ANGLE_ACROSS**2)).any())


@dataclass(frozen=True)
class Items:
    """Faces, edges or corners ("items") of all blocks, with their bounding boxes."""

    #: Index of the block to which each face, edge or corner belongs, in ascending order, shape (items,).
    block: np.ndarray
    low: np.ndarray  #: smallest coordinates of each item's bounding box, shape (items, 2) or (items, 3)
    high: np.ndarray  #: largest coordinates of each item's bounding box, shape (items, 2) or (items, 3)

    def near(self, shapes: Extents, pairs: np.ndarray, far: np.ndarray) -> tuple[np.ndarray, ...]:
        """For each pair of blocks, return the first block's faces, edges or corners near the second block.

        Parameters
        ----------
        shapes : Extents
            Shapes of the blocks.
        pairs : ndarray, shape (pairs, 2)
            Pairs of blocks.
        far : ndarray, shape (pairs,)
            Largest distance between bounding boxes at which an item is near, for each pair.

        Returns
        -------
        pair, item : ndarray, shape (near,)
            Index of the pair, in ascending order, and index of the item.
        """
        low, high = shapes.boxes
        block, other_block = pairs.T
        count = np.bincount(self.block, minlength=len(low))
        pair = np.repeat(np.arange(len(pairs)), count[block])
        item = ranges((np.cumsum(count) - count)[block], count[block])
        distance = np.maximum(
            self.low[item] - high[other_block[pair]], low[other_block[pair]] - self.high[item]
        ).max(axis=1)
        is_near = distance <= far[pair]
        return pair[is_near], item[is_near]


def near_items(
    shapes: Extents, pairs: np.ndarray, far: np.ndarray | float, kinds: tuple[Items, Items]
) -> tuple[np.ndarray, ...]:
    """For each pair of blocks, return the pairs of items whose bounding boxes are near each other.

    The first item belongs to the first block of the pair, and the second item to the second block.

    Parameters
    ----------
    shapes : Extents
        Shapes of the blocks.
    pairs : ndarray, shape (pairs, 2)
        Pairs of blocks.
    far : ndarray or float
        Largest distance at which two boxes are near, for each pair or for all pairs.
    kinds : tuple of Items
        Items of the first blocks, and items of the second blocks.

    Returns
    -------
    pair, first, second : ndarray, shape (near,)
        Index of the pair, in ascending order, and indices of the items of its first and second block.
    """
    first, second = kinds
    far = np.broadcast_to(far, len(pairs))
    pair1, item1 = first.near(shapes, pairs, far)
    pair2, item2 = second.near(shapes, pairs[:, ::-1], far)
    count1, count2 = (np.bincount(pair, minlength=len(pairs)) for pair in (pair1, pair2))
    start1, start2 = np.cumsum(count1) - count1, np.cumsum(count2) - count2
    rows = [np.zeros((3, 0), dtype=int)]
    for chunk in chunks(count1 * count2):
        number, i, j = combine(start1[chunk], count1[chunk], start2[chunk], count2[chunk])
        pair, i, j = number + chunk.start, item1[i], item2[j]
        distance = np.maximum(first.low[i] - second.high[j], second.low[j] - first.high[i]).max(axis=1)
        is_near = distance <= far[pair]
        rows.append(np.stack([pair, i, j])[:, is_near])
    return tuple(np.concatenate(rows, axis=1))


@dataclass(frozen=True)
class Facing(Rows, ABC):
    """Segments or polygons that the sides of two blocks share.

    Two sides that face each other share the part of their bisecting line or plane onto which both sides
    project. The table has n rows, one for each segment or polygon.
    """

    #: For each segment or polygon, the index of the pair of blocks that share it, shape (n,). The indices are
    #: in ascending order.
    pair: np.ndarray
    #: Largest distance between the two sides that share each segment or polygon, shape (n,). In space, the
    #: distance is negative if the two blocks overlap over the whole polygon.
    largest_gap: np.ndarray
    extent: np.ndarray  #: length of each segment (in space: area of each polygon), shape (n,)
    #: Midpoint of each segment (in space: centroid of each polygon), shape (n, 2) or (n, 3).
    middle: np.ndarray
    #: Unit normal of each segment or polygon, pointing into the first block, shape (n, 2) or (n, 3).
    normal: np.ndarray
    #: Uncertainty of each normal's direction in the drawing, in radians, shape (n,).
    accuracy: np.ndarray
    #: Angle in radians between the two sides that share each segment or polygon, shape (n,).
    angle: np.ndarray
    #: Length of the shorter of the two edges that share each segment (in space: width of the narrower of the
    #: two faces), shape (n,).
    shorter_side: np.ndarray

    @property
    def width(self) -> np.ndarray:
        """Return the width of each segment (in space: square root of each polygon's area), shape (n,)."""
        width: np.ndarray = self.extent ** (1 / (self.middle.shape[1] - 1))
        return width

    @property
    @abstractmethod
    def inner_points(self) -> np.ndarray:
        """Return three points inside each of the n segments or polygons, shape (n, 3, 2) or (n, 3, 3)."""

    @property
    @abstractmethod
    def breadth(self) -> np.ndarray:
        """Return the length of each segment (in space: the mean breadth of each polygon), shape (n,)."""

    @abstractmethod
    def outlines(self) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
        """Return the tangents and the outlines of all shared segments or polygons.

        An outline has an outer ring, which begins with the side along the tangent, and one further ring for
        each hole. A *row* is a segment or a polygon.

        Returns
        -------
        tangent : ndarray, shape (rows, 2) or (rows, 3)
            Unit vector along each row.
        row : ndarray, shape (rings,)
            Index of the row that each ring bounds.
        count : ndarray, shape (rings,)
            Number of corners of each ring.
        corners : ndarray, shape (corners, 2) or (corners, 3)
            Corners of the rings, one ring after the other.
        """

    @abstractmethod
    def distance(self, points: np.ndarray, number: np.ndarray) -> np.ndarray:
        """Return the distance of each point from the segment or polygon with the index ``number``.

        The shape is (points,).
        """

    @abstractmethod
    def overlap(self, first: np.ndarray, second: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return the length (in space: the area and the mean breadth) of each pair's overlap.

        In the plane, the length is returned twice. Both arrays have the shape (pairs,). ``first`` and
        ``second`` have the indices of the segments (in space: polygons) of each pair, which lie in one line
        (in space: plane).
        """

    @abstractmethod
    def uncovered(self, row: int, other_rows: np.ndarray, tolerance: float) -> Self:
        """Return the parts of a segment or polygon that other segments or polygons do not cover.

        ``row`` is the index of the segment or polygon, and ``other_rows`` has the indices of the others.
        Parts as narrow as errors of the drawing, whose points are uncertain by ``tolerance``, are left out.
        """


@dataclass(frozen=True)
class Touches(Rows):
    """Contacts of pairs of blocks at points (in space: also along lines)."""

    pair: np.ndarray  #: for each contact, the index of its pair of blocks, shape (touches,)
    #: Start of each line of contact, or the point of contact, shape (touches, 2) or (touches, 3).
    start: np.ndarray
    #: End of each line of contact, equal to ``start`` for a point, shape (touches, 2) or (touches, 3).
    end: np.ndarray
    #: Unit normal of each contact, pointing into the first block, shape (touches, 2) or (touches, 3).
    normal: np.ndarray
    #: Unit vector perpendicular to each contact's normal, shape (touches, 2) or (touches, 3). In the plane
    #: the vector is the normal rotated clockwise by 90°. In space it is parallel to the touching edge, or to
    #: the first of two touching edges. For a corner on a face, it is parallel to the first axis of the face.
    along: np.ndarray
    #: Uncertainty of each normal's direction in the drawing, in radians, shape (touches,).
    accuracy: np.ndarray

    def outlines(self, first: int) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
        """Return the tangent and the outline of each contact, in the same format as :meth:`Facing.outlines`.

        Each contact has one ring, of one point or of two ends. Rows are numbered from ``first`` on.
        """
        is_line = lengths(self.end - self.start) > 0
        ends = np.stack([self.start, self.end], axis=1)[np.column_stack([np.ones_like(is_line), is_line])]
        return self.along, first + np.arange(len(is_line)), 1 + is_line, ends

    def distance(self, points: np.ndarray, number: np.ndarray) -> np.ndarray:
        """Return the distance of each point from the contact with the index ``number``, shape (points,)."""
        return to_line(points, self.start[number], self.end[number])


@dataclass(frozen=True)
class Meetings(Rows):
    """Places where a corner of one block coincides with a corner of another block.

    In space, an edge of one block coincides with an edge of the other block.
    """

    #: Index of the pair of blocks whose corners (in space: edges) coincide, shape (meetings,).
    pair: np.ndarray
    #: Index of the coinciding corner (in space: edge) of the first block, shape (meetings,).
    first: np.ndarray
    #: Index of the coinciding corner (in space: edge) of the second block, shape (meetings,).
    second: np.ndarray
    #: In the plane, the point halfway between two coinciding corners, shape (meetings, 2). In space, the
    #: start of the line along which two edges coincide, shape (meetings, 3).
    start: np.ndarray
    #: In space, the end of the line along which two edges coincide, shape (meetings, 3). In the plane, the
    #: end equals ``start``.
    end: np.ndarray


class BlockCorners(ABC):
    """Base class that finds contacts of blocks at their corners and along their edges."""

    shapes: Extents
    point: np.ndarray  #: coordinates of the corners, shape (corners, 2) or (corners, 3)
    corners: Items  #: corners with the indices of their blocks
    #: Corners (in space: edges) of all blocks, which :meth:`without_normal` compares with the corners of
    #: other blocks.
    compared_items: Items
    #: In the plane, the coordinates of each corner of ``compared_items``, shape (items, 2). In space, the
    #: start of each edge of ``compared_items``, shape (items, 3).
    start: np.ndarray
    #: In space, the end of each edge of ``compared_items``, shape (items, 3). In the plane, the end equals
    #: ``start``.
    end: np.ndarray
    #: Two contacts of the same blocks count as one contact if their distance is at most this value, relative
    #: to the tolerance. A contact within this distance of a side that the blocks share counts as part of the
    #: side.
    near_distance_ratio: float

    @abstractmethod
    def kinds(self, pairs: np.ndarray) -> list[Touches]:
        """Return the contacts of pairs of blocks at corners and edges, sorted by kind.

        The result has one :class:`Touches` for each kind, such as corners on faces. ``Touches.pair`` is the
        index of the row in ``pairs``.
        """

    @abstractmethod
    def meetings(self, pairs: np.ndarray) -> "Meetings":
        """Return the places where corners (in space: edges) of two blocks coincide.

        ``Meetings.pair`` is the index of the row in ``pairs``.
        """

    @abstractmethod
    def bisected(self, meetings: "Meetings") -> Touches:
        """Return contacts, with their normals, at places where corners (in space: edges) coincide.

        ``meetings`` has the places. A contact lies on a bisector of sides that face each other, or on a side
        of a notch. Some places have no contact, see :mod:`~.bisectors`.
        """

    def touches(self, pairs: np.ndarray, candidates: np.ndarray, shared_sides: Facing) -> Touches:
        """Return the contacts at corners and edges, without those near a side that the pair shares.

        Contacts are ordered by pair, then by kind, then by decreasing length. If contacts of a pair are near
        each other, only the first of them in this order is returned.

        Parameters
        ----------
        pairs : ndarray, shape (pairs, 2)
            Pairs of blocks.
        candidates : ndarray, shape (k,)
            Indices of the pairs whose contacts are sought.
        shared_sides : Facing
            Lengths or polygons that the pairs share.
        """
        tables = self.kinds(pairs[candidates])
        kind = np.repeat(np.arange(len(tables)), [len(table.pair) for table in tables])
        contacts = tables[0].then(*tables[1:])
        contacts = replace(contacts, pair=candidates[contacts.pair])
        near_distance = self.near_distance_ratio * self.shapes.tolerance
        is_away = np.zeros(len(contacts.pair), dtype=bool)
        for share in (0.0, 0.5, 1.0):
            points = contacts.start + share * (contacts.end - contacts.start)
            is_away |= nearest(contacts.pair, points, shared_sides, shared_sides.pair) > near_distance
        contacts, kind = contacts.where(is_away), kind[is_away]
        length = lengths(contacts.end - contacts.start)
        rank = np.round(length / max(float(length.max(initial=0.0)), near_distance), 6)
        order = np.lexsort((-rank, kind, contacts.pair))
        accepted_contacts: defaultdict[int, list[int]] = defaultdict(list)
        for number in order.tolist():
            earlier_contacts = accepted_contacts[contacts.pair[number]]
            ends = np.repeat([contacts.start[number], contacts.end[number]], len(earlier_contacts), axis=0)
            distance = contacts.distance(ends, np.array(2 * earlier_contacts, dtype=int)).reshape(2, -1)
            if distance.min(axis=1, initial=np.inf).max() > near_distance:
                earlier_contacts.append(number)
        return contacts.where(np.array([*chain.from_iterable(accepted_contacts.values())], dtype=int))

    def touches_at_corners(
        self, pairs: np.ndarray, candidates: np.ndarray, all_joints: tuple[Facing, Touches]
    ) -> Touches:
        """Return the contacts at coinciding corners of two blocks (in space: along coinciding edges).

        A contact is left out if its pair has a joint near it, or if both blocks share a side with other
        blocks at that place, such as a point where four bricks meet. See :meth:`without_normal` for the
        parameters.
        """
        meetings = self.meetings(pairs[candidates])
        meetings = replace(meetings, pair=candidates[meetings.pair])
        near_distance, middle = (
            self.near_distance_ratio * self.shapes.tolerance,
            (meetings.start + meetings.end) / 2,
        )
        is_contact = np.ones(len(middle), dtype=bool)
        for joints in all_joints:
            is_contact &= nearest(meetings.pair, middle, joints, joints.pair) > near_distance
        is_contact &= ~self._both_have_joints(pairs, meetings.pair, middle, all_joints[:1])
        return self.bisected(meetings.where(is_contact))

    def _both_have_joints(
        self, pairs: np.ndarray, pair: np.ndarray, point: np.ndarray, all_joints: Sequence[Facing | Touches]
    ) -> np.ndarray:
        """Return a mask of the points at which both blocks of the point's pair have a joint, shape (points,).

        The joint may connect the block to any other block. ``all_joints`` has the joints.
        """
        is_joined = np.ones(len(pair), dtype=bool)
        for block in pairs[pair].T:
            distance = [
                nearest(block, point, joints, owner)
                for joints in all_joints
                for owner in pairs[joints.pair].T
            ]
            is_joined &= np.min(distance, axis=0) <= 2 * self.shapes.tolerance
        return is_joined

    def without_normal(
        self, pairs: np.ndarray, candidates: np.ndarray, all_joints: tuple[Facing, Touches]
    ) -> tuple[np.ndarray, np.ndarray]:
        """Return the pairs of blocks that meet at a point without a contact normal, and the points.

        A point is left out if both blocks have a joint at the point, with each other or with other blocks.

        Parameters
        ----------
        pairs : ndarray, shape (pairs, 2)
            Pairs of blocks.
        candidates : ndarray, shape (k,)
            Indices of the pairs to examine.
        all_joints : tuple of Facing and Touches
            Joints of all pairs.

        Returns
        -------
        pair : ndarray, shape (points,)
            Index of the pair, in ascending order.
        point : ndarray, shape (points, 2) or (points, 3)
            Point at which the blocks of the pair meet.
        """
        tolerance, kinds = self.shapes.tolerance, (self.corners, self.compared_items)
        both_orders = (pairs[candidates], pairs[candidates, ::-1])
        meetings = [near_items(self.shapes, ordered_pairs, tolerance, kinds) for ordered_pairs in both_orders]
        pair, i, j = np.concatenate(meetings, axis=1)
        is_touching = to_line(self.point[i], self.start[j], self.end[j]) <= tolerance
        pair, point = candidates[pair[is_touching]], self.point[i[is_touching]]
        for joints in all_joints:
            is_away = nearest(pair, point, joints, joints.pair) > self.near_distance_ratio * tolerance
            pair, point = pair[is_away], point[is_away]
        places = np.column_stack([pair, np.round(point / tolerance)])
        _, first_rows = np.unique(places, axis=0, return_index=True)
        pair, point = pair[first_rows], point[first_rows]
        both_have_joints = self._both_have_joints(pairs, pair, point, all_joints)
        return pair[~both_have_joints], point[~both_have_joints]


def to_line(points: np.ndarray, start: np.ndarray, end: np.ndarray) -> np.ndarray:
    """Return the distance of each point from the line segment with the same index, shape (points,).

    A segment with equal ends is a point.
    """
    line, offset = end - start, points - start
    square = dots(line, line)
    share = np.divide(dots(offset, line), square, out=np.zeros_like(square), where=square > 0)
    return lengths(offset - np.clip(share, 0, 1)[:, None] * line)


def nearest(
    key: np.ndarray, points: np.ndarray, joints: Facing | Touches, joint_key: np.ndarray
) -> np.ndarray:
    """Return the distance of each point from the nearest joint with the same key, shape (points,).

    The key of a point or joint is the index of its block or pair of blocks. The distance is infinite if no
    joint has the key of the point.

    Parameters
    ----------
    key : ndarray, shape (points,)
        Key of each point.
    points : ndarray, shape (points, 2) or (points, 3)
        Points.
    joints : Facing or Touches
        Joints: lengths, polygons or contacts.
    joint_key : ndarray, shape (rows,)
        Key of each row of ``joints``.
    """
    order = np.argsort(joint_key, kind="stable")
    first = np.searchsorted(joint_key[order], key)
    count = np.searchsorted(joint_key[order], key, side="right") - first
    number, point, row = combine(np.arange(len(key)), np.ones_like(first), first, count)
    distance = np.full(len(key), np.inf)
    np.minimum.at(distance, number, joints.distance(points[point], order[row]))
    return distance

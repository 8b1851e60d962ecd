"""Find where the outlines of blocks in the plane touch: shared lengths of edges, and corners on edges."""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Self

import numpy as np
import shapely

from masonry_opt.errors import CaseError
from masonry_opt.scene.contacts import sides
from masonry_opt.scene.contacts.bisectors import Sectors, contact_normals
from masonry_opt.scene.contacts.sides import SMALL_LENGTH_RATIO, Items, Meetings, Touches, near_items, to_line
from masonry_opt.scene.geometry import Geometry
from masonry_opt.scene.rows import dots, lengths, spaces
from masonry_opt.scene.scene import Scene

#: Two edges coincide if their distance is at most this value, relative to the tolerance. Corners of
#: coincident edges are not moved. Corners of other touching edges are moved to the middle between the edges.
_COINCIDENT_EDGE_TOLERANCE = 1e-3

#: Smallest length that two nearly parallel edges must share to form a joint, relative to the tolerance. Edges
#: at an angle must share a longer length, see :data:`~.sides.SMALL_LENGTH_RATIO`. With a smaller value,
#: errors of corners produce false joints.
_SHORTEST_PARALLEL = 3.0

#: Largest angle between two edges that count as nearly parallel, in radians. With a larger value, short
#: segments of edges at an angle form joints.
_LARGEST_ANGLE = 0.1

#: Largest number of pairs of edges that are compared. A scene with more pairs raises an error. A larger value
#: needs more time and memory.
_MOST_EDGES = 20_000_000


@dataclass(frozen=True)
class FacingEdges(sides.Facing):
    """Segments that edges of two blocks share.

    A shared segment is the part of the bisector of two edges onto which both edges project.
    """

    #: Start of each shared segment, in the direction of the first block's edge, shape (n, 2).
    start: np.ndarray
    end: np.ndarray  #: end of each shared segment, shape (n, 2)

    @classmethod
    def between(
        cls,
        pair: np.ndarray,
        largest_gap: np.ndarray,
        ends: tuple[np.ndarray, np.ndarray],
        accuracy: np.ndarray,
        lean: tuple[np.ndarray, np.ndarray],
    ) -> Self:
        """Return the shared segments with the given ends.

        ``lean`` has the angles between the two edges, and the lengths of the shorter edges.
        """
        start, end = ends
        extent = np.hypot(*(end - start).T)
        # Edges run counter-clockwise around their block, so the normal into the first block points to the
        # left of the edge.
        normal = -_tangent((end - start) / extent[:, None])
        return cls(pair, largest_gap, extent, (start + end) / 2, normal, accuracy, *lean, start, end)

    @classmethod
    def of(cls, corners: "PlaneCorners", pair: np.ndarray, i: np.ndarray, j: np.ndarray) -> "FacingEdges":
        """Return the segments that pairs of edges share, if they are longer than the tolerance.

        Edge ``i`` belongs to the first block of its pair, and edge ``j`` to the second block. Edges that run
        in opposite directions round their blocks face each other. If their distance is larger than the
        tolerance, they must also satisfy :func:`~.sides.faces_across`.
        """
        tail, tip, tolerance = corners.point, corners.tip, corners.shapes.tolerance
        along_i, along_j = (
            edge / np.hypot(*edge.T)[:, None] for edge in (tip[i] - tail[i], tail[j] - tip[j])
        )
        is_facing = (along_i * along_j).sum(axis=1) > 0
        pair, i, j = pair[is_facing], i[is_facing], j[is_facing]
        bisector = (along_i + along_j)[is_facing]
        bisector /= np.hypot(*bisector.T)[:, None]
        # Order the ends of both edges along the bisector, and compute their coordinates along it.
        lines = np.array([[tail[i], tip[i]], [tip[j], tail[j]]])
        x = ((lines - tail[i]) * bisector).sum(axis=-1)
        # The shared segment begins at the later start of the two edges, and ends at the earlier end.
        x_ends = np.array([np.maximum(*x[:, 0]), np.minimum(*x[:, 1])])
        is_of_first = x[0] == x_ends
        corner = np.where(is_of_first[..., None], *lines)
        # Find the point opposite to each corner: interpolate the opposite edge, from start to stop, at the
        # corner's coordinate along the bisector.
        start, stop = (np.where(is_of_first[..., None], lines[1, end], lines[0, end]) for end in (0, 1))
        x_start, x_stop = (np.where(is_of_first, x[1, end], x[0, end]) for end in (0, 1))
        gap = start + ((x_ends - x_start) / (x_stop - x_start))[..., None] * (stop - start) - corner
        width = np.hypot(*np.moveaxis(gap, 2, 0))
        # Move each end to the middle between the edges, unless the edges coincide up to rounding.
        ends = corner + np.where(width > _COINCIDENT_EDGE_TOLERANCE * tolerance, 0.5, 0.0)[..., None] * gap
        sine = np.abs(along_i[:, 0] * along_j[:, 1] - along_i[:, 1] * along_j[:, 0])[is_facing]
        largest_gap, extent = width.max(axis=0), x_ends[1] - x_ends[0]
        is_long = (extent > tolerance) & (
            (largest_gap <= tolerance) | sides.faces_across(sine, largest_gap, extent - tolerance)
        )
        accuracy_first, accuracy_second = (
            _accuracy(tip[edge] - tail[edge], tolerance)[is_long] for edge in (i, j)
        )
        lean = sine[is_long], tolerance / np.maximum(accuracy_first, accuracy_second)
        start, end = ends[:, is_long]
        accuracy = (accuracy_first + accuracy_second) / 2
        return cls.between(pair[is_long], largest_gap[is_long], (start, end), accuracy, lean)

    @property
    def inner_points(self) -> np.ndarray:
        """Return the points at a quarter, a half and three quarters of each segment, shape (n, 3, 2)."""
        share = np.array([0.25, 0.5, 0.75])[:, None]
        points: np.ndarray = self.start[:, None] + share * (self.end - self.start)[:, None]
        return points

    @property
    def breadth(self) -> np.ndarray:
        """Return the length of each segment, shape (n,)."""
        return self.extent

    def outlines(self) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
        """Return the tangent and the outline of each shared segment; see :meth:`.Facing.outlines`.

        An outline consists of the two ends of the segment.
        """
        points, number = np.stack([self.start, self.end], axis=1).reshape(-1, 2), np.arange(len(self.pair))
        return _tangent(self.normal), number, np.full(len(number), 2), points

    def distance(self, points: np.ndarray, number: np.ndarray) -> np.ndarray:
        """Return the distance of each point from the segment with the index ``number``, shape (points,)."""
        return to_line(points, self.start[number], self.end[number])

    def overlap(self, first: np.ndarray, second: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return the length of the overlap of each pair of collinear segments, as extent and as breadth.

        See :meth:`.Facing.overlap`.
        """
        low, high = self._interval_along(first, second)
        length = np.maximum(np.minimum(high, self.extent[first]) - np.maximum(low, 0.0), 0.0)
        return length, length

    def uncovered(self, row: int, other_rows: np.ndarray, tolerance: float) -> "FacingEdges":
        """Return the parts of a segment that other segments do not cover; see :class:`.Facing`."""
        intervals = zip(*self._interval_along(np.full(len(other_rows), row), other_rows), strict=True)
        parts = spaces(0.0, float(self.extent[row]), intervals, tolerance)
        start, end = (
            self.start[row] + np.outer(x, self._direction[row]) for x in np.reshape(parts, (-1, 2)).T
        )
        columns = (self.pair, self.largest_gap, self.accuracy, self.angle, self.shorter_side)
        pair, largest_gap, accuracy, *lean = (np.full(len(parts), column[row]) for column in columns)
        segments = FacingEdges.between(pair, largest_gap, (start, end), accuracy, (lean[0], lean[1]))
        # Return only uncovered parts that are long compared with the gap between their edges, or with the
        # tolerance.
        is_long = (largest_gap <= SMALL_LENGTH_RATIO * segments.extent) | (
            segments.extent >= _SHORTEST_PARALLEL * tolerance
        )
        return segments.where(is_long)

    @property
    def _direction(self) -> np.ndarray:
        """Return the unit vector from the start to the end of each segment, shape (n, 2)."""
        direction: np.ndarray = (self.end - self.start) / self.extent[:, None]
        return direction

    def _interval_along(self, axis: np.ndarray, segment: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return the smallest and the largest coordinate of each ``segment`` along the segment ``axis``.

        Each of the two arrays has the shape (rows,). The coordinate is zero at the start of ``axis``.
        """
        ends = (
            dots(end[segment] - self.start[axis], self._direction[axis]) for end in (self.start, self.end)
        )
        x = np.stack([*ends])
        return x.min(axis=0), x.max(axis=0)


def facing(scene: Scene, shapes: Geometry, pairs: np.ndarray, far: np.ndarray) -> FacingEdges:
    """Return the segments along which edges of pairs of blocks touch, or face each other across a gap.

    Edges share the part of their bisector onto which both project. They touch if their largest distance over
    this part is within the contact tolerance. Consecutive segments that touch, such as the chords of a curved
    edge, become one segment, or several segments if the edge bends by more than the tolerance.

    Parameters
    ----------
    scene : Scene
        The scene, in the plane.
    shapes : Geometry
        Shapes of the blocks of the scene.
    pairs : ndarray, shape (pairs, 2)
        Pairs of blocks that are near each other.
    far : ndarray, shape (pairs,)
        Largest distance between edges that face each other across a gap, for each pair.

    Raises
    ------
    CaseError
        If more pairs of edges are near each other than can be compared.
    """
    corners = PlaneCorners(shapes)
    pairs_of_edges = [
        corners.edges.near(shapes, ordered_pairs, far)[0] for ordered_pairs in (pairs, pairs[:, ::-1])
    ]
    first_edges, second_edges = (np.bincount(pair, minlength=len(pairs)) for pair in pairs_of_edges)
    if (first_edges * second_edges).sum() > _MOST_EDGES:
        edges_of_block = np.bincount(corners.edges.block)
        name = scene.blocks[edges_of_block.argmax()].name
        raise CaseError(
            f"{scene.origin}: the outlines have too many corners to find joints "
            f"(block {name!r} has {edges_of_block.max()} corners): "
            "raise 'tolerance', or draw the blocks with fewer corners"
        )
    parts = FacingEdges.of(corners, *near_items(shapes, pairs, far, 2 * (corners.edges,)))
    is_touching = parts.largest_gap <= shapes.contact_tolerance
    gap_segments = parts.where(~is_touching & (parts.largest_gap <= far[parts.pair]))
    segments = _join_parts(parts.where(is_touching), shapes.tolerance)
    # Leave out segments that are short compared with the gap between their edges. Such segments occur at
    # bends of curved edges that are drawn as chains of short edges.
    is_wide = segments.extent > SMALL_LENGTH_RATIO * segments.largest_gap
    segments = segments.where((segments.largest_gap <= shapes.tolerance) | is_wide)
    if shapes.contact_tolerance == shapes.tolerance:
        segments = _drop_corner_contacts(segments, shapes.tolerance)
    all_segments = segments.then(gap_segments)
    return all_segments.where(np.argsort(all_segments.pair, kind="stable"))


def sides_of_block(shapes: Geometry, block: int) -> tuple[np.ndarray, np.ndarray]:
    """Return a point on each edge of a block, and the outward unit normal of each edge, shape (edges, 2)."""
    tail, tip, _ = (rows[shapes.edges[2] == block] for rows in shapes.edges)
    direction = (tip - tail) / lengths(tip - tail)[:, None]
    return tail, np.column_stack([direction[:, 1], -direction[:, 0]])


def _join_parts(parts: FacingEdges, tolerance: float) -> FacingEdges:
    """Return the touching segments after joining consecutive segments of the same pair of blocks."""
    pairs, number, count = np.unique(parts.pair, return_inverse=True, return_counts=True)
    chains = [
        chain for pair in pairs[count > 1] for chain in _chains(parts.where(parts.pair == pair), tolerance)
    ]
    return parts.where(count[number] == 1).then(*chains)


def _drop_corner_contacts(segments: FacingEdges, tolerance: float) -> FacingEdges:
    """Leave out the touching segments at which one block may touch the other only with a corner.

    A block may touch only with a corner if the two edges are not parallel, and if the segment is short
    relative to the distance between the edges; see :data:`~.sides.SMALL_LENGTH_RATIO`. Very short segments of
    parallel edges are left out too.
    """
    is_long = segments.largest_gap <= SMALL_LENGTH_RATIO * segments.extent
    is_parallel = segments.angle <= _LARGEST_ANGLE
    return segments.where(is_long | (is_parallel & (segments.extent >= _SHORTEST_PARALLEL * tolerance)))


def _chains(parts: FacingEdges, tolerance: float) -> Iterator[FacingEdges]:
    """Join consecutive segments of one pair of blocks into chains, and yield each chain in simplified form.

    In a chain, each segment is followed by the segment that begins nearest to its end. The distance may be at
    most twice the tolerance, or a fifth of the widest gap between the edges, whichever is larger.
    """
    reach = max(tolerance, SMALL_LENGTH_RATIO * float(parts.largest_gap.max()))
    distance = np.hypot(*np.moveaxis(parts.end[:, None] - parts.start[None], 2, 0))
    np.fill_diagonal(distance, np.inf)
    followed_parts = np.flatnonzero(distance.min(axis=1) <= 2 * reach)
    follower = {int(part): int(distance[part].argmin()) for part in followed_parts}
    remaining_parts = set(range(len(parts.pair)))
    # An open chain begins with a segment that follows no other segment. The segments that remain after all
    # open chains are in closed chains.
    for first in [*sorted(remaining_parts - set(follower.values())), *sorted(remaining_parts)]:
        chain, current_part = [], first
        while current_part in remaining_parts:
            remaining_parts.remove(current_part)
            chain.append(current_part)
            current_part = follower.get(current_part, -1)
        if chain:
            yield _simplify_chain(parts.where(np.array(chain)), tolerance, reach / 2)


def _simplify_chain(chain: FacingEdges, tolerance: float, distance: float) -> FacingEdges:
    """Simplify the line through a chain of segments, and return its straight segments.

    A corner is removed if it lies within ``distance`` of the line without this corner. ``tolerance``
    is the accuracy of the drawing.
    """
    inner_points = (chain.end[:-1] + chain.start[1:]) / 2
    line = shapely.LineString(np.concatenate([chain.start[:1], inner_points, chain.end[-1:]]))
    corners = shapely.get_coordinates(shapely.simplify(line, distance, preserve_topology=False))
    values = chain.pair[0], chain.largest_gap.max(), chain.angle.max(), chain.shorter_side.min()
    pair, largest_gap, *lean = (np.full(len(corners) - 1, value) for value in values)
    accuracy = _accuracy(np.diff(corners, axis=0), tolerance)
    return FacingEdges.between(pair, largest_gap, (corners[:-1], corners[1:]), accuracy, (lean[0], lean[1]))


class PlaneCorners(sides.BlockCorners):
    """Corners of all blocks in the plane. From each corner, an edge runs to the next corner (``tip``)."""

    near_distance_ratio = 2.0
    tip: np.ndarray  #: end point of the edge that begins at each corner, shape (corners, 2)
    edges: Items  #: edges of all blocks, in the order of the corners at which they begin

    def __init__(self, shapes: Geometry, blocks: np.ndarray | None = None) -> None:
        self.shapes = shapes
        self.point, self.tip, block = shapes.edges
        self.start = self.end = self.point
        self.corners = self.compared_items = Items(block, self.point, self.point)
        self.edges = Items(block, np.minimum(self.point, self.tip), np.maximum(self.point, self.tip))

    def kinds(self, pairs: np.ndarray) -> list[Touches]:
        """Return the contacts at which a corner of a block is on an edge of another block, in two tables.

        The first table has the corners of each pair's first block, and the second table has the corners of
        each pair's second block.
        """
        return [self._touches_on_edges(pairs, -1.0), self._touches_on_edges(pairs[:, ::-1], 1.0)]

    def meetings(self, pairs: np.ndarray) -> Meetings:
        """Return the places at which corners of two blocks coincide within the tolerance."""
        tolerance = self.shapes.tolerance
        pair, i, j = near_items(self.shapes, pairs, tolerance, (self.corners, self.corners))
        is_near = np.hypot(*(self.point[j] - self.point[i]).T) <= tolerance
        pair, i, j = pair[is_near], i[is_near], j[is_near]
        middle = (self.point[i] + self.point[j]) / 2
        return Meetings(pair, i, j, middle, middle)

    def bisected(self, meetings: Meetings) -> Touches:
        """Return the contacts at which corners of two blocks coincide.

        Most contacts lie on the bisector of two sides that face each other. A corner in a notch has two
        contacts instead, one on each side of the notch.
        """
        first_sectors, second_sectors = (
            self._sectors(corner) for corner in (meetings.first, meetings.second)
        )
        row, angle = contact_normals(first_sectors, second_sectors)
        normal = np.column_stack([np.cos(angle), np.sin(angle)])
        accuracy = np.mean([self._accuracy_of(end) for end in (meetings.first, meetings.second)], axis=0)
        meetings = meetings.where(row)
        point = meetings.start
        return Touches(meetings.pair, point, point, normal, _tangent(normal), accuracy[row])

    def _sides(self, corner: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return the vectors along the next and the previous edge of each corner, away from the corner."""
        block = self.corners.block
        previous_edge = corner - 1
        is_adjacent = (self.tip[previous_edge] == self.point[corner]).all(axis=1) & (
            block[previous_edge] == block[corner]
        )
        for row in np.flatnonzero(~is_adjacent):
            # The edge before the first corner of an outline is the last edge of the outline. Find it as the
            # edge that ends at this corner.
            of_block = np.flatnonzero(block == block[corner[row]])
            ends_at_corner = (self.tip[of_block] == self.point[corner[row]]).all(axis=1)
            previous_edge[row] = of_block[ends_at_corner][0]
        return self.tip[corner] - self.point[corner], self.point[previous_edge] - self.point[corner]

    def _sectors(self, corner: np.ndarray) -> Sectors:
        """Return the angular sector that the block occupies at each corner."""
        return Sectors(*(np.arctan2(side[:, 1], side[:, 0]) for side in self._sides(corner)))

    def _accuracy_of(self, corner: np.ndarray) -> np.ndarray:
        """Return the uncertainty of the direction of the longer side at each corner, in radians."""
        return np.minimum(*(_accuracy(side, self.shapes.tolerance) for side in self._sides(corner)))

    def _touches_on_edges(self, pairs: np.ndarray, sign: float) -> Touches:
        """Return the contacts at which a corner of each pair's first block is on an edge of the second block.

        ``sign`` is the sign of the contacts' normals relative to the inward normals of the edges.
        """
        tolerance = self.shapes.tolerance
        pair, corner, edge = near_items(self.shapes, pairs, tolerance, (self.corners, self.edges))
        point, tail = self.point[corner], self.point[edge]
        edge_vector = self.tip[edge] - tail
        length = np.hypot(edge_vector[:, 0], edge_vector[:, 1])
        direction = edge_vector / length[:, None]
        normal = np.column_stack([-direction[:, 1], direction[:, 0]])
        along, across = ((point - tail) * direction).sum(axis=1), ((point - tail) * normal).sum(axis=1)
        is_inside = (np.abs(across) <= tolerance) & (along > tolerance) & (along < length - tolerance)
        point, normal = point[is_inside], sign * normal[is_inside]
        accuracy = _accuracy(edge_vector[is_inside], tolerance)
        return Touches(pair[is_inside], point, point, normal, _tangent(normal), accuracy)


def _accuracy(edges: np.ndarray, tolerance: float) -> np.ndarray:
    """Return the uncertainty of the direction of each edge in a drawing, in radians, shape (edges,)."""
    return tolerance / np.hypot(edges[:, 0], edges[:, 1])


def _tangent(normal: np.ndarray) -> np.ndarray:
    """Return the unit tangents of contacts: their normals, rotated clockwise by 90°, shape (rows, 2)."""
    return np.column_stack([normal[:, 1], -normal[:, 0]])

"""Find where solids touch: shared polygons of faces, edges and corners on faces, and edges that cross."""

from dataclasses import dataclass, replace

import numpy as np
import shapely

from masonry_opt.scene.contacts import sides
from masonry_opt.scene.contacts.bisectors import Sectors, contact_normals
from masonry_opt.scene.contacts.sides import Items, Meetings, Touches, near_items
from masonry_opt.scene.geometry import mean_thickness
from masonry_opt.scene.outlines import common_to, without_slivers, without_straight_corners
from masonry_opt.scene.rows import bounds, dots, first_alike, lengths, sums
from masonry_opt.scene.scene import Scene
from masonry_opt.scene.space.faces import Frames, OuterFaces, unit
from masonry_opt.scene.space.shapes import Shapes

#: Smallest width of a shared polygon, or length of an edge in a face, at which a joint is formed, relative to
#: the tolerance. With a larger value, more slivers of inexact drawings are ignored.
NARROWEST = 10

#: Two faces can face each other if the angle between the normal of one face and the reversed normal of the
#: other face is less than the angle with this cosine. With a smaller value, faces at a larger angle can face
#: each other too.
_LEAST_FACING_COSINE = 0.94

#: Two crossing edges form a contact only if their vectors ``SolidCorners.inwards`` differ by more than this
#: value along the common normal of the edges. If they differ less, the faces at both edges are nearly in one
#: plane.
_LEAST_INWARDS_DIFFERENCE = 1e-3

#: Sine of the largest angle between two faces that counts as a rounding error.
_FACE_ANGLE_TOLERANCE = 1e-7


@dataclass(frozen=True)
class FacingFaces(sides.Facing):
    """Polygons that faces of two blocks share.

    A shared polygon is the part of the bisecting plane of two faces onto which both faces project.
    """

    #: Bisecting plane of the two faces of each polygon. Its normal points out of the first block. Its first
    #: axis is as parallel as possible to the first axis of the first block's face.
    frame: Frames
    polygon: np.ndarray  #: shared polygons, connected, without corners on straight sides, shape (n,)

    @property
    def inner_points(self) -> np.ndarray:
        """Return the centroid of each polygon, and two points halfway from the centroid to corners.

        The corners are the first and the middle entry of the polygon's list of corners. Shape (n, 3, 3).
        """
        rings = shapely.get_exterior_ring(self.polygon)
        count = shapely.get_num_points(rings) - 1
        points = [self.middle]
        for corner in (np.zeros_like(count), count // 2):
            plane_points = shapely.get_coordinates(shapely.get_point(rings, corner))
            points.append((self.middle + self.frame.up(plane_points, np.arange(len(count)))) / 2)
        return np.stack(points, axis=1)

    @property
    def breadth(self) -> np.ndarray:
        """Return the mean breadth of each polygon, which is twice its area over its perimeter, shape (n,)."""
        return mean_thickness(self.extent, shapely.length(self.polygon))

    def outlines(self) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
        """Return, for each shared polygon, a tangent vector and the outline; see :meth:`.Facing.outlines`.

        The tangent is parallel to the longest side. Among sides of equal length, the side closest to the
        direction of the first axis of the frame is chosen, and then the side closest to the second axis. The
        choice does not depend on the orientation of the scene.
        """
        rings, polygon = shapely.get_rings(self.polygon, return_index=True)
        plane_points, ring = shapely.get_coordinates(rings, return_index=True)
        # The last corner of a Shapely ring repeats the first corner; drop the last corner.
        is_repeated = np.diff(ring, append=ring[-1:] + 1) != 0
        side = (np.roll(plane_points, -1, axis=0) - plane_points)[~is_repeated]
        plane_points, ring = plane_points[~is_repeated], ring[~is_repeated]
        count = np.bincount(ring, minlength=len(rings))
        is_outer = np.diff(polygon, prepend=-1) != 0
        length = np.hypot(*side.T) * is_outer[ring]
        _, greatest_length = bounds(polygon[ring], length, len(self.pair))
        longest_sides = np.flatnonzero(length >= greatest_length[polygon[ring]] * (1 - 1e-6))
        direction = side[longest_sides] / length[longest_sides, None]
        rank = np.round(direction @ [1.0, 1e-3], 6)
        best_rows = np.lexsort((-rank, polygon[ring[longest_sides]]))
        best_rows = best_rows[np.unique(polygon[ring[longest_sides[best_rows]]], return_index=True)[1]]
        frame, side_direction, first_side = self.frame, direction[best_rows], longest_sides[best_rows]
        tangent = side_direction[:, :1] * frame.u + side_direction[:, 1:] * frame.v
        # Shift the corners of each outer ring cyclically, so that the ring begins with the side to which the
        # tangent is parallel.
        begin, first = np.zeros_like(count), (np.cumsum(count) - count)[ring]
        begin[ring[first_side]] = first_side - first[first_side]
        order = first + (np.arange(len(ring)) - first + begin[ring]) % count[ring]
        return tangent, polygon, count, frame.up(plane_points[order], polygon[ring])

    def distance(self, points: np.ndarray, number: np.ndarray) -> np.ndarray:
        """Return the distance of each point from the polygon with the index ``number``, shape (points,)."""
        plane_points = shapely.points(self.frame.down(points, number))
        return np.hypot(
            shapely.distance(plane_points, self.polygon[number]), self.frame.above(points, number)
        )

    def overlap(self, first: np.ndarray, second: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return the area and the mean breadth of the intersection of two polygons; see :class:`.Facing`."""
        intersection = shapely.intersection(self.polygon[first], self._projections(first, second))
        area = shapely.area(intersection)
        return area, mean_thickness(area, shapely.length(intersection))

    def uncovered(self, row: int, other_rows: np.ndarray, tolerance: float) -> "FacingFaces":
        """Return the parts of a polygon that other polygons in its plane do not cover.

        See :class:`.Facing`.
        """
        cover = shapely.union_all(self._projections(np.full(len(other_rows), row), other_rows))
        remainder = np.array([shapely.difference(self.polygon[row], cover)])
        pieces, _ = _remove_tails(remainder, np.zeros(1, dtype=int), NARROWEST * tolerance)
        pieces = without_straight_corners(pieces, tolerance / 2)
        parts = self.where(np.full(len(pieces), row))
        centroids = shapely.get_coordinates(shapely.centroid(pieces))
        middle = parts.frame.up(centroids, np.arange(len(pieces)))
        return replace(parts, extent=shapely.area(pieces), middle=middle, polygon=pieces)

    def _projections(self, target: np.ndarray, source: np.ndarray) -> np.ndarray:
        """Return the projections of the polygons ``source`` onto the planes of the polygons ``target``."""
        return _project(self.polygon[source], self.frame.where(target), self.frame.where(source))


def facing(scene: Scene, shapes: Shapes, pairs: np.ndarray, far: np.ndarray) -> FacingFaces:
    """Return the polygons that faces of pairs of blocks share.

    Polygons are connected. Pieces and ends of pieces narrower than ten tolerances are left out.

    Parameters
    ----------
    scene : Scene
        The scene, in space.
    shapes : Shapes
        Shapes of the blocks of the scene.
    pairs : ndarray, shape (pairs, 2)
        Pairs of blocks that are near each other.
    far : ndarray, shape (pairs,)
        Largest distance between two faces over a shared polygon, for each pair.
    """
    faces, frame = Items(shapes.faces.block, *shapes.faces.boxes), shapes.faces.frame
    pair, i, j = near_items(shapes, pairs, far, (faces, faces))
    cosine = -dots(frame.normal[i], frame.normal[j])
    # The sine of the angle between two faces limits how far the second face rises above the plane of the
    # first face.
    lean = np.sqrt(np.maximum(1 - cosine**2, 0)) + _FACE_ANGLE_TOLERANCE
    reach = far[pair] / _LEAST_FACING_COSINE + lean * lengths(faces.high - faces.low)[j]
    # Two faces can be near each other only if the base point of the second face is within `reach` of the
    # plane of the first face.
    is_near = (cosine > _LEAST_FACING_COSINE) & (np.abs(frame.above(frame.base[j], i)) <= reach)
    return _shared_polygons(shapes, pair[is_near], i[is_near], j[is_near], far[pair[is_near]])


def sides_of_block(shapes: Shapes, block: int) -> tuple[np.ndarray, np.ndarray]:
    """Return a point on each face of a block, and the outward unit normal of each face, shape (faces, 3)."""
    frame = shapes.faces.frame.where(shapes.faces.block == block)
    return frame.base, frame.normal


def _shared_polygons(
    shapes: Shapes, pair: np.ndarray, i: np.ndarray, j: np.ndarray, far: np.ndarray
) -> FacingFaces:
    """Return the polygons that pairs of faces share.

    Face ``i`` belongs to the first block of its pair, and face ``j`` to the second block. The distance of the
    two faces is at most ``far`` over the whole polygon.
    """
    faces, narrowest = shapes.faces, NARROWEST * shapes.tolerance
    frame_i, frame_j = faces.frame.where(i), faces.frame.where(j)
    frame = Frames.of(frame_i.base, frame_i.normal - frame_j.normal, frame_i.u)
    # Move each bisecting plane to the middle between its two faces.
    half = _height(frame, frame_j, np.zeros((len(i), 2)), np.arange(len(i))) / 2
    frame = replace(frame, base=frame.base + half[:, None] * frame.normal)
    projected_i, projected_j = (
        _project(faces.polygon[face], frame, own_frame) for face, own_frame in ((i, frame_i), (j, frame_j))
    )
    pieces, number = common_to(projected_i, projected_j, shapes.tolerance)
    pieces, number = _remove_tails(pieces, number, narrowest)
    pieces = without_straight_corners(pieces, shapes.tolerance / 2)
    points, piece = shapely.get_coordinates(pieces, return_index=True)
    gap = _height(frame, frame_j, points, number[piece]) - _height(frame, frame_i, points, number[piece])
    smallest_gap, largest_gap = bounds(piece, gap, len(pieces))
    angle = lengths(np.cross(frame_i.normal, frame_j.normal))[number]
    width = mean_thickness(shapely.area(pieces), shapely.length(pieces))
    is_near = (smallest_gap >= -shapes.contact_tolerance) & (largest_gap <= far[number])
    is_near &= (largest_gap <= shapes.tolerance) | sides.faces_across(angle, largest_gap, width)
    pieces, number, largest_gap, angle = (
        pieces[is_near],
        number[is_near],
        largest_gap[is_near],
        angle[is_near],
    )
    frame = frame.where(number)
    middle = frame.up(shapely.get_coordinates(shapely.centroid(pieces)), np.arange(len(pieces)))
    first_accuracy, second_accuracy = (_accuracy(faces, face, shapes.tolerance)[number] for face in (i, j))
    accuracy, smaller_width = (
        (first_accuracy + second_accuracy) / 2,
        shapes.tolerance / np.maximum(first_accuracy, second_accuracy),
    )
    normal = -frame.normal
    return FacingFaces(
        pair[number],
        largest_gap,
        shapely.area(pieces),
        middle,
        normal,
        accuracy,
        angle,
        smaller_width,
        frame,
        pieces,
    )


def _accuracy(faces: OuterFaces, face: np.ndarray, tolerance: float) -> np.ndarray:
    """Return the uncertainty of the direction of each given face in a drawing, in radians, shape (faces,).

    ``face`` has the indices of the given faces, shape (faces,). The uncertainty is the tolerance divided by
    the shorter side of the smallest rectangle around the face.
    """
    distinct_faces, number = np.unique(face, return_inverse=True)
    boxes = shapely.oriented_envelope(faces.polygon[distinct_faces])
    corners = shapely.get_coordinates(boxes).reshape(len(distinct_faces), 5, 2)
    sides = np.hypot(*np.moveaxis(np.diff(corners[:, :3], axis=1), 2, 0))
    return np.asarray((tolerance / sides.min(axis=1))[number])


def _project(polygons: np.ndarray, frame: Frames, source: Frames) -> np.ndarray:
    """Return the orthogonal projections of polygons onto given planes.

    Each polygon has coordinates in its frame of ``source``; its projection has coordinates in its ``frame``.
    """
    plane_points, number = shapely.get_coordinates(polygons, return_index=True)
    projection = frame.down(source.up(plane_points, number), number)
    # Copy the polygons, because ``set_coordinates`` overwrites them.
    return shapely.set_coordinates(polygons.copy(), projection)


def _height(frame: Frames, plane: Frames, points: np.ndarray, number: np.ndarray) -> np.ndarray:
    """Return the height of planes above reference planes at given points, shape (points,).

    ``points`` are coordinates in the frames. ``number`` is the index of the frame and of the plane of each
    point.
    """
    cosine = dots(frame.normal[number], plane.normal[number])
    return -plane.above(frame.up(points, number), number) / cosine


def _remove_tails(pieces: np.ndarray, number: np.ndarray, narrowest: float) -> tuple[np.ndarray, np.ndarray]:
    """Remove parts of polygons that are narrower than a given width, and return the polygons.

    Such parts are thin ends, and thin strips between wider parts. A polygon may be divided into several
    polygons, or vanish. Each result has the number of its original polygon.
    """
    wide_parts = without_slivers(pieces, narrowest)
    # Detect narrow ends by the perimeter, because narrow ends may have no area. Polygons without narrow ends
    # keep their exact coordinates.
    is_cut = shapely.length(pieces) - shapely.length(wide_parts) > narrowest
    is_cut |= shapely.is_empty(wide_parts) | (shapely.get_num_geometries(wide_parts) != 1)
    pieces[is_cut] = wide_parts[is_cut]
    parts, piece = shapely.get_parts(pieces, return_index=True)
    has_area = ~shapely.is_empty(parts)
    return parts[has_area], number[piece[has_area]]


class SolidCorners(sides.BlockCorners):
    """Edges and corners of the outer faces of blocks in space, with methods that find their contacts.

    An edge is the segment from ``start`` to ``end``.
    """

    near_distance_ratio = NARROWEST
    outer: OuterFaces  #: outer faces of all blocks
    direction: np.ndarray  #: unit vector along each edge, shape (edges, 3)
    #: Sum of two unit vectors, one into each face at the edge (``first`` and ``last``), shape (edges, 3).
    inwards: np.ndarray
    #: Two unit vectors perpendicular to each edge, shape (edges, 3): ``first`` points into one face at the
    #: edge, ``last`` into the second face. The block occupies the sector from ``first`` to ``last``, counted
    #: right-handed about the edge.
    first: np.ndarray
    last: np.ndarray
    edges: Items  #: edges with the indices of their blocks
    faces: Items  #: outer faces with the indices of their blocks

    def __init__(self, shapes: Shapes, blocks: np.ndarray) -> None:
        self.shapes, self.outer = shapes, shapes.faces
        faces = self.outer
        tail, tip, face = faces.sides()
        block = faces.block[face]
        is_chosen = np.isin(block, blocks)
        tail, tip, face, block = tail[is_chosen], tip[is_chosen], face[is_chosen], block[is_chosen]
        # Round coordinates to a grid to find repetitions: each edge belongs to two faces, and each corner to
        # at least three faces.
        tail_grid, tip_grid = (np.round(ends / shapes.tolerance) for ends in (tail, tip))
        ends = np.column_stack([block, np.minimum(tail_grid, tip_grid), np.maximum(tail_grid, tip_grid)])
        edge, number = np.unique(first_alike(ends), return_inverse=True)
        self.start, self.end = tail[edge], tip[edge]
        self.direction = unit(self.end - self.start)
        direction = unit(tip - tail)
        inwards = np.cross(faces.frame.normal[face], direction)
        self.inwards = sums(number, inwards, len(edge))
        # The outlines of the two faces at an edge run along the edge in opposite directions.
        runs_along = dots(direction, self.direction[number]) > 0
        self.last = sums(number[runs_along], inwards[runs_along], len(edge))
        self.first = sums(number[~runs_along], inwards[~runs_along], len(edge))
        low, high = np.minimum(tail, tip), np.maximum(tail, tip)
        self.edges = self.compared_items = Items(block[edge], low[edge], high[edge])
        corner = np.unique(first_alike(np.column_stack([block, tail_grid])))
        self.point = tail[corner]
        self.corners = Items(block[corner], self.point, self.point)
        self.faces = Items(faces.block, *faces.boxes)

    def kinds(self, pairs: np.ndarray) -> list[Touches]:
        """Return three tables of contacts: edges that lie in faces, corners on faces, and crossing edges."""
        reversed_pairs = pairs[:, ::-1]
        edges = _edges_in_faces(self, pairs, 1).then(_edges_in_faces(self, reversed_pairs, -1))
        corners = _corners_on_faces(self, pairs, 1).then(_corners_on_faces(self, reversed_pairs, -1))
        return [edges, corners, _crossings(self, pairs)]

    def meetings(self, pairs: np.ndarray) -> Meetings:
        """Return the lines along which edges of two blocks coincide within the tolerance."""
        tolerance = self.shapes.tolerance
        pair, i, j = near_items(self.shapes, pairs, tolerance, (self.edges, self.edges))
        origin, direction, length = self.start[i], self.direction[i], lengths(self.end - self.start)[i]
        ends = [point[j] - origin for point in (self.start, self.end)]
        position = [dots(end, direction) for end in ends]
        offset = [lengths(end - x[:, None] * direction) for end, x in zip(ends, position, strict=True)]
        low, high = np.maximum(np.minimum(*position), 0.0), np.minimum(np.maximum(*position), length)
        meets = (np.maximum(*offset) <= tolerance) & (high - low > NARROWEST * tolerance)
        meets &= self._has_both_faces(i) & self._has_both_faces(j)
        start, end = (origin + x[:, None] * direction for x in (low, high))
        return Meetings(pair, i, j, start, end).where(meets)

    def _has_both_faces(self, edge: np.ndarray) -> np.ndarray:
        """Return a mask of the edges at which neither face was left out as too narrow, shape (edges,).

        Faces narrower than the tolerance are left out. At an edge of such a face, the sector that the block
        occupies is unknown.
        """
        return (lengths(self.first[edge]) > 0) & (lengths(self.last[edge]) > 0)

    def bisected(self, meetings: Meetings) -> Touches:
        """Return the contacts at which edges of two blocks coincide.

        Most contacts lie on the bisector of two faces that face each other. An edge in a notch has two
        contacts instead, one on each face of the notch.
        """
        i, j = meetings.first, meetings.second
        along = self.direction[i]
        across = unit(self.first[i])
        axes = across, np.cross(along, across)

        def angles(vectors: np.ndarray) -> np.ndarray:
            """Return the angles of vectors about the edges, measured from the axis ``across``, in radians."""
            return np.arctan2(dots(vectors, axes[1]), dots(vectors, axes[0]))

        is_parallel = (dots(along, self.direction[j]) > 0)[:, None]
        first, last = (np.where(is_parallel, *pair) for pair in self._directed_vectors(j))
        first_sectors = Sectors(angles(self.first[i]), angles(self.last[i]))
        row, angle = contact_normals(first_sectors, Sectors(angles(first), angles(last)))
        normal = np.cos(angle)[:, None] * axes[0][row] + np.sin(angle)[:, None] * axes[1][row]
        length = lengths(meetings.end - meetings.start)
        accuracy = self.shapes.tolerance / np.where(length > 0, length, 1.0)
        meetings = meetings.where(row)
        return Touches(meetings.pair, meetings.start, meetings.end, normal, along[row], accuracy[row])

    def _directed_vectors(self, edge: np.ndarray) -> tuple[tuple[np.ndarray, np.ndarray], ...]:
        """Return the vectors ``(first, last)`` of edges, and then the vectors of the reversed edges.

        If the direction of an edge is reversed, ``first`` and ``last`` are exchanged. See
        :class:`SolidCorners` for the two vectors.
        """
        first, last = self.first[edge], self.last[edge]
        return (first, last), (last, first)


def _edges_in_faces(corners: SolidCorners, pairs: np.ndarray, sign: int) -> Touches:
    """Return the contacts at which an edge of each pair's first block lies in a face of the second block.

    ``sign`` is 1 if the normals of these faces point into the first block of the contact, and -1 otherwise.
    """
    tolerance, faces = corners.shapes.tolerance, corners.outer
    narrowest = NARROWEST * tolerance
    pair, i, j = near_items(corners.shapes, pairs, tolerance, (corners.edges, corners.faces))
    height = [faces.frame.above(ends[i], j) for ends in (corners.start, corners.end)]
    plane_ends = [faces.frame.down(ends[i], j) for ends in (corners.start, corners.end)]
    is_near = (np.minimum(*height) <= tolerance) & (np.maximum(*height) >= -tolerance)
    is_near &= np.hypot(*(plane_ends[1] - plane_ends[0]).T) > narrowest
    pair, j, start, end, start_height, end_height = (
        column[is_near] for column in (pair, j, *plane_ends, *height)
    )
    lines = shapely.linestrings(np.stack([start, end], axis=1))
    # Most edges run along outlines of faces. A fast test with shrunken faces excludes such edges before the
    # slow computation of intersections.
    face, face_number = np.unique(j, return_inverse=True)
    shrunken_faces = shapely.buffer(faces.polygon[face], -narrowest / 2, join_style="bevel")
    shapely.prepare(shrunken_faces)
    crossing_rows = np.flatnonzero(shapely.intersects(shrunken_faces[face_number], lines))
    intersections = shapely.intersection(lines[crossing_rows], faces.polygon[j[crossing_rows]])
    pieces, number = shapely.get_parts(intersections, return_index=True)
    is_long = shapely.length(pieces) > narrowest
    pieces, number = pieces[is_long], crossing_rows[number[is_long]]
    face = j[number]
    inner_points = shapely.line_interpolate_point(pieces[:, None], [0.25, 0.5, 0.75], normalized=True)
    border = shapely.boundary(faces.polygon[face])[:, None]
    is_contact = (shapely.distance(border, inner_points) > narrowest).any(axis=1)
    points = []
    for end_of_piece in (0, -1):
        position = shapely.get_coordinates(shapely.get_point(pieces, end_of_piece))
        edge = (end - start)[number]
        share = ((position - start[number]) * edge).sum(axis=1) / (edge**2).sum(axis=1)
        offset = start_height[number] + share * (end_height - start_height)[number]
        is_contact &= np.abs(offset) <= tolerance
        points.append(faces.frame.up(position, face) + offset[:, None] / 2 * faces.frame.normal[face])
    contact_start, contact_end = points[0][is_contact], points[1][is_contact]
    # The outward normal of the second block's face points into the first block; ``sign`` is -1 if the two
    # blocks are swapped.
    normal = sign * faces.frame.normal[face[is_contact]]
    # Make the tangent perpendicular to the normal, because the edge may be slightly inclined to the face.
    direction = contact_end - contact_start
    direction -= dots(direction, normal)[:, None] * normal
    accuracy = _accuracy(faces, face[is_contact], tolerance)
    return Touches(pair[number[is_contact]], contact_start, contact_end, normal, unit(direction), accuracy)


def _corners_on_faces(corners: SolidCorners, pairs: np.ndarray, sign: int) -> Touches:
    """Return the contacts at which a corner of each pair's first block is on a face of the second block.

    ``sign`` is 1 if the normals of these faces point into the first block of the contact, and -1 otherwise.
    """
    tolerance, faces = corners.shapes.tolerance, corners.outer
    pair, i, j = near_items(corners.shapes, pairs, tolerance, (corners.corners, corners.faces))
    plane_points, height = faces.frame.down(corners.point[i], j), faces.frame.above(corners.point[i], j)
    position = shapely.points(plane_points)
    is_touching = (np.abs(height) <= tolerance) & shapely.contains(faces.polygon[j], position)
    is_touching &= shapely.distance(shapely.boundary(faces.polygon[j]), position) > tolerance
    pair, j, plane_points, height = (
        pair[is_touching],
        j[is_touching],
        plane_points[is_touching],
        height[is_touching],
    )
    point = faces.frame.up(plane_points, j) + height[:, None] / 2 * faces.frame.normal[j]
    accuracy = _accuracy(faces, j, tolerance)
    return Touches(pair, point, point, sign * faces.frame.normal[j], faces.frame.u[j], accuracy)


def _crossings(corners: SolidCorners, pairs: np.ndarray) -> Touches:
    """Return the contacts at points where edges of two blocks cross."""
    tolerance = corners.shapes.tolerance
    pair, i, j = near_items(corners.shapes, pairs, tolerance, (corners.edges, corners.edges))
    length = lengths(corners.end - corners.start)
    product = np.cross(corners.direction[i], corners.direction[j])
    sine = lengths(product)
    # Nearly parallel edges do not form a contact, because errors within the tolerance would change their
    # common normal too much.
    is_crossing = sine * np.minimum(length[i], length[j]) > NARROWEST * tolerance
    pair, i, j, product, sine = (column[is_crossing] for column in (pair, i, j, product, sine))
    direction_i, direction_j = corners.direction[i], corners.direction[j]
    normal = product / sine[:, None]
    offset = corners.start[j] - corners.start[i]
    distances = [dots(np.cross(offset, edge), normal) / sine for edge in (direction_j, direction_i)]
    gap = dots(offset, normal)
    is_touching = np.abs(gap) <= tolerance
    for distance, edge in zip(distances, (i, j), strict=True):
        is_touching &= (distance > tolerance) & (distance < length[edge] - tolerance)
    # Crossing edges form a contact only if the blocks are on opposite sides of the plane through both edges.
    # The vectors ``inwards`` of the edges then differ along the normal of this plane.
    difference = dots(normal, corners.inwards[i] - corners.inwards[j])
    is_touching &= np.abs(difference) > _LEAST_INWARDS_DIFFERENCE
    point = corners.start[i] + distances[0][:, None] * direction_i + gap[:, None] / 2 * normal
    sign = np.sign(difference)[:, None]
    # Errors of the edges rotate the common normal more if the angle between the edges is smaller.
    accuracy = tolerance * (1 / length[i] + 1 / length[j]) / sine
    point, normal = point[is_touching], (sign * normal)[is_touching]
    return Touches(pair[is_touching], point, point, normal, direction_i[is_touching], accuracy[is_touching])

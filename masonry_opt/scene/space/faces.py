"""Find the outer faces of solids from the faces of their parts.

The surfaces of the parts must be closed, and their faces are oriented outwards (:class:`Surfaces`). Faces of
a block in one plane share this plane (:class:`FacePlanes`). The outer faces (:class:`OuterFaces`) bound the
block; areas between two of its parts do not belong to them.
"""

from dataclasses import dataclass, replace
from functools import cached_property
from itertools import chain
from typing import NoReturn, Self

import numpy as np
import shapely

from masonry_opt.errors import CaseError, rounded
from masonry_opt.scene import outlines
from masonry_opt.scene.geometry import LARGEST_STRAIGHT_DISTANCE, TOLERANCE_OVER_ERROR
from masonry_opt.scene.rows import Rows, bounds, dots, first_alike, following, lengths, ranges, sums, turned
from masonry_opt.scene.scene import Scene
from masonry_opt.scene.tolerance_advice import set_tolerance

#: Estimated error of a corner's position, divided by the corner's distance from the mean plane of its face.
#: If one corner of a rectangular face is drawn out of plane, the mean plane tilts towards this corner. The
#: distance of this corner is then a quarter of its error. Messages recommend a tolerance of
#: ``TOLERANCE_OVER_ERROR`` times the estimated error.
_ERROR_OVER_HEIGHT = 4.0

#: Largest distance of a corner from the plane of its face that may result from inexact coordinates, relative
#: to the square root of the face's area. If no corner is farther away, the error message suggests a larger
#: tolerance. With a larger value, the message would suggest a tolerance also for faces bent on purpose.
_LARGEST_PLANARITY_ERROR = 0.02


@dataclass(frozen=True)
class Surfaces:
    """Faces of all blocks in a scene. A block may consist of several parts, each with its own faces.

    Blocks, parts, faces and corners are numbered consecutively over the whole scene. A *corner* is a vertex
    of one face, so a vertex of a cube has three corners.
    """

    scene: Scene  #: scene of the blocks, for messages
    points: np.ndarray  #: coordinates of the vertices, shape (vertices, 3)
    block: np.ndarray  #: index of the block to which each part belongs, in ascending order, shape (parts,)
    #: Index of the part to which each face belongs, in ascending order, shape (faces,).
    part: np.ndarray
    face: np.ndarray  #: index of the face to which each corner belongs, in ascending order, shape (corners,)
    vertex: np.ndarray  #: index of the vertex at each corner, shape (corners,)
    mixed: np.ndarray  #: indices of the blocks whose faces were drawn with inconsistent orientations

    @property
    def corners(self) -> np.ndarray:
        """Return the coordinates of the corners, shape (corners, 3)."""
        return self.points[self.vertex]

    @property
    def count(self) -> np.ndarray:
        """Return the number of corners of each face, shape (faces,)."""
        return np.bincount(self.face, minlength=len(self.part))

    def refuse(self, face: int, reason: str) -> NoReturn:
        """Raise CaseError with the message ``reason``; the number of the face replaces ``{}``."""
        part = self.part[face]
        block = self.block[part]
        number = face - np.searchsorted(self.part, part) + 1
        has_several_parts = np.count_nonzero(self.block == block) > 1
        of_part = f" of part no. {part - np.searchsorted(self.block, block) + 1}" if has_several_parts else ""
        name = self.scene.blocks[block].name
        text = reason.replace("{}", f"face no. {number}{of_part}", 1)
        raise CaseError(f"{self.scene.origin}: block {name!r}: {text}")

    @classmethod
    def of(cls, scene: Scene) -> Self:
        """Return the surfaces of a scene. All faces of one convex part are oriented in the same sense.

        Raises CaseError if a surface is not closed, or if no consistent orientation exists.
        """
        bodies = [block.polyhedra for block in scene.in_space()]
        parts = list(chain.from_iterable(bodies))
        points = np.concatenate([vertices for vertices, _ in parts])
        vertices_of_part = np.array([len(vertices) for vertices, _ in parts])
        part = np.repeat(np.arange(len(parts)), [len(faces) for _, faces in parts])
        rings = [ring for _, faces in parts for ring in faces]
        corners_of_face = np.array(list(map(len, rings)))
        vertex = np.fromiter(chain(*rings), dtype=np.int64)
        vertex += np.repeat((np.cumsum(vertices_of_part) - vertices_of_part)[part], corners_of_face)
        # Meshes may repeat a vertex for each of its faces: replace all copies in a part by the first copy.
        part_of_vertex = np.repeat(np.arange(len(parts)), vertices_of_part)
        vertex = first_alike(np.column_stack([part_of_vertex, points]))[vertex]
        face = np.repeat(np.arange(len(part)), corners_of_face)
        # Drop a corner that is equal to the next corner of its face.
        differs = vertex != vertex[following(corners_of_face)]
        block = np.repeat(np.arange(len(bodies)), list(map(len, bodies)))
        surfaces = cls(scene, points, block, part, face[differs], vertex[differs], np.zeros(0, dtype=int))
        return surfaces._orient()

    def _orient(self) -> Self:
        """Return the surfaces, with all faces of one convex part oriented in the same sense.

        See :meth:`of` for errors.
        """
        tail, tip = self.vertex, self.vertex[following(self.count)]
        key = np.minimum(tail, tip) * np.int64(len(self.points)) + np.maximum(tail, tip)
        _, edge, uses = np.unique(key, return_inverse=True, return_counts=True)
        wrong_corners = np.flatnonzero(uses[edge] != 2)
        if len(wrong_corners):
            start, end = (place(self.points[vertex[wrong_corners[0]]]) for vertex in (tail, tip))
            other_count = uses[edge[wrong_corners[0]]] - 1
            owners = f"{other_count} other faces have" if other_count else "no other face has"
            reason = (
                f"{{}} has an edge from {start} to {end} that {owners}: each edge must belong to two faces"
            )
            self.refuse(int(self.face[wrong_corners[0]]), reason)
        # Each edge is a side of two faces. Find the corner of each of the two faces at which this side
        # begins.
        corners_of_edge = np.argsort(edge, kind="stable").reshape(-1, 2)
        first, second = self.face[corners_of_edge].T
        same_direction = tail[corners_of_edge[:, 0]] == tail[corners_of_edge[:, 1]]
        turn, contradictory = turned(len(self.part), first, second, same_direction)
        if contradictory.any():
            reason = (
                "{} is part of a one-sided surface, which has no inside: define faces that enclose a solid"
            )
            self.refuse(int(contradictory.argmax()), reason)
        mixed_blocks = np.unique(self.block[self.part[first[same_direction]]])
        return replace(self, mixed=mixed_blocks).reversed(turn)

    def reversed(self, chosen: np.ndarray) -> Self:
        """Return the surfaces with the orientation of the chosen faces reversed.

        ``chosen`` is True for the faces to reverse, shape (faces,).
        """
        first, corner = np.cumsum(self.count) - self.count, np.arange(len(self.face))
        mirrored_corners = (2 * first + self.count - 1)[self.face] - corner
        return replace(self, vertex=self.vertex[np.where(chosen[self.face], mirrored_corners, corner)])


def place(point: np.ndarray, tolerance: float = 0.0) -> str:
    """Return the coordinates of a point as text; coordinates between ±``tolerance`` become 0."""
    return f"({', '.join(f'{0.0 if abs(value) <= tolerance else value:.6g}' for value in point)})"


@dataclass(frozen=True)
class Frames(Rows):
    """Planes with coordinate axes."""

    base: np.ndarray  #: origin of the coordinate system of each plane, shape (frames, 3)
    u: np.ndarray  #: unit vector of the first axis of each plane, shape (frames, 3)
    v: np.ndarray  #: unit vector of the second axis of each plane, shape (frames, 3)
    normal: np.ndarray  #: unit normal u × v, shape (frames, 3)

    @classmethod
    def of(cls, base: np.ndarray, normal: np.ndarray, along: np.ndarray) -> Self:
        """Create frames with given origins and normals.

        The first axis is the projection of ``along`` onto the plane. Neither ``normal`` nor ``along`` need
        have unit length.
        """
        normal = unit(normal)
        u = unit(along - dots(along, normal)[:, None] * normal)
        return cls(base, u, np.cross(normal, u), normal)

    def down(self, points: np.ndarray, frame: np.ndarray) -> np.ndarray:
        """Project points onto planes, and return their coordinates in these planes, shape (points, 2).

        ``frame`` is the index of the frame of each point.
        """
        offset = points - self.base[frame]
        return np.column_stack([dots(offset, self.u[frame]), dots(offset, self.v[frame])])

    def above(self, points: np.ndarray, frame: np.ndarray) -> np.ndarray:
        """Return the heights of points in space above the planes of frames, shape (points,).

        ``frame`` is the index of the frame of each point.
        """
        return dots(points - self.base[frame], self.normal[frame])

    def up(self, points: np.ndarray, frame: np.ndarray) -> np.ndarray:
        """Lift points from planes into space, and return their positions, shape (points, 3).

        The points are given by coordinates in the axes of the planes, shape (points, 2). ``frame`` is the
        index of the frame of each point.
        """
        return self.base[frame] + points[:, :1] * self.u[frame] + points[:, 1:] * self.v[frame]


@dataclass(frozen=True)
class OuterFaces(Rows):
    """Outer faces of all blocks, as plane polygons."""

    block: np.ndarray  #: index of the block to which each face belongs, in ascending order, shape (faces,)
    frame: Frames  #: plane and coordinate axes of each face; the normal points outwards
    #: Polygon of each face in the coordinates of the face's frame, counter-clockwise, with any holes, shape
    #: (faces,).
    polygon: np.ndarray

    @cached_property
    def boxes(self) -> tuple[np.ndarray, np.ndarray]:
        """Return the bounding box of each face: smallest and largest coordinates, shape (faces, 3) each."""
        plane_points, face = shapely.get_coordinates(self.polygon, return_index=True)
        return bounds(face, self.frame.up(plane_points, face), len(self.block))

    def sides(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Return start, end and face index of each side of the faces, including the sides of holes.

        Starts and ends have shape (sides, 3); indices of faces are in ascending order. Seen from outside, the
        face is to the left of each side.
        """
        tail, tip, face = outlines.sides_of(self.polygon)
        return self.frame.up(tail, face), self.frame.up(tip, face), face


def unit(vectors: np.ndarray) -> np.ndarray:
    """Return unit vectors in the directions of the given vectors."""
    return vectors / lengths(vectors)[:, None]


@dataclass(frozen=True)
class FacePlanes:
    """Planes of faces. Faces of a block that are coplanar within the tolerance share a plane."""

    frame: Frames  #: planes with coordinate axes
    block: np.ndarray  #: index of the block to which each plane belongs, in ascending order, shape (planes,)
    #: Index of the plane that contains each face, -1 for faces without area, shape (faces,).
    of_face: np.ndarray
    #: True if the normal of the face's plane points out of the face's part, shape (faces,).
    outwards: np.ndarray


def planes(surfaces: Surfaces, tolerance: float) -> FacePlanes:
    """Return the planes of all faces. Raises CaseError if a face is not flat within the tolerance."""
    corners, count, face = surfaces.corners, surfaces.count, surfaces.face
    middle = sums(face, corners, len(count)) / np.maximum(count, 1)[:, None]
    next_corner = corners[following(count)]
    area = sums(face, np.cross(corners - middle[face], next_corner - middle[face]) / 2, len(count))
    size = lengths(area)
    side = lengths(next_corner - corners)
    has_area = 2 * size > tolerance * np.bincount(face, side, len(count))
    normal = np.divide(area, size[:, None], out=np.zeros_like(area), where=size[:, None] > 0)
    height = np.abs(dots(corners - middle[face], normal[face]))
    height[~has_area[face]] = 0.0
    if len(height) and height.max() > tolerance:
        worst_corner = int(height.argmax())
        remedy = "divide it into flat faces"
        if (height <= _LARGEST_PLANARITY_ERROR * np.sqrt(size[face])).all():
            error = _ERROR_OVER_HEIGHT * float(height[worst_corner])
            remedy += f", or {set_tolerance(TOLERANCE_OVER_ERROR * error)} if coordinates are inexact"
        reason = (
            f"{{}} is not flat, because a corner is {rounded(height[worst_corner])} away from the plane of "
            f"the face (tolerance {rounded(tolerance)}): {remedy}"
        )
        surfaces.refuse(int(face[worst_corner]), reason)
    block = surfaces.block[surfaces.part]
    leader = _leading_faces(surfaces, np.flatnonzero(has_area), (middle, normal, size), tolerance)
    leads, plane_of_face = np.unique(leader[has_area], return_inverse=True)
    of_face = np.full(len(count), -1)
    of_face[has_area] = plane_of_face
    # The first axis of a plane is parallel to the longest side of its face, so that the axis rotates with the
    # scene.
    greatest_length = np.zeros(len(count))
    np.maximum.at(greatest_length, face, side)
    candidates = np.flatnonzero(side >= greatest_length[face] * (1 - 1e-6))
    longest_side = candidates[np.unique(face[candidates], return_index=True)[1]]
    direction = np.zeros_like(area)
    direction[face[longest_side]] = (next_corner - corners)[longest_side]
    frame = Frames.of(middle[leads], normal[leads], direction[leads])
    outwards = dots(normal, frame.normal[of_face]) > 0
    return FacePlanes(frame, block[leads], of_face, outwards)


def _leading_faces(
    surfaces: Surfaces,
    faces: np.ndarray,
    geometry: tuple[np.ndarray, np.ndarray, np.ndarray],
    tolerance: float,
) -> np.ndarray:
    """Group the faces of each block by plane. For each face, return the largest face of its group.

    The result contains face indices, shape (faces,); the index is -1 for a face without area. In each round,
    the largest remaining face of each block determines a plane, and all remaining faces of the block in this
    plane form its group.

    Parameters
    ----------
    surfaces : Surfaces
        All faces.
    faces : ndarray
        Indices of the faces that have an area.
    geometry : tuple of ndarray
        Middle, unit normal and area of each face.
    tolerance : float
        Largest distance of a corner from the plane.
    """
    middle, normal, size = geometry
    corners, count = surfaces.corners, surfaces.count
    block = surfaces.block[surfaces.part]
    first = np.cumsum(count) - count
    leader = np.full(len(count), -1)
    # Round the areas, so that rounding errors do not decide the order of faces with equal areas.
    rank = np.round(np.log(size[faces] / size.max(initial=0.0)), 6)
    remaining_faces = faces[np.lexsort((faces, -rank, block[faces]))]
    while len(remaining_faces):
        is_first = np.diff(block[remaining_faces], prepend=-1) != 0
        largest_face = remaining_faces[is_first][np.cumsum(is_first) - 1]
        is_in_plane = (
            np.abs(dots(middle[remaining_faces] - middle[largest_face], normal[largest_face])) <= tolerance
        )
        # Two opposite faces at a thin end of a part must not share a plane, even if their distance is at most
        # the tolerance.
        is_opposite = dots(normal[remaining_faces], normal[largest_face]) < 0
        is_in_plane &= ~(is_opposite & (surfaces.part[remaining_faces] == surfaces.part[largest_face]))
        candidate, plane = remaining_faces[is_in_plane], largest_face[is_in_plane]
        corner = ranges(first[candidate], count[candidate])
        plane_of_corner = np.repeat(plane, count[candidate])
        distance = np.abs(dots(corners[corner] - middle[plane_of_corner], normal[plane_of_corner]))
        is_flat = np.maximum.reduceat(distance, np.cumsum(count[candidate]) - count[candidate]) <= tolerance
        is_flat &= _height_of_part(surfaces, candidate, plane, geometry[:2]) <= tolerance
        is_in_plane[is_in_plane] = is_flat | (candidate == plane)
        leader[remaining_faces[is_in_plane]] = largest_face[is_in_plane]
        remaining_faces = remaining_faces[~is_in_plane]
    return leader


def _height_of_part(
    surfaces: Surfaces, face: np.ndarray, leader: np.ndarray, geometry: tuple[np.ndarray, np.ndarray]
) -> np.ndarray:
    """Return how far the part that contains each face extends beyond a plane that the face may share.

    The plane is that of the face's *leader*: a face of the same block, or the face itself. The result has
    shape (faces,).

    A narrow face may lie in a plane that its part crosses elsewhere. With this plane as the plane of the
    face, the part would not be convex.

    Parameters
    ----------
    surfaces : Surfaces
        All faces.
    face, leader : ndarray
        Indices of the faces, and of the faces whose planes they may share. All faces of one part have the
        same leader.
    geometry : tuple of ndarray
        Middle and unit normal of each face.
    """
    middle, normal = geometry
    first_corner = np.searchsorted(surfaces.part[surfaces.face], np.arange(len(surfaces.block) + 1))
    is_reversed = dots(normal[face], normal[leader]) < 0
    _, sample, pair = np.unique(2 * surfaces.part[face] + is_reversed, return_index=True, return_inverse=True)
    part, plane = surfaces.part[face[sample]], leader[sample]
    count = first_corner[part + 1] - first_corner[part]
    owner = np.repeat(np.arange(len(part)), count)
    corner = ranges(first_corner[part], count)
    sign = np.where(is_reversed[sample], -1.0, 1.0)[owner]
    height = sign * dots(surfaces.corners[corner] - middle[plane[owner]], normal[plane[owner]])
    return np.maximum.reduceat(height, np.cumsum(count) - count)[pair]


def _replace_crossed(polygons: np.ndarray, tolerance: float) -> np.ndarray:
    """Replace polygons by their convex hulls if they cross themselves only because of rounding.

    Rounding changes the area of a polygon by at most the tolerance times half its outline.
    """
    hulls = shapely.convex_hull(polygons)
    added_area = np.abs(shapely.area(hulls) - shapely.area(polygons))
    is_crossed_by_rounding = ~shapely.is_valid(polygons) & (
        added_area <= tolerance * shapely.length(hulls) / 2
    )
    return np.where(is_crossed_by_rounding, shapely.orient_polygons(hulls), polygons)


def outer_faces(surfaces: Surfaces, planes: FacePlanes, tolerance: float) -> OuterFaces:
    """Return the outer faces of all blocks. Raises CaseError if the outline of a face crosses itself."""
    corner = planes.of_face[surfaces.face] >= 0
    face = surfaces.face[corner]
    number, of_ring = np.unique(face, return_inverse=True)
    plane_points = planes.frame.down(surfaces.corners[corner], planes.of_face[face])
    pieces = shapely.polygons(shapely.linearrings(plane_points, indices=of_ring))
    pieces = _replace_crossed(pieces, tolerance)
    is_crossed = ~shapely.is_valid(pieces)
    if is_crossed.any():
        reason = "{} crosses itself: list the corners of the face in order along its outline"
        surfaces.refuse(int(number[is_crossed][0]), reason)
    side = 2 * planes.of_face[number] + ~planes.outwards[number]
    key, sample, count = np.unique(side, return_index=True, return_counts=True)
    side_polygons = pieces[sample]
    pieces_of_side = np.split(pieces[np.argsort(side, kind="stable")], np.cumsum(count)[:-1])
    grid = outlines.GRID * tolerance
    for index in np.flatnonzero(count > 1):
        side_pieces = pieces_of_side[index]
        union = shapely.union_all(side_pieces)
        # Convex pieces do not overlap, so the area of the union must be the sum of their areas. If the areas
        # differ, the union has failed in floating-point arithmetic. In this case, round the corners to a grid
        # and compute the union again.
        if abs(union.area - shapely.area(side_pieces).sum()) > tolerance * union.length:
            union = shapely.union_all(side_pieces, grid_size=grid)
        side_polygons[index] = union
    side_polygons[count > 1] = outlines.without_slivers(side_polygons[count > 1], -tolerance)
    # At the contact of two parts of a block, a plane has faces with both orientations. Remove their common
    # area, which is inside the block.
    for index in np.flatnonzero(key[:-1] // 2 == key[1:] // 2):
        pair = side_polygons[index : index + 2]
        remainder = outlines.sound(shapely.difference, pair, pair[::-1], grid=grid)
        side_polygons[index : index + 2] = outlines.without_slivers(remainder, 2 * tolerance)
    polygons, of_side = shapely.get_parts(side_polygons, return_index=True)
    valid_polygons = outlines.valid(
        outlines.without_straight_corners(polygons, LARGEST_STRAIGHT_DISTANCE * tolerance)
    )
    polygons, part = shapely.get_parts(valid_polygons, return_index=True)
    of_side = of_side[part]
    is_wide = outlines.wide(polygons, tolerance)
    polygons, of_side = polygons[is_wide], of_side[is_wide]
    plane, inwards = key[of_side] // 2, key[of_side] % 2 == 1
    # Reverse the second axis of faces whose outward normal is opposite to the normal of their plane.
    flipped = shapely.transform(polygons[inwards], lambda points: points * [1, -1])
    polygons[inwards] = shapely.orient_polygons(flipped)
    sign = np.where(inwards, -1.0, 1.0)[:, None]
    frame = planes.frame.where(plane)
    frame = Frames(frame.base, frame.u, sign * frame.v, sign * frame.normal)
    return OuterFaces(planes.block[plane], frame, polygons)

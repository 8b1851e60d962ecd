"""Faces of solids: those of their parts, closed and turned outwards, planes, and what of them is outside."""

from dataclasses import dataclass, replace
from functools import cached_property
from itertools import chain
from typing import NoReturn, Self

import numpy as np
import shapely

from masonry_opt.errors import CaseError
from masonry_opt.scene import outlines
from masonry_opt.scene.geometry import STRAIGHT, TOLERANCE_OVER_ERROR, set_tolerance
from masonry_opt.scene.rows import Rows, bounds, dots, first_alike, following, lengths, ranges, sums, turned
from masonry_opt.scene.scene import Scene

#: Error of one corner of a rectangle over the heights of its corners above their plane, which the error
#: tilts. A smaller value advises a tolerance that may leave other faces of the drawing not flat.
_ERROR_OVER_HEIGHT = 4.0

#: Height of a corner above the plane of its face, over the root of the area of the face, up to which
#: coordinates may be inexact. A larger value advises a tolerance for faces that are bent on purpose.
_INEXACT = 0.02


@dataclass(frozen=True)
class Surfaces:
    """Faces of all parts of all blocks in turn."""

    scene: Scene  #: theirs, for messages
    points: np.ndarray  #: vertices, shape (vertices, 3)
    block: np.ndarray  #: block of each part, rising, shape (parts,)
    part: np.ndarray  #: part of each face, rising, shape (faces,)
    face: np.ndarray  #: face of each corner, rising, shape (corners,)
    vertex: np.ndarray  #: vertex of each corner, shape (corners,)
    mixed: np.ndarray  #: blocks whose faces were not all given turned one way

    @property
    def corners(self) -> np.ndarray:
        """Positions of the corners, shape (corners, 3)."""
        return self.points[self.vertex]

    @property
    def count(self) -> np.ndarray:
        """Number of corners of each face, shape (faces,)."""
        return np.bincount(self.face, minlength=len(self.part))

    def refuse(self, face: int, why: str) -> NoReturn:
        """Raise CaseError that names the block, part and face."""
        part = self.part[face]
        block = self.block[part]
        number = face - np.searchsorted(self.part, part) + 1
        several = np.count_nonzero(self.block == block) > 1
        of_part = f" of part no. {part - np.searchsorted(self.block, block) + 1}" if several else ""
        name = self.scene.blocks[block].name
        raise CaseError(f"{self.scene.origin}: block {name!r}: face no. {number}{of_part} {why}")

    @classmethod
    def of(cls, scene: Scene) -> Self:
        """Those of a scene, turned one way in each part. Raises CaseError if they do not close or turn so."""
        bodies = [block.polyhedra for block in scene.in_space()]
        parts = list(chain.from_iterable(bodies))
        points = np.concatenate([vertices for vertices, _ in parts])
        of_vertices = np.array([len(vertices) for vertices, _ in parts])
        part = np.repeat(np.arange(len(parts)), [len(faces) for _, faces in parts])
        rings = [ring for _, faces in parts for ring in faces]
        of_corners, vertex = np.array(list(map(len, rings))), np.fromiter(chain(*rings), dtype=np.int64)
        vertex += np.repeat((np.cumsum(of_vertices) - of_vertices)[part], of_corners)
        # Meshes may repeat vertices face by face.
        vertex = first_alike(np.column_stack([np.repeat(np.arange(len(parts)), of_vertices), points]))[vertex]
        face = np.repeat(np.arange(len(part)), of_corners)
        apart = vertex != vertex[following(of_corners)]
        block = np.repeat(np.arange(len(bodies)), list(map(len, bodies)))
        given = cls(scene, points, block, part, face[apart], vertex[apart], np.zeros(0, dtype=int))
        tail, tip = given.vertex, given.vertex[following(given.count)]
        key = np.minimum(tail, tip) * np.int64(len(given.points)) + np.maximum(tail, tip)
        _, edge, uses = np.unique(key, return_inverse=True, return_counts=True)
        wrong = np.flatnonzero(uses[edge] != 2)
        if len(wrong):
            one, other = (place(given.points[end[wrong[0]]]) for end in (tail, tip))
            more = uses[edge[wrong[0]]] - 1
            others = f"{more} other faces have" if more else "no other face has"
            why = f"has an edge from {one} to {other} that {others}"
            remedy = "close the surface, each edge in two faces"
            given.refuse(int(given.face[wrong[0]]), f"{why}: {remedy}")
        mates = np.argsort(edge, kind="stable").reshape(-1, 2)
        one, other = given.face[mates].T
        same_way = tail[mates[:, 0]] == tail[mates[:, 1]]
        turn, twisted = turned(len(given.part), one, other, same_way)
        if twisted.any():
            why = "is part of a surface without inside and outside: give a solid's faces"
            given.refuse(int(twisted.argmax()), why)
        mixed = np.unique(given.block[given.part[one[same_way]]])
        return replace(given, mixed=mixed).reversed(turn)

    def reversed(self, chosen: np.ndarray) -> Self:
        """The surfaces with the chosen faces, shape (faces,), turned round."""
        first, at = np.cumsum(self.count) - self.count, np.arange(len(self.face))
        turned = (2 * first + self.count - 1)[self.face] - at
        return replace(self, vertex=self.vertex[np.where(chosen[self.face], turned, at)])


def place(point: np.ndarray, tolerance: float = 0.0) -> str:
    """A point in words, coordinates within the tolerance as 0."""
    return f"({', '.join(f'{0.0 if abs(value) <= tolerance else value:.6g}' for value in point)})"


@dataclass(frozen=True)
class Frames(Rows):
    """Planes: a point of each, two unit axes in it and its unit normal u × v, shape (frames, 3) each."""

    base: np.ndarray
    u: np.ndarray
    v: np.ndarray
    normal: np.ndarray

    @classmethod
    def of(cls, base: np.ndarray, normal: np.ndarray, along: np.ndarray) -> Self:
        """With these points and normals, the first axis as near as it can be to ``along``."""
        normal = unit(normal)
        u = unit(along - dots(along, normal)[:, None] * normal)
        return cls(base, u, np.cross(normal, u), normal)

    def down(self, points: np.ndarray, frame: np.ndarray) -> np.ndarray:
        """Coordinates in the given frames of points in space, shape (points, 2)."""
        beside = points - self.base[frame]
        return np.column_stack([dots(beside, self.u[frame]), dots(beside, self.v[frame])])

    def above(self, points: np.ndarray, frame: np.ndarray) -> np.ndarray:
        """Height of points in space over the given frames, shape (points,)."""
        return dots(points - self.base[frame], self.normal[frame])

    def up(self, points: np.ndarray, frame: np.ndarray) -> np.ndarray:
        """Points in space with these coordinates in the given frames, shape (points, 3)."""
        return self.base[frame] + points[:, :1] * self.u[frame] + points[:, 1:] * self.v[frame]


@dataclass(frozen=True)
class OuterFaces(Rows):
    """Plane outer faces of the blocks in turn."""

    block: np.ndarray  #: of each face, rising, shape (faces,)
    frame: Frames  #: their planes, normals outwards
    polygon: np.ndarray  #: shapely polygons in them, counter-clockwise, with holes, shape (faces,)

    @cached_property
    def boxes(self) -> tuple[np.ndarray, np.ndarray]:
        """Least and largest coordinates of each face, shape (faces, 3) each."""
        flat, face = shapely.get_coordinates(self.polygon, return_index=True)
        return bounds(face, self.frame.up(flat, face), len(self.block))

    def sides(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Sides of outlines and holes, their face to the left seen from outside: ends, and faces, rising."""
        tail, tip, face = outlines.sides_of(self.polygon)
        return self.frame.up(tail, face), self.frame.up(tip, face), face


def unit(vectors: np.ndarray) -> np.ndarray:
    """The rows over their lengths."""
    return vectors / lengths(vectors)[:, None]


@dataclass(frozen=True)
class Planes:
    """The planes in which faces lie, each shared by all faces of a block within the tolerance of it."""

    frame: Frames  #: the planes
    block: np.ndarray  #: of each plane, rising, shape (planes,)
    of_face: np.ndarray  #: plane of each face, -1 of those without area, shape (faces,)
    outwards: np.ndarray  #: whether the plane's normal is the face's outward normal, shape (faces,)


def planes(surfaces: Surfaces, tolerance: float) -> Planes:
    """The planes of all faces. Raises CaseError if a face is not flat within the tolerance."""
    corners, count, face = surfaces.corners, surfaces.count, surfaces.face
    middle = sums(face, corners, len(count)) / np.maximum(count, 1)[:, None]
    after = corners[following(count)]
    area = sums(face, np.cross(corners - middle[face], after - middle[face]) / 2, len(count))
    size = lengths(area)
    side = lengths(after - corners)
    thick = 2 * size > tolerance * np.bincount(face, side, len(count))
    normal = np.divide(area, size[:, None], out=np.zeros_like(area), where=size[:, None] > 0)
    height = np.abs(dots(corners - middle[face], normal[face]))
    height[~thick[face]] = 0.0
    if len(height) and height.max() > tolerance:
        worst = int(height.argmax())
        off = f"a corner lies {height[worst]:.3g} off its plane (the tolerance is {tolerance:.3g})"
        remedy = "divide it into flat faces"
        if (height <= _INEXACT * np.sqrt(size[face])).all():
            error = _ERROR_OVER_HEIGHT * float(height[worst])
            remedy += f", or {set_tolerance(TOLERANCE_OVER_ERROR * error)} if coordinates are inexact"
        surfaces.refuse(int(face[worst]), f"is not flat: {off}: {remedy}")
    # In each round the largest face left of each block takes all faces in its plane.
    block = surfaces.block[surfaces.part]
    first = np.cumsum(count) - count
    leader = np.full(len(count), -1)
    left = np.flatnonzero(thick)
    # Sizes of faces alike differ by rounding, which must not choose among them.
    rank = np.round(np.log(size[left] / size.max(initial=0.0)), 6)
    left = left[np.lexsort((left, -rank, block[left]))]
    while len(left):
        lead = np.diff(block[left], prepend=-1) != 0
        ahead = left[lead][np.cumsum(lead) - 1]
        within = np.abs(dots(middle[left] - middle[ahead], normal[ahead])) <= tolerance
        # A thin end of a part has two faces within the tolerance of one plane, and is no plane.
        opposite = dots(normal[left], normal[ahead]) < 0
        within &= ~(opposite & (surfaces.part[left] == surfaces.part[ahead]))
        some, plane = left[within], ahead[within]
        at, of = ranges(first[some], count[some]), np.repeat(plane, count[some])
        off = np.abs(dots(corners[at] - middle[of], normal[of]))
        flat = np.maximum.reduceat(off, np.cumsum(count[some]) - count[some]) <= tolerance
        within[within] = flat | (some == plane)
        leader[left[within]] = ahead[within]
        left = left[~within]
    leads, of_thick = np.unique(leader[thick], return_inverse=True)
    of_face = np.full(len(count), -1)
    of_face[thick] = of_thick
    # Along the first of the longest sides: an axis that turns with the scene.
    longest = np.zeros(len(count))
    np.maximum.at(longest, face, side)
    long = np.flatnonzero(side >= longest[face] * (1 - 1e-6))
    longest_side = long[np.unique(face[long], return_index=True)[1]]
    along = np.zeros_like(area)
    along[face[longest_side]] = (after - corners)[longest_side]
    frame = Frames.of(middle[leads], normal[leads], along[leads])
    outwards = dots(normal, frame.normal[of_face]) > 0
    return Planes(frame, block[leads], of_face, outwards)


def outer_faces(surfaces: Surfaces, planes: Planes, tolerance: float) -> OuterFaces:
    """The outer faces of the blocks. Raises CaseError if a face crosses itself."""
    corner = planes.of_face[surfaces.face] >= 0
    face = surfaces.face[corner]
    number, of_ring = np.unique(face, return_inverse=True)
    flat = planes.frame.down(surfaces.corners[corner], planes.of_face[face])
    pieces = shapely.polygons(shapely.linearrings(flat, indices=of_ring))
    crossed = ~shapely.is_valid(pieces)
    if crossed.any():
        surfaces.refuse(int(number[crossed][0]), "crosses itself: give its corners in order round the face")
    side = 2 * planes.of_face[number] + ~planes.outwards[number]
    key, sample, count = np.unique(side, return_index=True, return_counts=True)
    merged = pieces[sample]
    of_key = np.split(pieces[np.argsort(side, kind="stable")], np.cumsum(count)[:-1])
    grid = outlines.GRID * tolerance
    for index in np.flatnonzero(count > 1):
        own = of_key[index]
        together = shapely.union_all(own)
        # Convex pieces of one side do not overlap.
        if abs(together.area - shapely.area(own).sum()) > tolerance * together.length:
            together = shapely.union_all(own, grid_size=grid)
        merged[index] = together
    merged[count > 1] = outlines.without_slivers(merged[count > 1], -tolerance)
    # Where two parts of a block meet, faces of both sides lie in one plane.
    for index in np.flatnonzero(key[:-1] // 2 == key[1:] // 2):
        both = merged[index : index + 2]
        outer = outlines.sound(shapely.difference, both, both[::-1], grid=grid)
        merged[index : index + 2] = outlines.without_slivers(outer, 2 * tolerance)
    polygons, of_side = shapely.get_parts(merged, return_index=True)
    simple = outlines.valid(outlines.without_straight_corners(polygons, STRAIGHT * tolerance))
    polygons, part = shapely.get_parts(simple, return_index=True)
    of_side = of_side[part]
    kept = outlines.wide(polygons, tolerance)
    polygons, of_side = polygons[kept], of_side[kept]
    plane, inwards = key[of_side] // 2, key[of_side] % 2 == 1
    # Seen from the other side of the plane.
    flipped = shapely.transform(polygons[inwards], lambda points: points * [1, -1])
    polygons[inwards] = shapely.orient_polygons(flipped)
    sign = np.where(inwards, -1.0, 1.0)[:, None]
    frame = planes.frame.where(plane)
    frame = Frames(frame.base, frame.u, sign * frame.v, sign * frame.normal)
    return OuterFaces(planes.block[plane], frame, polygons)

"""Where solids touch: polygons that faces of two share, edges and corners on faces, and crossing edges."""

from dataclasses import dataclass, replace

import numpy as np
import shapely

from masonry_opt.scene.contacts import sides
from masonry_opt.scene.contacts.sides import Items, Touches, near_items
from masonry_opt.scene.outlines import common_to, without_slivers, without_straight_corners
from masonry_opt.scene.rows import bounds, dots, first_alike, lengths, sums
from masonry_opt.scene.scene import Scene
from masonry_opt.scene.space.faces import Frames, OuterFaces, unit
from masonry_opt.scene.space.shapes import Shapes

NARROWEST = 10  #: Polygons narrower than so many tolerances are nothing.
#: Cosine of the angle beyond which faces share nothing: within a tolerance along ten they lean by a tenth.
_FACING = 0.99
_FLAT = 1e-3  #: Sine of the angle between faces below which they lie in one plane.
_ROUNDING = 1e-7  #: Sine of an angle that is rounding.


@dataclass(frozen=True)
class FacingFaces(sides.Facing):
    """Polygons onto which two faces project."""

    frame: Frames  #: bisecting planes; normals point out of the first block, first axes are its face's
    polygon: np.ndarray  #: connected, without straight corners, shape (polygons,)

    def outlines(self) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
        rings, polygon = shapely.get_rings(self.polygon, return_index=True)
        flat, ring = shapely.get_coordinates(rings, return_index=True)
        closing = np.diff(ring, append=ring[-1:] + 1) != 0
        side = (np.roll(flat, -1, axis=0) - flat)[~closing]
        flat, ring = flat[~closing], ring[~closing]
        count = np.bincount(ring, minlength=len(rings))
        outer = np.diff(polygon, prepend=-1) != 0
        length = np.hypot(*side.T) * outer[ring]
        _, longest = bounds(polygon[ring], length, len(self.pair))
        # Of sides of one length that most along the first axis, then the second: it turns with the scene.
        as_long = np.flatnonzero(length >= longest[polygon[ring]] * (1 - 1e-6))
        direction = side[as_long] / length[as_long, None]
        rank = np.round(direction @ [1.0, 1e-3], 6)
        best = np.lexsort((-rank, polygon[ring[as_long]]))
        best = best[np.unique(polygon[ring[as_long[best]]], return_index=True)[1]]
        frame, along, chosen = self.frame, direction[best], as_long[best]
        tangent = along[:, :1] * frame.u + along[:, 1:] * frame.v
        # Outer rings are turned so that they begin there.
        begin, first = np.zeros_like(count), (np.cumsum(count) - count)[ring]
        begin[ring[chosen]] = chosen - first[chosen]
        turned = first + (np.arange(len(ring)) - first + begin[ring]) % count[ring]
        return tangent, polygon, count, frame.up(flat[turned], polygon[ring])

    def distance(self, points: np.ndarray, number: np.ndarray) -> np.ndarray:
        flat = shapely.points(self.frame.down(points, number))
        return np.hypot(shapely.distance(flat, self.polygon[number]), self.frame.above(points, number))


def facing(scene: Scene, shapes: Shapes, pairs: np.ndarray, far: np.ndarray) -> FacingFaces:
    """The polygons that faces of pairs of blocks share, nowhere farther apart than ``far``, shape (pairs,):
    connected ones, without pieces, and ends of them, narrower than ten tolerances."""
    faces, frame = Items(shapes.faces.block, *shapes.faces.boxes), shapes.faces.frame
    pair, i, j = near_items(shapes, pairs, far, (faces, faces))
    cosine = -dots(frame.normal[i], frame.normal[j])
    # Where they come near each other is no farther from a point of the other face than that is wide.
    lean = np.sqrt(np.maximum(1 - cosine**2, 0)) + _ROUNDING
    reach = far[pair] / _FACING + lean * lengths(faces.high - faces.low)[j]
    near = (cosine > _FACING) & (np.abs(frame.above(frame.base[j], i)) <= reach)
    return _shared(shapes, pair[near], i[near], j[near], far[pair[near]])


def _shared(shapes: Shapes, pair: np.ndarray, i: np.ndarray, j: np.ndarray, far: np.ndarray) -> FacingFaces:
    """What face i of the first and j of the second block of pairs share, no farther apart than ``far``."""
    faces, narrowest = shapes.faces, NARROWEST * shapes.tolerance
    one, other = faces.frame.where(i), faces.frame.where(j)
    frame = Frames.of(one.base, one.normal - other.normal, one.u)
    # Halfway: over the bisecting plane the two faces' heights are opposite everywhere.
    half = _height(frame, other, np.zeros((len(i), 2)), np.arange(len(i))) / 2
    frame = replace(frame, base=frame.base + half[:, None] * frame.normal)
    of_one, of_other = (_projected(faces.polygon[at], frame, own) for at, own in ((i, one), (j, other)))
    pieces, number = common_to(of_one, of_other, shapes.tolerance)
    pieces, number = _without_tails(pieces, number, narrowest)
    pieces = without_straight_corners(pieces, shapes.tolerance / 2)
    points, piece = shapely.get_coordinates(pieces, return_index=True)
    height = _height(frame, other, points, number[piece]) - _height(frame, one, points, number[piece])
    least, most = bounds(piece, height, len(pieces))
    kept = (least >= -shapes.contact_tolerance) & (most <= far[number])
    pieces, number, most = pieces[kept], number[kept], most[kept]
    frame = frame.where(number)
    middle = frame.up(shapely.get_coordinates(shapely.centroid(pieces)), np.arange(len(pieces)))
    of_first, of_second = (_accuracy(faces, of, shapes.tolerance)[number] for of in (i, j))
    accuracy, shorter = (of_first + of_second) / 2, shapes.tolerance / np.maximum(of_first, of_second)
    angle, area = lengths(np.cross(one.normal, other.normal))[number], shapely.area(pieces)
    normal = -frame.normal
    return FacingFaces(pair[number], most, area, middle, normal, accuracy, angle, shorter, frame, pieces)


def _accuracy(faces: OuterFaces, face: np.ndarray, tolerance: float) -> np.ndarray:
    """Return the angle in radians within which a drawing fixes the plane of each face, shape (face,): the
    tolerance over the shorter side of the rectangle round the face."""
    own, number = np.unique(face, return_inverse=True)
    around = shapely.oriented_envelope(faces.polygon[own])
    corners = shapely.get_coordinates(around).reshape(len(own), 5, 2)
    sides = np.hypot(*np.moveaxis(np.diff(corners[:, :3], axis=1), 2, 0))
    return np.asarray((tolerance / sides.min(axis=1))[number])


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
    """Pieces with their numbers, without what is narrower than so."""
    opened = without_slivers(pieces, narrowest)
    # Tails may have no area, but they have length; offsets there and back change nothing else.
    cut = shapely.length(pieces) - shapely.length(opened) > narrowest
    cut |= shapely.is_empty(opened) | (shapely.get_num_geometries(opened) != 1)
    pieces[cut] = opened[cut]
    parts, whole = shapely.get_parts(pieces, return_index=True)
    solid = ~shapely.is_empty(parts)
    return parts[solid], number[whole[solid]]


class SolidCorners(sides.BlockCorners):
    """Edges and corners of blocks' outer faces; edges' directions, and sums of those into their faces."""

    apart = NARROWEST

    def __init__(self, shapes: Shapes, blocks: np.ndarray) -> None:
        self.shapes, self.outer = shapes, shapes.faces
        outer = self.outer
        tail, tip, face = outer.sides()
        block = outer.block[face]
        asked = np.isin(block, blocks)
        tail, tip, face, block = tail[asked], tip[asked], face[asked], block[asked]
        # An edge is in two faces, a corner in three or more.
        grid, other = (np.round(ends / shapes.tolerance) for ends in (tail, tip))
        ends = np.column_stack([block, np.minimum(grid, other), np.maximum(grid, other)])
        one, number = np.unique(first_alike(ends), return_inverse=True)
        self.start, self.end = tail[one], tip[one]
        self.direction = unit(self.end - self.start)
        self.inwards = sums(number, np.cross(outer.frame.normal[face], unit(tip - tail)), len(one))
        self.edges = self.met = Items(block[one], np.minimum(tail, tip)[one], np.maximum(tail, tip)[one])
        one = np.unique(first_alike(np.column_stack([block, grid])))
        self.point = tail[one]
        self.corners = Items(block[one], self.point, self.point)
        self.faces = Items(outer.block, *outer.boxes)

    def kinds(self, pairs: np.ndarray) -> list[Touches]:
        """Edges in faces, corners on faces, and edges that cross."""
        back = pairs[:, ::-1]
        edges = _edges_in_faces(self, pairs, 1).then(_edges_in_faces(self, back, -1))
        corners = _corners_on_faces(self, pairs, 1).then(_corners_on_faces(self, back, -1))
        return [edges, corners, _crossings(self, pairs)]


def _edges_in_faces(corners: SolidCorners, pairs: np.ndarray, sign: int) -> Touches:
    """Where edges of the first blocks lie in faces of the second and not along their outline."""
    tolerance, faces = corners.shapes.tolerance, corners.outer
    narrowest = NARROWEST * tolerance
    pair, i, j = near_items(corners.shapes, pairs, tolerance, (corners.edges, corners.faces))
    height = [faces.frame.above(ends[i], j) for ends in (corners.start, corners.end)]
    flat = [faces.frame.down(ends[i], j) for ends in (corners.start, corners.end)]
    kept = (np.minimum(*height) <= tolerance) & (np.maximum(*height) >= -tolerance)
    kept &= np.hypot(*(flat[1] - flat[0]).T) > narrowest
    pair, j, start, end, low, high = (column[kept] for column in (pair, j, *flat, *height))
    lines = shapely.linestrings(np.stack([start, end], axis=1))
    # Most run along outlines: an overlay of each would take long.
    face, own = np.unique(j, return_inverse=True)
    within = shapely.buffer(faces.polygon[face], -narrowest / 2, join_style="bevel")
    shapely.prepare(within)
    through = np.flatnonzero(shapely.intersects(within[own], lines))
    common = shapely.intersection(lines[through], faces.polygon[j[through]])
    pieces, number = shapely.get_parts(common, return_index=True)
    kept = shapely.length(pieces) > narrowest
    pieces, number = pieces[kept], through[number[kept]]
    face = j[number]
    inner = shapely.line_interpolate_point(pieces[:, None], [0.25, 0.5, 0.75], normalized=True)
    border = shapely.boundary(faces.polygon[face])[:, None]
    deep = (shapely.distance(border, inner) > narrowest).any(axis=1)
    points = []
    for end_no in (0, -1):
        at = shapely.get_coordinates(shapely.get_point(pieces, end_no))
        way = (end - start)[number]
        t = ((at - start[number]) * way).sum(axis=1) / (way**2).sum(axis=1)
        over = low[number] + t * (high - low)[number]
        deep &= np.abs(over) <= tolerance
        points.append(faces.frame.up(at, face) + over[:, None] / 2 * faces.frame.normal[face])
    one, other = points[0][deep], points[1][deep]
    # Normals of faces point out of their block.
    normal = sign * faces.frame.normal[face[deep]]
    # Square to the normal, also where the edge leans within the tolerance.
    along = other - one
    along -= dots(along, normal)[:, None] * normal
    accuracy = _accuracy(faces, face[deep], tolerance)
    return Touches(pair[number[deep]], one, other, normal, unit(along), accuracy)


def _corners_on_faces(corners: SolidCorners, pairs: np.ndarray, sign: int) -> Touches:
    """Where corners of the first blocks stand on faces of the second and not on their outline."""
    tolerance, faces = corners.shapes.tolerance, corners.outer
    pair, i, j = near_items(corners.shapes, pairs, tolerance, (corners.corners, corners.faces))
    flat, height = faces.frame.down(corners.point[i], j), faces.frame.above(corners.point[i], j)
    at = shapely.points(flat)
    kept = (np.abs(height) <= tolerance) & shapely.contains(faces.polygon[j], at)
    kept &= shapely.distance(shapely.boundary(faces.polygon[j]), at) > tolerance
    pair, j, flat, height = pair[kept], j[kept], flat[kept], height[kept]
    point = faces.frame.up(flat, j) + height[:, None] / 2 * faces.frame.normal[j]
    accuracy = _accuracy(faces, j, tolerance)
    return Touches(pair, point, point, sign * faces.frame.normal[j], faces.frame.u[j], accuracy)


def _crossings(corners: SolidCorners, pairs: np.ndarray) -> Touches:
    """Where edges cross between their ends."""
    tolerance = corners.shapes.tolerance
    pair, i, j = near_items(corners.shapes, pairs, tolerance, (corners.edges, corners.edges))
    length = lengths(corners.end - corners.start)
    across = np.cross(corners.direction[i], corners.direction[j])
    sine = lengths(across)
    # Else they run along each other: moved by the tolerance, they would turn their normal.
    kept = sine * np.minimum(length[i], length[j]) > NARROWEST * tolerance
    pair, i, j, across, sine = (column[kept] for column in (pair, i, j, across, sine))
    one, other = corners.direction[i], corners.direction[j]
    normal = across / sine[:, None]
    between = corners.start[j] - corners.start[i]
    at = [dots(np.cross(between, edge), normal) / sine for edge in (other, one)]
    gap = dots(between, normal)
    kept = np.abs(gap) <= tolerance
    for own, edge in zip(at, (i, j), strict=True):
        kept &= (own > tolerance) & (own < length[edge] - tolerance)
    # Both blocks' faces there lie on their own sides of the plane of the edges.
    towards = dots(normal, corners.inwards[i] - corners.inwards[j])
    kept &= np.abs(towards) > _FLAT
    point = corners.start[i] + at[0][:, None] * one + gap[:, None] / 2 * normal
    sign = np.sign(towards)[:, None]
    # The normal follows the edges' directions, the more the smaller the angle between them is.
    accuracy = tolerance * (1 / length[i] + 1 / length[j]) / sine
    return Touches(pair[kept], point[kept], point[kept], (sign * normal)[kept], one[kept], accuracy[kept])

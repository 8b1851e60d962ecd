"""Draw scenes in space: the surfaces of blocks, a depth buffer that finds visible parts, and the picture."""

import math
from dataclasses import dataclass, replace
from itertools import product
from typing import Any

import numpy as np
import shapely
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.colors import to_rgb
from scipy.ndimage import distance_transform_edt, minimum_filter

from masonry_opt.drawing.colours import AT_REST, BLOCK, HATCH, SUPPORT_COLOUR
from masonry_opt.drawing.elements import Elements
from masonry_opt.drawing.figure import draw_marks, letters_in, points_in_unit, write_name
from masonry_opt.drawing.forces import round_below
from masonry_opt.drawing.marks import Marks, hatching, movable_box, moved, size_of
from masonry_opt.errors import OptionError
from masonry_opt.problem.assembly import Assembly
from masonry_opt.scene.rows import ranges
from masonry_opt.scene.scene import Scene
from masonry_opt.scene.solids import coordinates
from masonry_opt.scene.space.faces import Frames, OuterFaces
from masonry_opt.scene.space.shapes import Shapes

ViewAngles = tuple[float, float]  #: Azimuth and elevation of the viewer, in degrees.

#: Distance from the movable blocks at which drawn supports are cut off, relative to the size of the scene.
_SUPPORT_CUT_DISTANCE = 0.2
_HATCH = 0.03  #: Distance between hatching lines on supports, relative to the size of the scene.
#: Distance up to which points of a drawing in space count as equal, relative to the size of the scene.
_COINCIDENT_POINT_TOLERANCE = 1e-9

_ELEVATION = 22.0  #: Elevation of the default view, in degrees.
#: Azimuths from which the default view is chosen, in degrees. If several are equally good, the first is used.
_AZIMUTHS = (-60.0, -120.0, -30.0, -150.0, 30.0, 60.0, 120.0, 150.0)

#: The default view has the largest sum of two terms: the projected width of the scene, and the cosine of the
#: angle between the live load and the direction to the viewer. This value is the weight of the cosine. With a
#: larger value, the live load more often pushes towards the viewer.
_LIVE_DIRECTION_WEIGHT = 0.25
#: The default view avoids azimuths at which the arrow of the live load would look too short. These are the
#: azimuths at which the cosine between the live load and the horizontal line of sight exceeds this value in
#: magnitude. With a larger value, shorter arrows are accepted.
_MOST_TOWARDS = 0.95
#: Smallest length in pixels of the drawn pieces of a partly hidden line. Shorter pieces are artefacts of the
#: depth buffer.
_SHORTEST_PIECE = 3.0
#: A face hides a point if the point is behind the face by more than this distance, relative to the longer
#: side of the picture.
_DEPTH = 2e-3

#: Number of pixels along the longer side of the depth buffer. A larger value draws sharper edges of faces.
_DEPTH_BUFFER_PIXELS = 1400
_LIGHT = np.array([-0.35, 0.55, 0.75])  #: Direction towards the light, in the picture's axes.
_SHADE = 0.68  #: Brightness of faces that are turned away from the light, relative to faces in full light.
#: Fraction of white that is added to the colours of faces in pictures of blocks at rest.
_WHITE_SHARE = 0.55
#: Free space around the drawn elements, relative to the longer side of their bounding box.
_MARGIN_IN_SPACE = 0.03
#: Largest length of the drawn coordinate axes, relative to the longer side of the drawn elements.
_LARGEST_AXIS_LENGTH = 0.1
#: Distance of the letters x, y and z from the origin, relative to the length of the coordinate axes.
_AXIS_LETTER_DISTANCE = 1.4
#: The name of a block is centred at a pixel far from the boundary of a visible face. The distance of the
#: pixel from the boundary is at least this fraction of the largest distance in the face.
_LEAST_NAME_DISTANCE = 0.8
#: Smallest font size of block names, in points. Names that would have to be smaller are omitted.
_SMALLEST_NAME_SIZE_IN_SPACE = 2.0


@dataclass(frozen=True)
class Surface:
    """Faces, edges and hatching of all blocks in space, relative to the geometry's origin."""

    #: Corners of triangles on the faces, counter-clockwise from outside, shape (triangles, 3, 3).
    triangles: np.ndarray
    of_triangle: np.ndarray  #: index of the block to which each triangle belongs, shape (triangles,)
    edges: np.ndarray  #: both ends of each edge, shape (edges, 2, 3)
    of_edge: np.ndarray  #: index of the block to which each edge belongs, shape (edges,)
    hatching: np.ndarray  #: ends of the hatching lines on supports, shape (lines, 2, 3)

    def moved(self, motion: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return the triangles and the edges after the blocks have moved by ``motion``, shape (blocks, 6)."""
        triangles = moved(self.triangles, motion[self.of_triangle][:, None])
        return triangles, moved(self.edges, motion[self.of_edge][:, None])


def surface(elements: Elements) -> Surface:
    """Return the surface of the scene's blocks. Large supports are cut off near the movable blocks."""
    assembly, shapes, size = elements.assembly, elements.assembly.geometry, size_of(elements.assembly)
    assert isinstance(shapes, Shapes)
    low, high = movable_box(assembly)
    low, high = low - _SUPPORT_CUT_DISTANCE * size, high + _SUPPORT_CUT_DISTANCE * size
    least, most = shapes.boxes
    cut = np.setdiff1d(np.flatnonzero(((least < low) | (most > high)).any(axis=1)), assembly.movable)
    faces = _cut(shapes, cut, low, high)
    start, end, face = faces.sides()
    edges, rounding = np.stack([start, end], axis=1), _COINCIDENT_POINT_TOLERANCE * size
    # Remove duplicate edges, and the edges along which supports were cut off.
    ends = np.sort(np.round(edges / rounding), axis=1).reshape(-1, 6)
    _, unique = np.unique(np.column_stack([faces.block[face], ends]), axis=0, return_index=True)
    on_side = [np.abs(edges - side).max(axis=1).min(axis=1) < rounding for side in (low, high)]
    unique = unique[~(np.isin(faces.block[face], cut) & np.logical_or(*on_side))[unique]]
    triangles, of_face = _triangles(faces)
    support = faces.where(~np.isin(faces.block, assembly.movable))
    return Surface(
        triangles=triangles,
        of_triangle=faces.block[of_face],
        edges=edges[unique],
        of_edge=faces.block[face][unique],
        hatching=_hatching(support, _HATCH * size),
    )


def _triangles(faces: OuterFaces) -> tuple[np.ndarray, np.ndarray]:
    """Divide faces into triangles, and return the corners of the triangles, shape (triangles, 3, 3).

    Return also the index of the face of each triangle.
    """
    collections = shapely.constrained_delaunay_triangles(faces.polygon)
    flat, face = shapely.get_parts(collections, return_index=True)
    points, number = shapely.get_coordinates(shapely.orient_polygons(flat), return_index=True)
    return faces.frame.up(points, face[number]).reshape(-1, 4, 3)[:, :3], face


def _hatching(faces: OuterFaces, step: float) -> np.ndarray:
    """Return hatching lines at 45° to the first axis of each face, shape (lines, 2, 3)."""
    lines = [np.empty((0, 2, 3))]
    for number, polygon in enumerate(faces.polygon):
        flat = shapely.get_coordinates(hatching(polygon, shapely.bounds(polygon), step))
        lines.append(faces.frame.up(flat, np.full(len(flat), number)).reshape(-1, 2, 3))
    return np.concatenate(lines)


def _cut(shapes: Shapes, cut: np.ndarray, low: np.ndarray, high: np.ndarray) -> OuterFaces:
    """Clip the blocks listed in ``cut`` to a box from ``low`` to ``high``; return the faces of all blocks.

    The result includes the new faces on the sides of the box.
    """
    faces, parts = shapes.faces, shapes.parts
    if not len(cut):
        return faces
    normal, offset = np.concatenate([np.eye(3), -np.eye(3)]), np.concatenate([high, -low])
    sides = Frames.of(normal * offset[:, None], normal, np.roll(normal, 1, axis=1))
    box = np.array([*product(*zip(low, high, strict=True))])
    is_cut = np.isin(faces.block, cut)
    cut_faces = faces.where(is_cut)
    inside = [_section(box, cut_faces.frame, at) for at in range(len(cut_faces.block))]
    cut_faces = replace(cut_faces, polygon=shapely.intersection(cut_faces.polygon, inside))
    part, side = np.divmod(np.arange(6 * len(parts.block)), 6)
    part, side = (values[np.isin(parts.block[part], cut)] for values in (part, side))
    hulls = [parts.points[parts.of_point == index] for index in part]
    part_sections = [_section(hull, sides, at) for hull, at in zip(hulls, side, strict=True)]
    sections = shapely.intersection(part_sections, [_section(box, sides, at) for at in side])
    new_faces = OuterFaces(parts.block[part], sides.where(side), sections)
    all_faces = faces.where(~is_cut).then(cut_faces, new_faces)
    return all_faces.where(shapely.area(all_faces.polygon) > 0)


def _section(corners: np.ndarray, frames: Frames, at: int) -> shapely.Geometry:
    """Return the intersection of a plane with the convex hull of points, in coordinates of the plane.

    The points are ``corners``, shape (points, 3). ``at`` is the index of the plane in ``frames``.
    """
    height = frames.above(corners, np.full(len(corners), at))[:, None]
    over = (height >= 0).ravel()
    share = height[over] / (height[over] - height[~over].T)
    points = corners[over][:, None] + share[..., None] * (corners[~over] - corners[over][:, None])
    points = points.reshape(-1, 3)
    return shapely.MultiPoint(frames.down(points, np.full(len(points), at))).convex_hull


def refuse_view(scene: Scene, view: object) -> None:
    """Raise OptionError if a view is invalid, or if a view is passed for a scene in the plane."""
    if view is None:
        return
    if scene.dimension == 2:
        raise OptionError(
            f"{scene.origin}: 'view' applies to scenes in space only: omit 'view' for this scene in the plane"
        )
    values = view if isinstance(view, list | tuple) else ()
    are_numbers = all(isinstance(angle, int | float) and not isinstance(angle, bool) for angle in values)
    angles = coordinates(values, 2)
    if not are_numbers or angles is None or abs(angles[1]) > 90:
        raise OptionError(
            "'view' must be azimuth and elevation in degrees, such as (-60, 22), with an elevation from -90 "
            f"to 90 (found {view!r})"
        )


def axes_of(view: ViewAngles) -> np.ndarray:
    """Return the axes of a picture (right, up, towards the viewer) as unit vectors in rows, shape (3, 3)."""
    azimuth, elevation = np.radians(view)
    (east, north), (out, up) = ((np.cos(angle), np.sin(angle)) for angle in (azimuth, elevation))
    right, towards = np.array([-north, east, 0.0]), np.array([out * east, out * north, up])
    return np.stack([right, np.cross(towards, right), towards])


def best_view(assembly: Assembly) -> ViewAngles:
    """Choose a view that shows the wider side of the scene, with the live load pushing towards the viewer.

    The view depends only on the scene, so that drawings of a scene and of its results have the same view.
    """
    low, high = movable_box(assembly)
    wide = (high - low)[:2] / (high - low)[:2].max()
    total = assembly.problem.forces(assembly.problem.live).sum(axis=0)
    direction = total / (np.linalg.norm(total) or 1.0)

    def quality(azimuth: float) -> float:
        """Return the quality of a horizontal view, from projected width and direction of the live load.

        The width is that of the movable blocks' bounding box, relative to its longer horizontal side. The
        direction of the live load counts as the cosine of its angle to the direction to the viewer. If the
        live load is almost parallel to the line of sight, the cosine is replaced by −1.
        """
        right, _, towards = axes_of((azimuth, 0.0))
        push = float(direction @ towards)
        return float(np.abs(right[:2]) @ wide) + _LIVE_DIRECTION_WEIGHT * (
            push if abs(push) <= _MOST_TOWARDS else -1.0
        )

    return max(_AZIMUTHS, key=lambda azimuth: round(quality(azimuth), 9)), _ELEVATION


@dataclass(frozen=True)
class Raster:
    """Depth buffer: the depth and the index of the nearest triangle at each pixel of a picture."""

    corner: np.ndarray  #: lower left corner of the picture, in the picture's axes, shape (2,)
    pixel: float  #: side length of a pixel, in the case's unit of length
    #: Depth buffer, shape (rows, columns), with the lowest row first. Larger values are nearer to the viewer.
    #: Pixels without a triangle have ``-inf``.
    depth: np.ndarray
    #: For each pixel, index of the nearest triangle, shape (rows, columns). Pixels without a triangle have
    #: -1.
    triangle: np.ndarray

    def visible(self, lines: np.ndarray) -> np.ndarray:
        """Return the visible pieces of lines, shape (pieces, 2, 3).

        Lines have shape (lines, 2, 3). Lines and pieces are in the coordinates of the picture, see
        :func:`axes_of`.
        """
        run = lines[:, 1] - lines[:, 0]
        count = np.ceil(np.hypot(run[:, 0], run[:, 1]) / self.pixel).astype(int) + 2
        line = np.repeat(np.arange(len(lines)), count)
        share = ranges(np.zeros_like(count), count) / (count - 1)[line]
        at = lines[line, 0] + share[:, None] * run[line]
        seen = self.sees(at)
        last = np.append(line[1:] != line[:-1], True)
        first = np.append(True, last[:-1])
        starts = np.flatnonzero(seen & (first | ~np.append(False, seen[:-1])))
        ends = np.flatnonzero(seen & (last | ~np.append(seen[1:], False)))
        pieces = np.stack([at[starts], at[ends]], axis=1)
        length = np.hypot(*np.diff(pieces, axis=1)[:, 0, :2].T) / self.pixel
        return pieces[(first[starts] & last[ends]) | (length >= _SHORTEST_PIECE)]

    def sees(self, points: np.ndarray) -> np.ndarray:
        """Return a mask of the points that the viewer sees, shape (points,).

        Points have shape (points, 3), in picture coordinates.
        """
        rows, columns = self.depth.shape
        # Use the farthest depth at neighbouring pixels. A point on an edge is then visible if one of the two
        # faces at the edge is visible.
        farthest = minimum_filter(self.depth, size=3, mode="nearest")
        at = ((points[:, :2] - self.corner) / self.pixel).astype(int)
        column, row = at.clip(0, [columns - 1, rows - 1]).T
        bias = _DEPTH * self.pixel * max(rows, columns)
        return points[:, 2] + bias >= farthest[row, column]


def _middle_pixel(pixels: np.ndarray) -> np.ndarray:
    """Return a pixel near the middle of an area and far from its boundary.

    ``pixels`` are the columns and rows of all pixels of the area, shape (pixels, 2). The result is the pixel
    nearest to their mean among all pixels that are far from the boundary, see ``_LEAST_NAME_DISTANCE``.
    """
    at = pixels - pixels.min(axis=0) + 1
    area = np.zeros(at.max(axis=0) + 2, dtype=bool)
    area[tuple(at.T)] = True
    distance = distance_transform_edt(area)[tuple(at.T)]
    inner = pixels[distance >= _LEAST_NAME_DISTANCE * distance.max()]
    return inner[np.argmin(((inner - pixels.mean(axis=0)) ** 2).sum(axis=1))]


def raster(triangles: np.ndarray, box: np.ndarray, pixels: int) -> Raster:
    """Compute the depth buffer of the triangles that face the viewer.

    Triangles have shape (triangles, 3, 3), in the coordinates of the picture. ``box`` contains the lower left
    and the upper right corner of the picture, shape (2, 2). ``pixels`` is the number of pixels along its
    longer side.
    """
    width, height = box[1] - box[0]
    pixel = max(width, height) / pixels
    depth = np.full((math.ceil(height / pixel), math.ceil(width / pixel)), -np.inf)
    number = np.full(depth.shape, -1)
    flat = (triangles[..., :2] - box[0]) / pixel - 0.5
    (ax, ay), (bx, by) = (np.moveaxis(flat[:, corner] - flat[:, 0], -1, 0) for corner in (1, 2))
    twice = ax * by - ay * bx
    low = np.floor(flat.min(axis=1)).astype(int).clip(0)
    high = (np.ceil(flat.max(axis=1)).astype(int) + 1).clip(None, depth.shape[::-1])
    for triangle in np.flatnonzero((twice > 1e-9) & (low < high).all(axis=1)):
        (x0, y0), (x1, y1) = low[triangle], high[triangle]
        x, y = np.arange(x0, x1) - flat[triangle, 0, 0], (np.arange(y0, y1) - flat[triangle, 0, 1])[:, None]
        second_share = (x * by[triangle] - y * bx[triangle]) / twice[triangle]
        third_share = (y * ax[triangle] - x * ay[triangle]) / twice[triangle]
        first, second, third = triangles[triangle, :, 2]
        height = first + second_share * (second - first) + third_share * (third - first)
        window, slack = np.s_[y0:y1, x0:x1], -1e-6
        nearer = (
            (second_share >= slack)
            & (third_share >= slack)
            & (second_share + third_share <= 1 - slack)
            & (height > depth[window])
        )
        depth[window][nearer] = height[nearer]
        number[window][nearer] = triangle
    return Raster(box[0].copy(), float(pixel), depth, number)


class Solids:
    """Drawing of a scene in space, with marks such as arrows of loads and lines of joints.

    Blocks and marks are displaced by the fraction ``share`` of the magnified motion of the mechanism.
    """

    def __init__(
        self, axes: Axes, elements: Elements, marks: list[Marks], share: float, view: ViewAngles
    ) -> None:
        """Compute the depth buffer, and set the limits of matplotlib's axes."""
        self.axes, self.elements, self.marks, self.share, self.view = axes, elements, marks, share, view
        self.turned = axes_of(view)
        self.surface = surface(elements)
        moved = self.surface.moved(share * elements.motion)
        self.triangles, self.edges = (points @ self.turned.T for points in moved)
        shown = [self.triangles, *(mark_group.moved(share) @ self.turned.T for mark_group in marks)]
        flat = np.concatenate([points.reshape(-1, 3)[:, :2] for points in shown])
        low, high = flat.min(axis=0), flat.max(axis=0)
        side = float((high - low).max())
        self.box = np.array([low - _MARGIN_IN_SPACE * side, high + _MARGIN_IN_SPACE * side])
        self.raster = raster(self.triangles, self.box, _DEPTH_BUFFER_PIXELS)
        self.unit = round_below(_LARGEST_AXIS_LENGTH * side)
        # The coordinate axes are drawn in the lower left corner. If blocks cover the corner, the picture is
        # extended downwards.
        around = 2 * _AXIS_LETTER_DISTANCE * self.unit
        corner = np.s_[: int(around / self.raster.pixel), : int(around / self.raster.pixel)]
        if (self.raster.triangle[corner] >= 0).any():
            self.box[0, 1] -= around
        self.foot = self.box[0] + around / 2
        axes.set(xlim=self.box[:, 0], ylim=self.box[:, 1], aspect="equal")
        axes.set_axis_off()

    @property
    def note(self) -> str:
        """Return a note that states the length of the drawn coordinate axes and the angles of the view."""
        azimuth, elevation = self.view
        direction = f"seen from azimuth {azimuth:g}°, elevation {elevation:g}°"
        return f"length of the axes: {self.unit:g}, in the case's unit of length; {direction}"

    def draw(self, names: bool) -> None:
        """Draw faces, edges, marks, coordinate axes and, if ``names`` is True, the names of visible blocks.

        Lines and marks behind faces are not drawn, except for arrows and for marks inside blocks. The size of
        matplotlib's axes must be set before.
        """
        raster_of_faces = self.raster
        corner, pixel = raster_of_faces.corner, raster_of_faces.pixel
        (left, bottom), (high, wide) = corner, pixel * np.array(raster_of_faces.depth.shape)
        reach = (left, left + wide, bottom, bottom + high)
        look: dict[str, Any] = {"origin": "lower", "zorder": 1, "interpolation": "antialiased"}
        self.axes.imshow(self._faces(), extent=reach, **look)
        movable = np.isin(self.surface.of_edge, self.elements.assembly.movable)
        if self.share and self.elements.movement:
            at_rest = self.surface.triangles, self.surface.edges[movable]
            triangles, edges = (points @ self.turned.T for points in at_rest)
            self._lines(raster(triangles, self.box, _DEPTH_BUFFER_PIXELS).visible(edges), AT_REST, 0.5, 1.5)
        self._lines(self.surface.hatching @ self.turned.T, HATCH, 0.4, 2.0)
        width = self.elements.outline_width
        self._lines(self.edges[movable], "black", width, 2.2)
        self._lines(self.edges[~movable], HATCH, width, 2.1)
        for marks in self.marks:
            at = marks.moved(self.share) @ self.turned.T
            if not marks.through:
                is_line = marks.shape == "line"
                at = raster_of_faces.visible(at) if is_line else at[raster_of_faces.sees(at[:, 0])]
            if len(at):
                draw_marks(self.axes, marks, at[..., :2])
        arrow = {"arrowstyle": "->", "shrinkA": 0, "shrinkB": 0}
        for direction, letter in zip(self.unit * self.turned.T[:, :2], "xyz", strict=True):
            self.axes.annotate("", self.foot + direction, self.foot, arrowprops=arrow)
            x, y = self.foot + _AXIS_LETTER_DISTANCE * direction
            self.axes.text(x, y, letter, ha="center", va="center", fontsize=9)
        if names:
            self._write_names()

    def _faces(self) -> np.ndarray:
        """Return an image of the visible faces, shape (rows, columns, 4): red, green, blue, opacity."""
        light = np.clip(self._normals() @ (_LIGHT / np.linalg.norm(_LIGHT)), 0.0, 1.0)
        is_movable = ~np.isin(self.surface.of_triangle, self.elements.supports)
        colours = np.where(is_movable[:, None], to_rgb(BLOCK), to_rgb(SUPPORT_COLOUR))
        colours = colours * (_SHADE + (1 - _SHADE) * light)[:, None]
        if not self.share:
            colours = 1 - (1 - colours) * (1 - _WHITE_SHARE)
        # Pixels without a triangle have index -1. This index selects the last row of the table, which is
        # transparent.
        table = np.vstack([np.column_stack([colours, np.ones(len(colours))]), np.zeros(4)])
        return table[self.raster.triangle]

    def _normals(self) -> np.ndarray:
        """Return the outward unit normals of the triangles in picture coordinates, shape (triangles, 3)."""
        sides = np.diff(self.triangles, axis=1)
        normal = np.cross(sides[:, 0], sides[:, 1])
        return normal / np.maximum(np.linalg.norm(normal, axis=1), 1e-300)[:, None]

    def _lines(self, lines: np.ndarray, colour: str, width: float, order: float) -> None:
        """Draw the visible pieces of lines, which have shape (lines, 2, 3) in picture coordinates."""
        pieces = list(self.raster.visible(lines)[..., :2])
        self.axes.add_collection(LineCollection(pieces, color=colour, linewidth=width, zorder=order))

    def _write_names(self) -> None:
        """Write the name of each visible block on its largest visible face, as large as this face permits."""
        raster_of_faces, points_per_unit = self.raster, points_in_unit(self.axes)
        row, column = np.nonzero(raster_of_faces.triangle >= 0)
        triangle = raster_of_faces.triangle[row, column]
        block_of = self.surface.of_triangle[triangle]
        _, face_of_triangle = np.unique(np.round(self._normals(), 3), axis=0, return_inverse=True)
        face_of = face_of_triangle.ravel()[triangle]
        for number in np.unique(block_of):
            on_face = (block_of == number) & (face_of == np.bincount(face_of[block_of == number]).argmax())
            pixels = np.column_stack([column, row])[on_face]
            middle = _middle_pixel(pixels)
            wide, high = np.ptp(pixels, axis=0) * raster_of_faces.pixel * points_per_unit
            name = self.elements.assembly.scene.blocks[number].name
            letters = min(letters_in(name, 0.8 * wide), 0.4 * high)
            if letters >= _SMALLEST_NAME_SIZE_IN_SPACE:
                at = raster_of_faces.corner + (middle + 0.5) * raster_of_faces.pixel
                write_name(self.axes, name, at, letters, 0.2, va="center")

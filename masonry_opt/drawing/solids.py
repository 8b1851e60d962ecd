"""Surfaces of the blocks of a scene in space: triangles, edges, and the hatching of supports; the figure of a
page that shows them: its data, and three.js, which draws it."""

from dataclasses import dataclass, replace
from functools import cache
from itertools import product
from typing import Any

import numpy as np
import shapely

from masonry_opt.drawing.colours import BLOCK, FIXED
from masonry_opt.drawing.elements import INSIDE, Elements
from masonry_opt.drawing.marks import Marks, hatching, movable_box, moved, size_of
from masonry_opt.drawing.view import ViewAngles
from masonry_opt.errors import OptionError
from masonry_opt.problem.assembly import Assembly
from masonry_opt.scene.space.faces import Frames, OuterFaces
from masonry_opt.scene.space.shapes import Shapes
from masonry_opt.scene.tables import library

_BEYOND = 0.2  #: How far supports are shown beyond the movable blocks, over the size of the scene.
_HATCH = 0.03  #: Distance of the lines that hatch them, over that.
_ROUNDING = 1e-9  #: Share of the scene's size that is rounding.
_UNITS = 20_000  #: Of the figure along the scene's size: whole coordinates keep large scenes short.

#: Half the width of a mark of a point's width, over the size of the scene: of loads and resultants, which are
#: seen through blocks, and of marks on joints, these at most over the size of a usual joint.
_RADIUS_THROUGH, _RADIUS, _OF_JOINT = 1 / 900, 1 / 500, 1 / 80

#: What three.js ends with in the page that trimesh puts it in.
_END = 'Object.defineProperty(t,"__esModule",{value:!0})}));'


@dataclass(frozen=True)
class Surface:
    """Faces of all blocks. Points are relative to the geometry's origin."""

    triangles: np.ndarray  #: counter-clockwise seen from outside, shape (triangles, 3, 3)
    of_triangle: np.ndarray  #: their blocks
    edges: np.ndarray  #: shape (edges, 2, 3)
    of_edge: np.ndarray  #: their blocks
    hatching: np.ndarray  #: lines on supports, shape (lines, 2, 3)

    def moved(self, motion: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Triangles and edges after motions of the blocks, shape (blocks, 6)."""
        triangles = moved(self.triangles, motion[self.of_triangle][:, None])
        return triangles, moved(self.edges, motion[self.of_edge][:, None])


def surface(elements: Elements) -> Surface:
    """The faces of the scene's blocks, of supports cut off where they reach far beyond movable ones."""
    assembly: Assembly = elements.assembly
    shapes, size = assembly.geometry, size_of(assembly)
    assert isinstance(shapes, Shapes)
    low, high = movable_box(assembly)
    low, high = low - _BEYOND * size, high + _BEYOND * size
    points, block = shapes.corners
    beyond = np.unique(block[((points < low) | (points > high)).any(axis=1)])
    cut = np.setdiff1d(beyond, assembly.movable)
    faces = _cut(shapes, cut, low, high)
    start, end, face = faces.sides()
    # Each edge once, without those that a cut made.
    ends = np.sort(np.round(np.stack([start, end], axis=1) / (_ROUNDING * size)), axis=1)
    _, once = np.unique(np.column_stack([faces.block[face], ends.reshape(-1, 6)]), axis=0, return_index=True)
    near = _ROUNDING * size
    on_cut = [(np.abs(start - side) < near) & (np.abs(end - side) < near) for side in (low, high)]
    of_cut = np.isin(faces.block[face], cut) & (on_cut[0] | on_cut[1]).any(axis=1)
    once = once[~of_cut[once]]
    triangles, of_face = _triangles(faces)
    support = faces.where(~np.isin(faces.block, assembly.movable))
    return Surface(
        triangles=triangles,
        of_triangle=faces.block[of_face],
        edges=np.stack([start, end], axis=1)[once],
        of_edge=faces.block[face][once],
        hatching=_hatching(support, _HATCH * size),
    )


def _triangles(faces: OuterFaces) -> tuple[np.ndarray, np.ndarray]:
    """Triangles of the faces, shape (triangles, 3, 3), and the face of each."""
    found = shapely.constrained_delaunay_triangles(faces.polygon)
    flat, face = shapely.get_parts(found, return_index=True)
    points, number = shapely.get_coordinates(shapely.orient_polygons(flat), return_index=True)
    return faces.frame.up(points, face[number]).reshape(-1, 4, 3)[:, :3], face


def _hatching(faces: OuterFaces, step: float) -> np.ndarray:
    """Lines at 45° to the first axis of each face."""
    lines = [np.empty((0, 2, 3))]
    for number, polygon in enumerate(faces.polygon):
        flat = shapely.get_coordinates(hatching(polygon, shapely.bounds(polygon), step))
        lines.append(faces.frame.up(flat, np.full(len(flat), number)).reshape(-1, 2, 3))
    return np.concatenate(lines)


def _cut(shapes: Shapes, cut: np.ndarray, low: np.ndarray, high: np.ndarray) -> OuterFaces:
    """All faces, those of blocks to cut by a box, and what the box's sides cut."""
    faces, parts = shapes.faces, shapes.parts
    if not len(cut):
        return faces
    normal, offset = np.concatenate([np.eye(3), -np.eye(3)]), np.concatenate([high, -low])
    sides = Frames.of(normal * offset[:, None], normal, np.roll(normal, 1, axis=1))
    box = np.array([*product(*zip(low, high, strict=True))])
    chosen = np.isin(faces.block, cut)
    own = faces.where(chosen)
    inside = [_section(box, own.frame, at) for at in range(len(own.block))]
    own = replace(own, polygon=shapely.intersection(own.polygon, inside))
    part, side = np.divmod(np.arange(6 * len(parts.block)), 6)
    part, side = (of[np.isin(parts.block[part], cut)] for of in (part, side))
    hulls = [parts.points[parts.of_point == one] for one in part]
    of_parts = [_section(hull, sides, at) for hull, at in zip(hulls, side, strict=True)]
    sections = shapely.intersection(of_parts, [_section(box, sides, at) for at in side])
    cuts = OuterFaces(parts.block[part], sides.where(side), sections)
    every = faces.where(~chosen).then(own, cuts)
    return every.where(shapely.area(every.polygon) > 0)


def _section(corners: np.ndarray, frames: Frames, at: int) -> shapely.Geometry:
    """What a plane cuts of the convex hull of corners, in the plane's frame."""
    height = frames.above(corners, np.full(len(corners), at))[:, None]
    over = (height >= 0).ravel()
    share = height[over] / (height[over] - height[~over].T)
    points = corners[over][:, None] + share[..., None] * (corners[~over] - corners[over][:, None])
    points = points.reshape(-1, 3)
    return shapely.MultiPoint(frames.down(points, np.full(len(points), at))).convex_hull


@cache
def three() -> str:
    """The script three.js, with its licence, as trimesh brings it. Raises OptionError if trimesh, of the
    extra "meshes", is not installed, or brings another one."""
    why = "pages of solids need trimesh, which brings three.js; install it with: pip install '.[meshes]'"
    trimesh, viewer = library("trimesh", why), library("trimesh.viewer", why)
    whole = viewer.scene_to_html(trimesh.creation.box().scene())
    script, end, _ = whole.partition("<script>")[2].partition(_END)
    if not end or "</script" in script:
        why = "brings no known three.js: install that of constraints.txt"
        raise OptionError(f"trimesh {trimesh.__version__} {why}")
    return f"{script}{end}"


class Figure:
    """Elements in space in whole units of the figure."""

    def __init__(self, elements: Elements) -> None:
        self.elements = elements
        self.scale = _UNITS / size_of(elements.assembly)

    def data(self, view: ViewAngles) -> dict[str, Any]:
        """All that a page draws: see ``page_space.js``."""
        elements, contacts = self.elements, self.elements.assembly.joints
        drawn = surface(elements)
        corners = np.concatenate([drawn.triangles.reshape(-1, 3), drawn.edges.reshape(-1, 3)])
        block = np.concatenate([np.repeat(drawn.of_triangle, 3), np.repeat(drawn.of_edge, 2)])
        rows, number = np.unique(np.column_stack([block, self._at(corners)]), axis=0, return_inverse=True)
        triangles = number[: 3 * len(drawn.triangles)]
        lines, joint = contacts.lines()
        middle = (rows[:, 1:].min(axis=0) + rows[:, 1:].max(axis=0)) / 2
        areas = contacts.extent[contacts.extent > 0]
        usual = np.sqrt(np.median(areas)) if len(areas) else np.inf
        self.radius = min(_RADIUS * _UNITS, _OF_JOINT * usual * self.scale)
        self.table: dict[tuple[float, ...], int] = {(0.0,) * 6: 0}
        layers = {name: [self._marks(each) for each in marks] for name, marks in elements.layers.items()}
        layers["loads"] = [self._marks(each) for each in elements.loads]
        seen = {"size": _UNITS, "middle": middle.tolist(), "view": view}
        look = {"block": BLOCK, "fixed": FIXED, "radius": round(3 * self.radius, 2)}
        solids = {"points": rows[:, 1:].ravel().tolist(), "of": rows[:, 0].tolist()}
        solids |= {"triangles": triangles.tolist(), "edges": number[len(triangles) :].tolist()}
        solids |= {"hatching": self._at(drawn.hatching).ravel().tolist()}
        motions = [self._motion(motion) for motion in elements.motion]
        outlines = {"points": self._at(lines).ravel().tolist(), "of": joint.tolist()}
        of_marks = {"layers": layers, "table": list(self.table)}
        return {**seen, **look, "surface": solids, "motions": motions, "outlines": outlines, **of_marks}

    def _at(self, points: np.ndarray) -> np.ndarray:
        return np.rint(points * self.scale).astype(int)

    def _motion(self, motion: np.ndarray) -> tuple[float, ...]:
        moved = np.round(motion[:3] * self.scale, 1) + 0.0
        return (*moved.tolist(), *(np.round(motion[3:], 6) + 0.0).tolist())

    def _marks(self, marks: Marks) -> dict[str, Any]:
        motion = None
        if marks.motion is not None:
            motion = [self.table.setdefault(self._motion(each), len(self.table)) for each in marks.motion]
        through = marks.shape == "arrow" or marks.name in INSIDE
        half = marks.width * (_RADIUS_THROUGH * _UNITS if through else self.radius)
        placed = {"points": self._at(marks.points).ravel().tolist(), "motion": motion}
        look = {"radius": round(half, 2), "colour": marks.colour, "dashes": marks.dashes, "through": through}
        return {"shape": marks.shape, **placed, **look}

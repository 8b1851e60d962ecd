"""Marks: graphical elements of one kind as plain arrays, with their look and their legend entry."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np
import shapely

from masonry_opt.problem.assembly import Assembly

#: Number of joints from which a scene is large: its marks are drawn smaller, so that they do not overlap.
MANY = 1000

#: Names of marks that lie inside blocks. In space they are drawn as if blocks were transparent.
_INSIDE = ("resultants", "points", "contacts", "tie", "prop", "ends", "openings")


@dataclass(frozen=True)
class Marks:
    """Marks of one kind, with their points, look and motion.

    Points are relative to the geometry's origin, in the case's unit of length. Shapes are those of the
    plane. In space, points have three coordinates and motions have six components.
    """

    name: str  #: kind of mark, such as "slides" or "live"
    label: str  #: entry of the legend, shared by all marks with this label; "" for no entry
    #: Graphical form. A bar shows the scale of forces. A dot has a white rim, a point has no rim.
    shape: Literal["line", "arrow", "bar", "dot", "point", "square", "cross"]
    colour: str  #: as #RRGGBB
    width: float  #: width of lines, or diameter of dots, points, squares and crosses, in points (1/72 inch)
    #: Both ends of lines and bars, or tail and tip of arrows, shape (marks, 2, 2). Middles of the other
    #: forms, shape (marks, 1, 2).
    points: np.ndarray
    #: Full motion of each mark, shape (marks, 3), as defined in :func:`moved`. None if no mark moves.
    motion: np.ndarray | None = None
    dashes: tuple[float, ...] = ()  #: lengths of dashes and gaps, relative to the width; () for solid lines
    text: str = ""  #: text beside a bar or at a point

    @property
    def through(self) -> bool:
        """True if blocks in space do not hide the marks: arrows, and marks that lie inside blocks."""
        return self.shape == "arrow" or self.name in _INSIDE

    def moved(self, share: float) -> np.ndarray:
        """Return the points after a share of the full motion, in the shape of ``points``."""
        return self.points if self.motion is None else moved(self.points, share * self.motion[:, None])


def size_of(assembly: Assembly) -> float:
    """Return the largest side of the bounding box of the movable blocks at rest, the size of the scene."""
    low, high = movable_box(assembly)
    return float((high - low).max())


def movable_box(assembly: Assembly) -> tuple[np.ndarray, np.ndarray]:
    """Return the lowest and highest coordinates of the movable blocks at rest, shape (2,) or (3,) each."""
    low, high = assembly.geometry.boxes
    return low[assembly.movable].min(axis=0), high[assembly.movable].max(axis=0)


def shrink_of(assembly: Assembly) -> float:
    """Return the factor for widths of marks on joints, which is below 1 if the scene has many joints."""
    return 1.0 if len(assembly.joints.first) < MANY else 0.6


def moved(points: np.ndarray, motion: np.ndarray) -> np.ndarray:
    """Return points after rigid motions, in the shape of the points.

    In the plane, points have shape (..., 2) and motions (vx, vy, ω) have shape (..., 3). A point (x, y) is
    displaced by (vx - ω y, vy + ω x). In space, points have shape (..., 3) and motions (v, ω) have shape
    (..., 6). A point x is displaced by v + ω × x.
    """
    if points.shape[-1] == 3:
        return points + motion[..., :3] + np.cross(motion[..., 3:], points)
    vx, vy, omega = np.moveaxis(motion, -1, 0)
    x, y = np.moveaxis(points, -1, 0)
    return np.stack([x + vx - omega * y, y + vy + omega * x], axis=-1)


def joint_marks(lines: Marks, in_point: str | None = None) -> Iterator[Marks]:
    """Yield lines for joints with a length, and squares for joints in a point, such as a corner on an edge.

    ``lines`` run along joints, in space along the sides of their outlines. ``in_point`` is the legend entry
    of the squares. By default squares have no entry, or that of the lines if there are only squares.
    """
    is_point = (lines.points[:, 0] == lines.points[:, 1]).all(axis=1)
    line_motion, square_motion = (
        None if lines.motion is None else lines.motion[selected] for selected in (~is_point, is_point)
    )
    if not is_point.all():
        yield replace(lines, points=lines.points[~is_point], motion=line_motion)
    if is_point.any():
        label = in_point
        if label is None:
            label = lines.label if is_point.all() else ""
        squares = replace(lines, label=label, shape="square", width=2.4 * lines.width, dashes=())
        yield replace(squares, points=lines.points[is_point][:, :1], motion=square_motion)


def hatching(shape: shapely.Geometry, box: Sequence[float], step: float) -> np.ndarray:
    """Return lines at 45° on a shape, as an array of line strings.

    The box (left, low, right, high) bounds the lines. ``step`` is their distance along its lower side.
    """
    left, low, right, high = box
    starts = np.arange(left - (high - low), right, step)
    lines = shapely.linestrings([[(x, low), (x + high - low, high)] for x in starts])
    return line_parts(shapely.intersection(lines, shape))


def line_parts(shapes: np.ndarray) -> np.ndarray:
    """Return the line strings among the parts of shapes."""
    parts = shapely.get_parts(shapes)
    return parts[(shapely.get_type_id(parts) == shapely.GeometryType.LINESTRING) & ~shapely.is_empty(parts)]


def outlines(shapes: np.ndarray) -> list[list[np.ndarray]]:
    """Return the closed rings of each polygon and of its holes, shape (corners + 1, 2) each.

    The last point of a ring is its first corner.
    """
    rings = (shapely.get_rings(shapely.get_parts(shape)) for shape in shapes)
    return [[shapely.get_coordinates(ring) for ring in shape_rings] for shape_rings in rings]

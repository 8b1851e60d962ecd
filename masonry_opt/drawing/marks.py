"""Marks: graphical elements of one kind as plain arrays, with their look and their legend entry."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np
import shapely

from masonry_opt.problem.assembly import Assembly

#: In scenes with at least this number of joints, marks on joints are drawn smaller, so that they do not
#: overlap.
FEWEST_JOINTS_WITH_SMALL_MARKS = 1000

#: Names of marks inside blocks. In space, such marks are drawn as if blocks were transparent.
_MARKS_INSIDE_BLOCKS = ("resultants", "points", "contacts", "tie", "prop", "ends", "openings")


@dataclass(frozen=True)
class Marks:
    """Marks of one kind, such as arrows of live loads, with their points, style and motion.

    Points are relative to the geometry's origin, in the case's unit of length. The shapes of arrays below are
    for the plane. In space, points have three coordinates and motions have six components.
    """

    name: str  #: kind of mark, such as "slides" or "live"
    label: str  #: entry of the marks in the legend; "" for no entry
    #: Graphical form of the marks. A bar shows the scale of forces. A dot has a white rim, and a point has no
    #: rim.
    shape: Literal["line", "arrow", "bar", "dot", "point", "square", "cross"]
    colour: str  #: colour of the marks, in the form #RRGGBB
    width: float  #: width of lines, or diameter of dots, points, squares and crosses, in points (1/72 inch)
    #: Both ends of lines and bars, or tail and tip of arrows, shape (marks, 2, dim). For all other forms, the
    #: middle of each mark, shape (marks, 1, dim).
    points: np.ndarray
    #: Motion of each mark in the magnified mechanism, for the function :func:`moved`, shape (marks, 3), in
    #: space (marks, 6). None if no mark moves.
    motion: np.ndarray | None = None
    dashes: tuple[float, ...] = ()  #: lengths of dashes and gaps, relative to the width; () for solid lines
    text: str = ""  #: text next to a bar or at a point

    @property
    def through(self) -> bool:
        """True for marks that stay visible through blocks in space: arrows, and marks inside blocks."""
        return self.shape == "arrow" or self.name in _MARKS_INSIDE_BLOCKS

    def moved(self, share: float) -> np.ndarray:
        """Return the points of the marks after the fraction ``share`` of the magnified motion.

        The result has the shape of the attribute ``points``.
        """
        return self.points if self.motion is None else moved(self.points, share * self.motion[:, None])


def size_of(assembly: Assembly) -> float:
    """Return the size of the scene: the longest side of the movable blocks' bounding box at rest."""
    low, high = movable_box(assembly)
    return float((high - low).max())


def movable_box(assembly: Assembly) -> tuple[np.ndarray, np.ndarray]:
    """Return the lowest and highest coordinates of the movable blocks at rest, each of shape (2,) or (3,)."""
    low, high = assembly.geometry.boxes
    return low[assembly.movable].min(axis=0), high[assembly.movable].max(axis=0)


def shrink_of(assembly: Assembly) -> float:
    """Return the scale factor for the width of marks on joints: 1, or 0.6 in scenes with many joints."""
    return 1.0 if len(assembly.joints.first) < FEWEST_JOINTS_WITH_SMALL_MARKS else 0.6


def moved(points: np.ndarray, motion: np.ndarray) -> np.ndarray:
    """Return points that are displaced by rigid motions, linearised for small rotations.

    The result has the shape of ``points``. In the plane, points have shape (..., 2) and motions (vx, vy, ω)
    have shape (..., 3). A point (x, y) is displaced by (vx - ω y, vy + ω x). In space, points have shape
    (..., 3) and motions (v, ω) have shape (..., 6). A point x is displaced by v + ω × x.
    """
    if points.shape[-1] == 3:
        return points + motion[..., :3] + np.cross(motion[..., 3:], points)
    vx, vy, omega = np.moveaxis(motion, -1, 0)
    x, y = np.moveaxis(points, -1, 0)
    return np.stack([x + vx - omega * y, y + vy + omega * x], axis=-1)


def joint_marks(lines: Marks, in_point: str | None = None) -> Iterator[Marks]:
    """Generate lines for joints with a length, and squares for joints at a single point.

    ``lines`` run along joints, in space along the sides of their outlines. ``in_point`` is the legend entry
    of the squares. By default squares have no legend entry. If all joints are points, squares have the entry
    of the lines.
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
    """Return hatching lines at 45° inside a shape, as an array of Shapely line strings.

    The box (left, low, right, high) bounds the lines. ``step`` is their distance along its lower side.
    """
    left, low, right, high = box
    starts = np.arange(left - (high - low), right, step)
    lines = shapely.linestrings([[(x, low), (x + high - low, high)] for x in starts])
    return line_parts(shapely.intersection(lines, shape))


def line_parts(shapes: np.ndarray) -> np.ndarray:
    """Return the line strings among the parts of Shapely geometries."""
    parts = shapely.get_parts(shapes)
    return parts[(shapely.get_type_id(parts) == shapely.GeometryType.LINESTRING) & ~shapely.is_empty(parts)]


def outlines(shapes: np.ndarray) -> list[list[np.ndarray]]:
    """Return the outlines of each shape and of its holes as closed rings, each of shape (corners + 1, 2).

    The last point of a ring is its first corner.
    """
    rings = (shapely.get_rings(shapely.get_parts(shape)) for shape in shapes)
    return [[shapely.get_coordinates(ring) for ring in shape_rings] for shape_rings in rings]

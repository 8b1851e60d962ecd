"""Marks: elements of one kind as plain arrays, with how they look and what a legend says of them."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np
import shapely

from masonry_opt.problem.assembly import Assembly

MANY = 1000  #: Number of joints from which marks are small.

#: Names of marks that lie inside blocks.
_INSIDE = ("resultants", "points", "contacts", "tie", "prop", "ends", "openings")


@dataclass(frozen=True)
class Marks:
    """Marks of one kind. Points are relative to the geometry's origin, in the case's unit of length; in space
    they have three coordinates, and motions six."""

    name: str  #: kind of mark, such as "slides" or "live"
    label: str  #: entry of the legend, which marks of one label share; "" for none
    #: A bar shows a scale, a dot has a white rim and a point has none.
    shape: Literal["line", "arrow", "bar", "dot", "point", "square", "cross"]
    colour: str  #: as #RRGGBB
    width: float  #: of lines, or across what has no ends, in points of a printed picture
    #: Both ends of lines and bars, tail and tip of arrows, (marks, 2, 2); else the middle, (marks, 1, 2).
    points: np.ndarray
    #: Full motion of each mark, as in ``moved``, shape (marks, 3); None of marks that stay.
    motion: np.ndarray | None = None
    dashes: tuple[float, ...] = ()  #: lengths of dashes and gaps over the width
    text: str = ""  #: written beside a bar

    @property
    def through(self) -> bool:
        """Whether it is seen through blocks in space, as arrows are."""
        return self.shape == "arrow" or self.name in _INSIDE

    def moved(self, share: float) -> np.ndarray:
        """The points after a share of the full motion."""
        return self.points if self.motion is None else moved(self.points, share * self.motion[:, None])


def size_of(assembly: Assembly) -> float:
    """The largest side of the box round the movable blocks at rest."""
    low, high = movable_box(assembly)
    return float((high - low).max())


def movable_box(assembly: Assembly) -> tuple[np.ndarray, np.ndarray]:
    """Least and largest coordinates of the movable blocks at rest, shape (2,) or (3,) each."""
    low, high = assembly.geometry.boxes
    return low[assembly.movable].min(axis=0), high[assembly.movable].max(axis=0)


def shrink_of(assembly: Assembly) -> float:
    """How large marks on joints are: less where there are many."""
    return 1.0 if len(assembly.joints.first) < MANY else 0.6


def moved(points: np.ndarray, motion: np.ndarray) -> np.ndarray:
    """Points, shape (..., 2), moved by (vx - ω y, vy + ω x) under motions (vx, vy, ω), shape (..., 3); in
    space points, shape (..., 3), by v + ω × x under (v, ω), shape (..., 6)."""
    if points.shape[-1] == 3:
        return points + motion[..., :3] + np.cross(motion[..., 3:], points)
    vx, vy, omega = np.moveaxis(motion, -1, 0)
    x, y = np.moveaxis(points, -1, 0)
    return np.stack([x + vx - omega * y, y + vy + omega * x], axis=-1)


def joint_marks(lines: Marks, in_point: str | None = None) -> Iterator[Marks]:
    """Lines along joints, or in space along the sides of their outlines, but squares on joints of a corner on
    an edge, which have no length; of these a legend says ``in_point``, if not what it says of lines."""
    point = (lines.points[:, 0] == lines.points[:, 1]).all(axis=1)
    along, at = (None if lines.motion is None else lines.motion[which] for which in (~point, point))
    if not point.all():
        yield replace(lines, points=lines.points[~point], motion=along)
    if point.any():
        said = in_point if in_point is not None else lines.label if point.all() else ""
        look = replace(lines, label=said, shape="square", width=2.4 * lines.width, dashes=())
        yield replace(look, points=lines.points[point][:, :1], motion=at)


def hatching(shape: shapely.Geometry, box: Sequence[float], step: float) -> np.ndarray:
    """Lines at 45° on a shape, so far apart along the lower side of a box (left, low, right, high)."""
    left, low, right, high = box
    starts = np.arange(left - (high - low), right, step)
    lines = shapely.linestrings([[(x, low), (x + high - low, high)] for x in starts])
    return line_parts(shapely.intersection(lines, shape))


def line_parts(shapes: np.ndarray) -> np.ndarray:
    """The line strings among the parts of shapes."""
    parts = shapely.get_parts(shapes)
    return parts[(shapely.get_type_id(parts) == shapely.GeometryType.LINESTRING) & ~shapely.is_empty(parts)]


def outlines(shapes: np.ndarray) -> list[list[np.ndarray]]:
    """Rings of each polygon and of its holes, shape (corners, 2) each, the first corner again at the end."""
    rings = (shapely.get_rings(shapely.get_parts(shape)) for shape in shapes)
    return [[shapely.get_coordinates(ring) for ring in of_shape] for of_shape in rings]

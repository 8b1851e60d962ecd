"""What is seen of solids from one side: a raster of depths, and the pieces of lines that it does not hide."""

import math
from dataclasses import dataclass

import numpy as np
from scipy.ndimage import minimum_filter

from masonry_opt.drawing.elements import Elements
from masonry_opt.drawing.marks import movable_box
from masonry_opt.errors import OptionError
from masonry_opt.scene.rows import ranges
from masonry_opt.scene.scene import Scene
from masonry_opt.scene.solids import coordinates

ViewAngles = tuple[float, float]  #: Azimuth and elevation, in degrees.

#: Where no view is asked for: elevation, and azimuths among which the best is taken, the usual ones first.
_ELEVATION, _AZIMUTHS = 22.0, (-60.0, -120.0, -30.0, -150.0, 30.0, 60.0, 120.0, 150.0)

_TOWARDS = 0.25  #: How much it counts that a mechanism comes towards the eye, against widths seen.
_SHORT = 3.0  #: Visible pieces of lines shorter than so many pixels, beside hidden ones, are chance.
_DEPTH = 2e-3  #: Nothing is hidden by what lies less than this share of the picture before it.


def refuse_view(scene: Scene, view: object) -> None:
    """Raise OptionError if a view is none, or one of a scene in the plane."""
    if view is None:
        return
    if scene.dimension == 2:
        raise OptionError(f"{scene.origin}: the plane is seen from the front: leave 'view' to solids")
    given = view if isinstance(view, list | tuple) else ()
    numbers = all(isinstance(angle, int | float) and not isinstance(angle, bool) for angle in given)
    angles = coordinates(given, 2)
    if not numbers or angles is None or abs(angles[1]) > 90:
        raise OptionError(
            f"a view is azimuth and elevation in degrees, as (-60, 22), the latter up to ±90 (found {view!r})"
        )


def axes_of(view: ViewAngles) -> np.ndarray:
    """Directions in which a picture's right, its upper side and the eye lie, shape (3, 3): rows."""
    azimuth, elevation = np.radians(view)
    (east, north), (out, up) = ((np.cos(angle), np.sin(angle)) for angle in (azimuth, elevation))
    right, towards = np.array([-north, east, 0.0]), np.array([out * east, out * north, up])
    return np.stack([right, np.cross(towards, right), towards])


def best_view(elements: Elements) -> ViewAngles:
    """The view that shows the scene's wider side, and its mechanism coming nearer."""
    low, high = movable_box(elements.assembly)
    wide = (high - low)[:2] / (high - low)[:2].max()
    motion, centroid = elements.motion, elements.assembly.geometry.centroid
    moves = (motion[:, :3] + np.cross(motion[:, 3:], centroid)).sum(axis=0)
    comes = moves / (np.linalg.norm(moves) or 1.0)

    def shows(azimuth: float) -> float:
        right, _, towards = axes_of((azimuth, 0.0))
        return float(np.abs(right[:2]) @ wide + _TOWARDS * comes @ towards)

    return max(_AZIMUTHS, key=lambda azimuth: round(shows(azimuth), 9)), _ELEVATION


@dataclass(frozen=True)
class Raster:
    """Nearest triangle at each pixel of a picture."""

    left: float  #: the picture's lower left corner
    bottom: float
    pixel: float  #: the side of one
    #: Of the nearest triangle towards the eye, ``-inf`` without one, shape (rows, columns), the lowest first.
    depth: np.ndarray
    triangle: np.ndarray  #: its number, -1 where there is none

    def visible(self, lines: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """What is seen of lines, shape (lines, 2, 3) in the picture's axes: pieces, shape (pieces, 2, 2), and
        their lines."""
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
        pieces = np.stack([at[starts, :2], at[ends, :2]], axis=1)
        owner = line[starts]
        length = np.hypot(*(pieces[:, 1] - pieces[:, 0]).T) / self.pixel
        kept = (first[starts] & last[ends]) | (length >= _SHORT)
        return pieces[kept], owner[kept]

    def sees(self, points: np.ndarray) -> np.ndarray:
        """Whether points, shape (points, 3) in the picture's axes, are not hidden."""
        rows, columns = self.depth.shape
        # Against the farthest depth of the pixels around: an edge lies between two faces.
        farthest = minimum_filter(self.depth, size=3, mode="nearest")
        column = ((points[:, 0] - self.left) / self.pixel).astype(int).clip(0, columns - 1)
        row = ((points[:, 1] - self.bottom) / self.pixel).astype(int).clip(0, rows - 1)
        bias = _DEPTH * self.pixel * max(rows, columns)
        return points[:, 2] + bias >= farthest[row, column]


def raster(triangles: np.ndarray, box: np.ndarray, pixels: int) -> Raster:
    """The nearest of triangles that face the eye, shape (triangles, 3, 3) in the axes of a picture from lower
    left to upper right, shape (2, 2), with so many pixels along its longer side."""
    (left, bottom), (width, height) = box[0], box[1] - box[0]
    pixel = max(width, height) / pixels
    depth = np.full((math.ceil(height / pixel), math.ceil(width / pixel)), -np.inf)
    number = np.full(depth.shape, -1)
    flat = (triangles[..., :2] - box[0]) / pixel - 0.5
    (ax, ay), (bx, by) = (np.moveaxis(flat[:, corner] - flat[:, 0], -1, 0) for corner in (1, 2))
    twice = ax * by - ay * bx
    low = np.floor(flat.min(axis=1)).astype(int).clip(0)
    high = (np.ceil(flat.max(axis=1)).astype(int) + 1).clip(None, depth.shape[::-1])
    for each in np.flatnonzero((twice > 1e-9) & (low < high).all(axis=1)):
        (x0, y0), (x1, y1) = low[each], high[each]
        x, y = np.arange(x0, x1) - flat[each, 0, 0], (np.arange(y0, y1) - flat[each, 0, 1])[:, None]
        one = (x * by[each] - y * bx[each]) / twice[each]
        two = (y * ax[each] - x * ay[each]) / twice[each]
        first, second, third = triangles[each, :, 2]
        found = first + one * (second - first) + two * (third - first)
        window = np.s_[y0:y1, x0:x1]
        slack = -1e-6
        nearer = (one >= slack) & (two >= slack) & (one + two <= 1 - slack) & (found > depth[window])
        depth[window][nearer] = found[nearer]
        number[window][nearer] = each
    return Raster(float(left), float(bottom), float(pixel), depth, number)

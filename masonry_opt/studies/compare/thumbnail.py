"""A scene as a small picture of plain polygons, as paths of an SVG."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import shapely

from masonry_opt.scene.geometry import geometry
from masonry_opt.scene.scene import Scene

#: Pixels within which a picture fits, and units of its paths in a pixel.
_WIDTH, _HEIGHT, _UNITS = 110, 72, 10

#: Shown of the supports, beyond what can move: a share of the larger side.
_MARGIN = 0.06

#: Of more blocks only the outline is drawn: they are smaller than the lines between them.
_MOST = 800


@dataclass(frozen=True)
class Thumbnail:
    """Paths in units of a tenth of a pixel, y downwards: of the supports, and of what can move.

    Attributes
    ----------
    width, height: of the picture, in these units.
    fixed, movable: the paths' ``d``.
    """

    width: int
    height: int
    fixed: str
    movable: str


def thumbnail(scene: Scene) -> Thumbnail:
    """The picture of a scene.

    Raises CaseError if a block's polygon is none (see :func:`~masonry_opt.scene.geometry.geometry`).
    """
    shapes = geometry(scene).polygons
    fixed = np.array([block.fixed for block in scene.blocks])
    movable = shapes[~fixed]
    left, bottom, right, top = shapely.total_bounds(movable)
    margin = _MARGIN * max(right - left, top - bottom)
    frame = (left - margin, bottom - margin, right + margin, top + margin)
    wide, tall = frame[2] - frame[0], frame[3] - frame[1]
    scale = _UNITS * min(_WIDTH / wide, _HEIGHT / tall)
    if len(movable) > _MOST:
        movable = np.array([shapely.union_all(movable)])

    def path(drawn: np.ndarray) -> str:
        """Outlines and holes, in whole units."""
        rings = shapely.get_rings(shapely.get_parts(drawn))
        corners = (
            np.rint((shapely.get_coordinates(ring)[:-1] - (frame[0], frame[3])) * (scale, -scale))
            for ring in rings
        )
        return "".join("M" + " ".join(f"{x:.0f} {y:.0f}" for x, y in ring + 0.0) + "Z" for ring in corners)

    supports = shapely.clip_by_rect(shapes[fixed], *frame)
    return Thumbnail(round(wide * scale), round(tall * scale), path(supports), path(movable))

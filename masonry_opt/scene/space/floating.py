"""How far from a block that floats in space the nearest one is."""

from __future__ import annotations

import numpy as np
import shapely

from masonry_opt.errors import rounded_up
from masonry_opt.scene.contact import how_far, rounding
from masonry_opt.scene.scene import Scene
from masonry_opt.scene.space.frames import dots, lengths
from masonry_opt.scene.space.pairs import boxes, reach
from masonry_opt.scene.space.shapes import Shapes

#: Gap that may be a joint of mortar, over the cube root of a block's volume.
_MORTAR = 0.2


def nearest_solid(scene: Scene, shapes: Shapes, block: int) -> str:
    """How far from a block that touches nothing the nearest is, and what to do."""
    nearest, gap = _nearest(shapes, block)
    name = repr(scene.blocks[nearest].name)
    if gap <= shapes.tolerance:
        return f": it meets {name} along edges or at corners alone, where a joint needs a face of either"
    both, remedy = [block, nearest], ""
    if gap <= reach(shapes)[both].min():
        remedy = rounding(gap)
    elif gap <= _MORTAR * np.cbrt(shapes.volume[both].min()):
        remedy = f", or raise 'contact_tolerance' to {rounded_up(gap, 2)} if mortar was left out"
    return how_far(f"{name}, the nearest, is", gap, remedy)


def _nearest(shapes: Shapes, block: int) -> tuple[int, float]:
    """The block nearest to a block, and its distance."""
    low, high = boxes(shapes)
    at_least = lengths(np.maximum(np.maximum(low - high[block], low[block] - high), 0))
    at_least[block] = np.inf
    nearest, gap = block, np.inf
    for other in np.argsort(at_least):
        if at_least[other] >= gap:
            break
        apart = _distance(shapes, block, int(other))
        if apart < gap:
            nearest, gap = int(other), apart
    return nearest, gap


def _distance(shapes: Shapes, one: int, other: int) -> float:
    """Distance of two blocks that do not overlap: between corners and faces, or between edges."""
    tail, tip, face = shapes.faces.sides()
    sides = [np.flatnonzero(shapes.faces.block[face] == block) for block in (one, other)]
    faces = [np.flatnonzero(shapes.faces.block == block) for block in (one, other)]
    least = np.inf
    for own, of_other in zip(sides, faces[::-1], strict=True):
        i, j = (grid.ravel() for grid in np.meshgrid(own, of_other))
        flat = shapely.points(shapes.faces.frame.down(tail[i], j))
        off = shapely.distance(flat, shapes.faces.polygon[j])
        least = min(least, float(np.hypot(off, shapes.faces.frame.above(tail[i], j)).min()))
    i, j = (grid.ravel() for grid in np.meshgrid(*sides))
    a, b = tip[i] - tail[i], tip[j] - tail[j]
    between, across = tail[j] - tail[i], np.cross(a, b)
    square = dots(across, across)
    cross = square > 1e-12 * dots(a, a) * dots(b, b)
    between, across, square, a, b = (column[cross] for column in (between, across, square, a, b))
    within = np.ones(len(a), dtype=bool)
    for edge in (a, b):
        at = dots(np.cross(between, edge), across) / square
        within &= (at >= 0) & (at <= 1)
    apart = np.abs(dots(between, across))[within] / np.sqrt(square[within])
    return min(least, float(apart.min(initial=np.inf)))

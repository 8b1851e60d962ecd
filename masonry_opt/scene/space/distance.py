"""Distances of blocks in space."""

from __future__ import annotations

import numpy as np
import shapely

from masonry_opt.scene.rows import dots, lengths
from masonry_opt.scene.space.frames import OuterFaces


def nearest(faces: OuterFaces, boxes: tuple[np.ndarray, np.ndarray], block: int) -> tuple[int, float]:
    """The block nearest to a block, and its distance, given the boxes round all blocks."""
    low, high = boxes
    at_least = lengths(np.maximum(np.maximum(low - high[block], low[block] - high), 0))
    at_least[block] = np.inf
    found, gap = block, np.inf
    for other in np.argsort(at_least):
        if at_least[other] >= gap:
            break
        apart = _distance(faces, block, int(other))
        if apart < gap:
            found, gap = int(other), apart
    return found, gap


def _distance(every: OuterFaces, one: int, other: int) -> float:
    """Distance of two blocks that do not overlap: between corners and faces, or between edges."""
    tail, tip, face = every.sides()
    sides = [np.flatnonzero(every.block[face] == block) for block in (one, other)]
    faces = [np.flatnonzero(every.block == block) for block in (one, other)]
    least = np.inf
    for own, of_other in zip(sides, faces[::-1], strict=True):
        i, j = (grid.ravel() for grid in np.meshgrid(own, of_other))
        flat = shapely.points(every.frame.down(tail[i], j))
        off = shapely.distance(flat, every.polygon[j])
        least = min(least, float(np.hypot(off, every.frame.above(tail[i], j)).min()))
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

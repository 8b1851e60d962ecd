"""Areas and centroids of a scene's blocks, and the checks that a polygon must pass."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import shapely

from masonry_opt.errors import CaseError
from masonry_opt.scene.scene import Scene

#: Lengths below this fraction of the diagonal round the movable blocks are nothing: gaps, overlaps,
#: joints, corners.
RELATIVE_TOLERANCE = 1e-6


@dataclass(frozen=True)
class Geometry:
    """Polygons of a scene, moved so that its middle is the origin (far coordinates lose digits).

    Attributes
    ----------
    origin: middle of the scene in its own coordinates, shape (2,).
    tolerance: length below which the scene has no detail.
    polygons: shapely polygons, counter-clockwise, straight corners removed, one a block.
    area: of each block, shape (blocks,).
    centroid: of each block, relative to ``origin``, shape (blocks, 2).
    """

    origin: np.ndarray
    tolerance: float
    polygons: np.ndarray
    area: np.ndarray
    centroid: np.ndarray


def geometry(scene: Scene) -> Geometry:
    """Polygons, areas and centroids of the blocks.

    Clockwise polygons are turned round; corners on a straight edge are dropped.

    Raises
    ------
    CaseError
        If a polygon has no area, crosses itself or is not convex; the message names the block.
    """
    counts = np.array([len(block.vertices) for block in scene.blocks])
    corners = np.concatenate([block.polygon() for block in scene.blocks])
    # Supports may reach far beyond what stands on them: the movable blocks give the size.
    movable = np.repeat([not block.fixed for block in scene.blocks], counts)
    low, high = corners[movable].min(axis=0), corners[movable].max(axis=0)
    origin = (low + high) / 2
    tolerance = RELATIVE_TOLERANCE * float(np.hypot(*(high - low)))
    # Digits already lost in the coordinates themselves bound what can be told apart.
    tolerance = max(tolerance, 8 * float(np.spacing(np.abs(corners).max())))
    corners, counts = _simplified(corners - origin, counts, tolerance, scene)
    owner = np.repeat(np.arange(len(counts)), counts)
    rings = shapely.linearrings(corners, indices=owner)
    polygons = shapely.orient_polygons(shapely.polygons(rings))
    area = shapely.area(polygons)
    return Geometry(
        origin=origin,
        tolerance=tolerance,
        polygons=polygons,
        area=area,
        centroid=shapely.get_coordinates(shapely.centroid(polygons)),
    )


def _simplified(
    corners: np.ndarray, counts: np.ndarray, tolerance: float, scene: Scene
) -> tuple[np.ndarray, np.ndarray]:
    """Drop repeated and straight corners; refuse what is then no convex polygon."""
    start = np.concatenate([[0], np.cumsum(counts)[:-1]])
    owner = np.repeat(np.arange(len(counts)), counts)
    # A last corner that repeats the first closes the ring: keep one.
    # Repeated corners in between go too, or their edges would have no direction.
    corners, owner, counts = _without(
        _length(corners - corners[_cyclic(start, counts, -1)]) > tolerance,
        corners,
        owner,
        len(counts),
    )
    _refuse(counts < 3, scene, "has fewer than three different corners: it has no area")
    start = np.concatenate([[0], np.cumsum(counts)[:-1]])
    before = corners - corners[_cyclic(start, counts, -1)]
    after = corners[_cyclic(start, counts, 1)] - corners
    turn = before[:, 0] * after[:, 1] - before[:, 1] * after[:, 0]
    # Height of the corner above the line through its neighbours, signed by the turn.
    height = turn / np.maximum(_length(before + after), tolerance)
    straight = (np.abs(height) <= tolerance) & ((before * after).sum(axis=1) > 0)
    corners, owner, counts = _without(~straight, corners, owner, len(counts))
    _refuse(counts < 3, scene, "has no area: its corners lie on one line")
    height = height[~straight]

    start = np.concatenate([[0], np.cumsum(counts)[:-1]])
    direction = corners[_cyclic(start, counts, 1)] - corners
    angle = np.arctan2(direction[:, 1], direction[:, 0])
    turning = np.angle(np.exp(1j * (angle - angle[_cyclic(start, counts, -1)])))
    turns = np.rint(np.add.reduceat(turning, start) / (2 * np.pi))
    left = np.minimum.reduceat(height, start) > 0
    right = np.maximum.reduceat(height, start) < 0
    area = np.abs(shapely.area(shapely.polygons(shapely.linearrings(corners, indices=owner))))
    _refuse(np.abs(turns) != 1, scene, "crosses itself: give its corners in order round the block")
    _refuse(area <= tolerance**2, scene, "has no area")
    _refuse(~(left | right), scene, "is not convex: split it into convex blocks")
    return corners, counts


def _cyclic(start: np.ndarray, counts: np.ndarray, step: int) -> np.ndarray:
    """Index of the corner ``step`` places on, round each block's own ring."""
    base = np.repeat(start, counts)
    return base + (np.arange(counts.sum()) - base + step) % np.repeat(counts, counts)


def _without(
    keep: np.ndarray, corners: np.ndarray, owner: np.ndarray, blocks: int
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    return corners[keep], owner[keep], np.bincount(owner[keep], minlength=blocks)


def _length(vectors: np.ndarray) -> np.ndarray:
    return np.hypot(vectors[:, 0], vectors[:, 1])


def _refuse(wrong: np.ndarray, scene: Scene, why: str) -> None:
    raise_for(np.flatnonzero(wrong), scene, why)


def raise_for(blocks: Sequence[int] | np.ndarray, scene: Scene, why: str) -> None:
    """Raise CaseError naming the blocks, at most three of them, if there are any."""
    if len(blocks) == 0:
        return
    names = [repr(scene.blocks[index].name) for index in blocks]
    more = f" (and {len(names) - 1} more like it: {', '.join(names[1:4])})" if len(names) > 1 else ""
    raise CaseError(f"{scene.origin}: block {names[0]} {why}{more}")

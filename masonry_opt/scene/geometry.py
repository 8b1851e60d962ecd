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
    polygons: shapely polygons, counter-clockwise, straight corners removed, one a block; for finding
        joints and drawing.
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

    Clockwise polygons are turned round. Corners that lie within the tolerance of the outline without
    them are dropped for finding joints; area and centroid are those of the polygon as given.

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
    tolerance = scene.tolerance or RELATIVE_TOLERANCE * float(np.hypot(*(high - low)))
    # Digits already lost in the coordinates themselves bound what can be told apart.
    tolerance = max(tolerance, 8 * float(np.spacing(np.abs(corners).max())))
    owner = np.repeat(np.arange(len(counts)), counts)
    outlines = shapely.polygons(shapely.linearrings(corners - origin, indices=owner))
    area = shapely.area(outlines)
    polygons = _convex_outlines(corners - origin, owner, tolerance, scene)
    _refuse(area <= tolerance**2, scene, "has no area")
    centroid = shapely.get_coordinates(shapely.centroid(outlines))
    return Geometry(origin, tolerance, polygons, area, centroid)


def _convex_outlines(corners: np.ndarray, owner: np.ndarray, tolerance: float, scene: Scene) -> np.ndarray:
    """Counter-clockwise polygons without the corners that make no difference; refuse what is not
    convex."""
    start = _first_of_each(owner)
    # Begin each ring at its leftmost, then lowest corner: no straight edge runs through that one.
    leftmost = np.lexsort((corners[:, 1], corners[:, 0], owner))[start]
    counts = np.bincount(owner)
    base = np.repeat(start, counts)
    turned = base + (np.arange(len(owner)) - base + np.repeat(leftmost - start, counts)) % np.repeat(
        counts, counts
    )
    closed = np.insert(corners[turned], start + counts, corners[leftmost], axis=0)
    rings = shapely.linestrings(closed, indices=np.repeat(np.arange(len(counts)), counts + 1))
    rings = shapely.simplify(rings, tolerance, preserve_topology=False)
    closed, owner = shapely.get_coordinates(rings, return_index=True)
    last = np.append(owner[1:] != owner[:-1], True)
    corners, owner = closed[~last], owner[~last]
    counts = np.bincount(owner, minlength=len(counts))
    _refuse(counts < 3, scene, "has no area: its corners lie on one line or in one point")

    start = _first_of_each(owner)
    direction = closed[1:][~last[:-1]] - corners
    angle = np.arctan2(direction[:, 1], direction[:, 0])
    previous = np.arange(len(owner)) - 1
    previous[start] += counts
    turn = np.angle(np.exp(1j * (angle - angle[previous])))
    turns = np.rint(np.add.reduceat(turn, start) / (2 * np.pi))
    one_way = (np.minimum.reduceat(turn, start) > 0) | (np.maximum.reduceat(turn, start) < 0)
    _refuse(np.abs(turns) != 1, scene, "crosses itself: give its corners in order round the block")
    _refuse(~one_way, scene, "is not convex: split it into convex blocks")
    return shapely.orient_polygons(shapely.polygons(shapely.linearrings(corners, indices=owner)))


def _first_of_each(owner: np.ndarray) -> np.ndarray:
    """Index of the first entry of each owner, of a sorted array of owners."""
    return np.flatnonzero(np.append(True, owner[1:] != owner[:-1]))


def _refuse(wrong: np.ndarray, scene: Scene, why: str) -> None:
    raise_for(np.flatnonzero(wrong), scene, why)


def raise_for(blocks: Sequence[int] | np.ndarray, scene: Scene, why: str) -> None:
    """Raise CaseError naming the blocks, at most three of them, if there are any."""
    if len(blocks) == 0:
        return
    names = [repr(scene.blocks[index].name) for index in blocks]
    more = f" (and {len(names) - 1} more like it: {', '.join(names[1:4])})" if len(names) > 1 else ""
    raise CaseError(f"{scene.origin}: block {names[0]} {why}{more}")

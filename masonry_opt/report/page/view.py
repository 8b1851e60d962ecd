"""From a scene's coordinates to those of a picture in SVG."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import shapely

from masonry_opt.answer.result import Result
from masonry_opt.report.motion import Velocities, fastest, has_mechanism

#: The picture's longer side. Coordinates are whole numbers, which keeps large scenes short.
SIDE = 10_000

#: The fastest corner of a mechanism that is fully moved has moved by this share of the scene's size.
FULL = 0.1

#: The share of a full motion that is shown first: as far as pictures move a mechanism.
START = 0.6

#: What is left free round the blocks, as a share of the scene's size; more where loads may push from outside.
_MARGIN, _WITH_ARROWS = 0.05, 0.11


@dataclass(frozen=True)
class View:
    """What a picture shows of a scene, and how large. Points of the scene are relative to the geometry's
    origin, those of the picture whole numbers, y downwards.

    Attributes
    ----------
    left, top: corner of the scene's part that is shown.
    scale: the picture's units per unit of length.
    width, height: of the picture.
    full: what velocities are multiplied by where the mechanism is fully moved; 0 where nothing moves.
    motions: what moves each of the scene's blocks fully, shape (blocks, 3): vx, vy of the picture's corner
        (0, 0) with the block, and ω: the point (x, y) moves by (vx − ω y, vy + ω x).
    """

    left: float
    top: float
    scale: float
    width: int
    height: int
    full: float
    motions: np.ndarray

    def at(self, points: np.ndarray) -> np.ndarray:
        """Where points of the scene are in the picture, shape (..., 2)."""
        return np.rint((points - [self.left, self.top]) * [self.scale, -self.scale]).astype(int)


def view_of(result: Result) -> View:
    """The view of the movable blocks at rest and fully moved, and of what lies round them."""
    geometry, movable = result.assembly.geometry, result.assembly.movable
    corners, owner = shapely.get_coordinates(geometry.polygons[movable], return_index=True)
    low, high = corners.min(axis=0), corners.max(axis=0)
    size = float((high - low).max())
    full, velocities = 0.0, np.zeros((len(geometry.polygons), 3))
    if has_mechanism(result):
        full = FULL * size / fastest(result)
        velocities = Velocities(result).motion
        vx, vy, omega = velocities[movable][owner].T
        arm = corners - geometry.centroid[movable][owner]
        moved = corners + full * np.column_stack([vx - omega * arm[:, 1], vy + omega * arm[:, 0]])
        low, high = np.minimum(low, moved.min(axis=0)), np.maximum(high, moved.max(axis=0))
    scene = result.assembly.scene
    placed = any(block.live_at or block.dead_at for block in scene.blocks)
    outside = scene.edge_loads or scene.loads or placed
    margin = size * (_WITH_ARROWS if outside else _MARGIN)
    low, high = low - margin, high + margin
    scale = SIDE / float((high - low).max())
    width, height = np.rint((high - low) * scale).astype(int)
    # v + ω × (p − centroid) about the corner of the picture, whose y runs down.
    vx, vy, omega = velocities.T
    arm = geometry.centroid - [low[0], high[1]]
    of_corner = np.column_stack([vx + omega * arm[:, 1], -(vy - omega * arm[:, 0]), -omega])
    motions = full * of_corner * [scale, scale, 1.0]
    return View(float(low[0]), float(high[1]), scale, int(width), int(height), full, motions)

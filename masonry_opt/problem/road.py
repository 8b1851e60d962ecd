"""Vertical loads on a road as forces on the blocks under it."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from masonry_opt.errors import CaseError
from masonry_opt.problem.fill import profile_of
from masonry_opt.problem.spread import spread
from masonry_opt.scene.geometry import Geometry
from masonry_opt.scene.profile import profile_below
from masonry_opt.scene.scene import Scene


class Road:
    """A road line over the blocks of a scene in the plane, and what lies under it.

    A load acts straight down on the uppermost block under its place on the road; from where there is a fill
    that spreads loads it acts on the line of that fill's road, and fans out below. On a fixed block, over
    nothing, and beyond the ends of the road it does nothing.

    Raises CaseError if the road runs through a block, or no movable block lies under it.

    Parameters
    ----------
    line: points of the road from left to right, ``(x, y)`` in the scene's coordinates.
    called: how errors name it.

    Attributes
    ----------
    line: the same, shape (points, 2).
    ends: abscissae of its two ends.
    breaks: abscissae at which forces on blocks may jump as a load moves, the ends among them, rising.
    """

    def __init__(
        self,
        scene: Scene,
        shapes: Geometry,
        line: Sequence[tuple[float, float]],
        called: str = "the road",
    ) -> None:
        self.line = np.array(line, dtype=float)
        self.ends = (float(line[0][0]), float(line[-1][0]))
        self._origin, self._centroid = float(shapes.origin[0]), shapes.centroid
        profile = profile_below(scene, shapes, self.line - shapes.origin, called)
        changes = np.r_[True, profile.block[1:] != profile.block[:-1]]
        self._block = profile.block[changes]
        self._starts = np.r_[profile.x[changes, 0], profile.x[-1, 1]] + self._origin
        self._movable = np.array([not one.fixed for one in scene.blocks])
        if not self._movable[self._block[self._block >= 0]].any():
            raise CaseError(
                f"{scene.origin}: no movable block lies under {called} from {list(line[0])} to "
                f"{list(line[-1])}: give points of a line above the blocks that carry it"
            )
        self._fills = [
            (profile_of(scene, shapes, number), fill.spread_tangent)
            for number, fill in enumerate(scene.fills)
            if fill.spread is not False
        ]
        breaks = self._starts
        for below, _ in self._fills:
            start, end = np.clip(below.x[[0, -1], [0, 1]] + self._origin, *self.ends)
            breaks = np.r_[breaks[(breaks <= start) | (breaks >= end)], start, end]
        self.breaks = np.unique(breaks)

    def under(self, x: np.ndarray) -> np.ndarray:
        """Index of the movable block straight below each abscissa, shape (loads,); -1 where there is none.
        Where two meet it is the block to the right."""
        piece = np.searchsorted(self._starts, x, side="right") - 1
        on = (piece >= 0) & (x <= self._starts[-1])
        block = np.where(on, self._block[np.clip(piece, 0, len(self._block) - 1)], -1)
        return np.where((block >= 0) & self._movable[block], block, -1)

    def on_blocks(self, x: np.ndarray, load: np.ndarray) -> np.ndarray:
        """Sums of the forces fx and fy and of their moment about the centroid on each of the scene's blocks,
        shape (blocks, 3), of vertical loads (down > 0) at abscissae x, shape (loads,) each."""
        total, block = np.zeros((len(self._centroid), 3)), self.under(x)
        at, force = x - self._origin, -np.asarray(load, dtype=float)
        left = (x >= self.ends[0]) & (x <= self.ends[1])

        def add(block: np.ndarray, force: np.ndarray, turning: np.ndarray) -> None:
            np.add.at(total[:, 1], block, force)
            np.add.at(total[:, 2], block, turning - self._centroid[block, 0] * force)

        for below, tangent in self._fills:
            if len(on := np.flatnonzero(left & (at >= below.x[0, 0]) & (at <= below.x[-1, 1]))):
                shares, moments = spread(below, at[on], tangent)
                add(below.block, force[on] @ shares, force[on] @ moments)
                left[on] = False
        straight = left & (block >= 0)
        add(block[straight], force[straight], at[straight] * force[straight])
        return np.where(self._movable[:, None], total, 0.0)

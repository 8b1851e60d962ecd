"""Vertical loads on a road as forces on the blocks under it, spread through fill to the edges below it."""

import math
from collections.abc import Sequence

import numpy as np

from masonry_opt.errors import CaseError
from masonry_opt.problem.fill import profile_of
from masonry_opt.scene.geometry import Geometry, Profile, profile_below
from masonry_opt.scene.scene import Scene


class Road:
    """A road line over the blocks of a scene in the plane, and what lies under it.

    A load acts straight down on the uppermost block under its place on the road; from where there is a fill
    that spreads loads it acts on the line of that fill's road, and fans out below. On a fixed block, over
    nothing, and beyond the ends of the road it does nothing.

    ``line`` has its points from left to right in the scene's coordinates, shape (points, 2), ``ends`` the
    abscissae of its two ends, and ``breaks`` those at which forces on blocks may jump as a load moves, the
    ends among them, rising.

    Raises CaseError, which calls it as ``called``, if it runs through a block, or no movable one is under it.
    """

    def __init__(
        self, scene: Scene, shapes: Geometry, line: Sequence[tuple[float, float]], called: str = "the road"
    ) -> None:
        self.line = np.array(line, dtype=float)
        self.ends = (float(line[0][0]), float(line[-1][0]))
        self._origin, self._centroid = float(shapes.origin[0]), shapes.centroid
        profile = profile_below(scene, shapes, self.line - shapes.origin, called)
        changes = np.r_[True, profile.block[1:] != profile.block[:-1]]
        self._block = profile.block[changes]
        self._starts = np.r_[profile.x[changes, 0], profile.x[-1, 1]] + self._origin
        self._movable = ~scene.fixed
        if not self._movable[self._block[self._block >= 0]].any():
            raise CaseError(
                f"{scene.origin}: no movable block lies under {called} from {list(line[0])} to "
                f"{list(line[-1])}: give points of a line above the blocks that carry it"
            )
        self._fills = [
            (profile_of(scene, shapes, number), math.tan(math.radians(fill.spread)))
            for number, fill in enumerate(scene.fills)
            if fill.spread is not False
        ]
        breaks = self._starts
        for below, _ in self._fills:
            start, end = np.clip(below.x[[0, -1], [0, 1]] + self._origin, *self.ends)
            breaks = np.r_[breaks[(breaks <= start) | (breaks >= end)], start, end]
        self.breaks = np.unique(breaks)

    def on_blocks(self, x: np.ndarray, load: np.ndarray) -> np.ndarray:
        """Sums of the forces fx and fy and of their moment about the centroid on each of the scene's blocks,
        shape (blocks, 3), of vertical loads (down > 0) at abscissae x, shape (loads,) each."""
        total = np.zeros((len(self._centroid), 3))
        # Straight below each load; where two pieces meet, that to the right.
        piece = np.searchsorted(self._starts, x, side="right") - 1
        block = self._block[np.clip(piece, 0, len(self._block) - 1)]
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
        straight = left & (piece >= 0) & (x <= self._starts[-1]) & (block >= 0)
        add(block[straight], force[straight], at[straight] * force[straight])
        return np.where(self._movable[:, None], total, 0.0)


def spread(profile: Profile, x: np.ndarray, tangent: float) -> tuple[np.ndarray, np.ndarray]:
    """Shares of vertical point loads on a line that reach each piece of the edges below it, and where.

    A load fans out to both sides of the vertical, each ray to the first edge that it meets: rays whose
    tangent to the vertical is t, |t| ≤ ``tangent``, carry equal shares for equal steps of t, so that pressure
    on any level plane is uniform. A ray that meets an upright face, or the end of the fill, goes straight
    down beside it. Shares of a load sum to 1.

    Loads lie at abscissae x within the profile, relative to the geometry's origin, shape (loads,). Returns
    shares, and their first moments about x = 0 over the load, shape (loads, pieces) each.
    """
    ends = np.append(profile.x[:, 0], profile.x[-1, 1])
    line = np.append(profile.line[:, 0], profile.line[-1, 1])
    aside = profile.x - x[:, None, None]
    depth = np.interp(x, ends, line)[:, None, None] - profile.y
    rightward, to_right = _half(aside, depth, tangent)
    # The other half is the same in a mirror.
    leftward, to_left = (of[:, ::-1] for of in _half(-aside[:, ::-1, ::-1], depth[:, ::-1, ::-1], tangent))
    share = rightward + leftward
    return share, share * x[:, None] + to_right - to_left


def _half(u: np.ndarray, h: np.ndarray, tangent: float) -> tuple[np.ndarray, np.ndarray]:
    """Shares of the rays to one side and their first moments about the load, shape (loads, pieces) each, of
    pieces one after another, whose near and far ends lie u aside and h below, shape (loads, pieces, 2)."""
    (u0, u1), (h0, h1) = np.moveaxis(u, 2, 0), np.moveaxis(h, 2, 0)
    near = np.maximum(u0, 0.0)  # behind the load there is another half
    h0, u0, u1 = h0 + (near - u0) / (u1 - u0) * (h1 - h0), near, np.maximum(u1, near)
    du, dh = u1 - u0, h1 - h0
    t0, t1 = (_tangents(each, below, tangent) for each, below in ((u0, h0), (u1, h1)))
    # Up to which tangent rays have met what comes before each piece, and with it.
    after = np.maximum.accumulate(np.maximum(t0, t1), axis=1)
    before = np.pad(after, ((0, 0), (1, 0)))[:, :-1]
    first = np.maximum(before, t0)
    meets = after - first
    # Along the piece their density is that of 1 / h²: its centre, between where the first and last ray meet.
    s0, s1 = (
        np.divide(t * h0 - u0, du - t * dh, out=np.zeros_like(t), where=meets > 0) for t in (first, after)
    )
    at = u0 + (s0 + (s1 - s0) * _centre(h0 + s0 * dh, h0 + s1 * dh)) * du
    # Stopped by an upright face: they go down at the far end of the piece before.
    stopped = np.pad(first - before, ((0, 0), (0, 1)))[:, 1:]
    stopped[:, -1] = tangent - after[:, -1]
    return (meets + stopped) / (2 * tangent), (meets * at + stopped * u1) / (2 * tangent)


def _tangents(u: np.ndarray, h: np.ndarray, tangent: float) -> np.ndarray:
    """Tangents of rays to points so far aside and below, up to the tangent of the angle of spread."""
    inside = u < tangent * h
    return np.where(u > 0, np.divide(u, h, out=np.full_like(u, tangent), where=inside), 0.0)


def _centre(h0: np.ndarray, h1: np.ndarray) -> np.ndarray:
    """∫ s / h² ds over ∫ 1 / h² ds for h from h0 to h1, linear in s from 0 to 1."""
    ratio = np.divide(h1, h0, out=np.ones_like(h0), where=h0 > 0)
    e = ratio - 1
    series = np.abs(e) < 1e-3
    e_or_1 = np.where(series, 1.0, e)
    closed = (ratio * np.log(np.where(ratio > 0, ratio, 1.0)) - e) / e_or_1**2
    return np.where(series, 1 / 2 - e / 6 + e**2 / 12 - e**3 / 20 + e**4 / 30, closed)

"""Fill as forces on blocks: its weight, its pressure, and loads on a road, which spread through it."""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from masonry_opt.errors import CaseError
from masonry_opt.problem.limited_forces import Action, LimitedForce, Role
from masonry_opt.problem.loads import LoadedPiece, along, resultants
from masonry_opt.scene.geometry import Geometry, Profile, profile_below
from masonry_opt.scene.loads import KINDS
from masonry_opt.scene.road import Fill
from masonry_opt.scene.scene import Scene

_LEVEL = 1e-9  #: Rise of an edge over its length up to which it is level: coordinates are rounded.


@dataclass(frozen=True)
class FilledPiece:
    """A straight piece of a block's edge that a fill touches, below a straight piece of its road."""

    fill: int  #: indices into the scene's fills,
    block: int  #: the scene's blocks,
    edge: int  #: and the geometry's edges
    ends: np.ndarray  #: of the piece, relative to the geometry's origin, the block to its left, shape (2, 2)
    depth: np.ndarray  #: of these ends below the road, shape (2,)
    stress: np.ndarray  #: what stands on these ends per unit of plan, σ, shape (2,)
    zone: int = 0  #: in which of the fill's zones the piece lies

    @property
    def height(self) -> float:
        """Between its ends, of a piece that is not level."""
        up = abs(float(self.ends[1, 1] - self.ends[0, 1]))
        return up if up > _LEVEL * float(np.hypot(*(self.ends[1] - self.ends[0]))) else 0.0

    @property
    def weight(self) -> float:
        """Of what stands on it, of unit thickness."""
        return float(self.ends[0, 0] - self.ends[1, 0]) * float(self.stress.mean())


def profile_of(scene: Scene, shapes: Geometry, number: int) -> Profile:
    """The uppermost edges below the road of a fill, by its index. Raises CaseError if the road runs through a
    block, or there is nothing below a part of it."""
    where = f"the road of fill no. {number + 1}"
    profile = profile_below(scene, shapes, np.array(scene.fills[number].road) - shapes.origin, where)
    if len(nothing := np.flatnonzero(profile.block < 0)):
        start, end = profile.x[nothing[0]] + shapes.origin[0]
        raise CaseError(
            f"{scene.origin}: fill no. {number + 1} lies above nothing from x = {start:.6g} to "
            f"{end:.6g}: end its road there, or give it ground, a fixed block"
        )
    return profile


def filled_pieces(scene: Scene, shapes: Any) -> tuple[FilledPiece, ...]:
    """The pieces of edges that fills of a scene touch, on fixed blocks too: the uppermost edges below
    the road, and the upright face of one that stands higher than the next. Raises CaseError if a fill touches
    no movable block, and as :func:`profile_of`."""
    found: list[FilledPiece] = []
    for number in range(len(scene.fills)):
        profile = profile_of(scene, shapes, number)
        ends = np.stack([profile.x, profile.y], axis=2)[:, ::-1]
        below = zip(profile.edge.tolist(), ends, profile.depth[:, ::-1], strict=True)
        touched = [*below, *_beside(profile, shapes)]
        zones = scene.fills[number].zones
        owner, weight = shapes.edges[2].tolist(), zones[0].unit_weight
        whole = (
            FilledPiece(number, owner[edge], edge, ends, depth, weight * depth)
            for edge, ends, depth in touched
            if depth.max() > shapes.tolerance
        )
        pieces = [piece for one in whole for piece in _in_zones(one, zones, shapes)]
        if all(scene.blocks[piece.block].fixed for piece in pieces):
            raise CaseError(
                f"{scene.origin}: fill no. {number + 1} touches no movable block: its road lies on "
                "the blocks, or over fixed ones alone"
            )
        found += pieces
    return tuple(found)


def _in_zones(whole: FilledPiece, zones: tuple[Fill, ...], shapes: Geometry) -> Iterator[FilledPiece]:
    """A piece of edge in the zones of a fill: cut where the line of the backing bends, ends or crosses it."""
    if len(zones) == 1:
        yield whole
        return
    line, ends, depth = np.array(zones[1].road) - shapes.origin, whole.ends, whole.depth
    (across, up), start = ends[1] - ends[0], ends[0, 0]
    # Beside an upright face, whose block lies to the left: what ends there may lie on the other side.
    beside = np.sign(up) * shapes.tolerance if abs(across) <= shapes.tolerance else 0.0
    bends = (line[:, 0] - start) / across if across else np.empty(0)
    cuts = np.unique([0.0, 1.0, *bends[(bends > 0) & (bends < 1)]])

    def above(share: np.ndarray) -> np.ndarray:
        """Height of the line above the piece."""
        x, y = ends[0, :, None] + np.outer(ends[1] - ends[0], share)
        return np.interp(x, *line.T) - y

    low, high = above(cuts[:-1]), above(cuts[1:])
    crosses = low * high < 0
    crossings = cuts[:-1] + np.diff(cuts) * low / np.where(crosses, low - high, 1.0)
    cuts = np.unique([*cuts, *crossings[crosses]])
    for share in np.stack([cuts[:-1], cuts[1:]], axis=1):
        at = ends[0] + np.outer(share, ends[1] - ends[0])
        below = depth[0] + share * (depth[1] - depth[0])
        middle, height = at[:, 0].mean() + beside, above(share)
        backed = bool(height.sum() > 0 and line[0, 0] <= middle <= line[-1, 0])
        height = np.minimum(np.maximum(height, 0.0), below) if backed else np.zeros(2)
        stress = zones[0].unit_weight * (below - height) + zones[1].unit_weight * height
        yield replace(whole, ends=at, depth=below, stress=stress, zone=int(backed))


def _beside(profile: Profile, shapes: Geometry) -> Iterator[tuple[int, np.ndarray, np.ndarray]]:
    """Pieces of upright edges between those below a fill, and at its ends: edge, ends, depth of these."""
    tail, tip, _ = shapes.edges
    up = tip[:, 1] > tail[:, 1]
    # Beyond the ends of the road there is no fill.
    left = np.append(np.inf, profile.y[:, 1])
    right = np.append(profile.y[:, 0], np.inf)
    x = np.append(profile.x[:, 0], profile.x[-1, 1])
    road = np.append(profile.line[:, 0], profile.line[-1, 1])
    bottom, top = np.minimum(left, right), np.minimum(np.maximum(left, right), road)
    for k in np.flatnonzero(top - bottom > shapes.tolerance):
        foot = np.array([x[k], bottom[k]])
        edge, spans = along(tail, tip, foot, np.array([x[k], top[k]]), shapes.tolerance)
        # The block lies to the left of its edges: seen from a fill to their right they run upwards.
        facing = up[edge] == (right[k] < left[k])
        for number, span in zip(edge[facing].tolist(), spans[facing], strict=True):
            height = bottom[k] + (span if right[k] < left[k] else span[::-1])
            ends = np.column_stack([np.full(2, x[k]), height])
            yield number, ends, np.maximum(road[k] - height, 0.0)


def fill_forces(scene: Scene, shapes: Any, pieces: tuple[FilledPiece, ...]) -> dict[str, np.ndarray]:
    """Force and moment about the centroid that the weight of fills gives each of the scene's blocks, by kind
    "dead" and "live", shape (blocks, 3), in the scene's units; in an earthquake its mass on blocks too."""
    factor = {kind: scene.factor(kind, "fill") for kind in KINDS}
    per_weight = {kind: times * scene.down for kind, times in factor.items() if times}
    if (shaking := scene.shaking) is not None:
        per_weight["live"] = max(0.0, factor["dead"]) * shaking
    loaded = []
    for piece in pieces:
        across, up = piece.ends[1] - piece.ends[0]
        if scene.fills[piece.fill].weight and across:
            # Columns of fill stand on the piece's plan.
            per_length = scene.thickness * piece.stress * abs(across) / np.hypot(across, up)
            for kind, direction in per_weight.items():
                acting = np.outer(per_length, direction)
                loaded.append(LoadedPiece(piece.fill, piece.block, kind, piece.ends, acting))
    return resultants(shapes, loaded)


def pressures(scene: Scene, pieces: tuple[FilledPiece, ...]) -> Iterator[LimitedForce]:
    """What fills press with, horizontally, on each piece of edge of a movable block that is not level: K_a to
    m K_p times what stands above, over the piece's height (Rankine), times the factor of the load case."""
    for piece in pieces:
        fill, block, height = scene.fills[piece.fill], scene.blocks[piece.block], piece.height
        if fill.pressure and not block.fixed and height:
            own = scene.factor_of_pressure * scene.thickness * float(piece.stress.mean()) * height
            # Of a pressure that is linear between the ends, the share of the second.
            share = (piece.stress[0] + 2 * piece.stress[1]) / (3 * piece.stress.sum())
            at = (1 - share) * piece.ends[0] + share * piece.ends[1]
            # The block lies to the left of its edge.
            inward = np.array([-1.0 if piece.ends[1, 1] > piece.ends[0, 1] else 1.0, 0.0])
            active, _, passive = fill.zones[piece.zone].coefficients
            name = f"fill {piece.fill + 1}|{block.name}"
            action = Action(piece.block, at, inward)
            yield LimitedForce(Role.EARTH, name, (action,), active * own, passive * own)


class Road:
    """A road line over the blocks of a scene in the plane, and what lies under it.

    A load acts straight down on the uppermost block below; above a fill that spreads loads it fans out from
    that fill's road. On a fixed block, over nothing, and beyond the ends of the road it does nothing.

    ``line`` has its points from left to right in the scene's coordinates, shape (points, 2), ``ends`` the
    abscissae of its ends, ``breaks`` those at which forces on blocks may jump as a load moves, with the ends.

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

    A load fans out to both sides, each ray to the first edge that it meets: rays whose tangent to the
    vertical is t, |t| ≤ ``tangent``, carry equal shares for equal steps of t, so that pressure on any level
    plane is uniform. A ray that meets an upright face, or the end of the fill, goes straight down beside it.

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
    successive pieces whose near and far ends lie u aside and h below, shape (loads, pieces, 2)."""
    (u0, u1), (h0, h1) = np.moveaxis(u, 2, 0), np.moveaxis(h, 2, 0)
    near = np.maximum(u0, 0.0)  # behind the load there is another half
    h0, u0, u1 = h0 + (near - u0) / (u1 - u0) * (h1 - h0), near, np.maximum(u1, near)
    du, dh = u1 - u0, h1 - h0
    u, h = np.stack([u0, u1]), np.stack([h0, h1])
    # Tangents of the rays to both ends, up to that of the angle of spread.
    within = np.divide(u, h, out=np.full_like(u, tangent), where=u < tangent * h)
    t0, t1 = np.where(u > 0, within, 0.0)
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


def _centre(h0: np.ndarray, h1: np.ndarray) -> np.ndarray:
    """∫ s / h² ds over ∫ 1 / h² ds for h from h0 to h1, linear in s from 0 to 1."""
    ratio = np.divide(h1, h0, out=np.ones_like(h0), where=h0 > 0)
    e = ratio - 1
    series = np.abs(e) < 1e-3
    e_or_1 = np.where(series, 1.0, e)
    closed = (ratio * np.log(np.where(ratio > 0, ratio, 1.0)) - e) / e_or_1**2
    return np.where(series, 1 / 2 - e / 6 + e**2 / 12 - e**3 / 20 + e**4 / 30, closed)

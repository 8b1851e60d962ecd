"""Compute the forces of fill on blocks: its weight, its pressure, and loads that spread through it."""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from masonry_opt.brief import brief
from masonry_opt.errors import CaseError
from masonry_opt.problem.limited_forces import Action, LimitedForce, Role
from masonry_opt.problem.loads import LoadedPiece, along, resultants
from masonry_opt.scene.geometry import Geometry, Profile, profile_below
from masonry_opt.scene.loads import LOAD_KINDS
from masonry_opt.scene.road import Fill
from masonry_opt.scene.scene import Scene

#: Largest rise of an edge, relative to its length, at which the edge counts as level. With a smaller value,
#: earth pressure would act on level edges whose coordinates are rounded.
_LEVEL_EDGE_TOLERANCE = 1e-9

#: Number of Gauss points in each piece of a uniform load on a road. With more points, loads that spread
#: through fill are more accurate but take longer to compute.
_GAUSS_POINT_COUNT = 4
#: Number of equal parts into which a road over fill is divided for uniform loads. With more parts, loads that
#: spread through fill are more accurate but take longer to compute.
_ROAD_DIVISIONS = 200
#: Points and weights of the Gauss–Legendre rule on the interval from −1 to 1.
_GAUSS_RULE = np.polynomial.legendre.leggauss(_GAUSS_POINT_COUNT)


@dataclass(frozen=True)
class FilledPiece:
    """Straight piece of a block's edge that a fill touches, below a straight piece of the road."""

    fill: int  #: index in the scene's fills
    block: int  #: index in the scene's blocks
    edge: int  #: index in the geometry's edges
    #: Ends of the piece, relative to the geometry's origin, shape (2, 2). The block is on the left of the
    #: line from the first to the second end.
    ends: np.ndarray
    depth: np.ndarray  #: depth of both ends of the piece below the road, shape (2,)
    stress: np.ndarray  #: vertical stress σ from the fill at both ends of the piece, shape (2,)
    zone: int = 0  #: zone of the fill that touches the piece: 0 for the soil, 1 for its backing

    __repr__ = brief

    @property
    def height(self) -> float:
        """Return the difference in height between the ends of the piece, or 0 if the piece is level."""
        up = abs(float(self.ends[1, 1] - self.ends[0, 1]))
        length = float(np.hypot(*(self.ends[1] - self.ends[0])))
        return up if up > _LEVEL_EDGE_TOLERANCE * length else 0.0

    @property
    def weight(self) -> float:
        """Return the weight of the fill above the piece, per unit thickness."""
        return float(self.ends[0, 0] - self.ends[1, 0]) * float(self.stress.mean())


def _called(number: int) -> str:
    """Return the name of a fill's road for error messages. ``number`` is the index of the fill."""
    return f"the road of fill no. {number + 1}"


def profile_of(scene: Scene, shapes: Geometry, number: int, road: np.ndarray | None = None) -> Profile:
    """Return the profile of the uppermost block edges below the road of a fill.

    ``number`` is the index of the fill. ``road`` is its road relative to ``shapes.origin``, by default as
    drawn. Raises CaseError if the road runs through a block, or if there is no block below a part of the
    road.
    """
    if road is None:
        road = np.array(scene.fills[number].road) - shapes.origin
    profile = profile_below(scene, shapes, road, _called(number))
    uncovered = np.flatnonzero(profile.block < 0)
    if len(uncovered):
        start, end = profile.x[uncovered[0]] + shapes.origin[0]
        raise CaseError(
            f"{scene.origin}: fill no. {number + 1} has no block below it from x = {start:.6g} to "
            f"{end:.6g}: choose a road that has blocks below it everywhere, or add a fixed block as ground"
        )
    return profile


def filled_pieces(scene: Scene, shapes: Any) -> tuple[FilledPiece, ...]:
    """Return the pieces of block edges that the fills of a scene touch, on movable and fixed blocks.

    A fill touches the uppermost edges below its road, and the upright faces between two neighbouring edges of
    different height. Raises CaseError if a fill touches no movable block, and as :func:`profile_of` does.
    """
    pieces_of_all: list[FilledPiece] = []
    for number in range(len(scene.fills)):
        profile = profile_of(scene, shapes, number)
        ends = np.stack([profile.x, profile.y], axis=2)[:, ::-1]
        below = zip(profile.edge.tolist(), ends, profile.depth[:, ::-1], strict=True)
        zones = scene.fills[number].zones
        unit_weight = zones[0].unit_weight
        owner = shapes.edges[2].tolist()
        pieces: list[FilledPiece] = []
        for edge, edge_ends, depth in [*below, *_upright_pieces(profile, shapes)]:
            if depth.max() > shapes.tolerance:
                whole = FilledPiece(number, owner[edge], edge, edge_ends, depth, unit_weight * depth)
                pieces += _in_zones(whole, zones, shapes)
        if all(scene.blocks[piece.block].fixed for piece in pieces):
            raise CaseError(
                f"{scene.origin}: fill no. {number + 1} touches no movable block: its road lies directly on "
                "the blocks or only over fixed blocks; move the road above movable blocks"
            )
        pieces_of_all += pieces
    return tuple(pieces_of_all)


def _in_zones(whole: FilledPiece, zones: tuple[Fill, ...], shapes: Geometry) -> Iterator[FilledPiece]:
    """Split a piece of an edge into parts, each of which touches either the soil or the backing of a fill.

    The piece is cut where the upper line of the backing bends, ends or crosses the piece.
    """
    if len(zones) == 1:
        yield whole
        return
    line = np.array(zones[1].road) - shapes.origin
    ends = whole.ends
    depth = whole.depth
    across, up = ends[1] - ends[0]
    start = ends[0, 0]
    # A backing may end at the abscissa of an upright face. It touches the face only if it lies on the side of
    # the fill, to the right of the directed face. Therefore test a point slightly to the right.
    offset = np.sign(up) * shapes.tolerance if abs(across) <= shapes.tolerance else 0.0
    bends = (line[:, 0] - start) / across if across else np.empty(0)
    cuts = np.unique([0.0, 1.0, *bends[(bends > 0) & (bends < 1)]])

    def line_height(share: np.ndarray) -> np.ndarray:
        """Return the height of the backing's upper line above points of the piece.

        ``share`` has the positions of the points, from 0 at the start of the piece to 1 at its end.
        """
        x, y = ends[0, :, None] + np.outer(ends[1] - ends[0], share)
        return np.interp(x, *line.T) - y

    low = line_height(cuts[:-1])
    high = line_height(cuts[1:])
    crosses = low * high < 0
    crossings = cuts[:-1] + np.diff(cuts) * low / np.where(crosses, low - high, 1.0)
    cuts = np.unique([*cuts, *crossings[crosses]])
    for share in np.stack([cuts[:-1], cuts[1:]], axis=1):
        at = ends[0] + np.outer(share, ends[1] - ends[0])
        below = depth[0] + share * (depth[1] - depth[0])
        middle = at[:, 0].mean() + offset
        height = line_height(share)
        backed = bool(height.sum() > 0 and line[0, 0] <= middle <= line[-1, 0])
        # Compute the height of the backing above both ends of the piece. Soil fills the remaining depth.
        height = np.minimum(np.maximum(height, 0.0), below) if backed else np.zeros(2)
        stress = zones[0].unit_weight * (below - height) + zones[1].unit_weight * height
        yield replace(whole, ends=at, depth=below, stress=stress, zone=int(backed))


def _upright_pieces(profile: Profile, shapes: Geometry) -> Iterator[tuple[int, np.ndarray, np.ndarray]]:
    """Generate the pieces of vertical edges that touch the fill.

    The values are the index of the edge, the ends of the piece, and the depths of the ends below the road.
    """
    tail, tip, _ = shapes.edges
    up = tip[:, 1] > tail[:, 1]
    # Heights of the profile just to the left and to the right of each end of its pieces. There is no fill
    # beyond the ends of the road: an infinite height bounds the fill there, as a wall would.
    left = np.append(np.inf, profile.y[:, 1])
    right = np.append(profile.y[:, 0], np.inf)
    x = np.append(profile.x[:, 0], profile.x[-1, 1])
    road = np.append(profile.line[:, 0], profile.line[-1, 1])
    bottom, top = np.minimum(left, right), np.minimum(np.maximum(left, right), road)
    for k in np.flatnonzero(top - bottom > shapes.tolerance):
        foot = np.array([x[k], bottom[k]])
        edge, spans = along(tail, tip, foot, np.array([x[k], top[k]]), shapes.tolerance)
        # A block is on the left of its directed edges. If the fill is at larger x than an upright edge, the
        # edge therefore runs upwards.
        facing = up[edge] == (right[k] < left[k])
        for number, span in zip(edge[facing].tolist(), spans[facing], strict=True):
            height = bottom[k] + (span if right[k] < left[k] else span[::-1])
            ends = np.column_stack([np.full(2, x[k]), height])
            yield number, ends, np.maximum(road[k] - height, 0.0)


def fill_forces(scene: Scene, shapes: Any, pieces: tuple[FilledPiece, ...]) -> dict[str, np.ndarray]:
    """Return the dead and the live forces and moments on each block from the weight of fills.

    The result has the arrays "dead" and "live", shape (blocks, 3) each, in the scene's units. In an
    earthquake the mass of the fill pushes the blocks too.
    """
    factor = {kind: scene.factor(kind, "fill") for kind in LOAD_KINDS}
    per_weight = {kind: times * scene.down for kind, times in factor.items() if times}
    shaking = scene.shaking
    if shaking is not None:
        per_weight["live"] = max(0.0, factor["dead"]) * shaking
    loaded = []
    for piece in pieces:
        across, up = piece.ends[1] - piece.ends[0]
        if scene.fills[piece.fill].weight and across:
            # An inclined piece carries the fill above its horizontal projection.
            per_length = scene.thickness * piece.stress * abs(across) / np.hypot(across, up)
            for kind, direction in per_weight.items():
                acting = np.outer(per_length, direction)
                loaded.append(LoadedPiece(piece.fill, piece.block, kind, piece.ends, acting))
    return resultants(shapes, loaded)


def pressures(scene: Scene, pieces: tuple[FilledPiece, ...]) -> Iterator[LimitedForce]:
    """Generate the earth pressure on each inclined or upright piece of an edge, as a horizontal force.

    Only pieces of movable blocks have such a force. It lies between K_a and m K_p times the vertical stress
    over the height of the piece (Rankine). The factor of the load case multiplies both limits.
    """
    for piece in pieces:
        fill, block, height = scene.fills[piece.fill], scene.blocks[piece.block], piece.height
        if fill.pressure and not block.fixed and height:
            vertical = scene.factor_of_pressure * scene.thickness * float(piece.stress.mean()) * height
            # Locate the resultant of the linearly varying pressure, as a fraction of the length of the piece.
            share = (piece.stress[0] + 2 * piece.stress[1]) / (3 * piece.stress.sum())
            point = (1 - share) * piece.ends[0] + share * piece.ends[1]
            # The block is on the left of its edge.
            inward = np.array([-1.0 if piece.ends[1, 1] > piece.ends[0, 1] else 1.0, 0.0])
            active, _, passive = fill.zones[piece.zone].coefficients
            name = f"fill {piece.fill + 1}|{block.name}"
            action = Action(piece.block, point, inward)
            yield LimitedForce(Role.EARTH, name, (action,), active * vertical, passive * vertical)


class Road:
    """Road above the blocks of a plane scene. The road transmits loads to the blocks.

    A load acts straight down on the uppermost block below it. On a fill that spreads loads, it spreads from
    the road of the fill. A load on a fixed block, above no block or beyond the ends of the road has no
    effect. If supports have settled, roads keep their heights above the displaced blocks.

    Parameters
    ----------
    scene : Scene
        The scene.
    shapes : Geometry
        Shapes of the blocks; those of the displaced blocks if supports have settled.
    line : sequence of points
        Points of the road as drawn, from left to right, in the scene's coordinates.
    called : str
        Name of the road in errors.
    at_rest : Geometry or None
        Shapes of the blocks before supports have settled.

    Attributes
    ----------
    line : ndarray, shape (points, 2)
        Points of the line from left to right, in the scene's coordinates.
    ends : tuple of float
        Abscissae of the ends of the line.
    breaks : ndarray
        Abscissae at which forces on blocks may jump as a load moves, with the ends.

    Raises
    ------
    CaseError
        If the road runs through a block, or no movable block lies below it. The message names the road by
        ``called``.
    """

    def __init__(
        self,
        scene: Scene,
        shapes: Geometry,
        line: Sequence[tuple[float, float]],
        called: str = "the road",
        at_rest: Geometry | None = None,
    ) -> None:
        def relative(points: Sequence[tuple[float, float]], called: str) -> np.ndarray:
            """Return the points of a road, relative to ``shapes.origin``.

            If supports have settled, the points have moved with the blocks below the road.
            """
            drawn = np.array(points, dtype=float) - shapes.origin
            return drawn if at_rest is None else scene.settled.road(scene, at_rest, drawn, called)

        self.line = relative(line, called) + shapes.origin
        self.ends = (float(line[0][0]), float(line[-1][0]))
        self._origin = float(shapes.origin[0])
        self._centroid = shapes.centroid
        profile = profile_below(scene, shapes, self.line - shapes.origin, called)
        changes = np.r_[True, profile.block[1:] != profile.block[:-1]]
        self._block = profile.block[changes]
        self._starts = np.r_[profile.x[changes, 0], profile.x[-1, 1]] + self._origin
        self._movable = ~scene.fixed
        if not self._movable[self._block[self._block >= 0]].any():
            raise CaseError(
                f"{scene.origin}: no movable block is below {called} from {list(line[0])} to "
                f"{list(line[-1])}: choose points above movable blocks"
            )
        self._fills = [
            (
                profile_of(scene, shapes, number, relative(fill.road, _called(number))),
                math.tan(math.radians(fill.spread)),
            )
            for number, fill in enumerate(scene.fills)
            if fill.spread is not False
        ]
        breaks = self._starts
        for below, _ in self._fills:
            start, end = np.clip(below.x[[0, -1], [0, 1]] + self._origin, *self.ends)
            breaks = np.r_[breaks[(breaks <= start) | (breaks >= end)], start, end]
        self.breaks = np.unique(breaks)
        pieces = [np.append(below.x[:, 0], below.x[-1, 1]) + self._origin for below, _ in self._fills]
        # If a fill spreads loads, also divide the road into equal parts, over which uniform loads are
        # integrated.
        evenly = np.linspace(*self.ends, _ROAD_DIVISIONS + 1) if self._fills else self.ends
        self._cuts = np.unique(np.concatenate([self._starts, evenly, *pieces]))

    def on_blocks(self, x: np.ndarray, load: np.ndarray) -> np.ndarray:
        """Return the resultants of vertical point loads on each of the scene's blocks, shape (blocks, 3).

        The columns are the sums of fx and fy and their moment about the centroid. The loads, shape (loads,),
        are positive downwards and act at abscissae x, shape (loads,).
        """
        total = np.zeros((len(self._centroid), 3))
        # Find the road section directly below each load. A load at a boundary between two sections belongs to
        # the section on its right.
        piece = np.searchsorted(self._starts, x, side="right") - 1
        block = self._block[np.clip(piece, 0, len(self._block) - 1)]
        at = x - self._origin
        force = -np.asarray(load, dtype=float)
        pending = (x >= self.ends[0]) & (x <= self.ends[1])

        def add(block: np.ndarray, force: np.ndarray, moment: np.ndarray) -> None:
            """Add vertical forces to blocks, with their moments about the origin of the shapes."""
            np.add.at(total[:, 1], block, force)
            np.add.at(total[:, 2], block, moment - self._centroid[block, 0] * force)

        for below, tangent in self._fills:
            on_fill = np.flatnonzero(pending & (at >= below.x[0, 0]) & (at <= below.x[-1, 1]))
            if len(on_fill):
                shares, moments = spread(below, at[on_fill], tangent)
                add(below.block, force[on_fill] @ shares, force[on_fill] @ moments)
                pending[on_fill] = False
        straight = pending & (piece >= 0) & (x <= self._starts[-1]) & (block >= 0)
        add(block[straight], force[straight], at[straight] * force[straight])
        return np.where(self._movable[:, None], total, 0.0)

    def strips_on_blocks(self, start: np.ndarray, end: np.ndarray, load: np.ndarray) -> np.ndarray:
        """Return the resultants of uniform loads on each of the scene's blocks, shape (blocks, 3).

        A uniform load acts from abscissa ``start`` to ``end`` with the intensity ``load`` per unit length,
        shape (loads,) each. It is replaced by point loads at Gauss points between the positions at which
        blocks or pieces of edges below the road end. The replacement is exact for loads that act straight
        down. Forces of loads that spread through fill have errors of less than 2e-4 of the load.
        """
        points, weights = _GAUSS_RULE
        x, shares = [np.empty(0)], [np.empty(0)]
        for first, last, intensity in zip(start, end, load, strict=True):
            cuts = self._cuts[(self._cuts > first) & (self._cuts < last)]
            ends = np.r_[first, cuts, last]
            half = np.diff(ends)[:, None] / 2
            x.append((ends[:-1, None] + half + half * points).ravel())
            shares.append((intensity * half * weights).ravel())
        return self.on_blocks(np.concatenate(x), np.concatenate(shares))


def spread(profile: Profile, x: np.ndarray, tangent: float) -> tuple[np.ndarray, np.ndarray]:
    """Distribute vertical point loads on a fill to the pieces of block edges below the fill.

    The function returns the fraction of each load that acts on each piece, and its first moment.

    A load spreads in rays to both sides, and each ray acts on the first edge that it reaches. The load is
    uniform over the tangents t of the rays to the vertical, |t| ≤ ``tangent``, so the pressure on a level
    plane is uniform. A ray that reaches an upright face or the end of the fill continues straight down.

    Parameters
    ----------
    profile : Profile
        Pieces of the edges below the line.
    x : ndarray, shape (loads,)
        Abscissae of the loads within the profile, relative to the geometry's origin.
    tangent : float
        Tangent of the angle of spread.

    Returns
    -------
    shares, moments : ndarray, shape (loads, pieces)
        Share of each load on each piece, and its first moment about x = 0, per unit of load.
    """
    ends = np.append(profile.x[:, 0], profile.x[-1, 1])
    line = np.append(profile.line[:, 0], profile.line[-1, 1])
    aside = profile.x - x[:, None, None]
    depth = np.interp(x, ends, line)[:, None, None] - profile.y
    rightward, to_right = _half(aside, depth, tangent)
    # The rays to the left are computed as rays to the right of the mirrored profile.
    mirrored = _half(-aside[:, ::-1, ::-1], depth[:, ::-1, ::-1], tangent)
    leftward, to_left = (values[:, ::-1] for values in mirrored)
    share = rightward + leftward
    return share, share * x[:, None] + to_right - to_left


def _half(u: np.ndarray, h: np.ndarray, tangent: float) -> tuple[np.ndarray, np.ndarray]:
    """Return the fraction of each load that spreads to the right onto each piece, and its first moment.

    The moment is about the load, per unit of load. Both results have shape (loads, pieces), with one entry
    for each piece of an edge.

    ``u`` and ``h`` are the horizontal and vertical distances of the near and far ends of successive pieces
    from the load, shape (loads, pieces, 2).
    """
    (u0, u1), (h0, h1) = np.moveaxis(u, 2, 0), np.moveaxis(h, 2, 0)
    # Use only the part of each piece to the right of the load. ``spread`` computes the loads on the left
    # parts by a second call, with the mirrored profile.
    near = np.maximum(u0, 0.0)
    h0 = h0 + (near - u0) / (u1 - u0) * (h1 - h0)
    u0 = near
    u1 = np.maximum(u1, near)
    du, dh = u1 - u0, h1 - h0
    u, h = np.stack([u0, u1]), np.stack([h0, h1])
    # Compute the slope of the rays from the load to both ends of each piece: the tangent of the angle from
    # the vertical. The angle of spread limits the slope.
    within = np.divide(u, h, out=np.full_like(u, tangent), where=u < tangent * h)
    t0, t1 = np.where(u > 0, within, 0.0)
    # Rays with a slope of at most `before` end on pieces nearer to the load. Rays with a slope between
    # `before` and `after` can end on this piece.
    after = np.maximum.accumulate(np.maximum(t0, t1), axis=1)
    before = np.pad(after, ((0, 0), (1, 0)))[:, :-1]
    first = np.maximum(before, t0)
    meets = after - first
    # Compute where the first and the last ray arrive on each piece: 0 at the near end, 1 at the far end.
    s0, s1 = (
        np.divide(t * h0 - u0, du - t * dh, out=np.zeros_like(t), where=meets > 0) for t in (first, after)
    )
    # Along a straight piece, the density of the rays is proportional to 1 / h². Here h is the depth below the
    # load. The resultant acts at the centroid of this density.
    at = u0 + (s0 + (s1 - s0) * _centre(h0 + s0 * dh, h0 + s1 * dh)) * du
    # Rays that end on an upright face are assigned to the far end of the last piece before the face.
    stopped = np.pad(first - before, ((0, 0), (0, 1)))[:, 1:]
    stopped[:, -1] = tangent - after[:, -1]
    return (meets + stopped) / (2 * tangent), (meets * at + stopped * u1) / (2 * tangent)


def _centre(h0: np.ndarray, h1: np.ndarray) -> np.ndarray:
    """Return the centroid s of the density 1 / h² over 0 ≤ s ≤ 1, with h linear from h0 to h1.

    The centroid is (∫ s / h² ds) / (∫ 1 / h² ds).

    A Taylor series replaces the closed form if h0 and h1 are nearly equal.
    """
    ratio = np.divide(h1, h0, out=np.ones_like(h0), where=h0 > 0)
    e = ratio - 1
    series = np.abs(e) < 1e-3
    e_or_1 = np.where(series, 1.0, e)
    closed = (ratio * np.log(np.where(ratio > 0, ratio, 1.0)) - e) / e_or_1**2
    return np.where(series, 1 / 2 - e / 6 + e**2 / 12 - e**3 / 20 + e**4 / 30, closed)

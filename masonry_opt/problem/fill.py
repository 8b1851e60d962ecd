"""Fill as forces on blocks: its weight on the edges below it, and the faces that it presses on."""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from masonry_opt.errors import CaseError
from masonry_opt.problem.limited_forces import Action, LimitedForce, Role
from masonry_opt.problem.loads import Segments, no_loads, resultant
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
    """The pieces of edges that fills of a scene touch, on fixed blocks too: the uppermost edges below the
    road, and beside an edge that stands higher than the next its upright face. Raises CaseError if a fill
    touches no movable block, and as :func:`profile_of` does."""
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
    edges = Segments(*shapes.edges)
    up = edges.tip[:, 1] > edges.tail[:, 1]
    # Beyond the ends of the road there is no fill.
    left = np.append(np.inf, profile.y[:, 1])
    right = np.append(profile.y[:, 0], np.inf)
    x = np.append(profile.x[:, 0], profile.x[-1, 1])
    road = np.append(profile.line[:, 0], profile.line[-1, 1])
    bottom, top = np.minimum(left, right), np.minimum(np.maximum(left, right), road)
    for k in np.flatnonzero(top - bottom > shapes.tolerance):
        foot = np.array([x[k], bottom[k]])
        edge, spans = edges.along(foot, np.array([x[k], top[k]]), shapes.tolerance)
        # The block lies to the left of its edges: seen from a fill to their right they run upwards.
        facing = up[edge] == (right[k] < left[k])
        for number, span in zip(edge[facing].tolist(), spans[facing], strict=True):
            height = bottom[k] + (span if right[k] < left[k] else span[::-1])
            ends = np.column_stack([np.full(2, x[k]), height])
            yield number, ends, np.maximum(road[k] - height, 0.0)


def fill_forces(scene: Scene, shapes: Any, pieces: tuple[FilledPiece, ...]) -> dict[str, np.ndarray]:
    """Force and moment about the centroid that the weight of fills gives each of the scene's blocks, by kind
    "dead" and "live", shape (blocks, 3), in the scene's units; in an earthquake its mass on blocks too."""
    forces = no_loads(shapes)
    factor = {kind: scene.factor(kind, "fill") for kind in KINDS}
    per_weight = {kind: times * scene.down for kind, times in factor.items() if times}
    if (shaking := scene.shaking) is not None:
        per_weight["live"] = max(0.0, factor["dead"]) * shaking
    for piece in pieces:
        fill, (across, up) = scene.fills[piece.fill], piece.ends[1] - piece.ends[0]
        if fill.weight and across:
            # Columns of fill stand on the piece's plan.
            per_length = scene.thickness * piece.stress * abs(across) / np.hypot(across, up)
            for kind, direction in per_weight.items():
                acting = resultant(piece.ends, np.outer(per_length, direction), shapes.centroid[piece.block])
                forces[kind][piece.block] += acting
    return forces


def pressures(scene: Scene, pieces: tuple[FilledPiece, ...]) -> Iterator[LimitedForce]:
    """What fills press with, horizontally, on each piece of edge of a movable block that is not level:
    between K_a and m K_p times what stands above, summed over the piece's height, where that sum has its
    centre (Rankine); both times the factor of the load case."""
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

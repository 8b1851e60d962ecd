"""The forces on the movable blocks of a scene, and the points where they act."""

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from masonry_opt.errors import CaseError
from masonry_opt.scene.contacts.joints import Joints
from masonry_opt.scene.contacts.sides import LEAN
from masonry_opt.scene.geometry import Extents
from masonry_opt.scene.loads import KINDS, EdgeLoad, Kind
from masonry_opt.scene.rows import spaces
from masonry_opt.scene.scene import Scene


class _Given(NamedTuple):
    """A force: row of its block, where it acts (None: the centroid), and the mass that pushes there in an
    earthquake (None: what of the force is along gravity)."""

    row: int
    force: np.ndarray
    at: Sequence[float] | None
    mass: float | None


@dataclass(frozen=True)
class Forces:
    """Forces of one kind, none of them zero. Several may act on one block."""

    block: np.ndarray  #: which of the movable blocks each acts on, shape (f,)
    force: np.ndarray  #: in the case's unit of force, shape (f, dim)
    point: np.ndarray  #: where it acts, relative to the origin of the shapes, shape (f, dim)
    couple: np.ndarray  #: moments on each movable block beside these forces', shape (b, 1), in space (b, 3)

    def about(self, centroid: np.ndarray) -> np.ndarray:
        """Their sums on the blocks, and their moments about the blocks' centroids, shape (3b,): fx, fy, m of
        each block; in space (6b,): fx, fy, fz, mx, my, mz."""
        moment = moment_of(self.point - centroid[self.block], self.force)
        total = np.hstack([np.zeros_like(centroid), self.couple])
        np.add.at(total, self.block, np.column_stack([self.force, moment]))
        return total.ravel()


def moment_of(arm: np.ndarray, force: np.ndarray) -> np.ndarray:
    """Moments of forces with these arms, shape (f, dim) each: shape (f, 1), in space (f, 3)."""
    dimension = arm.shape[1]
    arm, force = (np.pad(of, ((0, 0), (0, 3 - dimension))) for of in (arm, force))
    return np.asarray(np.cross(arm, force)[:, -moments_in(dimension) :])


def moments_in(dimension: int) -> int:
    """Components of a moment: one for each pair of axes."""
    return dimension * (dimension - 1) // 2


def by_component(dimension: int, of_force: float, of_moment: float) -> np.ndarray:
    """One number for each component of a force, another of a moment, shape (3,), in space (6,)."""
    return np.repeat([of_force, of_moment], [dimension, moments_in(dimension)])


@dataclass(frozen=True)
class Loads:
    """Forces on the movable blocks of a scene, without those of edge loads, as its load case says: weights,
    further dead forces, and live ones, which in a scene that is tilted are the weights, turned a quarter from
    gravity, and in an earthquake the masses times its direction."""

    weight: Forces
    dead: Forces
    live: Forces


def weights(scene: Scene, shapes: Extents, movable: np.ndarray) -> np.ndarray:
    """Weights of the blocks with these indices, shape (b,)."""
    instead = {load.block: load.weight for load in scene.loads if load.weight is not None}
    blocks = [scene.blocks[index] for index in movable]
    sized = zip(blocks, shapes.size[movable] * scene.thickness, strict=True)
    return np.array([instead.get(block.name, block.weight_of(size)) for block, size in sized])


def loads(scene: Scene, shapes: Extents, movable: np.ndarray) -> Loads:
    """The loads of the blocks with these indices."""
    blocks = [scene.blocks[index] for index in movable]
    row_of = {block.name: row for row, block in enumerate(blocks)}
    weight, down, quake = weights(scene, shapes, movable), scene.down, scene.shaken_by
    # The mass of forces that are no weights, where none is given.
    unsaid = None if quake is None or quake.dead_as_mass else 0.0

    def of_weights(times: Sequence[Sequence[float] | np.ndarray], mass: float | None = None) -> list[_Given]:
        each = zip(blocks, weight[:, None] * np.array(times), strict=True)
        return [_Given(row, force, block.weight_at, mass) for row, (block, force) in enumerate(each)]

    # By what they are given as, and their group.
    given: dict[tuple[str, str | None], list[_Given]] = {("weight", None): of_weights([down] * len(blocks))}
    for kind in ("dead", "live"):
        own = enumerate((np.array(getattr(block, kind)), getattr(block, f"{kind}_at")) for block in blocks)
        given[kind, None] = [_Given(row, force, at, unsaid) for row, (force, at) in own]
    for load in scene.loads:
        told = unsaid if load.mass is None else load.mass
        acted = {kind: force for kind in ("dead", "live") if (force := getattr(load, kind)) is not None}
        for kind, force in (acted or {"dead": 0.0 * down}).items():
            among = given.setdefault((kind, load.group), [])
            among.append(_Given(row_of[load.block], np.array(force), load.at, told))
            told = None if told is None else 0.0  # of two forces the dead one has it
    given["live", None] += of_weights([block.live_per_weight for block in blocks], unsaid)

    def couples(kind: Kind) -> np.ndarray:
        none = (0.0,) * moments_in(len(down))
        total = np.zeros((len(blocks), len(none)))
        for given_as in ("dead", "live"):
            key = f"{given_as}_moment"
            own = np.array([getattr(block, key, none) for block in blocks])
            total += scene.factor(kind, given_as) * own
            for load in scene.loads:
                factor = scene.factor(kind, given_as, load.group)
                total[row_of[load.block]] += factor * np.array(getattr(load, key) or none)
        return total

    def forces(kind: str, couple: np.ndarray) -> Forces:
        acting = [one for one in listed[kind] if one.force.any()]
        row = np.array([one.row for one in acting], dtype=int)
        point = shapes.centroid[movable[row]]
        for number, one in enumerate(acting):
            if one.at is not None:
                point[number] = np.array(one.at) - shapes.origin
        force = np.array([one.force for one in acting], dtype=float).reshape(point.shape)
        return Forces(row, force, point, couple)

    listed: dict[str, list[_Given]] = {"weight": [], "dead": [], "live": []}
    for group, entries in given.items():
        dead, live = scene.factor("dead", *group), scene.factor("live", *group)
        of_dead = listed["weight" if group[0] == "weight" else "dead"]
        of_dead += [one._replace(force=dead * one.force) for one in entries if dead]
        listed["live"] += [one._replace(force=live * one.force) for one in entries if live]
        if dead and (shaking := scene.shaking) is not None:
            masses = (float(down @ one.force) if one.mass is None else one.mass for one in entries)
            pushes = [max(0.0, dead * mass) * shaking for mass in masses]
            listed["live"] += [one._replace(force=of) for one, of in zip(entries, pushes, strict=True)]
    if (sideways := scene.tilt_direction) is not None:
        listed["live"] = of_weights([sideways] * len(blocks))
    none = np.zeros((len(blocks), moments_in(len(down))))
    return Loads(forces("weight", none), forces("dead", couples("dead")), forces("live", couples("live")))


@dataclass(frozen=True)
class LoadedPiece:
    """A free piece of a block's edge with its load, which is linear between the ends."""

    load: int  #: index into the scene's edge loads, or fills
    block: int  #: index into the scene's blocks
    kind: Kind  #: "dead" or "live", as which it acts
    ends: np.ndarray  #: of the piece, relative to the geometry's origin, shape (2, 2)
    intensity: np.ndarray  #: force per unit length at these ends, over the scene's thickness, shape (2, 2)


def resultants(shapes: Extents, pieces: Iterable[LoadedPiece]) -> dict[str, np.ndarray]:
    """Force and moment about the centroid that loads on edges give each of the scene's blocks, by kind, shape
    (blocks, 3), in the scene's units; in space, where there are none, (blocks, 6)."""
    blocks, dimension = shapes.centroid.shape
    columns = dimension + moments_in(dimension)
    total: dict[str, np.ndarray] = {kind: np.zeros((blocks, columns)) for kind in KINDS}
    for piece in pieces:
        ends, intensity = piece.ends, piece.intensity
        line, length = ends[1] - ends[0], np.hypot(*(ends[1] - ends[0]))
        force, arm = length * intensity.mean(axis=0), ends.mean(axis=0) - shapes.centroid[piece.block]
        # What grows along the piece turns about its middle.
        growing = length / 12 * (intensity[1] - intensity[0])
        moment = arm[0] * force[1] - arm[1] * force[0] + line[0] * growing[1] - line[1] * growing[0]
        total[piece.kind][piece.block] += [*force, moment]
    return total


def along(
    tail: np.ndarray, tip: np.ndarray, start: np.ndarray, end: np.ndarray, tolerance: float
) -> tuple[np.ndarray, np.ndarray]:
    """Which segments, of ends (segments, 2), run along a line, and where on it they do, shape (found, 2)."""
    line = end - start
    length = np.hypot(*line)
    ahead, across = line / length, np.array([-line[1], line[0]]) / length
    x0, x1 = (tail - start) @ ahead, (tip - start) @ ahead
    y0, y1 = (tail - start) @ across, (tip - start) @ across
    low, high = np.maximum(np.minimum(x0, x1), 0.0), np.minimum(np.maximum(x0, x1), length)
    slope = np.divide(y1 - y0, x1 - x0, out=np.full_like(y0, np.inf), where=x1 != x0)
    found = np.flatnonzero(high - low > tolerance)
    # Distance from the line at both ends of the shared part.
    ends = np.column_stack([low, high])[found]
    away = np.abs(y0[found, None] + slope[found, None] * (ends - x0[found, None])).max(axis=1, initial=0)
    near = away <= np.minimum(tolerance, LEAN * (high - low)[found])
    return found[near], ends[near]


def loaded_pieces(
    scene: Scene, shapes: Any, joints: Joints
) -> tuple[tuple[LoadedPiece, ...], tuple[float, ...]]:
    """The pieces of edges on which edge loads act, and of each load's line the length that meets no free edge
    of a movable block, where it does nothing.

    A line's load acts on the edges of movable blocks that lie on it within the tolerance, less what joints
    cover of them. Raises CaseError if a load's line is shorter than the tolerance, or meets no free edge of a
    movable block, with what lies there instead.
    """
    if not scene.edge_loads:
        return (), ()
    tail, tip, owner = shapes.edges
    # What joints cover, for either of their blocks.
    covers = np.tile(joints.start, (2, 1)), np.tile(joints.end, (2, 1))
    covers_of = np.concatenate([joints.first, joints.second])
    bare, pieces, fixed = [], [], scene.fixed
    for number, load in enumerate(scene.edge_loads, start=1):
        start, end = np.array(load.start) - shapes.origin, np.array(load.end) - shapes.origin
        length = float(np.hypot(*(end - start)))
        if length <= shapes.tolerance:
            raise CaseError(
                f"{scene.origin}: edge_load no. {number}: its line is no longer than what is nothing in this "
                f"scene, {shapes.tolerance:.3g}: give the two ends of the loaded edge"
            )
        found, spans = along(tail, tip, start, end, shapes.tolerance)
        movable = ~fixed[owner[found]]
        # A joint runs between the edges of its blocks, up to half the tolerance off each.
        covering, covered = along(*covers, start, end, 2 * shapes.tolerance)
        met: list[tuple[float, float]] = []
        for edge, span in zip(found[movable], spans[movable], strict=True):
            block = owner[edge]
            free = spaces(span[0], span[1], covered[covers_of[covering] == block], shapes.tolerance)
            met += free
            for piece in free:
                direction = tip[edge] - tail[edge]
                intensity = scene.thickness * _intensity(load, np.array(piece) / length, direction)
                ends = start + np.outer(piece, (end - start) / length)
                for kind, acting in _acting(scene, load, intensity).items():
                    if acting.any():
                        pieces.append(LoadedPiece(number - 1, int(block), kind, ends, acting))
        if not met:
            raise _nothing_there(scene, number, length, bool(movable.any()), bool(len(found)))
        bare.append(math.fsum(high - low for low, high in spaces(0.0, length, met, shapes.tolerance)))
    return tuple(pieces), tuple(bare)


def _intensity(load: EdgeLoad, at: np.ndarray, edge: np.ndarray) -> np.ndarray:
    """Force per unit length at shares of the load's line, on an edge of that direction, shape (points, 2)."""
    if load.force is not None:
        return np.tile(load.force, (len(at), 1))
    first, last = np.broadcast_to(load.pressure or 0.0, 2)
    inward = np.array([-edge[1], edge[0]]) / np.hypot(*edge)
    return np.outer(first + (last - first) * at, inward)


def _acting(scene: Scene, load: EdgeLoad, intensity: np.ndarray) -> dict[Kind, np.ndarray]:
    """What of an intensity, shape (points, 2), acts as dead and as live."""
    factor = {kind: scene.factor(kind, load.kind, load.group) for kind in KINDS}
    acting = {kind: times * intensity for kind, times in factor.items() if times}
    if (shaking := scene.shaking) is not None and (quake := scene.shaken_by):
        along = float(scene.down @ load.force) if load.force and quake.dead_as_mass else 0.0
        mass = max(0.0, factor["dead"] * (along if load.mass is None else load.mass))
        push = np.tile(scene.thickness * mass * shaking, (len(intensity), 1))
        acting["live"] = acting.get("live", 0.0) + push
    return acting


def _nothing_there(scene: Scene, number: int, length: float, movable: bool, fixed: bool) -> CaseError:
    load = scene.edge_loads[number - 1]
    if movable:
        why = "the edges there are covered by other blocks: load a free edge, or a block in a [[load]]"
    elif fixed:
        why = "only fixed blocks have an edge there, and carry no load: load a movable block"
    else:
        why = "no block has an edge there: give two points of one, raise 'tolerance', or write a [[load]]"
    return CaseError(
        f"{scene.origin}: edge_load no. {number} from {list(load.start)} to {list(load.end)}: its whole "
        f"length of {length:.6g} meets no free edge of a movable block: {why}"
    )

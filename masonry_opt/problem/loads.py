"""Compute the forces on the movable blocks of a scene, and their points of action."""

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from masonry_opt.brief import brief
from masonry_opt.errors import CaseError, rounded
from masonry_opt.scene.contacts.joints import Joints
from masonry_opt.scene.contacts.sides import SMALL_LENGTH_RATIO
from masonry_opt.scene.geometry import Extents, Geometry, with_closed_gaps
from masonry_opt.scene.loads import LOAD_KINDS, EdgeLoad, Kind
from masonry_opt.scene.rows import dots, lengths, spaces
from masonry_opt.scene.scene import Scene
from masonry_opt.scene.solids import AnyBlock

#: Key of forces that are collected in one list: their kind in the scene ("weight", "dead" or "live") and the
#: name of their load group, or None.
_Group = tuple[str, str | None]


class _GivenForce(NamedTuple):
    """Force on a block as specified in the scene, not multiplied by the factors of the load case."""

    row: int  #: index of the force's block among the movable blocks
    force: np.ndarray  #: force vector, shape (dim,)
    at: Sequence[float] | None  #: point of action; None for the centroid
    #: Weight that an earthquake accelerates, in units of force. None stands for the component of the force
    #: along gravity.
    mass: float | None


@dataclass(frozen=True)
class Forces:
    """Nonzero forces of one kind (weight, dead or live) on movable blocks.

    Several forces may act on one block.
    """

    block: np.ndarray  #: index of the movable block on which each force acts, shape (f,)
    force: np.ndarray  #: vector of each force, in the scene's unit of force, shape (f, dim)
    #: point of action of each force, relative to ``assembly.geometry.origin``, shape (f, dim)
    point: np.ndarray
    couple: np.ndarray  #: additional moment on each movable block, shape (b, 1); in space (b, 3)

    __repr__ = brief

    def about(self, centroid: np.ndarray) -> np.ndarray:
        """Return the resultant of the forces on each block about its centroid, shape (3b,).

        Each block has fx, fy and m; in space fx, fy, fz, mx, my and mz, shape (6b,).
        """
        moment = moment_of(self.point - centroid[self.block], self.force)
        total = np.hstack([np.zeros_like(centroid), self.couple])
        np.add.at(total, self.block, np.column_stack([self.force, moment]))
        return total.ravel()


def moment_of(arm: np.ndarray, force: np.ndarray) -> np.ndarray:
    """Return the moments of forces with given lever arms, shape (f, 1), in space (f, 3).

    Arms and forces have shape (f, dim).
    """
    dimension = arm.shape[1]
    arm, force = (np.pad(vectors, ((0, 0), (0, 3 - dimension))) for vectors in (arm, force))
    return np.asarray(np.cross(arm, force)[:, -moments_in(dimension) :])


def moments_in(dimension: int) -> int:
    """Return the number of components of a moment vector: one in the plane, three in space."""
    return dimension * (dimension - 1) // 2


def by_component(dimension: int, of_force: float, of_moment: float) -> np.ndarray:
    """Return an array with one value for all force components and another for all moment components.

    The shape is (3,) in the plane and (6,) in space.
    """
    return np.repeat([of_force, of_moment], [dimension, moments_in(dimension)])


@dataclass(frozen=True)
class Loads:
    """Forces on the movable blocks of a scene in its load case, without edge loads and fills.

    - ``weight``: the weights of the blocks.
    - ``dead``: further dead forces.
    - ``live``: live forces. In a tilted scene they are the weights, turned by 90° from gravity. In an
      earthquake they are the masses times the ground acceleration.
    """

    weight: Forces
    dead: Forces
    live: Forces

    __repr__ = brief


def weights(scene: Scene, shapes: Extents, movable: np.ndarray) -> np.ndarray:
    """Return the weights of the blocks with the indices ``movable``, shape (b,)."""
    instead = {load.block: load.weight for load in scene.loads if load.weight is not None}
    blocks = [scene.blocks[index] for index in movable]
    sized = zip(blocks, shapes.size[movable] * scene.thickness, strict=True)
    return np.array([instead.get(block.name, block.weight_of(size)) for block, size in sized])


def loads(scene: Scene, shapes: Extents, movable: np.ndarray) -> Loads:
    """Return the loads on the blocks with the indices ``movable``, in the scene's load case."""
    blocks = [scene.blocks[index] for index in movable]
    weight = weights(scene, shapes, movable)
    factored = _factored_forces(scene, _given_forces(scene, blocks, weight))
    sideways = scene.tilt_direction
    if sideways is not None:
        factored["live"] = _weight_forces(blocks, weight, [sideways] * len(blocks))
    no_couples = np.zeros((len(blocks), moments_in(scene.dimension)))
    couples = {
        "weight": no_couples,
        "dead": _couples(scene, blocks, "dead"),
        "live": _couples(scene, blocks, "live"),
    }
    forces = {kind: _forces(factored[kind], couple, shapes, movable) for kind, couple in couples.items()}
    return Loads(forces["weight"], forces["dead"], forces["live"])


def _given_forces(
    scene: Scene, blocks: Sequence[AnyBlock], weight: np.ndarray
) -> dict[_Group, list[_GivenForce]]:
    """Return the forces specified in the scene, by kind and load group.

    The factors of the load case are not applied.
    """
    row_of = {block.name: row for row, block in enumerate(blocks)}
    down = scene.down
    default_mass = _default_mass(scene)
    groups: dict[_Group, list[_GivenForce]] = {
        ("weight", None): _weight_forces(blocks, weight, [down] * len(blocks))
    }
    for kind in ("dead", "live"):
        groups[kind, None] = [
            _GivenForce(row, np.array(getattr(block, kind)), getattr(block, f"{kind}_at"), default_mass)
            for row, block in enumerate(blocks)
        ]
    for load in scene.loads:
        mass = default_mass if load.mass is None else load.mass
        forces = {kind: getattr(load, kind) for kind in ("dead", "live") if getattr(load, kind) is not None}
        for kind, force in (forces or {"dead": 0.0 * down}).items():
            entries = groups.setdefault((kind, load.group), [])
            entries.append(_GivenForce(row_of[load.block], np.array(force), load.at, mass))
            if mass is not None:
                mass = 0.0  # count the mass only once if the load has a dead and a live force
    per_weight = [block.live_per_weight for block in blocks]
    groups["live", None] += _weight_forces(blocks, weight, per_weight, default_mass)
    return groups


def _default_mass(scene: Scene) -> float | None:
    """Return the mass that moves with a load in an earthquake, for loads that specify no mass.

    None means that the mass is the component of the force along gravity; 0 means no mass.
    """
    earthquake = scene.shaken_by
    return None if earthquake is None or earthquake.dead_as_mass else 0.0


def _weight_forces(
    blocks: Sequence[AnyBlock],
    weight: np.ndarray,
    multiples: Sequence[Sequence[float] | np.ndarray],
    mass: float | None = None,
) -> list[_GivenForce]:
    """Return one force for each block: its weight times a given vector, at the weight's point of action."""
    forces = weight[:, None] * np.array(multiples)
    return [
        _GivenForce(row, force, block.weight_at, mass)
        for row, (block, force) in enumerate(zip(blocks, forces, strict=True))
    ]


def _factored_forces(scene: Scene, groups: dict[_Group, list[_GivenForce]]) -> dict[str, list[_GivenForce]]:
    """Multiply weights, other dead forces and live forces by the factors of the load case.

    In an earthquake the live forces are the masses times the ground acceleration.
    """
    factored: dict[str, list[_GivenForce]] = {"weight": [], "dead": [], "live": []}
    for (kind, group), entries in groups.items():
        dead = scene.factor("dead", kind, group)
        live = scene.factor("live", kind, group)
        if dead:
            dead_entries = factored["weight" if kind == "weight" else "dead"]
            dead_entries += [entry._replace(force=dead * entry.force) for entry in entries]
        if live:
            factored["live"] += [entry._replace(force=live * entry.force) for entry in entries]
        shaking = scene.shaking
        if dead and shaking is not None:
            for entry in entries:
                mass = scene.down @ entry.force if entry.mass is None else entry.mass
                factored["live"].append(entry._replace(force=max(0.0, dead * mass) * shaking))
    return factored


def _couples(scene: Scene, blocks: Sequence[AnyBlock], kind: Kind) -> np.ndarray:
    """Return the dead or live moment on each block as specified in the scene, shape (b, 1) or (b, 3)."""
    row_of = {block.name: row for row, block in enumerate(blocks)}
    none = (0.0,) * moments_in(scene.dimension)
    total = np.zeros((len(blocks), len(none)))
    for given_as in ("dead", "live"):
        key = f"{given_as}_moment"
        of_blocks = np.array([getattr(block, key, none) for block in blocks])
        total += scene.factor(kind, given_as) * of_blocks
        for load in scene.loads:
            factor = scene.factor(kind, given_as, load.group)
            total[row_of[load.block]] += factor * np.array(getattr(load, key) or none)
    return total


def _forces(
    entries: Sequence[_GivenForce], couple: np.ndarray, shapes: Extents, movable: np.ndarray
) -> Forces:
    """Return the nonzero forces of one kind, with their points of action."""
    acting = [entry for entry in entries if entry.force.any()]
    row = np.array([entry.row for entry in acting], dtype=int)
    point = shapes.centroid[movable[row]]
    for number, entry in enumerate(acting):
        if entry.at is not None:
            point[number] = np.array(entry.at) - shapes.origin
    force = np.array([entry.force for entry in acting], dtype=float).reshape(point.shape)
    return Forces(row, force, point, couple)


@dataclass(frozen=True)
class LoadedPiece:
    """Free piece of a block's edge with a load that varies linearly between its ends."""

    load: int  #: index of the load among the scene's edge loads, or of the fill among the scene's fills
    block: int  #: index of the block in the scene's list of blocks
    kind: Kind  #: "dead" or "live"
    ends: np.ndarray  #: ends of the piece, relative to the geometry's origin, shape (2, 2)
    #: Force per unit length at both ends, for the whole thickness of the scene, shape (2, 2).
    intensity: np.ndarray

    __repr__ = brief


def resultants(shapes: Extents, pieces: Iterable[LoadedPiece]) -> dict[str, np.ndarray]:
    """Return the dead and the live resultants of edge loads on each block, about its centroid.

    The result has the arrays "dead" and "live", shape (blocks, 3) each, in the scene's units. In space, where
    edges carry no loads, the shape is (blocks, 6).
    """
    blocks, dimension = shapes.centroid.shape
    columns = dimension + moments_in(dimension)
    total: dict[str, np.ndarray] = {kind: np.zeros((blocks, columns)) for kind in LOAD_KINDS}
    for piece in pieces:
        ends, intensity = piece.ends, piece.intensity
        line = ends[1] - ends[0]
        length = np.hypot(*line)
        force = length * intensity.mean(axis=0)
        arm = ends.mean(axis=0) - shapes.centroid[piece.block]
        # The linearly varying part of the load has a moment about the middle of the piece.
        growing = length / 12 * (intensity[1] - intensity[0])
        moment = arm[0] * force[1] - arm[1] * force[0] + line[0] * growing[1] - line[1] * growing[0]
        total[piece.kind][piece.block] += [*force, moment]
    return total


def along(
    tail: np.ndarray, tip: np.ndarray, start: np.ndarray, end: np.ndarray, tolerance: float
) -> tuple[np.ndarray, np.ndarray]:
    """Return the segments that coincide with a line, and the part of the line that each segment covers.

    Parameters
    ----------
    tail, tip : ndarray, shape (segments, 2)
        Ends of the segments.
    start, end : ndarray, shape (2,)
        Ends of the line.
    tolerance : float
        Largest distance between segment and line. Covered parts of at most this length are left out.

    Returns
    -------
    segments : ndarray, shape (found,)
        Indices of the segments.
    spans : ndarray, shape (found, 2)
        Start and end of each covered part, as distances from the start of the line.
    """
    line = end - start
    length = np.hypot(*line)
    ahead = line / length
    across = np.array([-line[1], line[0]]) / length
    # Compute the coordinates of the segments' ends: x along the line, y perpendicular to the line.
    x0, x1 = (tail - start) @ ahead, (tip - start) @ ahead
    y0, y1 = (tail - start) @ across, (tip - start) @ across
    low, high = np.maximum(np.minimum(x0, x1), 0.0), np.minimum(np.maximum(x0, x1), length)
    slope = np.divide(y1 - y0, x1 - x0, out=np.full_like(y0, np.inf), where=x1 != x0)
    overlapping = np.flatnonzero(high - low > tolerance)
    ends = np.column_stack([low, high])[overlapping]
    # Compute each segment's distances from the line, at both ends of the part of the line that it covers.
    at_ends = y0[overlapping, None] + slope[overlapping, None] * (ends - x0[overlapping, None])
    distance = np.abs(at_ends).max(axis=1, initial=0)
    near = distance <= np.minimum(tolerance, SMALL_LENGTH_RATIO * (high - low)[overlapping])
    return overlapping[near], ends[near]


def loaded_pieces(
    scene: Scene, shapes: Any, joints: Joints
) -> tuple[tuple[LoadedPiece, ...], tuple[float, ...]]:
    """Return the loaded pieces of edges, and the length along which each edge load has no effect.

    A load acts on the edges of movable blocks along its line, within the tolerance, except where joints cover
    the edges. The load has no effect on the rest of its line, whose length is returned.

    Raises
    ------
    CaseError
        If a load's line is shorter than the tolerance, or touches no free edge of a movable block.
    """
    if not scene.edge_loads:
        return (), ()
    tail, tip, owner = _edges_over_gaps(shapes)
    # Use each joint twice, because a joint covers a part of an edge on each of its two blocks.
    joint_lines = np.tile(joints.start, (2, 1)), np.tile(joints.end, (2, 1))
    joint_blocks = np.concatenate([joints.first, joints.second])
    bare = []
    pieces = []
    fixed = scene.fixed
    for number, load in enumerate(scene.edge_loads, start=1):
        start, end = np.array(load.start) - shapes.origin, np.array(load.end) - shapes.origin
        length = float(np.hypot(*(end - start)))
        if length <= shapes.tolerance:
            raise CaseError(
                f"{scene.origin}: edge_load no. {number} is too short: its points 'from' and 'to' are at "
                f"most the tolerance of {rounded(shapes.tolerance)} apart; set them to the ends of the "
                "loaded edge"
            )
        edges, spans = along(tail, tip, start, end, shapes.tolerance)
        movable = ~fixed[owner[edges]]
        # A joint is at most half the contact tolerance away from the edges of its two blocks. The search
        # radius ``near`` is larger, so the search misses no joint.
        near = shapes.tolerance + shapes.contact_tolerance
        covering, covered = along(*joint_lines, start, end, near)
        loaded: list[tuple[float, float]] = []
        for edge, span in zip(edges[movable], spans[movable], strict=True):
            block = owner[edge]
            free = spaces(span[0], span[1], covered[joint_blocks[covering] == block], shapes.tolerance)
            loaded += free
            for piece in free:
                direction = tip[edge] - tail[edge]
                intensity = scene.thickness * _intensity(load, np.array(piece) / length, direction)
                ends = start + np.outer(piece, (end - start) / length)
                for kind, acting in _acting(scene, load, intensity).items():
                    if acting.any():
                        pieces.append(LoadedPiece(number - 1, int(block), kind, ends, acting))
        if not loaded:
            raise _nothing_there(scene, number, length, bool(movable.any()), bool(len(edges)))
        bare.append(math.fsum(high - low for low, high in spaces(0.0, length, loaded, shapes.tolerance)))
    return tuple(pieces), tuple(bare)


def _edges_over_gaps(shapes: Geometry) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return the ends of all edges, extended to the middle of gaps between blocks, and each edge's block.

    Gaps up to the contact tolerance represent mortar that is not drawn. Each edge is extended in its own
    direction, so that a load on the edge also acts on the mortar.
    """
    tail, tip, owner = shapes.edges
    if shapes.contact_tolerance <= shapes.tolerance:
        return tail, tip, owner
    closed = with_closed_gaps(tail, tip, owner, shapes.contact_tolerance)
    along_edge = (tip - tail) / lengths(tip - tail)[:, None]
    tail, tip = (
        end + dots(moved - end, along_edge)[:, None] * along_edge
        for end, moved in zip((tail, tip), closed, strict=True)
    )
    return tail, tip, owner


def _intensity(load: EdgeLoad, at: np.ndarray, edge: np.ndarray) -> np.ndarray:
    """Return the force per unit length of an edge load at positions along its line, shape (points, 2).

    ``at`` are positions from 0 at the start of the line to 1 at its end. ``edge`` is the direction of the
    loaded edge.
    """
    if load.force is not None:
        return np.tile(load.force, (len(at), 1))
    first, last = np.broadcast_to(load.pressure or 0.0, 2)
    inward = np.array([-edge[1], edge[0]]) / np.hypot(*edge)
    return np.outer(first + (last - first) * at, inward)


def _acting(scene: Scene, load: EdgeLoad, intensity: np.ndarray) -> dict[Kind, np.ndarray]:
    """Return the dead part and the live part of an edge load, shape (points, 2) each.

    In an earthquake the mass of the load contributes to the live part.
    """
    factor = {kind: scene.factor(kind, load.kind, load.group) for kind in LOAD_KINDS}
    acting = {kind: times * intensity for kind, times in factor.items() if times}
    shaking = scene.shaking
    earthquake = scene.shaken_by
    if shaking is None or earthquake is None:
        return acting
    if load.mass is not None:
        mass = load.mass
    elif load.force is not None and earthquake.dead_as_mass:
        mass = float(scene.down @ load.force)
    else:
        mass = 0.0
    shaken = max(0.0, factor["dead"] * mass)
    push = np.tile(scene.thickness * shaken * shaking, (len(intensity), 1))
    acting["live"] = acting.get("live", 0.0) + push
    return acting


def _nothing_there(scene: Scene, number: int, length: float, movable: bool, fixed: bool) -> CaseError:
    """Return the CaseError for an edge load whose line touches no free edge of a movable block."""
    load = scene.edge_loads[number - 1]
    if movable:
        why = "other blocks cover the edges on this line; load a free edge, or add a [[load]] on a block"
    elif fixed:
        why = "all edges on this line belong to fixed blocks, which carry no load; choose a movable block"
    else:
        why = (
            "no block has an edge on this line; choose points of an edge, raise 'tolerance', or use [[load]]"
        )
    return CaseError(
        f"{scene.origin}: edge_load no. {number} from {list(load.start)} to {list(load.end)} (length "
        f"{length:.6g}) touches no free edge of a movable block: {why}"
    )

"""Loads along lines to forces on blocks: which edges lie there, what of them is free, and the resultants."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from masonry_opt.errors import CaseError
from masonry_opt.scene.contact import Joints
from masonry_opt.scene.geometry import Geometry
from masonry_opt.scene.loads import EdgeLoad
from masonry_opt.scene.scene import Scene
from masonry_opt.scene.touching import LEAN


@dataclass(frozen=True)
class EdgeForces:
    """What the edge loads of a scene do to its blocks.

    Attributes
    ----------
    dead, live: force and moment about the centroid of each of the scene's blocks, shape (blocks, 3), in the
        scene's units.
    bare: of each edge load, the length of its line along which it meets no free edge of a movable block, and
        does nothing.
    pieces: where they act, but for those of no load.
    """

    dead: np.ndarray
    live: np.ndarray
    bare: tuple[float, ...]
    pieces: tuple[LoadedPiece, ...]


@dataclass(frozen=True)
class LoadedPiece:
    """A free piece of a block's edge with its load, which is linear between the ends.

    Attributes
    ----------
    load: index into the scene's edge loads.
    block: index into the scene's blocks.
    ends: of the piece, relative to the geometry's origin, shape (2, 2).
    intensity: force per unit length at these ends, over the scene's thickness, shape (2, 2).
    """

    load: int
    block: int
    ends: np.ndarray
    intensity: np.ndarray


@dataclass(frozen=True)
class _Segments:
    """Straight segments: ends, shape (segments, 2) each, and the block of each, shape (segments,)."""

    tail: np.ndarray
    tip: np.ndarray
    owner: np.ndarray

    def along(self, start: np.ndarray, end: np.ndarray, tolerance: float) -> tuple[np.ndarray, np.ndarray]:
        """Which segments run along a line, and from where to where on it, shape (found, 2)."""
        line = end - start
        length = np.hypot(*line)
        along, across = line / length, np.array([-line[1], line[0]]) / length
        x0, x1 = (self.tail - start) @ along, (self.tip - start) @ along
        y0, y1 = (self.tail - start) @ across, (self.tip - start) @ across
        low, high = np.maximum(np.minimum(x0, x1), 0.0), np.minimum(np.maximum(x0, x1), length)
        slope = np.divide(y1 - y0, x1 - x0, out=np.full_like(y0, np.inf), where=x1 != x0)
        found = np.flatnonzero(high - low > tolerance)
        # How far away the ends of what they share are.
        ends = np.column_stack([low, high])[found]
        away = np.abs(y0[found, None] + slope[found, None] * (ends - x0[found, None])).max(axis=1, initial=0)
        near = away <= np.minimum(tolerance, LEAN * (high - low)[found])
        return found[near], ends[near]


def edge_forces(scene: Scene, shapes: Geometry, joints: Joints) -> EdgeForces:
    """Resolve the scene's edge loads.

    A line's load acts on the edges of movable blocks that lie on it within the tolerance, less what joints
    cover of them, with its exact resultant and moment on each.

    Raises
    ------
    CaseError
        If a load meets no free edge of a movable block; the message says what lies there instead. If its
        line is shorter than the tolerance.
    """
    forces = {kind: np.zeros((len(scene.blocks), 3)) for kind in ("dead", "live")}
    if not scene.edge_loads:
        return EdgeForces(forces["dead"], forces["live"], (), ())
    edges, covers = _Segments(*shapes.edges()), _covers(joints)
    fixed = np.array([block.fixed for block in scene.blocks])
    bare, pieces = [], []
    for number, load in enumerate(scene.edge_loads, start=1):
        start, end = np.array(load.start) - shapes.origin, np.array(load.end) - shapes.origin
        length = float(np.hypot(*(end - start)))
        if length <= shapes.tolerance:
            raise CaseError(
                f"{scene.origin}: edge_load no. {number}: its line is no longer than what is nothing in this "
                f"scene, {shapes.tolerance:.3g}: give the two ends of the loaded edge"
            )
        found, spans = edges.along(start, end, shapes.tolerance)
        movable = ~fixed[edges.owner[found]]
        # A joint runs between the edges of its blocks, up to half the tolerance off each.
        covering, covered = covers.along(start, end, 2 * shapes.tolerance)
        met: list[tuple[float, float]] = []
        for edge, span in zip(found[movable], spans[movable], strict=True):
            block = edges.owner[edge]
            over = covered[covers.owner[covering] == block]
            free = _without(tuple(span), over, shapes.tolerance)
            met += free
            for piece in free:
                direction = edges.tip[edge] - edges.tail[edge]
                forces[load.kind][block] += scene.thickness * _resultant(
                    load, (start, end), piece, direction, shapes.centroid[block]
                )
                intensity = scene.thickness * _intensity(load, np.array(piece) / length, direction)
                ends = start + np.outer(piece, (end - start) / length)
                if intensity.any():
                    pieces.append(LoadedPiece(number - 1, int(block), ends, intensity))
        if not met:
            raise _nothing_there(scene, number, length, bool(movable.any()), bool(len(found)))
        bare.append(math.fsum(high - low for low, high in _without((0.0, length), met, shapes.tolerance)))
    return EdgeForces(forces["dead"], forces["live"], tuple(bare), tuple(pieces))


def _covers(joints: Joints) -> _Segments:
    """What joints cover, for either of their blocks."""
    both = np.concatenate([joints.first, joints.second])
    return _Segments(np.tile(joints.start, (2, 1)), np.tile(joints.end, (2, 1)), both)


def _without(
    span: tuple[float, float], covered: list[tuple[float, float]] | np.ndarray, tolerance: float
) -> list[tuple[float, float]]:
    """What intervals leave of a span, pieces longer than the tolerance."""
    pieces, at = [], span[0]
    for low, high in [*sorted(map(tuple, covered)), (span[1], span[1])]:
        if min(low, span[1]) - at > tolerance:
            pieces.append((at, float(min(low, span[1]))))
        at = max(at, high)
    return pieces


def _intensity(load: EdgeLoad, at: np.ndarray, edge: np.ndarray) -> np.ndarray:
    """Force per unit length at shares of the load's line, on an edge of that direction, shape (points, 2)."""
    if load.force is not None:
        return np.tile(load.force, (len(at), 1))
    first, last = load.at_ends
    inward = np.array([-edge[1], edge[0]]) / np.hypot(*edge)
    return np.outer(first + (last - first) * at, inward)


def _resultant(
    load: EdgeLoad,
    line: tuple[np.ndarray, np.ndarray],
    piece: tuple[float, float],
    edge: np.ndarray,
    centroid: np.ndarray,
) -> np.ndarray:
    """Force and moment about the centroid of what acts on one piece of an edge, shape (3,)."""
    start, end = line
    length = np.hypot(*(end - start))
    along = (end - start) / length
    low, high = piece
    arm = start + (low + high) / 2 * along - centroid
    if load.force is not None:
        force = (high - low) * np.array(load.force)
        return np.array([*force, arm[0] * force[1] - arm[1] * force[0]])
    first, last = load.at_ends
    at_low, at_high = (first + (last - first) * at / length for at in piece)
    inward = np.array([-edge[1], edge[0]]) / np.hypot(*edge)
    total = (high - low) * (at_low + at_high) / 2
    # A linear pressure's moment about the middle of its length.
    moment = (high - low) ** 2 * (at_high - at_low) / 12
    turning = total * (arm[0] * inward[1] - arm[1] * inward[0])
    turning += moment * (along[0] * inward[1] - along[1] * inward[0])
    return np.array([*(total * inward), turning])


def _nothing_there(scene: Scene, number: int, length: float, movable: bool, fixed: bool) -> CaseError:
    load = scene.edge_loads[number - 1]
    if movable:
        why = (
            "the edges there are covered by other blocks: load a free edge, or a block by its name and "
            "a point, in a [[load]]"
        )
    elif fixed:
        why = "only fixed blocks have an edge there, and carry no load: load a movable block"
    else:
        why = (
            "no block has an edge there: give two points of an edge, or raise 'tolerance'; a [[load]] acts "
            "inside of a block"
        )
    return CaseError(
        f"{scene.origin}: edge_load no. {number} from {list(load.start)} to {list(load.end)}: its whole "
        f"length of {length:.6g} meets no free edge of a movable block: {why}"
    )

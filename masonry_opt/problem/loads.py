"""The forces on the movable blocks of a scene, and the points where they act."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from masonry_opt.scene.load_cases import Kind
from masonry_opt.scene.scene import Scene

#: Two numbers in the plane, three in space.
_Vector = tuple[float, ...]

#: Row of the block, force, and point where it acts (None: the centroid).
_Force = tuple[int, _Vector, _Vector | None]

#: The same, and the mass that pushes there in an earthquake (None: what of the force is along gravity).
_Given = tuple[int, _Vector, _Vector | None, float | None]


class Shapes(Protocol):
    """What loads need to know of the blocks' shapes, in the plane and in space (dim is 2 or 3).

    Attributes
    ----------
    origin: shape (dim,).
    centroid: of each block, relative to ``origin``, shape (blocks, dim).
    size: of each block, what a ``unit_weight`` refers to: its area, that of a thickness of 1, or its volume,
        shape (blocks,).
    """

    @property
    def origin(self) -> np.ndarray: ...
    @property
    def centroid(self) -> np.ndarray: ...
    @property
    def size(self) -> np.ndarray: ...


def no_loads(shapes: Shapes) -> dict[str, np.ndarray]:
    """Zeros for force and moment about the centroid of each of the scene's blocks, by kind "dead" and "live",
    shape (blocks, 3), in space (blocks, 6)."""
    blocks, dimension = shapes.centroid.shape
    return {kind: np.zeros((blocks, 3 * (dimension - 1))) for kind in ("dead", "live")}


@dataclass(frozen=True)
class Forces:
    """Forces of one kind, none of them zero. Several may act on one block.

    Attributes
    ----------
    block: which of the movable blocks each acts on, shape (f,).
    force: in the case's unit of force, shape (f, dim).
    point: where it acts, relative to the origin of the shapes, shape (f, dim).
    couple: moments on each movable block beside those of the forces, shape (b, 1), in space (b, 3).
    """

    block: np.ndarray
    force: np.ndarray
    point: np.ndarray
    couple: np.ndarray

    def about(self, centroid: np.ndarray) -> np.ndarray:
        """Their sums on the blocks, and their moments about the blocks' centroids, shape (3b,): fx, fy, m of
        each block; in space (6b,): fx, fy, fz, mx, my, mz."""
        moment = moment_of(self.point - centroid[self.block], self.force)
        total = np.hstack([np.zeros_like(centroid), self.couple])
        np.add.at(total, self.block, np.column_stack([self.force, moment]))
        return total.ravel()


def moment_of(arm: np.ndarray, force: np.ndarray) -> np.ndarray:
    """Moments of forces with these arms, shape (f, dim) each: shape (f,), in space (f, 3)."""
    if arm.shape[1] == 3:
        return np.cross(arm, force)
    return arm[:, 0] * force[:, 1] - arm[:, 1] * force[:, 0]


@dataclass(frozen=True)
class Loads:
    """Forces on the movable blocks of a scene, without those of edge loads, as its load case says: weights,
    further dead forces, and live ones, which in a scene that is tilted are the weights, turned a quarter from
    gravity, and in an earthquake the masses times its direction."""

    weight: Forces
    dead: Forces
    live: Forces


def weights(scene: Scene, shapes: Shapes, movable: np.ndarray) -> np.ndarray:
    """Weights of the blocks with these indices, shape (b,)."""
    instead = {load.block: load.weight for load in scene.loads if load.weight is not None}
    blocks = [scene.blocks[index] for index in movable]
    return np.array(
        [
            instead.get(block.name, block.weight_of(size * scene.thickness))
            for block, size in zip(blocks, shapes.size[movable], strict=True)
        ]
    )


def loads(scene: Scene, shapes: Shapes, movable: np.ndarray) -> Loads:
    """The loads of the blocks with these indices."""
    blocks = [scene.blocks[index] for index in movable]
    row_of = {block.name: row for row, block in enumerate(blocks)}
    weight, down, quake = weights(scene, shapes, movable).tolist(), scene.down, scene.shaken_by
    # The mass of forces that are no weights, where none is given.
    unsaid = None if quake is None or quake.dead_as_mass else 0.0

    def of_weights(times: Iterable[_Vector], mass: float | None = None) -> list[_Given]:
        each = zip(blocks, weight, times, strict=True)
        return [
            (row, tuple(part * own for part in parts), block.weight_at, mass)
            for row, (block, own, parts) in enumerate(each)
        ]

    # By what they are given as, and their group.
    given: dict[tuple[str, str | None], list[_Given]] = {
        ("weight", None): of_weights([tuple(down.tolist())] * len(blocks))
    }
    for kind in ("dead", "live"):
        own = enumerate((getattr(block, kind), getattr(block, f"{kind}_at")) for block in blocks)
        given[kind, None] = [(row, force, at, unsaid) for row, (force, at) in own]
    for load in scene.loads:
        told = unsaid if load.mass is None else load.mass
        acted = {kind: force for kind in ("dead", "live") if (force := getattr(load, kind)) is not None}
        for kind, force in (acted or {"dead": (0.0,) * len(down)}).items():
            given.setdefault((kind, load.group), []).append((row_of[load.block], force, load.at, told))
            told = None if told is None else 0.0  # of two forces the dead one has it
    given["live", None] += of_weights([block.live_per_weight for block in blocks], unsaid)

    def acting(kind: Kind, among: Iterable[tuple[str, str | None]]) -> list[_Force]:
        return [
            (row, tuple(factor * part for part in force), at)
            for group in among
            if (factor := scene.factor(kind, *group))
            for row, force, at, _ in given[group]
        ]

    def couples(kind: Kind) -> np.ndarray:
        if scene.dimension == 2:
            return np.zeros((len(blocks), 1))
        total = np.zeros((len(blocks), 3))
        for given_as in ("dead", "live"):
            key = f"{given_as}_moment"
            moments = np.array([getattr(block, key, (0.0, 0.0, 0.0)) for block in blocks])
            total += scene.factor(kind, given_as) * moments
            for load in scene.loads:
                factor = scene.factor(kind, given_as, load.group)
                total[row_of[load.block]] += factor * np.array(getattr(load, key) or (0.0, 0.0, 0.0))
        return total

    def forces(listed: list[_Force], couple: np.ndarray) -> Forces:
        acting = [(row, force, at) for row, force, at in listed if any(force)]
        row = np.array([row for row, _, _ in acting], dtype=int)
        point = shapes.centroid[movable[row]]
        for number, (_, _, at) in enumerate(acting):
            if at is not None:
                point[number] = np.array(at) - shapes.origin
        force = np.array([force for _, force, _ in acting], dtype=float).reshape(point.shape)
        return Forces(row, force, point, couple)

    live = acting("live", given)
    if (sideways := scene.tilt_direction) is not None:
        tilted = of_weights([tuple(sideways.tolist())] * len(blocks))
        live = [(row, force, at) for row, force, at, _ in tilted]
    if (shaking := scene.shaking) is not None:
        live += [
            (row, tuple((mass * shaking).tolist()), at)
            for group, entries in given.items()
            if (factor := scene.factor("dead", *group))
            for row, force, at, told in entries
            if (mass := max(0.0, factor * (float(down @ force) if told is None else told)))
        ]
    weighing = acting("dead", [("weight", None)])
    dead = acting("dead", [group for group in given if group[0] != "weight"])
    return Loads(
        forces(weighing, np.zeros_like(couples("dead"))),
        forces(dead, couples("dead")),
        forces(live, couples("live")),
    )

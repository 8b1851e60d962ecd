"""The forces on the movable blocks of a scene, and the points where they act."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from masonry_opt.scene.extents import Extents
from masonry_opt.scene.load_cases import Kind
from masonry_opt.scene.scene import Scene


class _Given(NamedTuple):
    """A force: row of its block, where it acts (None: the centroid), and the mass that pushes there in an
    earthquake (None: what of the force is along gravity)."""

    row: int
    force: np.ndarray
    at: Sequence[float] | None
    mass: float | None


def no_loads(shapes: Extents) -> dict[str, np.ndarray]:
    """Zeros for force and moment about the centroid of each of the scene's blocks, by kind "dead" and "live",
    shape (blocks, 3), in space (blocks, 6)."""
    blocks, dimension = shapes.centroid.shape
    return {kind: np.zeros((blocks, dimension + moments_in(dimension))) for kind in ("dead", "live")}


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
    """Moments of forces with these arms, shape (f, dim) each: shape (f, 1), in space (f, 3)."""
    dimension = arm.shape[1]
    arm, force = (np.pad(of, ((0, 0), (0, 3 - dimension))) for of in (arm, force))
    moment: np.ndarray = np.cross(arm, force)[:, -moments_in(dimension) :]
    return moment


def moments_in(dimension: int) -> int:
    """Components of a moment: one for each pair of axes."""
    return dimension * (dimension - 1) // 2


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
    sizes = shapes.size[movable] * scene.thickness
    return np.array(
        [instead.get(block.name, block.weight_of(size)) for block, size in zip(blocks, sizes, strict=True)]
    )


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

    def acting(kind: Kind, among: Iterable[tuple[str, str | None]]) -> list[_Given]:
        return [
            one._replace(force=factor * one.force)
            for group in among
            if (factor := scene.factor(kind, *group))
            for one in given[group]
        ]

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

    def forces(listed: list[_Given], couple: np.ndarray) -> Forces:
        acting = [one for one in listed if one.force.any()]
        row = np.array([one.row for one in acting], dtype=int)
        point = shapes.centroid[movable[row]]
        for number, one in enumerate(acting):
            if one.at is not None:
                point[number] = np.array(one.at) - shapes.origin
        force = np.array([one.force for one in acting], dtype=float).reshape(point.shape)
        return Forces(row, force, point, couple)

    live = acting("live", given)
    if (sideways := scene.tilt_direction) is not None:
        live = of_weights([sideways] * len(blocks))
    if (shaking := scene.shaking) is not None:
        live += [
            one._replace(force=mass * shaking)
            for group, entries in given.items()
            if (factor := scene.factor("dead", *group))
            for one in entries
            if (mass := max(0.0, factor * (float(down @ one.force) if one.mass is None else one.mass)))
        ]
    weighing = acting("dead", [("weight", None)])
    dead = acting("dead", [group for group in given if group[0] != "weight"])
    none = np.zeros((len(blocks), moments_in(len(down))))
    return Loads(forces(weighing, none), forces(dead, couples("dead")), forces(live, couples("live")))

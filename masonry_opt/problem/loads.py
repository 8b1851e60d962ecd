"""The forces on the movable blocks of a scene, and the points where they act."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Literal

import numpy as np

from masonry_opt.scene.blocks import Point
from masonry_opt.scene.geometry import Geometry
from masonry_opt.scene.scene import Scene

#: Row of the block, force, and point where it acts (None: the centroid).
_Force = tuple[int, Point, Point | None]


@dataclass(frozen=True)
class Forces:
    """Forces of one kind, none of them zero. Several may act on one block.

    Attributes
    ----------
    block: which of the movable blocks each acts on, shape (f,).
    force: in the case's unit of force, shape (f, 2).
    point: where it acts, relative to the geometry's origin, shape (f, 2).
    """

    block: np.ndarray
    force: np.ndarray
    point: np.ndarray

    def about(self, centroid: np.ndarray) -> np.ndarray:
        """Their sums on the blocks, and their moments about the blocks' centroids, shape (3b,)."""
        arm = self.point - centroid[self.block]
        moment = arm[:, 0] * self.force[:, 1] - arm[:, 1] * self.force[:, 0]
        total = np.zeros((len(centroid), 3))
        np.add.at(total, self.block, np.column_stack([self.force, moment]))
        return total.ravel()


@dataclass(frozen=True)
class Loads:
    """Forces on the movable blocks of a scene, without those of edge loads: weights, further dead forces, and
    live ones, which in a scene that is tilted are the weights, turned a quarter from gravity."""

    weight: Forces
    dead: Forces
    live: Forces


def weights(scene: Scene, shapes: Geometry, movable: np.ndarray) -> np.ndarray:
    """Weights of the blocks with these indices, shape (b,)."""
    instead = {load.block: load.weight for load in scene.loads if load.weight is not None}
    blocks = [scene.blocks[index] for index in movable]
    return np.array(
        [
            instead.get(block.name, block.weight_of(area * scene.thickness))
            for block, area in zip(blocks, shapes.area[movable], strict=True)
        ]
    )


def loads(scene: Scene, shapes: Geometry, movable: np.ndarray) -> Loads:
    """The loads of the blocks with these indices."""
    blocks = [scene.blocks[index] for index in movable]
    row_of = {block.name: row for row, block in enumerate(blocks)}
    size = float(np.hypot(*scene.gravity))
    gravity = (scene.gravity[0] / size, scene.gravity[1] / size)
    weight = weights(scene, shapes, movable).tolist()

    def of_weights(times: Iterable[Point]) -> list[_Force]:
        each = zip(blocks, weight, times, strict=True)
        return [(row, (x * own, y * own), block.weight_at) for row, (block, own, (x, y)) in enumerate(each)]

    def given(kind: Literal["dead", "live"]) -> list[_Force]:
        own = [(row, getattr(block, kind), getattr(block, f"{kind}_at")) for row, block in enumerate(blocks)]
        on = [(row_of[load.block], getattr(load, kind), load.at) for load in scene.loads]
        return own + [(row, force, at) for row, force, at in on if force is not None]

    def forces(listed: list[_Force]) -> Forces:
        acting = [(row, force, at) for row, force, at in listed if any(force)]
        row = np.array([row for row, _, _ in acting], dtype=int)
        point = shapes.centroid[movable[row]]
        for number, (_, _, at) in enumerate(acting):
            if at is not None:
                point[number] = np.array(at) - shapes.origin
        return Forces(row, np.array([force for _, force, _ in acting], dtype=float).reshape(-1, 2), point)

    if scene.tilt:
        x, y = gravity
        live = of_weights([(-y, x) if scene.tilt == "right" else (y, -x)] * len(blocks))
    else:
        live = given("live") + of_weights([block.live_per_weight for block in blocks])
    return Loads(
        weight=forces(of_weights([gravity] * len(blocks))), dead=forces(given("dead")), live=forces(live)
    )

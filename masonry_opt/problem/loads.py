"""The forces on the movable blocks of a scene, and the points where they act."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from masonry_opt.scene.geometry import Geometry
from masonry_opt.scene.scene import Scene
from masonry_opt.scene.tilt import turned_towards


@dataclass(frozen=True)
class Forces:
    """One force on each movable block, zero where there is none.

    Attributes
    ----------
    force: in the case's unit of force, shape (b, 2).
    point: where it acts, relative to the geometry's origin, shape (b, 2).
    """

    force: np.ndarray
    point: np.ndarray

    def about(self, centroid: np.ndarray) -> np.ndarray:
        """Forces and their moments about the centroids, shape (3b,)."""
        arm = self.point - centroid
        moment = arm[:, 0] * self.force[:, 1] - arm[:, 1] * self.force[:, 0]
        return np.column_stack([self.force, moment]).ravel()


@dataclass(frozen=True)
class Loads:
    """What acts on the movable blocks of a scene beside loads on edges.

    Attributes
    ----------
    weight: along gravity.
    dead: further dead forces.
    live: what λ scales; of a scene that is tilted the weights, turned a quarter from gravity.
    """

    weight: Forces
    dead: Forces
    live: Forces


def loads(scene: Scene, shapes: Geometry, movable: np.ndarray) -> Loads:
    """The loads of the blocks with these indices."""
    blocks = [scene.blocks[index] for index in movable]
    centroid = shapes.centroid[movable]
    size = float(np.hypot(*scene.gravity))
    gravity = (scene.gravity[0] / size, scene.gravity[1] / size)
    weight = np.array(
        [
            block.weight_of(area * scene.thickness)
            for block, area in zip(blocks, shapes.area[movable], strict=True)
        ]
    )

    def points(given: list[tuple[float, float] | None]) -> np.ndarray:
        return np.array(
            [
                np.array(point) - shapes.origin if point is not None else own
                for point, own in zip(given, centroid, strict=True)
            ]
        )

    def of_weights(direction: tuple[float, float]) -> Forces:
        return Forces(weight[:, None] * np.array(direction), points([block.weight_at for block in blocks]))

    dead = np.array([block.dead for block in blocks], dtype=float)
    live = np.array([block.live for block in blocks], dtype=float)
    return Loads(
        weight=of_weights(gravity),
        dead=Forces(dead, points([block.dead_at for block in blocks])),
        live=of_weights(turned_towards(scene.tilt, gravity))
        if scene.tilt
        else Forces(live, points([block.live_at for block in blocks])),
    )

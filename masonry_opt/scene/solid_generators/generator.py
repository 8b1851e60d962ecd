"""Generators of solids: the place, live loads and unit weight that all in space have."""

from __future__ import annotations

import math
from typing import Any

from masonry_opt.scene.blocks import NonNegative
from masonry_opt.scene.generator import AnyGenerator
from masonry_opt.scene.solids import Solid, Vector

#: Of one convex part, a ``box``, or ``vertices`` and ``faces``, as :class:`Solid` has them.
PartKeys = dict[str, Any]


class SolidGenerator(AnyGenerator):
    """A generator of blocks in space.

    Parameters
    ----------
    name:
        See :class:`~masonry_opt.scene.generator.AnyGenerator`.
    at:
        Where its origin lies, ``[x, y, z]``; which point that is, each generator says.
    live_per_weight:
        Live force on every block as a multiple of its weight, ``[fx, fy, fz]``, where the weight acts.
    unit_weight:
        Weight per unit volume.
    """

    at: Vector = (0.0, 0.0, 0.0)
    live_per_weight: Vector = (0.0, 0.0, 0.0)
    unit_weight: NonNegative

    def blocks(self) -> list[Solid]:
        """The blocks, each with its weight and its live load as a multiple of that."""
        raise NotImplementedError

    def _stone(self, name: str, *parts: PartKeys, **weight: Any) -> Solid:
        """A movable block; points are seen from the generator's origin. It weighs by its volume, or as
        ``weight`` and ``weight_at`` say."""
        if "weight_at" in weight:
            weight["weight_at"] = self._moved(weight["weight_at"])
        weight = weight or {"unit_weight": self.unit_weight}
        return self._solid(name, parts, live_per_weight=self.live_per_weight, **weight)

    def _support(self, name: str, *parts: PartKeys) -> Solid:
        return self._solid(name, parts, fixed=True)

    def _solid(self, name: str, parts: tuple[PartKeys, ...], **keys: Any) -> Solid:
        moved = [self._moved_shape(part) for part in parts]
        shape = moved[0] if len(moved) == 1 else {"parts": moved}
        return Solid(name=self._named(name), **shape, **keys)

    def _moved_shape(self, shape: PartKeys) -> PartKeys:
        if "box" in shape:
            sides = zip(shape["box"], self.at, strict=True)
            return {"box": [(low + by, high + by) for (low, high), by in sides]}
        return shape | {"vertices": [self._moved(vertex) for vertex in shape["vertices"]]}

    def _moved(self, point: tuple[float, float, float]) -> tuple[float, float, float]:
        x, y, z = (coordinate + by for coordinate, by in zip(point, self.at, strict=True))
        return x, y, z


def polar(radius: float, angle: float, z: float) -> tuple[float, float, float]:
    """The point at a distance from the z axis, in a direction counter-clockwise from x, in radians."""
    return radius * math.cos(angle), radius * math.sin(angle), z

"""The ``[arch]`` generator: voussoirs of a circular or pointed arch, between fixed abutments or on blocks."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator
from typing import Annotated

from pydantic import Field, Strict

from masonry_opt.scene.arch_ring import ArchRing
from masonry_opt.scene.blocks import Block, Point, Record
from masonry_opt.scene.generator import Generator


class PointLoad(Record):
    """A live force on one voussoir, in the middle of its back (the outer edge).

    Parameters
    ----------
    voussoir:
        Its number, counted from the first of the arch's angles, or from the left, 1 the first.
    force:
        ``[fx, fy]``, scaled by the load factor.
    """

    voussoir: Annotated[int, Strict(), Field(ge=1)]
    force: Point


class Arch(ArchRing, Generator):
    """An arch in the plane.

    Raises CaseError if the measures make no arch, or a point load names no voussoir.

    Parameters
    ----------
    radius, angles, span, rise, thickness, voussoirs, weights, skewbacks, abutments, unit_weight:
        Of its ring: see :class:`~masonry_opt.scene.arch_ring.ArchRing`.
    point_loads:
        Live forces on single voussoirs (:class:`PointLoad`).
    name, at, live_per_weight, live:
        See :class:`~masonry_opt.scene.generator.Generator`; the origin is the centre of ``radius``, or the
        middle of the line between the springing points of ``span``, at the inner ends of the feet.
    """

    point_loads: list[PointLoad] = []

    def _mistakes(self) -> Iterator[str]:
        yield from super()._mistakes()
        numbers = Counter(load.voussoir for load in self.point_loads)
        for number, loads in numbers.items():
            if number > self.voussoirs:
                yield f"'point_loads' has a load on voussoir {number}, of {self.voussoirs}: count from 1"
            if loads > 1:
                yield f"'point_loads' has two loads on voussoir {number}: add them up"

    def blocks(self, thickness: float = 1.0) -> list[Block]:
        """The voussoirs ``v1``, ``v2``, ..., then ``skewback 1`` and ``skewback 2``, then ``abutment 1`` and
        ``abutment 2``."""
        forces = {f"v{load.voussoir}": load.force for load in self.point_loads}
        built = []
        for name, corners, area, weight_at, back in self._stones():
            if area is None:
                built.append(self._support(name, corners))
                continue
            force = forces.get(name, (0.0, 0.0))
            live = {"live": force, "live_at": back} if any(force) else {}
            weight = self.unit_weight * area * thickness
            built.append(self._stone(name, corners, weight, weight_at=weight_at, **live))
        return built

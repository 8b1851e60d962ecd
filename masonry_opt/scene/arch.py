"""The ``[arch]`` generator: voussoirs of a circular arch between two fixed abutments."""

from __future__ import annotations

import math
from collections import Counter
from typing import Annotated, Literal

from pydantic import Field, Strict, model_validator

from masonry_opt.scene.blocks import Block, NonNegative, Number, Point, Positive, Record


class PointLoad(Record):
    """A live force on one voussoir, in the middle of its back (the outer edge).

    Parameters
    ----------
    voussoir:
        Its number, counted from the first of the arch's angles, 1 the first.
    force:
        ``[fx, fy]``, scaled by the load factor.
    """

    voussoir: Annotated[int, Strict(), Field(ge=1)]
    force: Point


class Arch(Record):
    """Equal voussoirs with radial joints round the origin, each end on a fixed abutment.

    Parameters
    ----------
    radius:
        Of the centreline.
    angles:
        Where the arch begins and ends, in degrees, counter-clockwise from the x axis. ``[180, 0]`` is a
        semicircle whose voussoirs are counted from the left.
    thickness:
        Radial, less than twice the radius.
    voussoirs:
        How many.
    unit_weight:
        Weight per unit area.
    weights:
        "sector": the weight of an annular sector, at that sector's centroid. "centreline": the same
        weight, spread along the centreline, as in many closed forms. "straight": that of the polygon
        with straight edges. The polygon is what is drawn in any case.
    live:
        Live force on every voussoir as a multiple of its weight, where the weight acts.
    point_loads:
        Live forces on single voussoirs (:class:`PointLoad`), in place of ``live``.

    Raises
    ------
    CaseError
        If the angles or the thickness make no arch, or a point load names no voussoir.
    """

    radius: Positive
    angles: tuple[Number, Number]
    thickness: Positive
    voussoirs: Annotated[int, Strict(), Field(ge=1, le=100_000)]
    unit_weight: NonNegative
    weights: Literal["sector", "centreline", "straight"]
    live: Point = (0.0, 0.0)
    point_loads: list[PointLoad] = []

    @model_validator(mode="after")
    def _is_an_arch(self) -> Arch:
        swept = abs(self.angles[1] - self.angles[0])
        if not 0 < swept < 360:
            raise ValueError(f"'angles' sweep {swept:g}°: must be more than 0° and less than 360°")
        if not swept < 180 * self.voussoirs:
            raise ValueError(f"a voussoir of {swept / self.voussoirs:g}° is no wedge: raise 'voussoirs'")
        if not self.thickness < 2 * self.radius:
            raise ValueError(
                f"'thickness' must be less than twice the radius {self.radius:g} (found {self.thickness:g})"
            )
        numbers = Counter(load.voussoir for load in self.point_loads)
        for number, loads in numbers.items():
            if number > self.voussoirs:
                raise ValueError(
                    f"'point_loads' has a load on voussoir {number}, of {self.voussoirs}: count from 1"
                )
            if loads > 1:
                raise ValueError(f"'point_loads' has two loads on voussoir {number}: add them up")
        if numbers and any(self.live):
            raise ValueError("give 'live' or 'point_loads', not both")
        return self

    @property
    def voussoir_angle(self) -> float:
        """Angle of a voussoir in radians."""
        return math.radians(abs(self.angles[1] - self.angles[0])) / self.voussoirs

    def blocks(self) -> list[Block]:
        """The voussoirs ``v1``, ``v2``, ..., then ``abutment 1`` and ``abutment 2``."""
        first, last = map(math.radians, self.angles)
        joints = [first + (last - first) * k / self.voussoirs for k in range(self.voussoirs + 1)]
        forces = {load.voussoir: load.force for load in self.point_loads}
        built = [
            self._voussoir(number, joints[number - 1], joints[number], forces.get(number))
            for number in range(1, self.voussoirs + 1)
        ]
        onwards = math.copysign(1.0, last - first)
        return [
            *built,
            self._abutment("abutment 1", first, -onwards),
            self._abutment("abutment 2", last, onwards),
        ]

    def _voussoir(self, number: int, begin: float, end: float, force: Point | None) -> Block:
        inner, outer = self._radii()
        middle, angle = (begin + end) / 2, self.voussoir_angle
        # Mean distance of an annulus's area from its centre, times what the angle leaves of it:
        # 2/3 (outer³ - inner³) / (outer² - inner²), divided out, as thin rings lose digits in it.
        mean = self.radius + self.thickness**2 / (12 * self.radius)
        arc = 2 * math.sin(angle / 2) / angle
        area, centroid = {
            "sector": (angle * self.radius * self.thickness, mean * arc),
            "centreline": (angle * self.radius * self.thickness, self.radius * arc),
            "straight": (math.sin(angle) * self.radius * self.thickness, mean * math.cos(angle / 2)),
        }[self.weights]
        weight, weight_at = self.unit_weight * area, _polar(centroid, middle)
        live = force or (self.live[0] * weight, self.live[1] * weight)
        back = _polar(outer * math.cos(angle / 2), middle)
        return Block(
            name=f"v{number}",
            vertices=[_polar(inner, begin), _polar(outer, begin), _polar(outer, end), _polar(inner, end)],
            weight=weight,
            weight_at=weight_at,
            live=live,
            live_at=None if not any(live) else back if force else weight_at,
        )

    def _abutment(self, name: str, angle: float, turn: float) -> Block:
        """A square on the far side of the springing; ``turn`` is 1 if that is counter-clockwise."""
        inner, outer = (_polar(radius, angle) for radius in self._radii())
        away = (-turn * self.thickness * math.sin(angle), turn * self.thickness * math.cos(angle))
        beyond = [(x + away[0], y + away[1]) for x, y in (outer, inner)]
        return Block(name=name, vertices=[inner, outer, *beyond], fixed=True)

    def _radii(self) -> tuple[float, float]:
        return self.radius - self.thickness / 2, self.radius + self.thickness / 2


def _polar(radius: float, angle: float) -> tuple[float, float]:
    return radius * math.cos(angle), radius * math.sin(angle)

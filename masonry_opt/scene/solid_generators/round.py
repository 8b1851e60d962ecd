"""The generators ``[dome]`` and ``[shaft]``: rings of voussoirs, and drums, round the z axis."""

import math
from collections.abc import Iterator
from itertools import pairwise
from typing import Annotated, Literal

from pydantic import Field, Strict

from masonry_opt.scene.blocks import Number, Positive, YesNo
from masonry_opt.scene.generator import Count, PartKeys, SolidGenerator, Widths, both, polar
from masonry_opt.scene.solids import Solid, prism

_Place = tuple[float, float]  #: Distance from the axis and height.


class Dome(SolidGenerator):
    """Rings of voussoirs about the z axis, each of the same angle seen from the centre, their corners on two
    spheres, on a fixed ring.

    Faces are flat and shared whole: voussoirs of "running" bond have further corners in the middle, at those
    of the rings above and below, and are two convex parts.

    Raises CaseError if the measures make no dome.

    Parameters
    ----------
    radius: Of the sphere half way between the corners within and without; its centre is the origin.
    thickness: Radial, between the two spheres.
    springing: Angle of the foot above the horizontal through the centre, in degrees: 0 is half a sphere.
    rings: How many, without the key.
    voussoirs: How many a ring.
    oculus: Radius of the opening at the top, within. Without it a key that spans the angle of a ring closes
        the dome.
    bond: "running": every other ring is turned by half a voussoir. "meridians": the upright joints run
        through.
    base: Whether a fixed ring, as high as the dome is thick, is built under it.
    name, at, live_per_weight, unit_weight: See :class:`~masonry_opt.scene.generator.SolidGenerator`; the
        origin is the centre of the spheres.
    """

    radius: Positive
    thickness: Positive
    springing: Annotated[Number, Field(ge=0, lt=90)] = 0.0
    rings: Count
    voussoirs: Annotated[int, Strict(), Field(ge=3, le=1000)]
    oculus: Positive | None = None
    bond: Literal["running", "meridians"] = "running"
    base: YesNo = True

    def _mistakes(self) -> Iterator[str]:
        yield from super()._mistakes()
        if not self.thickness < 2 * self.radius:
            yield f"'thickness' must be less than twice the 'radius' (found {self.thickness:g})"
            return
        foot = self._inner * math.cos(math.radians(self.springing))
        if self.oculus is not None and not self.oculus < foot:
            yield f"'oculus' must be less than the foot's radius within, {foot:g} (found {self.oculus:g})"

    @property
    def _inner(self) -> float:
        return self.radius - self.thickness / 2

    @property
    def _sectors(self) -> int:
        """Of a ring: between neighbouring meridians with corners."""
        return self.voussoirs * (2 if self.bond == "running" else 1)

    def blocks(self) -> list[Solid]:
        """The voussoirs, ring by ring from the foot, named ``ring-voussoir``; then ``key`` and ``base``."""
        first = math.radians(self.springing)
        if self.oculus is None:
            # Half of the key lies on this side of the axis.
            step = (math.pi / 2 - first) / (self.rings + 0.5)
        else:
            step = (math.acos(self.oculus / self._inner) - first) / self.rings
        # The ends of each bed joint, within and without, so far above the horizontal.
        angles = [first + step * number for number in range(self.rings + 1)]
        radii = self._inner, self._inner + self.thickness
        beds = [[polar(radius, angle) for radius in radii] for angle in angles]
        each = self._sectors // self.voussoirs
        built = []
        for ring, (low, high) in enumerate(pairwise(beds)):
            for number in range(self.voussoirs):
                sectors = [each * number + ring % 2 * (each - 1) + part for part in range(each)]
                parts = [self._part(low, high, sector) for sector in sectors]
                built.append(self._stone(f"{ring + 1}-{number + 1}", *parts))
        if self.oculus is None:
            built.append(self._stone("key", prism(*(self._polygon(place) for place in beds[-1]))))
        if self.base:
            # Below the foot and square to it.
            down = self.thickness * math.sin(first), -self.thickness * math.cos(first)
            below = [(r + down[0], z + down[1]) for r, z in beds[0]]
            parts = [self._part(below, beds[0], sector) for sector in range(self._sectors)]
            built.append(self._support("base", *parts))
        return built

    def _corner(self, place: _Place, meridian: int) -> tuple[float, float, float]:
        # As whole numbers of sectors, so that neighbours have the same corners to the last digit.
        return polar(place[0], 2 * math.pi * (meridian % self._sectors) / self._sectors, place[1])

    def _part(self, low: list[_Place], high: list[_Place], sector: int) -> PartKeys:
        """Between two bed joints and the meridians of a sector."""
        faces = ([self._corner(place, at) for place in (*low, *high[::-1])] for at in (sector, sector + 1))
        return prism(*faces)

    def _polygon(self, place: _Place) -> list[tuple[float, float, float]]:
        return [self._corner(place, meridian) for meridian in range(self._sectors)]


class Shaft(SolidGenerator):
    """Equally high drums, prisms or frusta of a regular polygon, on a fixed base whose top is z = 0.

    Raises CaseError if a value is none that can be built.

    Parameters
    ----------
    diameter: Of the circle through the polygon's corners, or ``[bottom, top]`` if the shaft tapers. Across
        flat sides it measures cos(π/sides) times that.
    sides: Of the polygon, three or more: 4 a square pier, 16 or 24 a round column. One side faces +x, and
        with multiples of four sides others face -x and ±y.
    height, drums: Of the shaft, and how many drums it has.
    base: Whether a fixed base is built under it, with the foot's outline and as high as a drum.
    name, at, live_per_weight, unit_weight: See :class:`~masonry_opt.scene.generator.SolidGenerator`; the
        origin is the middle of the foot.
    """

    diameter: Widths
    sides: Annotated[int, Strict(), Field(ge=3, le=1000)]
    height: Positive
    drums: Count
    base: YesNo = True

    def blocks(self) -> list[Solid]:
        """The drums ``d1``, ``d2``, ... from the foot upwards, then the ``base``."""
        bottom, top = both(self.diameter)
        drum = self.height / self.drums
        levels = [
            self._polygon(bottom + (top - bottom) * number / self.drums, self.height * number / self.drums)
            for number in range(self.drums + 1)
        ]
        drums = enumerate(pairwise(levels), start=1)
        built = [self._stone(f"d{number}", prism(low, high)) for number, (low, high) in drums]
        if self.base:
            built.append(self._support("base", prism(self._polygon(bottom, -drum), levels[0])))
        return built

    def _polygon(self, diameter: float, z: float) -> list[tuple[float, float, float]]:
        return [polar(diameter / 2, (2 * side + 1) * math.pi / self.sides, z) for side in range(self.sides)]

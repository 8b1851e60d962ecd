"""The generators ``[barrel]`` and ``[groin]``, long arches; ``[dome]`` and ``[shaft]``, round the z axis."""

import math
from collections.abc import Iterator, Sequence
from itertools import pairwise, product
from typing import Annotated, Literal

from pydantic import Field, Strict

from masonry_opt.errors import CaseError
from masonry_opt.scene.arch import ArchRing, Stone
from masonry_opt.scene.blocks import Number, Point, Positive, YesNo
from masonry_opt.scene.generator import CLOSER, Count, Shape, SolidGenerator, Widths, both, cut, every, polar
from masonry_opt.scene.solids import Solid, prism


class Barrel(ArchRing, SolidGenerator):
    """A barrel vault along y: an arch whose point (x, y) is (x, t, y), t from 0 to the vault's length.

    Raises CaseError if the measures make no arch, or the stones are longer than the vault.

    Parameters
    ----------
    radius, angles, span, rise, thickness, voussoirs, weights, skewbacks, abutments: See
        :class:`~masonry_opt.scene.arch.ArchRing`.
    length: Of the vault, along y.
    stone: Length of a stone, along y (default: that of the vault). At the ends a piece shorter than a quarter
        of it joins its neighbour.
    bond: "running": every other voussoir begins with half a stone. "stacked": rings lie side by side.
    unit_weight: Weight per unit volume.
    name, at, live_per_weight: See :class:`~masonry_opt.scene.generator.SolidGenerator`; the origin is the
        arch's, at y = 0.
    """

    length: Positive
    stone: Positive | None = None
    bond: Literal["running", "stacked"] = "running"

    def _mistakes(self) -> Iterator[str]:
        yield from super()._mistakes()
        if self.stone is not None and self.stone > self.length:
            yield f"'stone' is longer than the vault: at most its 'length', {self.length:g}"

    @property
    def size(self) -> int:
        """Number of stones, or a few more."""
        return self.voussoirs * (1 if self.stone is None else 2 + int(min(self.length / self.stone, 1e9)))

    def blocks(self) -> list[Solid]:
        """The stones, voussoir by voussoir from the left, named ``v1-1``, ``v1-2``, ... along y; those of
        skewbacks, ``skewback 1-1``; then ``abutment 1`` and ``abutment 2``."""
        built = []
        # Skewbacks lie in bond with the voussoirs on them; abutments come last and are whole.
        rows = [*range(self.voussoirs), 1, self.voussoirs, 0, 0]
        for stone, row in zip(self._stones(), rows, strict=False):
            if stone.area is None:
                built.append(self._block(stone.name, self._slice(stone, 0.0, self.length), fixed=True))
                continue
            for number, (start, end) in enumerate(self._cuts(row), start=1):
                weight, at = self.unit_weight * stone.area * (end - start), stone.weight_at
                middle = None if at is None else (at[0], (start + end) / 2, at[1])
                name, shape = f"{stone.name}-{number}", self._slice(stone, start, end)
                built.append(self._stone(name, shape, weight=weight, weight_at=middle))
        return built

    @staticmethod
    def _slice(stone: Stone, start: float, end: float) -> Shape:
        return prism(*([(x, place, z) for x, z in stone.corners] for place in (start, end)))

    def _cuts(self, row: int) -> list[tuple[float, float]]:
        """Ends of the stones of a voussoir along y."""
        if self.stone is None:
            return [(0.0, self.length)]
        begins = self.stone / 2 if self.bond == "running" and row % 2 else 0.0
        return cut(0.0, self.length, every(self.stone, begins, self.length), self.stone)


class Groin(SolidGenerator):
    """Two barrel vaults along x and y whose intrados meet on the diagonals, on four fixed corners.

    On each groin a course is one stone of two convex parts, a leg in either barrel; from there courses go on
    in running bond.

    Raises CaseError if the measures make no arch, or the bay leaves no room for stones beside the corners.

    Parameters
    ----------
    span, rise, thickness: Of the barrels' arch: see :class:`~masonry_opt.scene.arch.ArchRing`.
    voussoirs: Of that, an even number: a joint runs along the crown.
    bay: Length of each barrel from end to end, more than the span and both thicknesses.
    stone: Length of a stone along its barrel.
    abutments: Whether a fixed abutment is built under each corner.
    name, at, live_per_weight, unit_weight: See :class:`~masonry_opt.scene.generator.SolidGenerator`; the
        origin is the middle of the square, at the height of the springing points.
    """

    span: Positive
    rise: Positive
    thickness: Positive
    voussoirs: Annotated[int, Strict(), Field(ge=2, le=1000, multiple_of=2)]
    bay: Positive
    stone: Positive
    abutments: YesNo = True

    def _mistakes(self) -> Iterator[str]:
        yield from super()._mistakes()
        try:
            least = 2 * (max(self._courses()[0])[0] + CLOSER * self.stone)
        except CaseError as error:
            yield str(error).removeprefix("ArchRing: ")
            return
        if self.bay < least:
            yield f"'bay' must be {least:g} or more, the arch and half a stone (found {self.bay:g})"

    @property
    def size(self) -> int:
        """Number of stones, or some more."""
        return int(4 * self.voussoirs * (2 + min(self.bay / 2 / self.stone, 1e9)))

    def blocks(self) -> list[Solid]:
        """The stones of each corner in turn, course by course from the springing: ``corner g1`` on the groin,
        ``corner y1-1``, ... along y, ``corner x1-1``, ... along x; then ``abutment 1`` to ``abutment 4``."""
        built = []
        *courses, foot = self._courses()
        corners = [(1, 1), (-1, 1), (-1, -1), (1, -1)]
        for corner, signs in enumerate(corners, start=1):
            for number, section in enumerate(courses, start=1):
                (_, end), *others = self._cuts(section, number)
                legs = [_leg(section, None, end, signs, along) for along in "yx"]
                built.append(self._stone(f"{corner} g{number}", *legs))
                for along, (count, piece) in product("yx", enumerate(others, start=1)):
                    shape = _leg(section, *piece, signs, along)
                    built.append(self._stone(f"{corner} {along}{number}-{count}", shape))
        if self.abutments:
            end = max(self.bay / 2, max(foot)[0] + self.thickness)
            for corner, signs in enumerate(corners, start=1):
                legs = [_leg(foot, None, end, signs, along) for along in "yx"]
                built.append(self._block(f"abutment {corner}", *legs, fixed=True))
        return built

    def _courses(self) -> list[list[Point]]:
        """Sections of the right half of the arch from the springing upwards, and of its abutment."""
        arch = {key: getattr(self, key) for key in ("span", "rise", "thickness", "voussoirs", "unit_weight")}
        stones = [stone.corners for stone in ArchRing(**arch)._stones()]
        return [*stones[self.voussoirs // 2 : self.voussoirs][::-1], stones[-1]]

    def _cuts(self, section: list[Point], course: int) -> list[tuple[float, float]]:
        """Ends of the stones of a course from its groin to the end of the barrel."""
        (start, _), end = max(section), self.bay / 2  # from the corner that reaches farthest out
        begins = self.stone * (0.5 if course % 2 == 0 else 1.0)
        joints = [end - place for place in every(self.stone, begins, end)]
        return cut(start, end, joints[::-1], self.stone)


def _leg(
    section: Sequence[Point], start: float | None, end: float, signs: tuple[int, int], along: str
) -> Shape:
    """A course's piece along x or y, from a place or the groin to another, in the corner of these signs."""

    def face(at: float | None) -> list[tuple[float, float, float]]:
        places = [(x, x if at is None else at, z) for x, z in section]
        turned = places if along == "y" else [(v, u, z) for u, v, z in places]
        return [(signs[0] * x, signs[1] * y, z) for x, y, z in turned]

    return prism(face(start), face(end))


class Dome(SolidGenerator):
    """Rings of voussoirs about the z axis, each of the same angle seen from the centre, their corners on two
    spheres, on a fixed ring.

    Faces are flat and shared whole: voussoirs of "running" bond have further corners in the middle, at those
    of the rings above and below, and are two convex parts.

    Raises CaseError if the measures make no dome.

    Parameters
    ----------
    radius: Of the sphere half way between the corners within and without.
    thickness: Radial, between the two spheres.
    springing: Angle of the foot above the horizontal through the centre, in degrees: 0 is half a sphere.
    rings, voussoirs: How many rings, without the key, and voussoirs in each.
    oculus: Radius of the opening at the top, within. Without it a key that spans the angle of a ring closes
        the dome.
    bond: "running": every other ring is turned by half a voussoir. "meridians": upright joints run through.
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
            faces = ([self._corner(place, at) for at in range(self._sectors)] for place in beds[-1])
            built.append(self._stone("key", prism(*faces)))
        if self.base:
            # Below the foot and square to it.
            down = self.thickness * math.sin(first), -self.thickness * math.cos(first)
            below = [(r + down[0], z + down[1]) for r, z in beds[0]]
            parts = [self._part(below, beds[0], sector) for sector in range(self._sectors)]
            built.append(self._block("base", *parts, fixed=True))
        return built

    def _corner(self, place: Point, meridian: int) -> tuple[float, float, float]:
        """The corner at a distance and height on a meridian: for neighbours the same to the last digit."""
        return polar(place[0], 2 * math.pi * (meridian % self._sectors) / self._sectors, place[1])

    def _part(self, low: list[Point], high: list[Point], sector: int) -> Shape:
        """Between two bed joints and the meridians of a sector."""
        faces = ([self._corner(place, at) for place in (*low, *high[::-1])] for at in (sector, sector + 1))
        return prism(*faces)


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
        widths = [bottom + (top - bottom) * number / self.drums for number in range(self.drums + 1)]
        levels = [self._polygon(width, self.height * at / self.drums) for at, width in enumerate(widths)]
        drums = enumerate(pairwise(levels), start=1)
        built = [self._stone(f"d{number}", prism(low, high)) for number, (low, high) in drums]
        if self.base:
            built.append(self._block("base", prism(self._polygon(bottom, -drum), levels[0]), fixed=True))
        return built

    def _polygon(self, diameter: float, z: float) -> list[tuple[float, float, float]]:
        return [polar(diameter / 2, (2 * side + 1) * math.pi / self.sides, z) for side in range(self.sides)]

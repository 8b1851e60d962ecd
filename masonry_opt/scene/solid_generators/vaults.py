"""Define the generators of vaults, ``[barrel]`` and ``[groin]``, and of ``[dome]`` and ``[shaft]``."""

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
    """A barrel vault along y: an arch in the plane of x and z, extruded along y.

    Point (x, y) of the arch becomes (x, t, y), with t from 0 to the length of the vault.

    Parameters
    ----------
    radius, angles, span, rise, thickness, voussoirs, weights, skewbacks, abutments: See
        :class:`~masonry_opt.scene.arch.ArchRing`.
    length: Length of the vault, along y.
    stone: Length of a stone, along y (default: the length of the vault). At the ends, a piece shorter than a
        quarter of a stone is joined to its neighbour.
    bond: "running": every second voussoir begins with half a stone. "stacked": all voussoirs have joints at
        the same positions, so the vault consists of separate rings.
    unit_weight: Weight per unit volume.
    name, at, live_per_weight: See :class:`~masonry_opt.scene.generator.SolidGenerator`; the origin is the
        origin of the arch, at y = 0.

    Raises
    ------
    CaseError
        If the dimensions do not describe an arch, or if the stones are longer than the vault.
    """

    length: Positive
    stone: Positive | None = None
    bond: Literal["running", "stacked"] = "running"

    def _mistakes(self) -> Iterator[str]:
        yield from super()._mistakes()
        if self.stone is not None and self.stone > self.length:
            yield f"'stone' must be at most {self.length:g}, the length of the vault (found {self.stone:g})"

    @property
    def size(self) -> int:
        """Return an upper bound on the number of stones."""
        return self.voussoirs * (1 if self.stone is None else 2 + int(min(self.length / self.stone, 1e9)))

    def blocks(self) -> list[Solid]:
        """Return the blocks of the vault: voussoirs from left to right, then skewbacks and abutments.

        If ``stone`` is set, voussoirs and skewbacks are cut into stones along y. The names of stones are
        ``v1-1``, ``v1-2``, ... and ``skewback 1-1``, ... along y. Abutments are named ``abutment 1`` and
        ``abutment 2``.

        Returns
        -------
        list of Solid
            The blocks, in the coordinates of the scene.
        """
        solids = []
        # In a running bond, rows with odd numbers are offset by half a stone. To stagger the joints, a
        # skewback has an odd row number if the voussoir next to it has an even one, and vice versa. The row
        # numbers of abutments have no effect, because abutments are not cut into stones.
        rows = [*range(self.voussoirs), 1, self.voussoirs, 0, 0]
        for stone, row in zip(self._stones(), rows, strict=False):
            if stone.area is None:
                solids.append(self._block(stone.name, self._slice(stone, 0.0, self.length), fixed=True))
                continue
            for number, (start, end) in enumerate(self._stone_spans(row), start=1):
                weight = self.unit_weight * stone.area * (end - start)
                at = stone.weight_at
                middle = None if at is None else (at[0], (start + end) / 2, at[1])
                shape = self._slice(stone, start, end)
                solids.append(self._stone(f"{stone.name}-{number}", shape, weight=weight, weight_at=middle))
        return solids

    @staticmethod
    def _slice(stone: Stone, start: float, end: float) -> Shape:
        """Return the part of a voussoir, skewback or abutment that lies between two values of y."""
        return prism(*([(x, place, z) for x, z in stone.corners] for place in (start, end)))

    def _stone_spans(self, row: int) -> list[tuple[float, float]]:
        """Return the start and end of each stone of a row, as values of y."""
        if self.stone is None:
            return [(0.0, self.length)]
        begins = self.stone / 2 if self.bond == "running" and row % 2 else 0.0
        return cut(0.0, self.length, every(self.stone, begins, self.length), self.stone)


class Groin(SolidGenerator):
    """A groin vault: two equal barrel vaults along x and y that intersect, supported at four corners.

    The intrados surfaces of the two vaults intersect along the diagonals, which are the groins. On each
    groin, a course has one stone with two convex parts, one in each barrel. From this stone, the course
    continues in running bond along both barrels.

    Parameters
    ----------
    span, rise, thickness: Dimensions of the arch of both barrels, see
        :class:`~masonry_opt.scene.arch.ArchRing`.
    voussoirs: Even number of voussoirs of the arch, so that a joint runs along the crown.
    bay: Length of each barrel from end to end, more than the span and both thicknesses.
    stone: Length of a stone along its barrel.
    abutments: True for a fixed abutment under each corner.
    name, at, live_per_weight, unit_weight: See :class:`~masonry_opt.scene.generator.SolidGenerator`; the
        origin is the middle of the square, at the height of the springing points.

    Raises
    ------
    CaseError
        If the dimensions do not describe an arch, or if the bay is too short for stones between the corners.
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
            shortest_bay = 2 * (max(self._courses()[0])[0] + CLOSER * self.stone)
        except CaseError as error:
            yield str(error).removeprefix("ArchRing: ")
            return
        if self.bay < shortest_bay:
            yield (
                f"'bay' must be at least {shortest_bay:g}, the width of the arch plus half a stone "
                f"(found {self.bay:g})"
            )

    @property
    def size(self) -> int:
        """Return an upper bound on the number of stones."""
        return int(4 * self.voussoirs * (2 + min(self.bay / 2 / self.stone, 1e9)))

    def blocks(self) -> list[Solid]:
        """Return the stones, and finally the abutments. The order is by corner of the vault, then by course.

        For corner 1, names are ``1 g1``, ... on the groin, ``1 y1-1``, ... along y and ``1 x1-1``, ... along
        x. Abutments are named ``abutment 1`` to ``abutment 4``.

        Returns
        -------
        list of Solid
            The blocks, in the coordinates of the scene.
        """
        solids = []
        *courses, foot = self._courses()
        corners = [(1, 1), (-1, 1), (-1, -1), (1, -1)]
        for corner, signs in enumerate(corners, start=1):
            for number, section in enumerate(courses, start=1):
                (_, end), *other_pieces = self._stone_spans(section, number)
                legs = [_leg(section, None, end, signs, axis) for axis in "yx"]
                solids.append(self._stone(f"{corner} g{number}", *legs))
                for axis, (count, piece) in product("yx", enumerate(other_pieces, start=1)):
                    shape = _leg(section, *piece, signs, axis)
                    solids.append(self._stone(f"{corner} {axis}{number}-{count}", shape))
        if self.abutments:
            end = max(self.bay / 2, max(foot)[0] + self.thickness)
            for corner, signs in enumerate(corners, start=1):
                legs = [_leg(foot, None, end, signs, axis) for axis in "yx"]
                solids.append(self._block(f"abutment {corner}", *legs, fixed=True))
        return solids

    def _courses(self) -> list[list[Point]]:
        """Return the cross-sections of all courses, from bottom to crown, and of the abutment as last entry.

        All cross-sections are in the right half of the arch, where x is not negative.
        """
        arch = {key: getattr(self, key) for key in ("span", "rise", "thickness", "voussoirs", "unit_weight")}
        stones = [stone.corners for stone in ArchRing(**arch)._stones()]
        return [*stones[self.voussoirs // 2 : self.voussoirs][::-1], stones[-1]]

    def _stone_spans(self, section: list[Point], course: int) -> list[tuple[float, float]]:
        """Return the start and end of each stone of a course, from the groin to the end of the barrel."""
        start = max(section)[0]  # x of the outermost corner
        end = self.bay / 2
        begins = self.stone * (0.5 if course % 2 == 0 else 1.0)
        joints = [end - place for place in every(self.stone, begins, end)]
        return cut(start, end, joints[::-1], self.stone)


def _leg(
    section: Sequence[Point], start: float | None, end: float, signs: tuple[int, int], axis: str
) -> Shape:
    """Return the shape of a piece along x or y: a whole stone, or one leg of a groin stone or abutment.

    The piece begins at ``start``, or at the groin if ``start`` is None, and ends at ``end``. ``signs`` are
    the signs of x and y in the piece's corner of the vault.
    """

    def face(at: float | None) -> list[tuple[float, float, float]]:
        """Return the corners of the section at position ``at``, or at the groin if ``at`` is None."""
        places = [(x, x if at is None else at, z) for x, z in section]
        rotated_places = places if axis == "y" else [(y, x, z) for x, y, z in places]
        return [(signs[0] * x, signs[1] * y, z) for x, y, z in rotated_places]

    return prism(face(start), face(end))


class Dome(SolidGenerator):
    """A dome: rings of voussoirs around the z axis, on a fixed ring.

    Seen from the centre, all rings span equal angles. The corners of voussoirs lie on two spheres. Faces are
    flat, and neighbours share whole faces. In a "running" bond, each voussoir has additional corners in the
    middle, at the corners of the rings above and below, and consists of two convex parts.

    Parameters
    ----------
    radius: Radius of the sphere halfway between the inner and the outer corners.
    thickness: Radial distance between the two spheres.
    springing: Angle of the foot above the horizontal plane through the centre, in degrees: 0 for a
        hemisphere.
    rings, voussoirs: Number of rings, not counting the key, and number of voussoirs in each ring.
    oculus: Inner radius of the opening at the top. Without an opening, a key that spans the angle of one ring
        closes the dome.
    bond: "running": every second ring is rotated by half a voussoir. "meridians": the joints between
        voussoirs are continuous along meridians.
    base: True for a fixed ring under the dome, whose height is the thickness of the dome.
    name, at, live_per_weight, unit_weight: See :class:`~masonry_opt.scene.generator.SolidGenerator`; the
        origin is the centre of the spheres.

    Raises
    ------
    CaseError
        If the dimensions do not describe a dome.
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
        foot = self._inner_radius * math.cos(math.radians(self.springing))
        if self.oculus is not None and not self.oculus < foot:
            yield f"'oculus' must be less than {foot:g}, the inner radius at the foot (found {self.oculus:g})"

    @property
    def _inner_radius(self) -> float:
        """Return the radius of the inner sphere."""
        return self.radius - self.thickness / 2

    @property
    def _sector_count(self) -> int:
        """Return the number of equal sectors of a ring; the joints of all rings are between these sectors."""
        return self.voussoirs * (2 if self.bond == "running" else 1)

    def blocks(self) -> list[Solid]:
        """Return the voussoirs of the dome, and finally the blocks ``key`` and ``base``.

        Voussoir 2 of ring 1 is named ``1-2``. Rings are numbered from the foot upwards.

        Returns
        -------
        list of Solid
            The blocks, in the coordinates of the scene.
        """
        first = math.radians(self.springing)
        if self.oculus is None:
            # On each side of the axis, the block ``key`` at the crown spans half the angle that a ring spans.
            step = (math.pi / 2 - first) / (self.rings + 0.5)
        else:
            step = (math.acos(self.oculus / self._inner_radius) - first) / self.rings
        # Angles in radians between the bed joints and the horizontal plane. Each bed joint runs from the
        # inner to the outer sphere.
        angles = [first + step * number for number in range(self.rings + 1)]
        radii = self._inner_radius, self._inner_radius + self.thickness
        beds = [[polar(radius, angle) for radius in radii] for angle in angles]
        parts_per_stone = self._sector_count // self.voussoirs
        solids = []
        for ring, (low, high) in enumerate(pairwise(beds)):
            for number in range(self.voussoirs):
                first_sector = parts_per_stone * number + ring % 2 * (parts_per_stone - 1)
                sectors = range(first_sector, first_sector + parts_per_stone)
                parts = [self._part(low, high, sector) for sector in sectors]
                solids.append(self._stone(f"{ring + 1}-{number + 1}", *parts))
        if self.oculus is None:
            faces = ([self._corner(place, at) for at in range(self._sector_count)] for place in beds[-1])
            solids.append(self._stone("key", prism(*faces)))
        if self.base:
            # The base is under the foot of the dome. Its depth is measured perpendicular to the lowest bed
            # joint.
            offset = self.thickness * math.sin(first), -self.thickness * math.cos(first)
            base_bed = [(distance + offset[0], z + offset[1]) for distance, z in beds[0]]
            parts = [self._part(base_bed, beds[0], sector) for sector in range(self._sector_count)]
            solids.append(self._block("base", *parts, fixed=True))
        return solids

    def _corner(self, place: Point, meridian: int) -> tuple[float, float, float]:
        """Return the corner on a meridian at a given distance from the axis and a given height.

        The corners of neighbouring voussoirs are exactly equal.
        """
        return polar(place[0], 2 * math.pi * (meridian % self._sector_count) / self._sector_count, place[1])

    def _part(self, low: list[Point], high: list[Point], sector: int) -> Shape:
        """Return the shape of a stone between two bed joints and two neighbouring meridians."""
        faces = ([self._corner(place, at) for place in (*low, *high[::-1])] for at in (sector, sector + 1))
        return prism(*faces)


class Shaft(SolidGenerator):
    """A shaft of drums of equal height on a fixed base. Drums are polygonal prisms or frusta.

    The section is a regular polygon. The top of the base is at z = 0.

    Parameters
    ----------
    diameter: Diameter of the circle through the polygon's corners, or ``[bottom, top]`` if the shaft tapers.
        The distance between flat sides is cos(π/sides) times the diameter.
    sides: Number of sides of the polygon, three or more: 4 for a square pier, 16 or 24 for a round column.
        One side faces +x. If the number is a multiple of four, other sides face -x, +y and -y.
    height, drums: Height of the shaft, and number of its drums.
    base: True for a fixed base under the shaft, with the outline of the foot and the height of a drum.
    name, at, live_per_weight, unit_weight: See :class:`~masonry_opt.scene.generator.SolidGenerator`; the
        origin is the middle of the foot.

    Raises
    ------
    CaseError
        If a value is not valid.
    """

    diameter: Widths
    sides: Annotated[int, Strict(), Field(ge=3, le=1000)]
    height: Positive
    drums: Count
    base: YesNo = True

    def blocks(self) -> list[Solid]:
        """Return the drums ``d1``, ``d2``, ... from the foot upwards, and finally the ``base``.

        Returns
        -------
        list of Solid
            The blocks, in the coordinates of the scene.
        """
        bottom, top = both(self.diameter)
        drum = self.height / self.drums
        widths = [bottom + (top - bottom) * number / self.drums for number in range(self.drums + 1)]
        levels = [self._polygon(width, self.height * at / self.drums) for at, width in enumerate(widths)]
        drums = enumerate(pairwise(levels), start=1)
        solids = [self._stone(f"d{number}", prism(low, high)) for number, (low, high) in drums]
        if self.base:
            solids.append(self._block("base", prism(self._polygon(bottom, -drum), levels[0]), fixed=True))
        return solids

    def _polygon(self, diameter: float, z: float) -> list[tuple[float, float, float]]:
        """Return the corners of the shaft's polygonal section at height z."""
        return [polar(diameter / 2, (2 * side + 1) * math.pi / self.sides, z) for side in range(self.sides)]

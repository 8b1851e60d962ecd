"""The generators ``[barrel]`` and ``[groin]``: an arch's voussoirs made long and cut into stones; two such
barrels that cross over a square."""

from collections.abc import Iterator, Sequence
from typing import Annotated, Any, Literal

from pydantic import Field, Strict

from masonry_opt.errors import CaseError
from masonry_opt.scene.arch import ArchRing
from masonry_opt.scene.blocks import Point, Positive, YesNo
from masonry_opt.scene.generator import PartKeys, SolidGenerator
from masonry_opt.scene.solid_generators.bond import CLOSER, cut, every
from masonry_opt.scene.solids import Solid, prism


class Barrel(ArchRing, SolidGenerator):
    """A barrel vault along y, the point (x, y) of its arch being (x, t, y), t from 0 to its
    length: without ``stone`` that arch, extruded.

    Raises CaseError if the measures make no arch, or the stones are longer than the vault.

    Parameters
    ----------
    radius, angles, span, rise, thickness, voussoirs, weights, skewbacks, abutments: Of its ring: see
        :class:`~masonry_opt.scene.arch.ArchRing`.
    length: Of the vault, along y.
    stone: Length of a stone, along y (default: that of the vault). Pieces at the ends are no shorter than a
        quarter of it: where one would be, its neighbour is as much longer.
    bond: "running": every other voussoir begins with half a stone. "stacked": stones lie as rings side by
        side.
    unit_weight: Weight per unit volume.
    name, at, live_per_weight: See :class:`~masonry_opt.scene.generator.SolidGenerator`; the origin is that of
        the arch, at y = 0.
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
                built.append(self._support(stone.name, _slice(stone.corners, 0.0, self.length)))
                continue
            for number, (start, end) in enumerate(self._cuts(row), start=1):
                weight: dict[str, Any] = {"weight": self.unit_weight * stone.area * (end - start)}
                if stone.weight_at is not None:
                    x, z = stone.weight_at
                    weight["weight_at"] = (x, (start + end) / 2, z)
                shape = _slice(stone.corners, start, end)
                built.append(self._stone(f"{stone.name}-{number}", shape, **weight))
        return built

    def _cuts(self, row: int) -> list[tuple[float, float]]:
        """Ends of the stones of a voussoir along y."""
        if self.stone is None:
            return [(0.0, self.length)]
        begins = self.stone / 2 if self.bond == "running" and row % 2 else 0.0
        return cut(0.0, self.length, every(self.stone, begins, self.length), self.stone)


def _slice(corners: Sequence[Point], start: float, end: float) -> PartKeys:
    """The piece of a stone of this section between two places along y."""
    front, back = ([(x, y, z) for x, z in corners] for y in (start, end))
    return prism(front, back)


class Groin(SolidGenerator):
    """Two barrel vaults along x and y whose intrados meet on the diagonals, on four fixed corners.

    On each groin a course is one stone with a leg in either barrel, two convex parts; from there courses go
    on in running bond to the ends of the barrels.

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
            least = 2 * (_farthest(self._courses()[0]) + CLOSER * self.stone)
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
                for along in "yx":
                    for count, piece in enumerate(others, start=1):
                        shape = _leg(section, *piece, signs, along)
                        built.append(self._stone(f"{corner} {along}{number}-{count}", shape))
        if self.abutments:
            end = max(self.bay / 2, _farthest(foot) + self.thickness)
            for corner, signs in enumerate(corners, start=1):
                legs = [_leg(foot, None, end, signs, along) for along in "yx"]
                built.append(self._support(f"abutment {corner}", *legs))
        return built

    def _courses(self) -> list[list[Point]]:
        """Sections of the right half of the arch from the springing upwards, and of its abutment."""
        arch = {key: getattr(self, key) for key in ("span", "rise", "thickness", "voussoirs", "unit_weight")}
        stones = [stone.corners for stone in ArchRing(**arch)._stones()]
        return [*stones[self.voussoirs // 2 : self.voussoirs][::-1], stones[-1]]

    def _cuts(self, section: list[Point], course: int) -> list[tuple[float, float]]:
        """Ends of the stones of a course from its groin to the end of the barrel."""
        start, end = _farthest(section), self.bay / 2
        begins = self.stone * (0.5 if course % 2 == 0 else 1.0)
        joints = [end - place for place in every(self.stone, begins, end)]
        return cut(start, end, joints[::-1], self.stone)


def _farthest(section: Sequence[Point]) -> float:
    return max(x for x, _ in section)


def _leg(
    section: Sequence[Point], start: float | None, end: float, signs: tuple[int, int], along: str
) -> PartKeys:
    """The piece of a course of the barrel along x or y, from a place along it, or from the groin, to another,
    in the corner with these signs of x and y."""

    def face(at: float | None) -> list[tuple[float, float, float]]:
        places = [(x, x if at is None else at, z) for x, z in section]
        turned = places if along == "y" else [(v, u, z) for u, v, z in places]
        return [(signs[0] * x, signs[1] * y, z) for x, y, z in turned]

    return prism(face(start), face(end))

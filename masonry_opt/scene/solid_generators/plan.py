"""The generator ``[plan]``: walls along axes in plan, bonded where they meet, with openings under lintels."""

import math
from collections.abc import Iterator
from itertools import combinations, count, pairwise
from typing import Annotated, Literal, NamedTuple

from pydantic import Field, Strict

from masonry_opt.scene.blocks import Positive, YesNo
from masonry_opt.scene.generator import Count, SolidGenerator
from masonry_opt.scene.mistakes import repeated
from masonry_opt.scene.rows import spaces
from masonry_opt.scene.solid_generators.bond import CLOSER, cut, every
from masonry_opt.scene.solid_generators.stretches import PlanWall, WallStretch, conflicts, crossed
from masonry_opt.scene.solids import Solid

_ROUNDING = 1e-6  #: Of a block, what is rounding.
_Run = tuple[float, float]  #: From and to.


class _Hole(NamedTuple):
    """An opening of a wall in a stretch: where its jambs and its lintel's ends are along that, and its first
    course and the lintel's."""

    number: int
    jambs: _Run
    lintel: _Run
    sill: int
    top: int


class Plan(SolidGenerator):
    """Walls of blocks in running bond, bonded or butted where they meet at right angles, on a fixed base
    whose top is z = 0.

    Courses alternate by half a block. At a corner or crossing a block of the wall that passes through reaches
    beyond the other's face. Pieces beside ends and openings are no shorter than a quarter of a block: where
    one would be, its neighbour is as much longer.

    Raises CaseError if an axis turns by other than right angles, walls overlap, an opening does not fit, or a
    piece would be shorter than a quarter of a block.

    Parameters
    ----------
    block: Length and height of a block.
    thickness: Of a block, and so of a leaf.
    walls:
        :class:`PlanWall` records.
    courses: Height of the walls.
    bond: Where walls meet. "toothed": of two walls the first named passes through in the first course, the
        other in the second, in turn. "butted": a wall that ends at another lies against it; of two that end
        the second named lies against the first, and of two that cross.
    headers: Of walls of two leaves: 2 for every second course of headers, 3 for every third, ... These are
        blocks across both leaves, half as wide as both. Without them nothing but friction holds the leaves
        together.
    base: Whether a fixed base is built under all, which reaches a leaf's thickness farther.
    name, at, live_per_weight, unit_weight: See :class:`~masonry_opt.scene.generator.SolidGenerator`; the
        origin is that of the axes, at the foot of the walls.
    """

    block: tuple[Positive, Positive]
    thickness: Positive
    walls: Annotated[list[PlanWall], Field(min_length=1, max_length=100)]
    courses: Count
    bond: Literal["toothed", "butted"] = "toothed"
    headers: Annotated[int, Strict(), Field(ge=1, le=1000)] | None = None
    base: YesNo = True

    def _mistakes(self) -> Iterator[str]:
        if mistakes := [*self._wrong_axes()] or [*super()._mistakes()]:
            yield from mistakes
            return
        if self.headers and all(wall.leaves == 1 for wall in self.walls):
            yield "'headers' bind two leaves: give a wall 'leaves = 2', or take 'headers' away"
        stretches = crossed(self._stretches(), self.bond == "toothed")
        for one, other, parallel in conflicts(stretches):
            a, b = one.wall.name, other.wall.name
            if parallel:
                yield f"walls '{a}' and '{b}' overlap: move one; what goes on in one line is one 'axis'"
            else:
                yield f"wall '{a}' ends within wall '{b}': end its 'axis' on that of '{b}', or at its face"
        mistakes = [*self._wrong_openings(stretches)]
        yield from mistakes or self._slivers(stretches)

    def _wrong_axes(self) -> Iterator[str]:
        for name in repeated(wall.name for wall in self.walls):
            yield f"two walls are named '{name}': rename one"
        for wall in self.walls:
            for number, (one, other) in enumerate(pairwise(wall.axis), start=1):
                if (one[0] == other[0]) == (one[1] == other[1]):
                    yield (
                        f"wall '{wall.name}': its 'axis' runs neither along x nor along y from point no. "
                        f"{number} to the next: walls meet at right angles"
                    )
                    break
            runs = [a[0] == b[0] for a, b in pairwise(wall.axis)]
            if any(a == b for a, b in pairwise(runs)):
                yield f"wall '{wall.name}': its 'axis' has a point where it does not turn: take it away"

    def _wrong_openings(self, stretches: list[WallStretch]) -> Iterator[str]:
        holes = [(stretch.wall.name, [*self._holes(stretch)]) for stretch in stretches]
        held = {(name, hole.number) for name, own in holes for hole in own}
        for wall in self.walls:
            top = wall.courses or self.courses
            for number, opening in enumerate(wall.openings, start=1):
                where = f"wall '{wall.name}': opening no. {number}"
                if (rows := opening.sill + opening.height + 1) > top:
                    yield f"{where}: its lintel ends at course {rows}, of {top}: lower 'sill' or 'height'"
                elif (wall.name, number) not in held:
                    yield (
                        f"{where}: with its lintel it reaches beyond the wall, or into one that crosses: "
                        "move it, or make its 'width' or 'bearing' less"
                    )
        for name, own in holes:
            for a, b in combinations(own, 2):
                overlap = min(a.lintel[1], b.lintel[1]) - max(a.lintel[0], b.lintel[0])
                if overlap > self._nothing and a.sill <= b.top and b.sill <= a.top:
                    yield (
                        f"wall '{name}': openings no. {a.number} and no. {b.number} overlap, with their "
                        "lintels: move one, or make a 'bearing' less"
                    )

    def _slivers(self, stretches: list[WallStretch]) -> Iterator[str]:
        for stretch in stretches:
            holes = [*self._holes(stretch)]
            for course in range(stretch.courses):
                pieces = [high - low for low, high in _runs(stretch, holes, course)]
                if min(pieces, default=math.inf) < CLOSER * self.block[0] - self._nothing:
                    yield (
                        f"wall '{stretch.wall.name}': a piece of course {course + 1} would be "
                        f"{min(pieces):.3g} long, less than a quarter of a block: move ends or openings"
                    )
                    break

    @property
    def _nothing(self) -> float:
        return _ROUNDING * self.block[0]

    @property
    def size(self) -> int:
        """Number of blocks, or some more."""
        least = min(self.block[0], self.thickness) if self.headers else self.block[0]
        lengths = [(stretch, (stretch.end - stretch.start) / least + 4) for stretch in self._stretches()]
        return int(sum(min(most, 1e9) * stretch.courses * stretch.wall.leaves for stretch, most in lengths))

    def _stretches(self) -> list[WallStretch]:
        found = []
        for wall in self.walls:
            before, courses = 0.0, wall.courses or self.courses
            for one, other in pairwise(wall.axis):
                along = 0 if one[1] == other[1] else 1
                start, end = sorted((one[along], other[along]))
                place = wall, along, one[1 - along], start, end
                way = 1.0 if one[along] == start else -1.0
                measure = one[along] - way * before, way
                found.append(WallStretch(*place, wall.leaves * self.thickness, courses, *measure))
                before += end - start
        return found

    def _holes(self, stretch: WallStretch) -> Iterator[_Hole]:
        """The openings of its wall that lie in the stretch, clear of its crossings."""
        for number, opening in enumerate(stretch.wall.openings, start=1):
            jambs = (stretch.origin + stretch.way * at for at in (opening.at, opening.at + opening.width))
            left, right = sorted(jambs)
            bearing = opening.bearing or self.block[0] / 2
            low, high = left - bearing, right + bearing
            if any(a - self._nothing <= low and high <= b + self._nothing for a, b, _ in stretch.bays()):
                top = opening.sill + opening.height
                yield _Hole(number, (left, right), (low, high), opening.sill, top)

    def blocks(self) -> list[Solid]:
        """The blocks, course by course and in each wall by wall, named ``wall course-block``; a wall's blocks
        are counted along its axis's straights in turn, in each by rising coordinates, leaf by leaf. The
        ``base`` comes last."""
        stretches = crossed(self._stretches(), self.bond == "toothed")
        holes = [[*self._holes(stretch)] for stretch in stretches]
        built, height = [], self.block[1]
        for course in range(max(stretch.courses for stretch in stretches)):
            numbers = {wall.name: count(1) for wall in self.walls}
            for stretch, own in zip(stretches, holes, strict=True):
                if course >= stretch.courses:
                    continue
                for along, across in self._course(stretch, own, course):
                    x, y = (across, along) if stretch.along else (along, across)
                    name = f"{stretch.wall.name} {course + 1}-{next(numbers[stretch.wall.name])}"
                    shape = {"box": (x, y, (course * height, (course + 1) * height))}
                    built.append(self._stone(name, shape))
        if self.base:
            sides = [
                (
                    min(stretch.bounds[axis][0] for stretch in stretches) - self.thickness,
                    max(stretch.bounds[axis][1] for stretch in stretches) + self.thickness,
                )
                for axis in (0, 1)
            ]
            built.append(self._support("base", {"box": (*sides, (-height, 0.0))}))
        return built

    def _course(self, stretch: WallStretch, holes: list[_Hole], course: int) -> list[tuple[_Run, _Run]]:
        """The blocks of a stretch in a course: from and to along it, and across it."""
        whole, double = stretch.faces, stretch.wall.leaves == 2
        headers = double and self.headers is not None and (course + 1) % self.headers == 0
        leaves = [(whole[0], stretch.line), (stretch.line, whole[1])] if double and not headers else [whole]
        length = self.thickness if headers else self.block[0]
        joints: list[float] = []
        for start, end, left in stretch.bays():
            # Of two courses one begins with half a block: toothed, that which passes through, so that no
            # joint lies over the other wall's face.
            half = left.passes[course % 2] if left and self.bond == "toothed" else course % 2
            joints += every(length, start + length / 2 * (headers or half), end - CLOSER * length)
        middles = [middle for crossing in stretch.crossings for middle in crossing.middles]
        runs = _runs(stretch, holes, course)
        stones = [stone for run in runs for stone in cut(*run, joints, length, middles)]
        pieces = [(stone, leaf) for leaf in leaves for stone in stones]
        lintels = [(hole.lintel, whole) for hole in holes if course == hole.top]
        # Leaf by leaf; lintels among the first leaf's.
        return sorted([*pieces, *lintels], key=lambda piece: (piece[1][0], piece[0]))


def _runs(stretch: WallStretch, holes: list[_Hole], course: int) -> list[_Run]:
    """Lengths of a stretch that a course fills with blocks, beside openings and lintels."""
    here = [hole for hole in holes if hole.sill <= course <= hole.top]
    taken = [hole.lintel if course == hole.top else hole.jambs for hole in here]
    return spaces(stretch.start, stretch.end, [*stretch.gaps(course), *taken])

"""The generator ``[plan]``: walls along axes in plan, bonded where they meet, with openings under lintels."""

import math
from collections.abc import Iterator
from itertools import combinations, count, pairwise, permutations
from typing import Annotated, Literal, NamedTuple

import numpy as np
from pydantic import Field, Strict

from masonry_opt.scene.blocks import Name, NonNegative, Point, Positive, Record, YesNo
from masonry_opt.scene.generator import CLOSER, Count, SolidGenerator, cut, every
from masonry_opt.scene.mistakes import repeated
from masonry_opt.scene.rows import spaces
from masonry_opt.scene.solids import Solid

_ROUNDING = 1e-6  #: Of a block, what is rounding.
_EXACT = 1e-9  #: Of the plan's size, a distance that is nothing.
_Run = tuple[float, float]  #: From and to.


class Opening(Record):
    """A door or window through a wall, under a lintel one course high and as deep as the wall is thick.

    Parameters
    ----------
    at: Of its nearer jamb, from the first point of the wall's axis along it.
    width: Between the jambs.
    sill: Courses below it: 0 is a door.
    height: Courses of it.
    bearing: Of the lintel on either side (default: half a block, which lies in bond where ``sill`` and
        ``height`` add up to an odd number and jambs are whole blocks from the wall's end).
    """

    at: NonNegative
    width: Positive
    sill: Annotated[int, Strict(), Field(ge=0, le=1000)] = 0
    height: Count
    bearing: Positive | None = None


class PlanWall(Record):
    """A wall of a plan.

    Parameters
    ----------
    name: Its blocks are named after it, "front 3-2".
    axis: Points ``[[x, y], ...]`` of its middle line, each straight above, below, left or right of the one
        before. It meets another wall where it crosses or ends on the other's axis.
    leaves: One or two, each as thick as a block.
    courses: Its height (default: that of the plan).
    openings: :class:`Opening` records.
    """

    name: Name
    axis: Annotated[list[Point], Field(min_length=2, max_length=50)]
    leaves: Literal[1, 2] = 1
    courses: Count | None = None
    openings: list[Opening] = []


class WallCrossing(NamedTuple):
    """Where another wall crosses a stretch or meets its end."""

    start: float  #: faces of the other wall, along the stretch
    end: float
    leaves: int  #: of the other wall
    courses: int  #: of the other wall; above them there is nothing to cross
    passes: tuple[bool, bool]  #: whether the stretch passes through, in even courses (from 0) and in odd ones

    @property
    def middles(self) -> list[float]:
        """Of the other wall's leaves."""
        leaf = (self.end - self.start) / self.leaves
        return [self.start + (number + 0.5) * leaf for number in range(self.leaves)]


class _Hole(NamedTuple):
    """An opening along a stretch: its jambs, its lintel's ends, its first course and the lintel's."""

    number: int
    jambs: _Run
    lintel: _Run
    sill: int
    top: int


class WallStretch(NamedTuple):
    """A straight piece of a wall along x or y."""

    wall: PlanWall  #: it is a piece of
    along: int  #: 0 if it runs along x, 1 along y
    line: float  #: the other coordinate of its axis
    start: float  #: of it along the axis; at corners the outer faces
    end: float
    thickness: float  #: of the wall, as the courses
    courses: int
    holes: tuple[_Hole, ...]  #: the wall's openings; once it is crossed, those in it, clear of crossings
    crossings: tuple[WallCrossing, ...] = ()  #: rising

    @property
    def faces(self) -> _Run:
        """Across its axis."""
        return self.line - self.thickness / 2, self.line + self.thickness / 2

    @property
    def bounds(self) -> tuple[_Run, _Run]:
        """Least and greatest x, and y."""
        along = self.start, self.end
        return (self.faces, along) if self.along else (along, self.faces)

    def bays(self) -> Iterator[tuple[float, float, WallCrossing | None]]:
        """Lengths between crossings, and the crossing at the start of each."""
        ends = [*(crossing.start for crossing in self.crossings), self.end]
        for left, end in zip([None, *self.crossings], ends, strict=True):
            start = left.end if left else self.start
            if start < end:
                yield start, end, left

    def clear(self, hole: _Hole, nothing: float) -> bool:
        """Whether an opening lies between crossings."""
        left, right = hole.lintel
        return any(low - nothing <= left and right <= high + nothing for low, high, _ in self.bays())

    def runs(self, course: int) -> list[_Run]:
        """Lengths that a course fills, beside walls that pass through it, openings and lintels."""
        here = [hole for hole in self.holes if hole.sill <= course <= hole.top]
        taken = [hole.lintel if course == hole.top else hole.jambs for hole in here]
        taken += [(a.start, a.end) for a in self.crossings if course < a.courses and not a.passes[course % 2]]
        return spaces(self.start, self.end, taken)


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
    walls: :class:`PlanWall` records.
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
        stretches = self._crossed()
        yield from _overlaps(stretches)
        mistakes = [*self._wrong_openings(stretches)]
        yield from mistakes or self._slivers(stretches)

    def _wrong_axes(self) -> Iterator[str]:
        for name in repeated(wall.name for wall in self.walls):
            yield f"two walls are named '{name}': rename one"
        for wall in self.walls:
            along = [(a[1] == b[1], a[0] == b[0]) for a, b in pairwise(wall.axis)]
            askew = [number for number, (level, upright) in enumerate(along, start=1) if level == upright]
            if askew:
                runs = f"runs neither along x nor along y from point no. {askew[0]} to the next"
                yield f"wall '{wall.name}': its 'axis' {runs}: walls meet at right angles"
            if any(upright == after for (_, upright), (_, after) in pairwise(along)):
                yield f"wall '{wall.name}': its 'axis' has a point where it does not turn: take it away"

    def _wrong_openings(self, stretches: list[WallStretch]) -> Iterator[str]:
        held = {(stretch.wall.name, hole.number) for stretch in stretches for hole in stretch.holes}
        for wall in self.walls:
            top = wall.courses or self.courses
            for number, opening in enumerate(wall.openings, start=1):
                where = f"wall '{wall.name}': opening no. {number}"
                if (rows := opening.sill + opening.height + 1) > top:
                    yield f"{where}: its lintel ends at course {rows}, of {top}: lower 'sill' or 'height'"
                elif (wall.name, number) not in held:
                    beyond = "with its lintel it reaches beyond the wall, or into one that crosses"
                    yield f"{where}: {beyond}: move it, or make its 'width' or 'bearing' less"
        for stretch in stretches:
            for a, b in combinations(stretch.holes, 2):
                overlap = min(a.lintel[1], b.lintel[1]) - max(a.lintel[0], b.lintel[0])
                if overlap > self._nothing and a.sill <= b.top and b.sill <= a.top:
                    overlapping = f"openings no. {a.number} and no. {b.number} overlap, with their lintels"
                    yield f"wall '{stretch.wall.name}': {overlapping}: move one, or make a 'bearing' less"

    def _slivers(self, stretches: list[WallStretch]) -> Iterator[str]:
        for stretch in stretches:
            for course in range(stretch.courses):
                pieces = [high - low for low, high in stretch.runs(course)]
                if min(pieces, default=math.inf) < CLOSER * self.block[0] - self._nothing:
                    piece = f"wall '{stretch.wall.name}': a piece of course {course + 1}"
                    short = f"{min(pieces):.3g} long, less than a quarter of a block"
                    yield f"{piece} would be {short}: move ends or openings"
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
                way = 1.0 if one[along] == start else -1.0
                holes = tuple(self._holes(wall, one[along] - way * before, way))
                place = wall, along, one[1 - along], start, end
                found.append(WallStretch(*place, wall.leaves * self.thickness, courses, holes))
                before += end - start
        return found

    def _holes(self, wall: PlanWall, origin: float, way: float) -> Iterator[_Hole]:
        """Its openings along a stretch where the wall's measure begins at a place and grows that way."""
        for number, opening in enumerate(wall.openings, start=1):
            left, right = sorted(origin + way * at for at in (opening.at, opening.at + opening.width))
            bearing = opening.bearing or self.block[0] / 2
            lintel, top = (left - bearing, right + bearing), opening.sill + opening.height
            yield _Hole(number, (left, right), lintel, opening.sill, top)

    def _crossed(self) -> list[WallStretch]:
        """Its stretches with crossings, ends that meet reaching to outer faces, and openings between them."""
        stretches = self._stretches()
        near = _EXACT * _size(stretches)
        found: list[list[WallCrossing]] = [[] for _ in stretches]
        for (i, one), (j, other) in permutations(enumerate(stretches), 2):
            both = [(one, other), (other, one)]
            apart = any(not a.start - near <= b.line <= a.end + near for a, b in both)
            if apart or one.along == other.along:
                continue  # their axes neither cross nor touch
            ends = [near >= min(abs(a.start - b.line), abs(a.end - b.line)) for a, b in both]
            # Butted, what ends there lies against what goes on, and else the second named.
            through = i < j if ends[0] == ends[1] else ends[1]
            passes = (through, through) if self.bond == "butted" else (i < j, i > j)
            found[i].append(WallCrossing(*other.faces, other.wall.leaves, other.courses, passes))
        whole = []
        for stretch, own in zip(stretches, found, strict=True):
            start, end = stretch.start, stretch.end
            for crossing in sorted(own):
                centre = (crossing.start + crossing.end) / 2
                start = crossing.start if abs(centre - stretch.start) <= near else start
                end = crossing.end if abs(centre - stretch.end) <= near else end
            crossed = stretch._replace(start=start, end=end, crossings=tuple(sorted(own)))
            holes = (hole for hole in stretch.holes if crossed.clear(hole, self._nothing))
            whole.append(crossed._replace(holes=tuple(holes)))
        return whole

    def blocks(self) -> list[Solid]:
        """The blocks, course by course, wall by wall, named ``wall course-block``. A wall's are counted along
        the straights of its axis, in each by rising coordinates, leaf by leaf. The ``base`` is last."""
        stretches = self._crossed()
        built, height = [], self.block[1]
        for course in range(max(stretch.courses for stretch in stretches)):
            numbers = {wall.name: count(1) for wall in self.walls}
            for stretch in [each for each in stretches if course < each.courses]:
                for along, across in self._course(stretch, course):
                    x, y = (across, along) if stretch.along else (along, across)
                    name = f"{stretch.wall.name} {course + 1}-{next(numbers[stretch.wall.name])}"
                    built.append(self._stone(name, {"box": (x, y, (course * height, (course + 1) * height))}))
        if self.base:
            reach = np.array([stretch.bounds for stretch in stretches])
            low, high = reach[:, :, 0].min(axis=0), reach[:, :, 1].max(axis=0)
            sides = zip((low - self.thickness).tolist(), (high + self.thickness).tolist(), strict=True)
            built.append(self._block("base", {"box": (*sides, (-height, 0.0))}, fixed=True))
        return built

    def _course(self, stretch: WallStretch, course: int) -> list[tuple[_Run, _Run]]:
        """The blocks of a stretch in a course: from and to along it, and across it."""
        whole, double = stretch.faces, stretch.wall.leaves == 2
        headers = double and self.headers is not None and (course + 1) % self.headers == 0
        leaves = [(whole[0], stretch.line), (stretch.line, whole[1])] if double and not headers else [whole]
        length = self.thickness if headers else self.block[0]
        joints: list[float] = []
        for start, end, left in stretch.bays():
            # Of two courses one begins with half a block: toothed, that which passes the other wall's faces.
            half = left.passes[course % 2] if left and self.bond == "toothed" else course % 2
            joints += every(length, start + length / 2 * (headers or half), end - CLOSER * length)
        middles = [middle for crossing in stretch.crossings for middle in crossing.middles]
        stones = [stone for run in stretch.runs(course) for stone in cut(*run, joints, length, middles)]
        pieces = [(stone, leaf) for leaf in leaves for stone in stones]
        lintels = [(hole.lintel, whole) for hole in stretch.holes if course == hole.top]
        # Leaf by leaf; lintels among the first leaf's.
        return sorted([*pieces, *lintels], key=lambda piece: (piece[1][0], piece[0]))


def _overlaps(stretches: list[WallStretch]) -> Iterator[str]:
    """What is wrong with crossed stretches that overlap and cannot be bonded."""
    near = _EXACT * _size(stretches)
    for one, other in combinations(stretches, 2):
        overlap = [min(a[1], b[1]) - max(a[0], b[0]) for a, b in zip(one.bounds, other.bounds, strict=True)]
        if min(overlap) <= near:
            continue
        if one.along == other.along:
            names = f"'{one.wall.name}' and '{other.wall.name}'"
            yield f"walls {names} overlap: move one; what goes on in one line is one 'axis'"
            continue
        for a, b in permutations((one, other)):
            if a.start > b.faces[0] + near or a.end < b.faces[1] - near:
                ends = f"wall '{a.wall.name}' ends within wall '{b.wall.name}'"
                yield f"{ends}: end its 'axis' on that of '{b.wall.name}', or at its face"
                break


def _size(stretches: list[WallStretch]) -> float:
    return max(max(abs(each.line), abs(each.start), abs(each.end), each.thickness) for each in stretches)

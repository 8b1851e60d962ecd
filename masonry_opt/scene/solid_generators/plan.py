"""Define the generator ``[plan]``: bonded walls along axes in plan, with openings under lintels."""

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

#: Length, relative to a block, that counts as zero.
_LENGTH_TOLERANCE = 1e-6

#: Distance of axes, relative to the plan's size, that counts as zero.
_AXIS_TOLERANCE = 1e-9

#: Start and end of a length.
_Run = tuple[float, float]


class Opening(Record):
    """A door or window through a wall, under a lintel one course high and as deep as the wall is thick.

    Parameters
    ----------
    at: Distance of the nearer jamb from the first point of the wall's axis, along the axis.
    width: Distance between the jambs.
    sill: Number of courses below the opening: 0 is a door.
    height: Number of courses of the opening.
    bearing: Bearing of the lintel on either side. The default is half a block, which fits the bond if
        ``sill`` and ``height`` add up to an odd number, and the jambs are whole blocks from the wall's end.
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
    name: Name of the wall; its blocks are named after it, "front 3-2".
    axis: Points ``[[x, y], ...]`` of its middle line, which runs along x or y from each point to the next.
        The wall meets another one if their axes cross, or one axis ends on the other.
    leaves: One or two, each as thick as a block.
    courses: Number of courses (default: that of the plan).
    openings: :class:`Opening` records.
    """

    name: Name
    axis: Annotated[list[Point], Field(min_length=2, max_length=50)]
    leaves: Literal[1, 2] = 1
    courses: Count | None = None
    openings: list[Opening] = []


class WallCrossing(NamedTuple):
    """A place where another wall crosses a stretch, or meets its end."""

    start: float  #: position of the other wall's first face along the stretch
    end: float  #: position of the other wall's second face along the stretch
    leaves: int  #: number of leaves of the other wall
    courses: int  #: number of courses of the other wall
    passes: tuple[bool, bool]  #: True if the stretch passes through, in even courses (from 0) and in odd ones

    @property
    def middles(self) -> list[float]:
        """Return the positions of the middles of the other wall's leaves along the stretch."""
        leaf = (self.end - self.start) / self.leaves
        return [self.start + (number + 0.5) * leaf for number in range(self.leaves)]


class _Hole(NamedTuple):
    """An opening along a stretch."""

    number: int  #: number of the opening in its wall, from 1
    jambs: _Run  #: positions of the jambs along the stretch
    lintel: _Run  #: positions of the lintel's ends along the stretch
    sill: int  #: first course of the opening, from 0
    top: int  #: course of the lintel


class WallStretch(NamedTuple):
    """A straight piece of a wall along x or y."""

    wall: PlanWall  #: the wall to which it belongs
    along: int  #: 0 if it runs along x, 1 along y
    line: float  #: the other coordinate of its axis
    start: float  #: its first end along the axis; at corners an outer face
    end: float  #: its second end along the axis; at corners an outer face
    thickness: float  #: thickness of the wall
    courses: int  #: number of courses of the wall
    #: The wall's openings. After crossings are known, only those in the stretch that are clear of crossings.
    holes: tuple[_Hole, ...]
    crossings: tuple[WallCrossing, ...] = ()  #: in rising order

    @property
    def faces(self) -> _Run:
        """Return the coordinates of the faces, perpendicular to the axis."""
        return self.line - self.thickness / 2, self.line + self.thickness / 2

    @property
    def bounds(self) -> tuple[_Run, _Run]:
        """Return the least and greatest x, and the least and greatest y."""
        along = self.start, self.end
        return (self.faces, along) if self.along else (along, self.faces)

    def bays(self) -> Iterator[tuple[float, float, WallCrossing | None]]:
        """Yield the start and end of each length between crossings, and the crossing before it."""
        ends = [*(crossing.start for crossing in self.crossings), self.end]
        for left, end in zip([None, *self.crossings], ends, strict=True):
            start = left.end if left else self.start
            if start < end:
                yield start, end, left

    def clear(self, hole: _Hole, nothing: float) -> bool:
        """Return True if an opening with its lintel lies between crossings.

        ``nothing`` is a length that counts as zero.
        """
        left, right = hole.lintel
        return any(low - nothing <= left and right <= high + nothing for low, high, _ in self.bays())

    def runs(self, course: int) -> list[_Run]:
        """Return the lengths that a course fills.

        Walls that pass through the stretch, openings and lintels are left out.
        """
        here = [hole for hole in self.holes if hole.sill <= course <= hole.top]
        taken = [hole.lintel if course == hole.top else hole.jambs for hole in here]
        taken += [(a.start, a.end) for a in self.crossings if course < a.courses and not a.passes[course % 2]]
        return spaces(self.start, self.end, taken)


class Plan(SolidGenerator):
    """Walls of blocks in running bond, bonded or butted where they meet at right angles, on a fixed base.

    The top of the base is z = 0. Courses alternate by half a block. At a corner or crossing a block of the
    wall that passes through reaches beyond the other's face. Pieces beside ends and openings are at least a
    quarter of a block long. A shorter piece is joined to its neighbour.

    Raises CaseError if an axis has other than right angles, if walls overlap, if an opening does not fit, or
    if a piece would be shorter than a quarter of a block.

    Parameters
    ----------
    block: Length and height of a block.
    thickness: Thickness of a block, and so of a leaf.
    walls: :class:`PlanWall` records.
    courses: Number of courses of the walls.
    bond: Bond where walls meet. "toothed": the wall that is named first passes through in the first course,
        the other one in the second, in turn. "butted": a wall that ends at another one lies against it. If
        both end there, or both cross, the second named lies against the first.
    headers: For walls of two leaves: 2 for headers in every second course, 3 in every third, ... Headers are
        blocks across both leaves, half as wide as both. Without them only friction connects the leaves.
    base: True for a fixed base under all walls, which extends beyond them by the thickness of a leaf.
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
        mistakes = [*self._wrong_axes()] or [*super()._mistakes()]
        if mistakes:
            yield from mistakes
            return
        if self.headers and all(wall.leaves == 1 for wall in self.walls):
            yield "'headers' bind two leaves: give a wall 'leaves = 2', or take 'headers' away"
        stretches = self._crossed()
        yield from _overlaps(stretches)
        mistakes = [*self._wrong_openings(stretches)]
        yield from mistakes or self._slivers(stretches)

    def _wrong_axes(self) -> Iterator[str]:
        """Yield the mistakes in the names and axes of walls."""
        for name in repeated(wall.name for wall in self.walls):
            yield f"two walls are named '{name}': rename one"
        for wall in self.walls:
            directions = [(a[1] == b[1], a[0] == b[0]) for a, b in pairwise(wall.axis)]
            oblique = [
                number for number, (along_x, along_y) in enumerate(directions, start=1) if along_x == along_y
            ]
            if oblique:
                runs = f"runs neither along x nor along y from point no. {oblique[0]} to the next"
                yield f"wall '{wall.name}': its 'axis' {runs}: walls meet at right angles"
            if any(along_y == next_along_y for (_, along_y), (_, next_along_y) in pairwise(directions)):
                yield f"wall '{wall.name}': its 'axis' has a point where it does not turn: take it away"

    def _wrong_openings(self, stretches: list[WallStretch]) -> Iterator[str]:
        """Yield the openings that do not fit their wall, or overlap."""
        valid = {(stretch.wall.name, hole.number) for stretch in stretches for hole in stretch.holes}
        for wall in self.walls:
            top = wall.courses or self.courses
            for number, opening in enumerate(wall.openings, start=1):
                where = f"wall '{wall.name}': opening no. {number}"
                rows = opening.sill + opening.height + 1
                if rows > top:
                    yield f"{where}: its lintel ends at course {rows}, of {top}: lower 'sill' or 'height'"
                elif (wall.name, number) not in valid:
                    beyond = "with its lintel it reaches beyond the wall, or into one that crosses"
                    yield f"{where}: {beyond}: move it, or make its 'width' or 'bearing' less"
        for stretch in stretches:
            for a, b in combinations(stretch.holes, 2):
                overlap = min(a.lintel[1], b.lintel[1]) - max(a.lintel[0], b.lintel[0])
                if overlap > self._nothing and a.sill <= b.top and b.sill <= a.top:
                    overlapping = f"openings no. {a.number} and no. {b.number} overlap, with their lintels"
                    yield f"wall '{stretch.wall.name}': {overlapping}: move one, or make a 'bearing' less"

    def _slivers(self, stretches: list[WallStretch]) -> Iterator[str]:
        """Yield the first piece of each stretch that is shorter than a quarter of a block."""
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
        """Return a length that counts as zero."""
        return _LENGTH_TOLERANCE * self.block[0]

    @property
    def size(self) -> int:
        """Return an upper bound of the number of blocks."""
        least = min(self.block[0], self.thickness) if self.headers else self.block[0]
        lengths = [(stretch, (stretch.end - stretch.start) / least + 4) for stretch in self._stretches()]
        return int(sum(min(most, 1e9) * stretch.courses * stretch.wall.leaves for stretch, most in lengths))

    def _stretches(self) -> list[WallStretch]:
        """Return the straight pieces of all walls, without their crossings."""
        stretches = []
        for wall in self.walls:
            before = 0.0  # length of the axis before the stretch
            courses = wall.courses or self.courses
            for first, second in pairwise(wall.axis):
                along = 0 if first[1] == second[1] else 1
                start, end = sorted((first[along], second[along]))
                sign = 1.0 if first[along] == start else -1.0
                holes = tuple(self._holes(wall, first[along] - sign * before, sign))
                place = wall, along, first[1 - along], start, end
                stretches.append(WallStretch(*place, wall.leaves * self.thickness, courses, holes))
                before += end - start
        return stretches

    def _holes(self, wall: PlanWall, origin: float, sign: float) -> Iterator[_Hole]:
        """Yield the openings of a wall, measured along a stretch.

        The wall's own measure is zero at ``origin``, and grows along the stretch if the sign is 1, against it
        if it is −1.
        """
        for number, opening in enumerate(wall.openings, start=1):
            left, right = sorted(origin + sign * at for at in (opening.at, opening.at + opening.width))
            bearing = opening.bearing or self.block[0] / 2
            lintel = (left - bearing, right + bearing)
            top = opening.sill + opening.height
            yield _Hole(number, (left, right), lintel, opening.sill, top)

    def _crossed(self) -> list[WallStretch]:
        """Return the stretches with their crossings.

        Ends that meet other walls reach to the outer faces. Openings that are not clear of crossings are left
        out.
        """
        stretches = self._stretches()
        near = _AXIS_TOLERANCE * _size(stretches)
        found: list[list[WallCrossing]] = [[] for _ in stretches]
        for (i, one), (j, other) in permutations(enumerate(stretches), 2):
            both = [(one, other), (other, one)]
            apart = any(not a.start - near <= b.line <= a.end + near for a, b in both)
            if apart or one.along == other.along:
                continue  # their axes neither cross nor touch
            ends = [near >= min(abs(a.start - b.line), abs(a.end - b.line)) for a, b in both]
            # In a butted bond a wall that ends lies against one that goes on, else the second against the
            # first.
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
        """Return the blocks, course by course and wall by wall, then the ``base``.

        They are named ``wall course-block``. The blocks of a wall are counted along the straights of its
        axis, in each by rising coordinates, leaf by leaf.
        """
        stretches = self._crossed()
        built = []
        height = self.block[1]
        for course in range(max(stretch.courses for stretch in stretches)):
            numbers = {wall.name: count(1) for wall in self.walls}
            for stretch in [stretch for stretch in stretches if course < stretch.courses]:
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
        """Return the blocks of a stretch in a course, as their lengths along it and across it."""
        whole, double = stretch.faces, stretch.wall.leaves == 2
        headers = double and self.headers is not None and (course + 1) % self.headers == 0
        leaves = [(whole[0], stretch.line), (stretch.line, whole[1])] if double and not headers else [whole]
        length = self.thickness if headers else self.block[0]
        joints: list[float] = []
        for start, end, left in stretch.bays():
            # Every other course begins with half a block. In a toothed bond these courses pass the other
            # wall.
            half = left.passes[course % 2] if left and self.bond == "toothed" else course % 2
            joints += every(length, start + length / 2 * (headers or half), end - CLOSER * length)
        middles = [middle for crossing in stretch.crossings for middle in crossing.middles]
        stones = [stone for run in stretch.runs(course) for stone in cut(*run, joints, length, middles)]
        pieces = [(stone, leaf) for leaf in leaves for stone in stones]
        lintels = [(hole.lintel, whole) for hole in stretch.holes if course == hole.top]
        # Stones are sorted leaf by leaf; lintels are among those of the first leaf.
        return sorted([*pieces, *lintels], key=lambda piece: (piece[1][0], piece[0]))


def _overlaps(stretches: list[WallStretch]) -> Iterator[str]:
    """Yield the pairs of stretches that overlap and cannot be bonded."""
    near = _AXIS_TOLERANCE * _size(stretches)
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
    """Return the largest coordinate or thickness of the stretches."""
    return max(
        max(abs(stretch.line), abs(stretch.start), abs(stretch.end), stretch.thickness)
        for stretch in stretches
    )

"""Define the generator ``[plan]``: bonded walls along axes in plan, with openings under lintels."""

import math
from collections.abc import Iterator
from itertools import combinations, count, pairwise, permutations
from typing import Annotated, Literal, NamedTuple

import numpy as np
from pydantic import Field, Strict

from masonry_opt.errors import rounded
from masonry_opt.scene.blocks import Name, NonNegative, Point, Positive, Record, YesNo
from masonry_opt.scene.generator import CLOSER, Count, SolidGenerator, cut, every
from masonry_opt.scene.mistakes import repeated
from masonry_opt.scene.rows import spaces
from masonry_opt.scene.solids import Solid

#: Length, relative to the length of a block, below which a distance counts as zero.
_ZERO_LENGTH_TOLERANCE = 1e-6

#: Largest distance at which two wall axes count as touching, relative to the size of the plan.
_AXIS_TOLERANCE = 1e-9

#: Start and end of a piece of a wall, as coordinates along the wall.
_Run = tuple[float, float]


class Opening(Record):
    """A door or window in a wall. Its lintel is one course high and as thick as the wall.

    Parameters
    ----------
    at: Distance of the nearer jamb from the first point of the wall's axis, along the axis.
    width: Distance between the jambs.
    sill: Number of courses below the opening: 0 for a door.
    height: Number of courses of the opening.
    bearing: Bearing of the lintel on either side. The default is half a block, which fits the bond if
        ``sill`` and ``height`` add up to an odd number, and the jambs are whole blocks from the wall's end.

    Raises
    ------
    CaseError
        If a value is out of range.
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
    name: Name of the wall, with which the names of its blocks begin: ``front 3-2``.
    axis: Points ``[[x, y], ...]`` of the middle line of the wall. The line is parallel to x or y between
        successive points. Two walls meet if their axes cross, or if one axis ends on the other axis.
    leaves: Number of leaves, one or two, each as thick as a block.
    courses: Number of courses (default: the number of courses of the plan).
    openings: :class:`Opening` records.

    Raises
    ------
    CaseError
        If the axis has fewer than two points, or if a value is out of range.
    """

    name: Name
    axis: Annotated[list[Point], Field(min_length=2, max_length=50)]
    leaves: Literal[1, 2] = 1
    courses: Count | None = None
    openings: list[Opening] = []


class WallCrossing(NamedTuple):
    """Place where a straight piece of a wall crosses another wall, or ends at another wall."""

    start: float  #: smaller of the positions, along this wall, of the other wall's two faces
    end: float  #: larger of the positions, along this wall, of the other wall's two faces
    leaves: int  #: number of leaves of the other wall
    courses: int  #: number of courses of the other wall
    #: One flag for even courses (counted from 0) and one for odd courses: True if this wall passes through
    #: the other wall, False if the other wall interrupts this wall.
    passes: tuple[bool, bool]

    @property
    def middles(self) -> list[float]:
        """Return the position, along this wall, of the middle line of each leaf of the wall that it meets."""
        leaf = (self.end - self.start) / self.leaves
        return [self.start + (number + 0.5) * leaf for number in range(self.leaves)]


class _Hole(NamedTuple):
    """Opening in a straight piece of a wall."""

    number: int  #: number of the opening in its wall, from 1
    jambs: _Run  #: positions of the jambs along the wall
    lintel: _Run  #: positions of the lintel's ends along the wall
    sill: int  #: first course of the opening, from 0
    top: int  #: course of the lintel


class WallStretch(NamedTuple):
    """Stretch of a wall: a straight piece along x or y, with its openings and crossings."""

    wall: PlanWall  #: wall to which this straight piece belongs
    along: int  #: direction of this piece of wall: 0 for x, 1 for y
    line: float  #: y of the axis if this piece of wall is along x, and x if it is along y
    #: Coordinate along the axis at which this piece of wall begins, less than ``end``. At a corner of two
    #: walls, this piece begins at the outer face of the other wall.
    start: float
    #: Coordinate along the axis at which this piece of wall ends. At a corner of two walls, this piece ends
    #: at the outer face of the other wall.
    end: float
    thickness: float  #: thickness of the wall
    courses: int  #: number of courses of the wall
    #: Openings of the wall. After the crossings have been computed, openings outside this piece of wall or at
    #: crossings are removed.
    holes: tuple[_Hole, ...]
    #: Other walls that cross or meet this piece of wall, in ascending order of position.
    crossings: tuple[WallCrossing, ...] = ()

    @property
    def faces(self) -> _Run:
        """Return the coordinates of the two faces of the wall, measured perpendicular to its axis."""
        return self.line - self.thickness / 2, self.line + self.thickness / 2

    @property
    def bounds(self) -> tuple[_Run, _Run]:
        """Return the smallest and largest x of this piece of wall, and its smallest and largest y."""
        extent = self.start, self.end
        return (self.faces, extent) if self.along else (extent, self.faces)

    def bays(self) -> Iterator[tuple[float, float, WallCrossing | None]]:
        """Divide this stretch of wall where other walls cross it, and yield the start and end of each piece.

        Each piece comes with the crossing before it, or None for the first piece.
        """
        ends = [*(crossing.start for crossing in self.crossings), self.end]
        for previous_crossing, end in zip([None, *self.crossings], ends, strict=True):
            start = previous_crossing.end if previous_crossing else self.start
            if start < end:
                yield start, end, previous_crossing

    def clear(self, hole: _Hole, zero_length: float) -> bool:
        """Return True if neither an opening nor its lintel extends beyond this piece or into a crossing wall.

        ``zero_length`` is the largest length that counts as zero.
        """
        left, right = hole.lintel
        return any(low - zero_length <= left and right <= high + zero_length for low, high, _ in self.bays())

    def runs(self, course: int) -> list[_Run]:
        """Return the runs of a course: start and end of each uninterrupted row of blocks.

        Walls that pass through this wall, openings and lintels interrupt the course.
        """
        course_holes = [hole for hole in self.holes if hole.sill <= course <= hole.top]
        gaps = [hole.lintel if course == hole.top else hole.jambs for hole in course_holes]
        gaps += [
            (crossing.start, crossing.end)
            for crossing in self.crossings
            if course < crossing.courses and not crossing.passes[course % 2]
        ]
        return spaces(self.start, self.end, gaps)


class Plan(SolidGenerator):
    """Walls in running bond on a fixed base. Where walls meet at right angles, they are bonded or butted.

    The top of the base is at z = 0. Every second course is shifted by half a block. At a corner or crossing,
    a block of the wall that passes through extends beyond the face of the other wall. Pieces at ends and
    openings are at least a quarter of a block long. A shorter piece is joined to its neighbour.

    Parameters
    ----------
    block: Length and height of a block.
    thickness: Thickness of a block, which is the thickness of a leaf.
    walls: :class:`PlanWall` records.
    courses: Number of courses of the walls.
    bond: Bond of walls that meet. "toothed": in the first course the wall that is named first passes through
        the other wall, in the second course the other wall passes through, and so on. "butted": a wall that
        ends at another wall is built against its face. If both walls end there, or if both cross, the wall
        that is named second is built against the first.
    headers: For walls of two leaves: 2 for headers in every second course, 3 for headers in every third
        course, and so on. A header is a block through both leaves, as wide as one leaf is thick. Without
        headers, only friction connects the leaves.
    base: True for a fixed base under all walls, which extends beyond them by the thickness of a leaf.
    name, at, live_per_weight, unit_weight: See :class:`~masonry_opt.scene.generator.SolidGenerator`; the
        origin is the origin of the coordinates of the axes, at the foot of the walls.

    Raises
    ------
    CaseError
        If an axis has an angle that is not a right angle, if walls overlap, if an opening does not fit, or if
        a piece would be shorter than a quarter of a block.
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
            yield "'headers' need a wall with two leaves: set 'leaves = 2' for a wall, or remove 'headers'"
        stretches = self._crossed_stretches()
        yield from _overlapping_walls(stretches)
        mistakes = [*self._wrong_openings(stretches)]
        yield from mistakes or self._short_pieces(stretches)

    def _wrong_axes(self) -> Iterator[str]:
        """Generate an error message for each repeated wall name, and for each axis that is not valid."""
        for name in repeated(wall.name for wall in self.walls):
            yield f"two walls are named '{name}': rename one of them"
        for wall in self.walls:
            directions = [(start[1] == end[1], start[0] == end[0]) for start, end in pairwise(wall.axis)]
            oblique = [
                number for number, (along_x, along_y) in enumerate(directions, start=1) if along_x == along_y
            ]
            if oblique:
                yield (
                    f"the 'axis' of wall '{wall.name}' is not parallel to x or y between point "
                    f"no. {oblique[0]} and the next point: draw all parts of the axis along x or y"
                )
            if any(along_y == next_along_y for (_, along_y), (_, next_along_y) in pairwise(directions)):
                yield (
                    f"the 'axis' of wall '{wall.name}' must turn by 90° at each point between its two ends: "
                    "remove the points at which it is straight"
                )

    def _wrong_openings(self, stretches: list[WallStretch]) -> Iterator[str]:
        """Generate an error message for each opening that does not fit its wall or overlaps another one."""
        valid = {(stretch.wall.name, hole.number) for stretch in stretches for hole in stretch.holes}
        for wall in self.walls:
            top = wall.courses or self.courses
            for number, opening in enumerate(wall.openings, start=1):
                label = f"opening no. {number} of wall '{wall.name}'"
                rows = opening.sill + opening.height + 1
                if rows > top:
                    yield (
                        f"the lintel of {label} is in course {rows}, but the wall has {top} courses: "
                        "reduce 'sill' or 'height'"
                    )
                elif (wall.name, number) not in valid:
                    yield (
                        f"{label} or its lintel extends beyond the wall or into a crossing wall: move the "
                        "opening, or reduce its 'width' or 'bearing'"
                    )
        for stretch in stretches:
            for first, second in combinations(stretch.holes, 2):
                overlap = min(first.lintel[1], second.lintel[1]) - max(first.lintel[0], second.lintel[0])
                if overlap > self._zero_length and first.sill <= second.top and second.sill <= first.top:
                    yield (
                        f"in wall '{stretch.wall.name}', openings no. {first.number} and no. {second.number} "
                        "or their lintels overlap: move an opening, or reduce a 'bearing'"
                    )

    def _short_pieces(self, stretches: list[WallStretch]) -> Iterator[str]:
        """Generate an error message for each straight piece of wall in which a row of blocks is too short.

        In each course, every uninterrupted row of blocks must be at least a quarter of a block long.
        """
        for stretch in stretches:
            for course in range(stretch.courses):
                pieces = [high - low for low, high in stretch.runs(course)]
                if min(pieces, default=math.inf) < CLOSER * self.block[0] - self._zero_length:
                    yield (
                        f"in wall '{stretch.wall.name}', a piece of course {course + 1} would be "
                        f"{rounded(min(pieces))} long, less than a quarter of a block: "
                        "move an end of the wall or an opening"
                    )
                    break

    @property
    def _zero_length(self) -> float:
        """Return the length up to which a distance counts as zero, to allow for rounding errors."""
        return _ZERO_LENGTH_TOLERANCE * self.block[0]

    @property
    def size(self) -> int:
        """Return an upper bound on the number of blocks."""
        shortest_block = min(self.block[0], self.thickness) if self.headers else self.block[0]
        lengths = [
            (stretch, (stretch.end - stretch.start) / shortest_block + 4) for stretch in self._stretches()
        ]
        return int(
            sum(
                min(block_count, 1e9) * stretch.courses * stretch.wall.leaves
                for stretch, block_count in lengths
            )
        )

    def _stretches(self) -> list[WallStretch]:
        """Return the straight pieces of all walls, before their crossings are computed."""
        stretches = []
        for wall in self.walls:
            previous_length = 0.0  # length of the wall's axis before this piece of wall
            courses = wall.courses or self.courses
            for first, second in pairwise(wall.axis):
                direction = 0 if first[1] == second[1] else 1
                start, end = sorted((first[direction], second[direction]))
                sign = 1.0 if first[direction] == start else -1.0
                holes = tuple(self._holes(wall, first[direction] - sign * previous_length, sign))
                place = wall, direction, first[1 - direction], start, end
                stretches.append(WallStretch(*place, wall.leaves * self.thickness, courses, holes))
                previous_length += end - start
        return stretches

    def _holes(self, wall: PlanWall, origin: float, sign: float) -> Iterator[_Hole]:
        """Yield the openings of a wall, with their positions along one of the wall's straight pieces.

        Distances along the wall's axis begin at ``origin``. They increase along the piece if the sign is 1,
        and decrease if the sign is −1.
        """
        for number, opening in enumerate(wall.openings, start=1):
            left, right = sorted(origin + sign * at for at in (opening.at, opening.at + opening.width))
            bearing = opening.bearing or self.block[0] / 2
            lintel = (left - bearing, right + bearing)
            top = opening.sill + opening.height
            yield _Hole(number, (left, right), lintel, opening.sill, top)

    def _crossed_stretches(self) -> list[WallStretch]:
        """Return the straight pieces of all walls, with their crossings.

        Ends that meet other walls are extended to the outer faces of these walls. Openings that touch
        crossings are left out.
        """
        stretches = self._stretches()
        tolerance = _AXIS_TOLERANCE * _plan_size(stretches)
        crossings: list[list[WallCrossing]] = [[] for _ in stretches]
        for (i, first), (j, second) in permutations(enumerate(stretches), 2):
            orders = [(first, second), (second, first)]
            is_apart = any(
                not piece.start - tolerance <= other_piece.line <= piece.end + tolerance
                for piece, other_piece in orders
            )
            if is_apart or first.along == second.along:
                continue  # the axes neither cross nor touch
            ends = [
                tolerance >= min(abs(piece.start - other_piece.line), abs(piece.end - other_piece.line))
                for piece, other_piece in orders
            ]
            # In a butted bond, one of two walls that meet passes through the junction, and the other is built
            # against it. A wall that ends at the junction is built against a wall that continues. If both end
            # or both continue, the wall that is listed later is built against the wall listed earlier.
            passes_through = i < j if ends[0] == ends[1] else ends[1]
            passes = (passes_through, passes_through) if self.bond == "butted" else (i < j, i > j)
            crossings[i].append(WallCrossing(*second.faces, second.wall.leaves, second.courses, passes))
        crossed_stretches = []
        for stretch, stretch_crossings in zip(stretches, crossings, strict=True):
            start, end = stretch.start, stretch.end
            for crossing in sorted(stretch_crossings):
                centre = (crossing.start + crossing.end) / 2
                start = crossing.start if abs(centre - stretch.start) <= tolerance else start
                end = crossing.end if abs(centre - stretch.end) <= tolerance else end
            crossed_stretch = stretch._replace(
                start=start, end=end, crossings=tuple(sorted(stretch_crossings))
            )
            holes = (hole for hole in stretch.holes if crossed_stretch.clear(hole, self._zero_length))
            crossed_stretches.append(crossed_stretch._replace(holes=tuple(holes)))
        return crossed_stretches

    def blocks(self) -> list[Solid]:
        """Return the blocks, course by course and wall by wall, and finally the ``base``.

        The names are ``wall course-block``. The blocks of a course are numbered along the straight pieces of
        the wall's axis. In each piece they are numbered leaf by leaf, by ascending coordinates.

        Returns
        -------
        list of Solid
            The blocks, in the coordinates of the scene.
        """
        stretches = self._crossed_stretches()
        solids = []
        height = self.block[1]
        for course in range(max(stretch.courses for stretch in stretches)):
            numbers = {wall.name: count(1) for wall in self.walls}
            for stretch in [stretch for stretch in stretches if course < stretch.courses]:
                for along, across in self._course(stretch, course):
                    x, y = (across, along) if stretch.along else (along, across)
                    name = f"{stretch.wall.name} {course + 1}-{next(numbers[stretch.wall.name])}"
                    solids.append(
                        self._stone(name, {"box": (x, y, (course * height, (course + 1) * height))})
                    )
        if self.base:
            reach = np.array([stretch.bounds for stretch in stretches])
            low, high = reach[:, :, 0].min(axis=0), reach[:, :, 1].max(axis=0)
            sides = zip((low - self.thickness).tolist(), (high + self.thickness).tolist(), strict=True)
            solids.append(self._block("base", {"box": (*sides, (-height, 0.0))}, fixed=True))
        return solids

    def _course(self, stretch: WallStretch, course: int) -> list[tuple[_Run, _Run]]:
        """Return the extents, along and across the wall, of the blocks in a course of a straight piece."""
        wall_faces, has_two_leaves = stretch.faces, stretch.wall.leaves == 2
        headers = has_two_leaves and self.headers is not None and (course + 1) % self.headers == 0
        leaves = (
            [(wall_faces[0], stretch.line), (stretch.line, wall_faces[1])]
            if has_two_leaves and not headers
            else [wall_faces]
        )
        length = self.thickness if headers else self.block[0]
        joints: list[float] = []
        for start, end, previous_crossing in stretch.bays():
            # After a crossing in a toothed bond, a course begins with half a block if this wall passes
            # through the other wall in this course. Elsewhere, every second course begins with half a block.
            half = (
                previous_crossing.passes[course % 2]
                if previous_crossing and self.bond == "toothed"
                else course % 2
            )
            joints += every(length, start + length / 2 * (headers or half), end - CLOSER * length)
        middles = [middle for crossing in stretch.crossings for middle in crossing.middles]
        stones = [stone for run in stretch.runs(course) for stone in cut(*run, joints, length, middles)]
        pieces = [(stone, leaf) for leaf in leaves for stone in stones]
        lintels = [(hole.lintel, wall_faces) for hole in stretch.holes if course == hole.top]
        # Sort the blocks by leaf. Lintels are sorted with the first leaf.
        return sorted([*pieces, *lintels], key=lambda piece: (piece[1][0], piece[0]))


def _overlapping_walls(stretches: list[WallStretch]) -> Iterator[str]:
    """Generate an error message for each place where two walls overlap but cannot be bonded."""
    tolerance = _AXIS_TOLERANCE * _plan_size(stretches)
    for first, second in combinations(stretches, 2):
        overlap = [
            min(first_range[1], second_range[1]) - max(first_range[0], second_range[0])
            for first_range, second_range in zip(first.bounds, second.bounds, strict=True)
        ]
        if min(overlap) <= tolerance:
            continue
        if first.along == second.along:
            yield (
                f"walls '{first.wall.name}' and '{second.wall.name}' overlap: "
                "move one of them, or replace walls on the same line by a single wall"
            )
            continue
        for stretch, other_stretch in permutations((first, second)):
            if (
                stretch.start > other_stretch.faces[0] + tolerance
                or stretch.end < other_stretch.faces[1] - tolerance
            ):
                yield (
                    f"wall '{stretch.wall.name}' ends inside wall '{other_stretch.wall.name}': "
                    f"end its 'axis' on the axis or at the face of '{other_stretch.wall.name}'"
                )
                break


def _plan_size(stretches: list[WallStretch]) -> float:
    """Return the size of the plan: the largest coordinate or thickness of its walls."""
    return max(
        max(abs(stretch.line), abs(stretch.start), abs(stretch.end), stretch.thickness)
        for stretch in stretches
    )

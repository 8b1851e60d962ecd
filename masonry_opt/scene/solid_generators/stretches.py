"""Walls in plan, their straight stretches, where they cross, and which passes through in a course."""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from itertools import combinations, permutations
from typing import Annotated, Literal, NamedTuple

from pydantic import Field, Strict

from masonry_opt.scene.blocks import Name, NonNegative, Point, Positive, Record
from masonry_opt.scene.generator import Count

_ROUNDING = 1e-9  #: Of the plan's size, a distance that is nothing.


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
    openings:
        :class:`Opening` records.
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


@dataclass(frozen=True)
class WallStretch:
    """A straight piece of a wall along x or y."""

    wall: PlanWall  #: it is a piece of
    along: int  #: 0 if it runs along x, 1 along y
    line: float  #: the other coordinate of its axis
    start: float  #: of it along the axis; at corners the outer faces
    end: float
    thickness: float  #: of the wall, as the courses
    courses: int
    #: Where the wall's own measure, from the first point of its axis, is 0 along the stretch, and 1 if it
    #: grows with the coordinate, else -1.
    origin: float
    way: float
    crossings: tuple[WallCrossing, ...] = ()  #: rising

    @property
    def faces(self) -> tuple[float, float]:
        """Across its axis."""
        return self.line - self.thickness / 2, self.line + self.thickness / 2

    @property
    def bounds(self) -> tuple[tuple[float, float], tuple[float, float]]:
        """Least and greatest x, and y."""
        along = self.start, self.end
        return (self.faces, along) if self.along else (along, self.faces)

    def gaps(self, course: int) -> Iterator[tuple[float, float]]:
        """Where other walls pass through it in a course."""
        for crossing in self.crossings:
            if course < crossing.courses and not crossing.passes[course % 2]:
                yield crossing.start, crossing.end

    def bays(self) -> Iterator[tuple[float, float, WallCrossing | None]]:
        """Lengths between crossings, and the crossing at the start of each."""
        start, left = self.start, None
        for crossing in self.crossings:
            if crossing.start > start:
                yield start, crossing.start, left
            start, left = crossing.end, crossing
        if start < self.end:
            yield start, self.end, left


def crossed(stretches: list[WallStretch], toothed: bool) -> list[WallStretch]:
    """The stretches with their crossings, ends that meet reaching to the outer face."""
    near = _ROUNDING * _size(stretches)
    found: list[list[WallCrossing]] = [[] for _ in stretches]
    for (i, one), (j, other) in combinations(enumerate(stretches), 2):
        both = [(one, other), (other, one)]
        if one.along == other.along or any(not a.start - near <= b.line <= a.end + near for a, b in both):
            continue  # their axes neither cross nor touch
        ends = [near >= min(abs(a.start - b.line), abs(a.end - b.line)) for a, b in both]
        # Butted, what ends there lies against what goes on, and else the second named.
        first = not ends[0] or ends[1]
        passes = ((True, False), (False, True)) if toothed else ((first, first), (not first, not first))
        for number, wall, through in ((i, other, passes[0]), (j, one, passes[1])):
            found[number].append(WallCrossing(*wall.faces, wall.wall.leaves, wall.courses, through))
    whole = []
    for stretch, own in zip(stretches, found, strict=True):
        start, end = stretch.start, stretch.end
        for crossing in sorted(own):
            centre = (crossing.start + crossing.end) / 2
            start = crossing.start if abs(centre - stretch.start) <= near else start
            end = crossing.end if abs(centre - stretch.end) <= near else end
        whole.append(replace(stretch, start=start, end=end, crossings=tuple(sorted(own))))
    return whole


def conflicts(stretches: list[WallStretch]) -> Iterator[tuple[WallStretch, WallStretch, bool]]:
    """Crossed stretches that overlap and cannot be bonded, and whether they are parallel: else one ends
    within the other."""
    near = _ROUNDING * _size(stretches)
    for one, other in combinations(stretches, 2):
        overlap = [min(a[1], b[1]) - max(a[0], b[0]) for a, b in zip(one.bounds, other.bounds, strict=True)]
        if min(overlap) <= near:
            continue
        if one.along == other.along:
            yield one, other, True
            continue
        for a, b in permutations((one, other)):
            if a.start > b.faces[0] + near or a.end < b.faces[1] - near:
                yield a, b, False
                break


def _size(stretches: list[WallStretch]) -> float:
    return max(max(abs(each.line), abs(each.start), abs(each.end), each.thickness) for each in stretches)

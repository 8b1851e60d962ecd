"""Straight stretches of walls in plan, where they cross, and which of two passes through in a course."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from itertools import combinations, permutations
from typing import NamedTuple

#: Of the plan's size, a distance that is nothing.
_ROUNDING = 1e-9


class WallCrossing(NamedTuple):
    """Where another wall crosses a stretch or meets its end.

    Attributes
    ----------
    start, end: faces of the other wall, along the stretch.
    leaves, courses: of the other wall; above them there is nothing to cross.
    passes: whether the stretch passes through, in even courses and in odd ones, counted from 0.
    """

    start: float
    end: float
    leaves: int
    courses: int
    passes: tuple[bool, bool]

    @property
    def middles(self) -> list[float]:
        """Of the other wall's leaves."""
        leaf = (self.end - self.start) / self.leaves
        return [self.start + (number + 0.5) * leaf for number in range(self.leaves)]


@dataclass(frozen=True)
class WallStretch:
    """A straight piece of a wall along x or y.

    Attributes
    ----------
    wall: index of the wall.
    along: 0 if it runs along x, 1 along y.
    line: the other coordinate of its axis.
    start, end: of it along the axis; at corners the outer faces.
    thickness, leaves, courses: of the wall.
    origin, forwards: where the wall's own measure, from the first point of its axis, is 0 along the stretch,
        and whether it grows with the coordinate.
    crossings: rising.
    """

    wall: int
    along: int
    line: float
    start: float
    end: float
    thickness: float
    leaves: int
    courses: int
    origin: float
    forwards: bool
    crossings: tuple[WallCrossing, ...] = ()

    @property
    def faces(self) -> tuple[float, float]:
        """Across its axis."""
        return self.line - self.thickness / 2, self.line + self.thickness / 2

    @property
    def bounds(self) -> tuple[tuple[float, float], tuple[float, float]]:
        """Least and greatest x, and y."""
        along = self.start, self.end
        return (self.faces, along) if self.along else (along, self.faces)

    def place(self, measure: float) -> float:
        """The coordinate along it of a measure of the wall."""
        return self.origin + measure if self.forwards else self.origin - measure

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
            found[number].append(WallCrossing(*wall.faces, wall.leaves, wall.courses, through))
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

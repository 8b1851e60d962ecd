"""The ``[facade]`` generator: one pattern of blocks round an opening, repeated across and upwards."""

from __future__ import annotations

import itertools
from collections.abc import Iterable, Iterator
from typing import Annotated

from pydantic import Field, Strict

from masonry_opt.scene.blocks import MOST_BLOCKS, Block, NonNegative, Positive, rectangle
from masonry_opt.scene.generator import WeighedGenerator

Count = Annotated[int, Strict(), Field(ge=1, le=1000)]


class Facade(WeighedGenerator):
    """Running bond with x × y equal openings, each under a lintel, on a fixed base whose top is y = 0.

    Courses alternate, whole blocks first; where a block of the shifted course would cross the edge of
    an opening, its inner half is left away, so that both jambs are straight. A storey is ``sill``
    courses, the ``opening``'s, and those of the lintel and the ``spandrel`` above it.

    Parameters
    ----------
    openings:
        Numbers of openings across and upwards.
    block:
        Length and height of a full block.
    jamb:
        Width, in blocks, of the masonry on either side of an opening: piers between openings are twice
        as wide as those at the ends.
    opening:
        Width in blocks and height in courses of an opening.
    sill, spandrel:
        Courses below an opening, and above its lintel, within its storey.
    doors:
        Which openings of the lowest storey reach the ground, counted from the left, 1 the first. (Without
        ``sill`` all of them do.)
    weight:
        Weight of a full block; shorter blocks weigh in proportion.
    lintel_weight:
        Weight of a lintel, which bears half a block on either side; goes with ``weight``.
    unit_weight:
        Weight per unit area of blocks and lintels, in place of both weights; per unit volume where the
        scene has a ``thickness``.
    omit_top_left:
        Whether the leftmost block of the top course is left away, as in the paper's façades.
    name, at, live_per_weight, live:
        See :class:`~masonry_opt.scene.generator.Generator`; the origin is the left end of the foot.

    Raises
    ------
    CaseError
        If the lintel's course is not one of shifted blocks, in which it bears on whole ones, a weight is
        missing or doubled, or the façade is larger than 100,000 blocks: all that is wrong at once.
    """

    openings: tuple[Count, Count]
    block: tuple[Positive, Positive]
    jamb: Count
    opening: tuple[Count, Count]
    sill: Annotated[int, Strict(), Field(ge=0, le=1000)]
    spandrel: Count
    doors: list[Count] = []
    lintel_weight: NonNegative | None = None
    omit_top_left: Annotated[bool, Strict()] = False

    def _mistakes(self) -> Iterator[str]:
        yield from super()._mistakes()
        if self.weight is not None and self.lintel_weight is None:
            yield "'weight' needs a 'lintel_weight' (or give 'unit_weight' in place of both)"
        if self.unit_weight is not None and self.lintel_weight is not None:
            yield "'unit_weight' weighs the lintels too: take 'lintel_weight' away"
        if (self.sill + self.opening[1]) % 2 == 0:
            yield "'sill' and the height of 'opening' must add up to an odd number of courses"
        if self.storey % 2:
            yield (
                "'sill', the height of 'opening', one for the lintel and 'spandrel' must add up to an even "
                "number of courses"
            )
        for door in self.doors:
            if door > self.openings[0]:
                yield f"'doors' has {door}, of {self.openings[0]} openings across: count from 1"
        if len(set(self.doors)) < len(self.doors):
            yield "'doors' has an opening twice"
        if self.doors and not self.sill:
            yield "'doors' need a 'sill': without one every opening of the lowest storey reaches the ground"
        if self.size > MOST_BLOCKS:
            yield f"is {self.size} blocks large; the most is {MOST_BLOCKS}"

    @property
    def size(self) -> int:
        """How many blocks it would have without openings."""
        return self.width * self.storey * self.openings[1]

    @property
    def storey(self) -> int:
        """Courses of a storey."""
        return self.sill + self.opening[1] + 1 + self.spandrel

    @property
    def width(self) -> int:
        """Width in blocks."""
        return self.openings[0] * (self.opening[0] + 2 * self.jamb)

    def blocks(self, thickness: float = 1.0) -> list[Block]:
        """The blocks, course by course from the left, named ``course-block``, the base last."""
        length, height = self.block
        full = self._weight_of(length * height, thickness)
        # The lintel bears half a block on either side of its opening.
        lintel = full * (self.opening[0] + 1) if self.lintel_weight is None else self.lintel_weight
        built: list[Block] = []
        for row in range(self.openings[1] * self.storey):
            pieces = self._course(row, full, lintel)
            if self.omit_top_left and row == self.openings[1] * self.storey - 1:
                pieces = pieces[1:]
            for number, (left, right, weight) in enumerate(pieces, start=1):
                corners = rectangle(left * length, right * length, row * height, (row + 1) * height)
                name = f"{row + 1}-{number}"
                built.append(self._placed(name, corners, weight=weight, live_per_weight=self._push))
        corners = rectangle(-length, (self.width + 1) * length, -height, 0.0)
        return [*built, self._placed("base", corners, fixed=True)]

    def _course(self, row: int, full: float, lintel: float) -> list[tuple[float, float, float]]:
        """Left end, right end (in blocks) and weight of the pieces of a course, given that of a full block
        and of a lintel."""
        level = row % self.storey - self.sill
        bond = [x + 0.5 * (row % 2) for x in range(self.width)]
        gaps: list[tuple[float, float]] = []
        if 0 <= level < self.opening[1]:
            gaps = [(left, left + self.opening[0]) for left in self._openings()]
        elif level == self.opening[1]:
            gaps = [(left - 0.5, left + self.opening[0] + 0.5) for left in self._openings()]
        elif row < self.sill:
            gaps = [(left, left + self.opening[0]) for left in self._openings(self.doors)]
        ends = sorted({0.0, *bond, float(self.width), *(end for gap in gaps for end in gap)})
        pieces = [
            (left, right, full * (right - left))
            for left, right in itertools.pairwise(ends)
            if not any(start <= left < end for start, end in gaps)
        ]
        if level == self.opening[1]:
            pieces += [(left, right, lintel) for left, right in gaps]
        return sorted(pieces)

    def _openings(self, numbers: Iterable[int] | None = None) -> list[float]:
        """Left ends of the openings, or of those with these numbers, in blocks."""
        step = self.opening[0] + 2 * self.jamb
        listed = range(1, self.openings[0] + 1) if numbers is None else numbers
        return [float(self.jamb + (number - 1) * step) for number in listed]

"""The generators ``[wall]``, ``[facade]`` and ``[column]``: courses of blocks and drums on a fixed base."""

from collections.abc import Iterable, Iterator, Sequence
from itertools import accumulate, pairwise
from typing import Annotated, Literal

from pydantic import Discriminator, Field, Strict, Tag

from masonry_opt.scene.blocks import Block, Name, NonNegative, Number, Positive, YesNo, rectangle
from masonry_opt.scene.generator import Count, WeighedGenerator, Widths, both

Lengths = Annotated[list[Number], Field(min_length=1)]
Course = Annotated[
    Annotated[Name, Tag("<one>")] | Annotated[Lengths, Tag("<several>")],
    Discriminator(lambda entry: "<one>" if isinstance(entry, str) else "<several>"),
]

#: Block of a course: its left and right ends in block lengths, and its weight. The weight is None if it
#: follows from the area.
_CoursePiece = tuple[float, float, float | None]


class Wall(WeighedGenerator):
    """Wall of courses on a fixed base, from x = 0 to the right and from y = 0 upwards.

    The courses are listed from the bottom.

    Parameters
    ----------
    block: Length and height of a full block.
    weight: Weight of a full block. The weights of shorter blocks are proportional to their lengths.
    unit_weight: In place of ``weight``: weight per unit area, or per unit volume if the scene has a
        ``thickness``.
    courses: Courses, each a list of lengths in full blocks, or the name of a list in ``course``. Negative
        lengths are gaps.
    course: Courses by name, which make the bond of a wall easy to read.
    repeat: Number of times that the whole list of courses is built.
    base: True for a fixed base under the bottom course, one block longer at either end.
    name, at, live_per_weight, live: See :class:`~masonry_opt.scene.generator.Generator`; the origin is the
        foot's left end, without the base.

    Raises
    ------
    CaseError
        If a course has no block or an unknown name, or if the weight is missing or given twice.
    """

    block: tuple[Positive, Positive]
    courses: Annotated[list[Course], Field(min_length=1)]
    course: dict[Name, Lengths] = {}
    repeat: Annotated[int, Strict(), Field(ge=1, le=100_000)] = 1
    base: YesNo = True

    def _mistakes(self) -> Iterator[str]:
        yield from super()._mistakes()
        for number, entry in enumerate(self.courses, start=1):
            if not isinstance(entry, str):
                yield from _wrong_lengths(f"course no. {number}", entry)
            elif entry not in self.course:
                known_names = ", ".join(self.course) or "none"
                yield f"course no. {number}: no course is named '{entry}' (existing names: {known_names})"
        for name, lengths in self.course.items():
            if name not in self.courses:
                yield f"course '{name}' is not used in 'courses': use the course or remove it"
            yield from _wrong_lengths(f"course '{name}'", lengths)

    @property
    def size(self) -> int:
        """Return the number of blocks and gaps in all courses."""
        return self.repeat * sum(len(self._lengths(entry)) for entry in self.courses)

    def _lengths(self, entry: str | list[float]) -> list[float]:
        return self.course.get(entry, []) if isinstance(entry, str) else entry

    def blocks(self, thickness: float | None = None) -> list[Block]:
        """Return the blocks of all courses, named ``course-block``, and then the base.

        Parameters
        ----------
        thickness: As in :meth:`Generator.blocks <masonry_opt.scene.generator.Generator.blocks>`.

        Returns
        -------
        list of Block
            The blocks, in the coordinates of the scene.
        """
        width = 0.0
        courses: list[list[_CoursePiece]] = []
        for entry in self.courses:
            parts = self._lengths(entry)
            positions = [*accumulate(map(abs, parts), initial=0.0)]
            pieces = zip(positions, parts, strict=False)
            courses.append(
                [(x, x + part, _weight_share(self.weight, part)) for x, part in pieces if part > 0]
            )
            width = max(width, positions[-1])
        return _build_courses(self, courses * self.repeat, width, thickness)


class Facade(WeighedGenerator):
    """Façade in running bond on a fixed base, with a grid of equal openings under lintels.

    The top of the base is at y = 0.

    Every second course is shifted by half a block; the lowest course is not shifted. If a block of a shifted
    course would cross the edge of an opening, its inner half is left out. A storey has an even number of
    courses: ``sill``, the height of ``opening``, the lintel, which lies in a shifted course, and
    ``spandrel``.

    Parameters
    ----------
    openings: Number of openings in a storey, and number of storeys.
    block: Length and height of a full block.
    jamb: Width, in blocks, of the masonry on either side of an opening; piers between two openings are twice
        as wide.
    opening: Width of an opening in blocks, and its height in courses.
    sill, spandrel: Courses below an opening, and above its lintel, within its storey.
    doors: Openings of the lowest storey that reach the ground, numbered from 1 at the left. Without a
        ``sill``, all openings of the lowest storey do.
    weight: Weight of a full block. The weights of shorter blocks are proportional to their lengths.
    lintel_weight: Weight of a lintel, which rests on half a block at either side. It is required with
        ``weight``.
    unit_weight: In place of both weights: weight per unit area, or per unit volume if the scene has a
        ``thickness``.
    omit_top_left: True to leave out the leftmost block of the top course, as in the paper's façades.
    base: True for a fixed base.
    name, at, live_per_weight, live: See :class:`~masonry_opt.scene.generator.Generator`; the origin is the
        foot's left end, without the base.

    Raises
    ------
    CaseError
        If the courses do not add up, if a door does not exist, or if a weight is missing or given twice.
    """

    openings: tuple[Count, Count]
    block: tuple[Positive, Positive]
    jamb: Count
    opening: tuple[Count, Count]
    sill: Annotated[int, Strict(), Field(ge=0, le=1000)]
    spandrel: Count
    doors: list[Count] = []
    lintel_weight: NonNegative | None = None
    omit_top_left: YesNo = False
    base: YesNo = True

    def _mistakes(self) -> Iterator[str]:
        yield from super()._mistakes()
        if self.weight is not None and self.lintel_weight is None:
            yield "'weight' needs a 'lintel_weight': add it, or give 'unit_weight' in place of both"
        if self.unit_weight is not None and self.lintel_weight is not None:
            yield "'unit_weight' determines the weight of lintels too: remove 'lintel_weight'"
        if (self.sill + self.opening[1]) % 2 == 0:
            yield (
                "'sill' and the height of 'opening' must add up to an odd number of courses: "
                "the lintel must be in a course that is shifted by half a block"
            )
        if self.storey % 2:
            yield (
                "'sill', the height of 'opening' and 'spandrel' must add up to an odd number: "
                "with the lintel, a storey must have an even number of courses"
            )
        for door in self.doors:
            if door > self.openings[0]:
                yield f"'doors' names opening {door}, but a storey has openings 1 to {self.openings[0]} only"
        if len(set(self.doors)) < len(self.doors):
            yield "'doors' names an opening twice: remove one of the two entries"
        if self.doors and not self.sill:
            yield "'doors' need a 'sill': without a sill, every opening of the lowest storey is a door"

    @property
    def size(self) -> int:
        """Return the number of blocks that the façade would have without openings."""
        return self.width * self.storey * self.openings[1]

    @property
    def storey(self) -> int:
        """Return the number of courses of one storey."""
        return self.sill + self.opening[1] + 1 + self.spandrel

    @property
    def width(self) -> int:
        """Return the width in blocks."""
        return self.openings[0] * (self.opening[0] + 2 * self.jamb)

    def blocks(self, thickness: float | None = None) -> list[Block]:
        """Return the blocks of all courses, named ``course-block``, and then the base.

        Parameters
        ----------
        thickness: As in :meth:`Generator.blocks <masonry_opt.scene.generator.Generator.blocks>`.

        Returns
        -------
        list of Block
            The blocks, in the coordinates of the scene.
        """
        courses = [self._course(row) for row in range(self.openings[1] * self.storey)]
        if self.omit_top_left:
            del courses[-1][0]
        return _build_courses(self, courses, self.width, thickness)

    def _course(self, row: int) -> list[_CoursePiece]:
        """Return the blocks of a course."""
        level = row % self.storey - self.sill
        bond = [x + 0.5 * (row % 2) for x in range(self.width)]
        gaps: list[tuple[float, float]] = []
        if 0 <= level <= self.opening[1]:
            bearing = 0.5 if level == self.opening[1] else 0.0
            gaps = self._openings(range(1, self.openings[0] + 1), bearing)
        elif row < self.sill:
            gaps = self._openings(self.doors)
        ends = sorted({0.0, *bond, float(self.width), *(end for gap in gaps for end in gap)})
        runs = [run for run in pairwise(ends) if not any(start <= run[0] < end for start, end in gaps)]
        pieces = [(left, right, _weight_share(self.weight, right - left)) for left, right in runs]
        if level == self.opening[1]:  # the course of the lintels, which rest on half a block on either side
            pieces += [(left, right, self.lintel_weight) for left, right in gaps]
        return sorted(pieces, key=lambda piece: piece[0])

    def _openings(self, numbers: Iterable[int], bearing: float = 0.0) -> list[tuple[float, float]]:
        """Return the left and right ends of the openings with the given numbers, in block lengths.

        Each end is moved outwards by ``bearing``.
        """
        step = self.opening[0] + 2 * self.jamb
        lefts = [float(self.jamb + (number - 1) * step) for number in numbers]
        return [(left - bearing, left + self.opening[0] + bearing) for left in lefts]


class Column(WeighedGenerator):
    """Column, pier or buttress: drums of equal height from y = 0 upwards, on a fixed base.

    Parameters
    ----------
    width: Width of the column, or its widths ``[bottom, top]``.
    height: Height of the column.
    drums: Number of drums.
    batter: Side that slopes if the widths differ: "both", or only "left" or "right" with an upright opposite
        side. A buttress leans against a wall with its upright side.
    weight: Weight of the column; the weights of drums are proportional to their areas.
    unit_weight: In place of ``weight``: weight per unit area, or per unit volume if the scene has a
        ``thickness``.
    base: True for a fixed base under the column, as wide as its foot and as high as a drum. Without a base
        the column is supported by other blocks.
    name, at, live_per_weight, live: See :class:`~masonry_opt.scene.generator.Generator`; the origin is the
        foot's left end, without the base.

    Raises
    ------
    CaseError
        If the weight is missing or given twice, or if ``batter`` names one side although both widths are
        equal.
    """

    width: Widths
    height: Positive
    drums: Annotated[int, Strict(), Field(ge=1)]
    batter: Literal["both", "left", "right"] = "both"
    base: YesNo = True

    def _mistakes(self) -> Iterator[str]:
        yield from super()._mistakes()
        bottom, top = both(self.width)
        if self.batter != "both" and bottom == top:
            yield (
                f"a 'batter' of the {self.batter} side needs two different widths: "
                "give 'width' as [bottom, top]"
            )

    def blocks(self, thickness: float | None = None) -> list[Block]:
        """Return the drums ``d1``, ``d2``, ... from the bottom upwards, and finally the base.

        Parameters
        ----------
        thickness: As in :meth:`Generator.blocks <masonry_opt.scene.generator.Generator.blocks>`.

        Returns
        -------
        list of Block
            The blocks, in the coordinates of the scene.
        """
        bottom, top = both(self.width)
        area = (bottom + top) / 2 * self.height
        # Share of the batter on the left side.
        left_share = {"both": 0.5, "left": 1.0, "right": 0.0}[self.batter]
        levels = []  # left end, right end and height of each bed joint of the column
        for up in (joint / self.drums for joint in range(self.drums + 1)):
            reduction = (bottom - top) * up
            levels.append((left_share * reduction, bottom - (1 - left_share) * reduction, self.height * up))
        blocks: list[Block] = []
        for number, ((x0, x1, low), (x2, x3, high)) in enumerate(pairwise(levels), start=1):
            share = (x1 - x0 + x3 - x2) / (bottom + top) / self.drums
            corners = [(x0, low), (x1, low), (x3, high), (x2, high)]
            weight = _weight_share(self.weight, share)
            blocks.append(self._weighed_stone(f"d{number}", corners, weight, share * area, thickness))
        if self.base:
            foot = rectangle(0.0, bottom, -self.height / self.drums, 0.0)
            blocks.append(self._block("base", {"vertices": foot}, fixed=True))
        return blocks


def _weight_share(weight: float | None, share: float) -> float | None:
    """Return the weight of a piece: the given share of a total weight; None if no weight is given."""
    return None if weight is None else weight * share


def _build_courses(
    wall: Wall | Facade, courses: Sequence[Sequence[_CoursePiece]], width: float, thickness: float | None
) -> list[Block]:
    """Return the blocks of all courses, one course above the other, and the base."""
    length, height = wall.block
    blocks: list[Block] = []
    for row, course in enumerate(courses):
        for number, (left, right, weight) in enumerate(course, start=1):
            corners = rectangle(left * length, right * length, row * height, (row + 1) * height)
            name, area = f"{row + 1}-{number}", (right - left) * length * height
            blocks.append(wall._weighed_stone(name, corners, weight, area, thickness))
    if wall.base:
        foot = rectangle(-length, (width + 1) * length, -height, 0.0)
        blocks.append(wall._block("base", {"vertices": foot}, fixed=True))
    return blocks


def _wrong_lengths(course: str, lengths: list[float]) -> Iterator[str]:
    """Generate an error message for each mistake in the lengths of a course."""
    if any(length == 0 for length in lengths):
        yield f"{course} has a length of 0: use a positive length for a block, or a negative length for a gap"
    if all(length < 0 for length in lengths):
        yield f"{course} has gaps only: add a positive length, which is the length of a block"

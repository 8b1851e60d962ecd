"""The ``[wall]`` generator: courses of rectangular blocks on a fixed base."""

from __future__ import annotations

from typing import Annotated

from pydantic import Discriminator, Field, Strict, Tag, model_validator

from masonry_opt.scene.blocks import (
    MOST_BLOCKS,
    Block,
    Name,
    NonNegative,
    Number,
    Point,
    Positive,
    Record,
    rectangle,
)

Lengths = Annotated[list[Number], Field(min_length=1)]
Course = Annotated[
    Annotated[Name, Tag("name")] | Annotated[Lengths, Tag("lengths")],
    Discriminator(lambda entry: "name" if isinstance(entry, str) else "lengths"),
]


class Wall(Record):
    """Courses of blocks, bottom first, starting at x = 0 on a fixed base whose top is y = 0.

    Parameters
    ----------
    block:
        Length and height of a full block.
    weight:
        Weight of a full block; shorter blocks weigh in proportion.
    live:
        Live force on every block as a multiple of its weight, ``[fx, fy]``, at the centroid.
    courses:
        Each course as a list of lengths in full blocks, a negative length being a gap, or as the
        name of a list in ``course``.
    course:
        Named courses, so that a bond can be read at a glance.
    repeat:
        How often the list of courses is built, one above the other.
    base:
        Whether a fixed base, one block longer at either end, is built under the bottom course.

    Raises
    ------
    CaseError
        If a course is empty, has a zero length or only gaps, or a name stands for no course.
    """

    block: tuple[Positive, Positive]
    weight: NonNegative
    live: Point = (0.0, 0.0)
    courses: Annotated[list[Course], Field(min_length=1)]
    course: dict[Name, Lengths] = {}
    repeat: Annotated[int, Strict(), Field(ge=1, le=100_000)] = 1
    base: Annotated[bool, Strict()] = True

    @model_validator(mode="after")
    def _known_courses(self) -> Wall:
        blocks_of: dict[str, int] = {}
        count = 0
        for number, entry in enumerate(self.courses, start=1):
            if not isinstance(entry, str):
                count += self._count(number, entry)
                continue
            if entry not in self.course:
                known = ", ".join(self.course) or "none"
                raise ValueError(f"course no. {number}: no course is named '{entry}' (named: {known})")
            if entry not in blocks_of:
                blocks_of[entry] = self._count(number, self.course[entry])
            count += blocks_of[entry]
        if count * self.repeat > MOST_BLOCKS:
            raise ValueError(f"has {count * self.repeat} blocks and gaps; the most is {MOST_BLOCKS}")
        for name in set(self.course) - set(blocks_of):
            raise ValueError(f"course '{name}' is never used in 'courses'")
        return self

    @staticmethod
    def _count(number: int, lengths: list[float]) -> int:
        """How many blocks and gaps a course has; refuse a course that cannot be built."""
        if any(length == 0 for length in lengths):
            raise ValueError(f"course no. {number}: a length is 0 (blocks > 0, gaps < 0)")
        if all(length < 0 for length in lengths):
            raise ValueError(f"course no. {number}: has gaps only, no block")
        return len(lengths)

    def _lengths(self, entry: str | list[float]) -> list[float]:
        return self.course[entry] if isinstance(entry, str) else entry

    def blocks(self) -> list[Block]:
        """The blocks, course by course from the left, named ``course-block``, the base last."""
        length, height = self.block
        built: list[Block] = []
        right = 0.0
        for row, entry in enumerate(self.courses * self.repeat):
            x, count = 0.0, 0
            for part in self._lengths(entry):
                if part > 0:
                    count += 1
                    built.append(self._block(f"{row + 1}-{count}", x, x + part, row, part))
                x += abs(part)
            right = max(right, x)
        if self.base:
            corners = rectangle(-length, (right + 1) * length, -height, 0.0)
            built.append(Block(name="base", vertices=corners, fixed=True))
        return built

    def _block(self, name: str, left: float, right: float, row: int, part: float) -> Block:
        length, height = self.block
        weight = self.weight * part
        return Block(
            name=name,
            vertices=rectangle(left * length, right * length, row * height, (row + 1) * height),
            weight=weight,
            live=(self.live[0] * weight, self.live[1] * weight),
        )

"""The ``[wall]`` generator: courses of rectangular blocks on a fixed base."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Annotated

from pydantic import Discriminator, Field, Strict, Tag

from masonry_opt.scene.blocks import MOST_BLOCKS, Block, Name, Number, Positive, rectangle
from masonry_opt.scene.generator import WeighedGenerator

Lengths = Annotated[list[Number], Field(min_length=1)]
Course = Annotated[
    Annotated[Name, Tag("<name>")] | Annotated[Lengths, Tag("<lengths>")],
    Discriminator(lambda entry: "<name>" if isinstance(entry, str) else "<lengths>"),
]


class Wall(WeighedGenerator):
    """Courses of blocks, bottom first, starting at x = 0 on a fixed base whose top is y = 0.

    Parameters
    ----------
    block:
        Length and height of a full block.
    weight:
        Weight of a full block; shorter blocks weigh in proportion.
    unit_weight:
        Weight per unit area, in place of ``weight``; per unit volume where the scene has a ``thickness``.
    courses:
        Each course as a list of lengths in full blocks, a negative length being a gap, or as the
        name of a list in ``course``.
    course:
        Named courses, so that a bond can be read at a glance.
    repeat:
        How often the list of courses is built, one above the other.
    base:
        Whether a fixed base, one block longer at either end, is built under the bottom course.
    name, at, live_per_weight, live:
        See :class:`~masonry_opt.scene.generator.Generator`; the origin is the left end of the foot,
        where the first course begins.

    Raises
    ------
    CaseError
        If a course is empty, has a zero length or only gaps, a name stands for no course, or the weight is
        missing or doubled.
    """

    block: tuple[Positive, Positive]
    courses: Annotated[list[Course], Field(min_length=1)]
    course: dict[Name, Lengths] = {}
    repeat: Annotated[int, Strict(), Field(ge=1, le=100_000)] = 1
    base: Annotated[bool, Strict()] = True

    def _mistakes(self) -> Iterator[str]:
        yield from super()._mistakes()
        for number, entry in enumerate(self.courses, start=1):
            if isinstance(entry, str):
                if entry not in self.course:
                    known = ", ".join(self.course) or "none"
                    yield f"course no. {number}: no course is named '{entry}' (named: {known})"
            else:
                yield from _wrong_lengths(f"course no. {number}", entry)
        used = {entry for entry in self.courses if isinstance(entry, str)}
        for name, lengths in self.course.items():
            if name not in used:
                yield f"course '{name}' is never used in 'courses'"
            yield from _wrong_lengths(f"course '{name}'", lengths)
        if self.size > MOST_BLOCKS:
            yield f"has {self.size} blocks and gaps; the most is {MOST_BLOCKS}"

    @property
    def size(self) -> int:
        """How many blocks and gaps it has."""
        return self.repeat * sum(len(self._lengths(entry)) for entry in self.courses)

    def _lengths(self, entry: str | list[float]) -> list[float]:
        return self.course.get(entry, []) if isinstance(entry, str) else entry

    def blocks(self, thickness: float = 1.0) -> list[Block]:
        """The blocks, course by course from the left, named ``course-block``, the base last."""
        length, height = self.block
        full = self._weight_of(length * height, thickness)
        built: list[Block] = []
        right = 0.0
        for row, entry in enumerate(self.courses * self.repeat):
            x, count = 0.0, 0
            for part in self._lengths(entry):
                if part > 0:
                    count += 1
                    corners = rectangle(x * length, (x + part) * length, row * height, (row + 1) * height)
                    name, weight = f"{row + 1}-{count}", full * part
                    built.append(self._placed(name, corners, weight=weight, live_per_weight=self._push))
                x += abs(part)
            right = max(right, x)
        if self.base:
            corners = rectangle(-length, (right + 1) * length, -height, 0.0)
            built.append(self._placed("base", corners, fixed=True))
        return built


def _wrong_lengths(course: str, lengths: list[float]) -> Iterator[str]:
    if any(length == 0 for length in lengths):
        yield f"{course}: a length is 0 (blocks > 0, gaps < 0)"
    if all(length < 0 for length in lengths):
        yield f"{course}: has gaps only, no block"

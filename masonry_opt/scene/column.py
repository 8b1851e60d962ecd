"""The ``[column]`` generator: drums on top of each other, upright or with sloping sides (a buttress)."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Annotated, Literal

from pydantic import Discriminator, Field, Strict, Tag

from masonry_opt.scene.blocks import MOST_BLOCKS, Block, Positive
from masonry_opt.scene.generator import WeighedGenerator

Widths = Annotated[
    Annotated[Positive, Tag("<number>")] | Annotated[tuple[Positive, Positive], Tag("<two>")],
    Discriminator(lambda value: "<two>" if isinstance(value, (list, tuple)) else "<number>"),
]


class Column(WeighedGenerator):
    """Equally high drums from the left end of the foot, (0, 0), upwards, on a fixed base: a column, a pier
    or a buttress.

    Parameters
    ----------
    width:
        Of the column, or ``[bottom, top]``.
    height:
        Of the column.
    drums:
        How many.
    batter:
        Which side slopes where the widths differ: "both" alike, or "left" or "right" alone, the other one
        upright (a buttress leans with that one).
    weight:
        Weight of the column; drums weigh by their areas.
    unit_weight:
        Weight per unit area, in place of ``weight``; per unit volume where the scene has a ``thickness``.
    base:
        Whether a fixed base, as wide as the foot and as high as a drum, is built under it. Without one it
        stands on other blocks.
    name, at, live_per_weight, live:
        See :class:`~masonry_opt.scene.generator.Generator`; the origin is the left end of the foot.

    Raises
    ------
    CaseError
        If the weight is missing or doubled, or a side is to slope and the widths are the same.
    """

    width: Widths
    height: Positive
    drums: Annotated[int, Strict(), Field(ge=1, le=MOST_BLOCKS)]
    batter: Literal["both", "left", "right"] = "both"
    base: Annotated[bool, Strict()] = True

    def _mistakes(self) -> Iterator[str]:
        yield from super()._mistakes()
        bottom, top = self._widths()
        if self.batter != "both" and bottom == top:
            yield f"'batter' says that the {self.batter} side slopes: give 'width' as [bottom, top]"

    @property
    def size(self) -> int:
        """How many drums it has."""
        return self.drums

    def blocks(self, thickness: float = 1.0) -> list[Block]:
        """The drums ``d1``, ``d2``, ... from the bottom, then the base."""
        bottom, top = self._widths()
        weight = self._weight_of((bottom + top) / 2 * self.height, thickness)
        built: list[Block] = []
        for number in range(1, self.drums + 1):
            (x0, x1, low), (x2, x3, high) = self._level(number - 1), self._level(number)
            share = (x1 - x0 + x3 - x2) / (bottom + top) / self.drums * weight
            corners = [(x0, low), (x1, low), (x3, high), (x2, high)]
            built.append(self._placed(f"d{number}", corners, weight=share, live_per_weight=self._push))
        if self.base:
            low = -self.height / self.drums
            corners = [(0.0, low), (bottom, low), (bottom, 0.0), (0.0, 0.0)]
            built.append(self._placed("base", corners, fixed=True))
        return built

    def _widths(self) -> tuple[float, float]:
        return self.width if isinstance(self.width, tuple) else (self.width, self.width)

    def _level(self, joint: int) -> tuple[float, float, float]:
        """Left end, right end and height of the bed joint above that many drums."""
        bottom, top = self._widths()
        up = joint / self.drums
        # How much of the batter is the left side's.
        left = {"both": 0.5, "left": 1.0, "right": 0.0}[self.batter]
        narrower = (bottom - top) * up
        return left * narrower, bottom - (1 - left) * narrower, self.height * up

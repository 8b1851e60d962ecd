"""The generator ``[shaft]``: a column of drums with any number of sides, straight or tapering."""

from __future__ import annotations

import math
from itertools import pairwise
from typing import Annotated

from pydantic import Field, Strict

from masonry_opt.scene.blocks import Positive, YesNo
from masonry_opt.scene.generator import Count, SolidGenerator, Widths, polar
from masonry_opt.scene.solids import Solid, prism


class Shaft(SolidGenerator):
    """Equally high drums, prisms or frusta of a regular polygon, on a fixed base whose top is z = 0.

    Raises CaseError if a value is none that can be built.

    Parameters
    ----------
    diameter: Of the circle through the polygon's corners, or ``[bottom, top]`` if the shaft tapers. Across
        flat sides it measures cos(π/sides) times that.
    sides: Of the polygon, three or more: 4 a square pier, 16 or 24 a round column. One side faces +x, and
        with multiples of four sides others face -x and ±y.
    height, drums: Of the shaft, and how many drums it has.
    base: Whether a fixed base is built under it, with the foot's outline and as high as a drum.
    name, at, live_per_weight, unit_weight: See :class:`~masonry_opt.scene.generator.SolidGenerator`; the
        origin is the middle of the foot.
    """

    diameter: Widths
    sides: Annotated[int, Strict(), Field(ge=3, le=1000)]
    height: Positive
    drums: Count
    base: YesNo = True

    @property
    def size(self) -> int:
        """Number of drums."""
        return self.drums

    def blocks(self) -> list[Solid]:
        """The drums ``d1``, ``d2``, ... from the foot upwards, then the ``base``."""
        bottom, top = self.diameter if isinstance(self.diameter, tuple) else (self.diameter,) * 2
        drum = self.height / self.drums
        levels = [
            self._polygon(bottom + (top - bottom) * number / self.drums, self.height * number / self.drums)
            for number in range(self.drums + 1)
        ]
        built = [
            self._stone(f"d{number}", prism(low, high))
            for number, (low, high) in enumerate(pairwise(levels), start=1)
        ]
        if self.base:
            built.append(self._support("base", prism(self._polygon(bottom, -drum), levels[0])))
        return built

    def _polygon(self, diameter: float, z: float) -> list[tuple[float, float, float]]:
        return [polar(diameter / 2, (2 * side + 1) * math.pi / self.sides, z) for side in range(self.sides)]

"""Loads on edges: pressures of water and earth, and loads on a top edge."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Discriminator, Field, Tag, model_validator

from masonry_opt.scene.blocks import Number, Point, Record

Pressure = Annotated[
    Annotated[Number, Tag("<number>")] | Annotated[Point, Tag("<two>")],
    Discriminator(lambda value: "<two>" if isinstance(value, (list, tuple)) else "<number>"),
]


class EdgeLoad(Record):
    """A load along a straight line, on whatever edges of movable blocks lie there and are free.

    Intensities are forces per unit length, or per unit area where the scene has a ``thickness``.

    Parameters
    ----------
    start, end:
        The line's ends, ``[x, y]``; in a case file ``from`` and ``to``.
    pressure:
        Normal to the edges, into the blocks: one intensity, or those at start and end, linear between.
    force:
        ``[fx, fy]``, in any direction, uniform; in place of ``pressure``.
    kind:
        "dead" (the default), or "live", which the load factor scales.

    Raises
    ------
    CaseError
        If the line has no length, or both or neither of pressure and force are given.
    """

    start: Annotated[Point, Field(alias="from")]
    end: Annotated[Point, Field(alias="to")]
    pressure: Pressure | None = None
    force: Point | None = None
    kind: Literal["dead", "live"] = "dead"

    @model_validator(mode="after")
    def _is_one_load(self) -> EdgeLoad:
        if (self.pressure is None) == (self.force is None):
            raise ValueError("give 'pressure' or 'force'" + ("" if self.force is None else ", not both"))
        if self.start == self.end:
            raise ValueError("'from' and 'to' are one point: give the two ends of the loaded line")
        return self

    @property
    def at_ends(self) -> tuple[float, float]:
        """Pressure at start and end."""
        if self.pressure is None:
            return 0.0, 0.0
        return self.pressure if isinstance(self.pressure, tuple) else (self.pressure, self.pressure)

"""Loads on single blocks by name, and loads along edges."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field, Tag, model_validator

from masonry_opt.scene.blocks import ONE_OR_SEVERAL, Name, NonNegative, Number, Point, Record

Pressure = Annotated[Annotated[Number, Tag("<one>")] | Annotated[Point, Tag("<several>")], ONE_OR_SEVERAL]


class Load(Record):
    """Forces on one block, added to its own; several on one block add up.

    Parameters
    ----------
    block:
        Name of a block that is not fixed.
    live:
        Live force ``[fx, fy]``, scaled by the load factor.
    dead:
        Dead force ``[fx, fy]`` beside the weight.
    at:
        The point where both act, ``[x, y]`` (default: the block's centroid).
    weight:
        In place of the block's own weight; once for each block.

    Raises
    ------
    CaseError
        If it says nothing, or gives a point without a force.
    """

    block: Name
    live: Point | None = None
    dead: Point | None = None
    at: Point | None = None
    weight: NonNegative | None = None

    @model_validator(mode="after")
    def _says_something(self) -> Load:
        if self.live is None and self.dead is None:
            if self.at is not None:
                raise ValueError("'at' needs a force: give 'live' or 'dead'")
            if self.weight is None:
                raise ValueError("has no force: give 'live', 'dead' or 'weight'")
        return self


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
        pressure = self.pressure or 0.0
        return pressure if isinstance(pressure, tuple) else (pressure, pressure)

"""Loads on single blocks by name, and loads along edges."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Annotated, Literal

from pydantic import Field, Tag

from masonry_opt.scene.blocks import ONE_OR_SEVERAL, Name, NonNegative, Number, Point, Record
from masonry_opt.scene.solids import PlaneOrSpaceVector, Vector

#: Groups of load cases that no load may name: weights of blocks and of fill, loads that name no group, as
#: they are given, and axles.
GROUPS = ("weight", "fill", "dead", "live", "axles")

Pressure = Annotated[Annotated[Number, Tag("<one>")] | Annotated[Point, Tag("<several>")], ONE_OR_SEVERAL]


class Load(Record):
    """Forces on one block, added to its own; several on one block add up.

    Raises CaseError if it says nothing, gives a point without a force, or both kinds of force in one group.

    Parameters
    ----------
    block: Name of a block that is not fixed.
    live: Live force ``[fx, fy]``, in space ``[fx, fy, fz]``, scaled by the load factor.
    dead: Dead force, as there, beside the weight.
    at: The point where both act, ``[x, y]`` or ``[x, y, z]`` (default: the block's centroid).
    weight: In place of the block's own weight; once for each block.
    live_moment, dead_moment: Moments ``[mx, my, mz]`` on a :class:`Solid`, beside those of the forces.
    mass: A weight, as a force, that pushes in an earthquake at that point and is no dead load itself
        (default: what of the forces that act as dead is along gravity; 0: none of them).
    group: A name by which a :class:`LoadCase` calls it.
    """

    block: Name
    live: PlaneOrSpaceVector | None = None
    dead: PlaneOrSpaceVector | None = None
    at: PlaneOrSpaceVector | None = None
    weight: NonNegative | None = None
    live_moment: Vector | None = None
    dead_moment: Vector | None = None
    mass: NonNegative | None = None
    group: Name | None = None

    def _mistakes(self) -> Iterator[str]:
        _refuse_group(self.group)
        if self.group is not None and self.gives("live") == self.gives("dead"):
            if self.gives("live"):
                yield "gives live and dead forces in one 'group': make them two loads"
            if not self.mass:
                yield ("'group' goes with 'live', 'dead' or 'mass'; weights are of group \"weight\"")
        if self.live is None and self.dead is None and not self.mass:
            if self.at is not None:
                yield "'at' needs a force: give 'live', 'dead' or 'mass'"
            if self.weight is None and not self.is_force:
                yield "has no force: give 'live', 'dead' or 'weight', or a 'mass'"

    def gives(self, kind: Literal["dead", "live"]) -> bool:
        """Whether it has a force or moment of a kind."""
        return getattr(self, kind) is not None or getattr(self, f"{kind}_moment") is not None

    @property
    def is_force(self) -> bool:
        """Whether it is a force or moment, not a weight alone."""
        return self.gives("live") or self.gives("dead")


class EdgeLoad(Record):
    """A load along a straight line, on whatever edges of movable blocks lie there and are free.

    Intensities are forces per unit length, or per unit area where the scene has a ``thickness``.

    Raises CaseError if the line has no length, or both or neither of pressure and force are given.

    Parameters
    ----------
    start, end: The line's ends, ``[x, y]``; in a case file ``from`` and ``to``.
    pressure: Normal to the edges, into the blocks: one intensity, or those at start and end, linear between.
    force: ``[fx, fy]``, in any direction, uniform; in place of ``pressure``.
    kind: "dead" (the default), or "live", which the load factor scales.
    mass, group: As of :class:`Load`, the mass per unit length (default: what of a ``force`` is along gravity;
        of a ``pressure`` none).
    """

    start: Annotated[Point, Field(alias="from")]
    end: Annotated[Point, Field(alias="to")]
    pressure: Pressure | None = None
    force: Point | None = None
    kind: Literal["dead", "live"] = "dead"
    mass: NonNegative | None = None
    group: Name | None = None

    def _mistakes(self) -> Iterator[str]:
        _refuse_group(self.group)
        if (self.pressure is None) == (self.force is None):
            yield "give 'pressure' or 'force'" + ("" if self.force is None else ", not both")
        if self.start == self.end:
            yield "'from' and 'to' are one point: give the two ends of the loaded line"

    @property
    def at_ends(self) -> tuple[float, float]:
        """Pressure at start and end."""
        pressure = self.pressure or 0.0
        return pressure if isinstance(pressure, tuple) else (pressure, pressure)


def _refuse_group(name: str | None) -> None:
    if name in GROUPS:
        raise ValueError(f"'group' \"{name}\" is a word of load cases: name it otherwise")

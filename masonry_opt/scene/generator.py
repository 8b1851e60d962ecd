"""Generators of blocks in the plane and in space: name, place, loads; where the stones of a course end."""

import math
from collections.abc import Iterable, Iterator, Sequence
from itertools import pairwise
from typing import TYPE_CHECKING, Annotated, Any, ClassVar

import numpy as np
from pydantic import Field, Strict, Tag

from masonry_opt.scene.blocks import Block, Body, Name, NonNegative, Point, Positive, Record
from masonry_opt.scene.solids import ONE_OR_SEVERAL, Solid, Vector

MOST_BLOCKS = 100_000  #: Blocks, openings and gaps of a generator: more than can be solved, and soon built.
Count = Annotated[int, Strict(), Field(ge=1, le=1000)]  #: Of courses, rings, drums.
Widths = Annotated[
    Annotated[Positive, Tag("<one>")] | Annotated[tuple[Positive, Positive], Tag("<several>")], ONE_OR_SEVERAL
]

CLOSER = 0.25  #: Of a stone: pieces may be as short, and stones as much longer instead of a shorter piece.
_ROUNDING = 1e-9  #: Of a stone, what is rounding.

#: Of a polygon its ``vertices``; of one convex part what gives its shape in a :class:`Solid`.
Shape = dict[str, Any]


class AnyGenerator(Record):
    """A table of a case file that stands for many blocks, in the plane or in space. They are named after its
    ``name``, "left 3-2" in place of "3-2": for several generators in one scene.

    Raises CaseError, with all that is wrong, if the values make nothing that can be built, or more than
    100,000 blocks.
    """

    name: Name | None = None
    if TYPE_CHECKING:
        at: tuple[float, ...]

    most_told: ClassVar[int] = 5
    kind: ClassVar[type[Body]]  #: What its blocks are.

    def _mistakes(self) -> Iterator[str]:
        if self.size > MOST_BLOCKS:
            yield f"is {self.size} blocks large; the most is {MOST_BLOCKS}"

    @property
    def size(self) -> int:
        """Number of blocks that it builds, or more, but for a few: known before they are built."""
        return math.prod(getattr(self, key, 1) for key in ("rings", "voussoirs", "drums"))

    def _block(self, name: str, *parts: Shape, **keys: Any) -> Any:
        """A block of these parts, whose points are seen from the generator's origin."""
        moved = [self._moved(part) for part in parts]
        shape = moved[0] if len(moved) == 1 else {"parts": moved}
        called = name if self.name is None else f"{self.name} {name}"
        return self.kind(name=called, **shape, **self._moved(keys))

    def _moved(self, keys: Shape) -> Shape:
        points = {key: keys[key] for key in ("vertices", "weight_at", "live_at") if keys.get(key) is not None}
        moved = {key: np.add(at, self.at).tolist() for key, at in points.items()}
        if "box" in keys:
            moved["box"] = np.add(np.transpose(keys["box"]), self.at).T.tolist()
        return keys | moved


class Generator(AnyGenerator):
    """A generator of blocks in the plane. Its origin lies ``at`` ``[x, y]``; which point that is, each
    generator says. ``live_per_weight`` is a live force on every block as a multiple of its weight, ``[fx,
    fy]``, where the weight acts; ``live`` is its old name. (``live`` of a block or of a load is a force.)"""

    kind: ClassVar[type[Body]] = Block

    at: Point = (0.0, 0.0)
    live_per_weight: Point = (0.0, 0.0)
    live: Point = (0.0, 0.0)

    def _mistakes(self) -> Iterator[str]:
        yield from super()._mistakes()
        if any(self.live) and any(self.live_per_weight):
            yield "'live' is the old name of 'live_per_weight': give one of them"

    def blocks(self, thickness: float | None = None) -> list[Block]:
        """Return the blocks, with weights and live loads.

        A generator with a ``unit_weight`` gives each block a ``unit_weight``, which a scene multiplies by its
        own thickness. If ``thickness`` is given, each block has instead its ``weight`` at this thickness,
        which a scene leaves as it is.
        """
        raise NotImplementedError

    def _stone(self, name: str, corners: Iterable[Point], **keys: Any) -> Block:
        """Return a movable block, whose points are relative to the generator's origin."""
        push = self.live_per_weight if any(self.live_per_weight) else self.live
        return self._block(name, {"vertices": corners}, live_per_weight=push, **keys)


class WeighedGenerator(Generator):
    """A generator whose blocks weigh by their size: by ``weight``, that of a whole, or by ``unit_weight``."""

    weight: NonNegative | None = None
    unit_weight: NonNegative | None = None

    def _mistakes(self) -> Iterator[str]:
        yield from super()._mistakes()
        if (self.weight is None) == (self.unit_weight is None):
            yield "give 'weight' or 'unit_weight'" + ("" if self.weight is None else ", not both")

    def _weighed_stone(
        self, name: str, corners: Iterable[Point], weight: float | None, area: float, thickness: float | None
    ) -> Block:
        """Return a movable block of the given weight, or without one of the generator's unit weight."""
        if weight is not None:
            return self._stone(name, corners, weight=weight)
        if thickness is None:
            return self._stone(name, corners, unit_weight=self.unit_weight)
        return self._stone(name, corners, weight=(self.unit_weight or 0.0) * area * thickness)


class SolidGenerator(AnyGenerator):
    """A generator of blocks in space, which weigh ``unit_weight`` per unit volume. ``at`` and
    ``live_per_weight`` are as of a :class:`Generator`, of three numbers each."""

    kind: ClassVar[type[Body]] = Solid

    at: Vector = (0.0, 0.0, 0.0)
    live_per_weight: Vector = (0.0, 0.0, 0.0)
    unit_weight: NonNegative

    def blocks(self) -> list[Solid]:
        """The blocks, each with its weight and its live load as a multiple of that."""
        raise NotImplementedError

    def _stone(self, name: str, *parts: Shape, **weight: Any) -> Solid:
        """A movable block, that weighs by its volume, or as ``weight`` and ``weight_at`` say."""
        weight = weight or {"unit_weight": self.unit_weight}
        return self._block(name, *parts, live_per_weight=self.live_per_weight, **weight)


def polar(radius: float, angle: float, *z: float) -> Any:
    """The point at a distance from the origin, or the z axis, at an angle from x towards y, in radians."""
    return (radius * math.cos(angle), radius * math.sin(angle), *z)


def both(widths: float | tuple[float, float]) -> tuple[float, float]:
    """One width, or two that differ, as two."""
    return widths if isinstance(widths, tuple) else (widths, widths)


def cut(
    start: float, end: float, joints: Iterable[float], length: float, spare: Sequence[float] = ()
) -> list[tuple[float, float]]:
    """The stones of some length from one end of a run to the other. Of the bond's joints, rising, those
    nearer than a closer to an end are left out; what is more than a closer longer than a stone is cut in
    equal ones, at spare places first where these are half a stone or more from joints."""

    def within(places: Iterable[float], low: float, high: float, least: float) -> list[float]:
        least *= length * (1 - _ROUNDING)
        return [place for place in places if low + least < place < high - least]

    ends = [start, *within(joints, start, end, CLOSER), end]
    too_long = [(a, b) for a, b in pairwise(ends) if b - a > length * (1 + CLOSER + _ROUNDING)]
    spares = [place for run in too_long for place in within(spare, *run, 0.5)]
    stones: list[tuple[float, float]] = []
    for low, high in pairwise(sorted([*ends, *spares])):
        count = max(1, math.ceil((high - low) / length - CLOSER - _ROUNDING))
        between = [low + (high - low) * number / count for number in range(1, count)]
        stones += pairwise([low, *between, high])
    return stones


def every(length: float, start: float, end: float) -> list[float]:
    """Joints a stone apart, the first at ``start``, up to ``end``."""
    return [start + number * length for number in range(math.floor((end - start) / length + _ROUNDING) + 1)]

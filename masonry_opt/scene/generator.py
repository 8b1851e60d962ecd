"""Define generators of blocks in the plane and in space, and cut courses into stones."""

import math
from collections.abc import Iterable, Iterator, Sequence
from itertools import pairwise
from typing import TYPE_CHECKING, Annotated, Any, ClassVar

import numpy as np
from pydantic import Field, Strict, Tag

from masonry_opt.scene.blocks import Block, Body, Name, NonNegative, Point, Positive, Record
from masonry_opt.scene.solids import ONE_OR_SEVERAL, Solid, Vector

#: Largest ``size`` of a generator, and largest sum of the sizes of all generators of a case file. A larger
#: size raises an error before any block is built. With a larger limit, a mistyped number can exhaust the
#: memory.
MOST_BLOCKS_GENERATED = 100_000

#: Number of courses, rings or drums.
Count = Annotated[int, Strict(), Field(ge=1, le=1000)]

#: One width, or two widths that differ.
Widths = Annotated[
    Annotated[Positive, Tag("<one>")] | Annotated[tuple[Positive, Positive], Tag("<several>")], ONE_OR_SEVERAL
]

#: Length of the shortest cut stone (closer), relative to a whole stone. If a cut stone would be shorter, the
#: adjacent stone is lengthened instead.
CLOSER = 0.25

#: Largest length, relative to a stone, that counts as a rounding error when a course is cut into stones.
_STONE_LENGTH_TOLERANCE = 1e-9

#: Keys that define a shape: ``vertices`` of a polygon, or keys of a convex part of a :class:`Solid`.
Shape = dict[str, Any]


class AnyGenerator(Record):
    """Table of a case file that generates many blocks, in the plane or in space.

    Parameters
    ----------
    name: Name with which the names of the generated blocks begin: ``left 3-2`` in place of ``3-2``. A
        scene with several generators needs such names.

    Raises
    ------
    CaseError
        If the values do not describe blocks, or describe more than 100,000 blocks. The message has all
        mistakes.
    """

    name: Name | None = None
    if TYPE_CHECKING:
        at: tuple[float, ...]

    most_listed_mistakes: ClassVar[int] = 5
    kind: ClassVar[type[Body]]  #: Class of the generated blocks.

    def _mistakes(self) -> Iterator[str]:
        if self.size > MOST_BLOCKS_GENERATED:
            yield (
                f"the generator would make {self.size} blocks, but at most {MOST_BLOCKS_GENERATED} are "
                "allowed: use larger blocks, or split the scene"
            )

    @property
    def size(self) -> int:
        """Return the number of generated blocks, or an upper bound on this number.

        The result is computed without building the blocks.
        """
        return math.prod(getattr(self, key, 1) for key in ("rings", "voussoirs", "drums"))

    def _block(self, name: str, *parts: Shape, **keys: Any) -> Any:
        """Return a block that consists of ``parts`` and has the properties ``keys``.

        Points in ``parts`` and in ``keys`` are relative to the generator's origin. The block has the
        coordinates of the scene.
        """
        moved_parts = [self._moved_keys(part) for part in parts]
        shape = moved_parts[0] if len(moved_parts) == 1 else {"parts": moved_parts}
        full_name = name if self.name is None else f"{self.name} {name}"
        return self.kind(name=full_name, **shape, **self._moved_keys(keys))

    def _moved_keys(self, keys: Shape) -> Shape:
        """Return the keys and values of a block, with its points moved to the coordinates of the scene.

        The points in ``keys`` are relative to the generator's origin.
        """
        points = {key: keys[key] for key in ("vertices", "weight_at", "live_at") if keys.get(key) is not None}
        moved_points = {key: np.add(at, self.at).tolist() for key, at in points.items()}
        if "box" in keys:
            moved_points["box"] = np.add(np.transpose(keys["box"]), self.at).T.tolist()
        return keys | moved_points


class Generator(AnyGenerator):
    """Base class of generators of blocks in the plane.

    Parameters
    ----------
    name: See :class:`AnyGenerator`.
    at: Position ``[x, y]`` of the generator's origin. Each generator describes where its origin is.
    live_per_weight: Live force ``[fx, fy]`` on every block as a multiple of its weight, applied at the
        same point as the weight.
    live: Old name of ``live_per_weight`` in generators. In blocks and loads, ``live`` is a force.
    """

    kind: ClassVar[type[Body]] = Block

    at: Point = (0.0, 0.0)
    live_per_weight: Point = (0.0, 0.0)
    live: Point = (0.0, 0.0)

    def _mistakes(self) -> Iterator[str]:
        yield from super()._mistakes()
        if any(self.live) and any(self.live_per_weight):
            yield "'live' is the old name of 'live_per_weight', and both are set: remove 'live'"

    def blocks(self, thickness: float | None = None) -> list[Block]:
        """Return the generated blocks, with weights and live loads.

        Parameters
        ----------
        thickness: Thickness out of the plane. If it is given, and the generator has a ``unit_weight``, each
            block has the ``weight`` of this thickness, which a scene does not multiply. By default each block
            has the ``unit_weight``, which a scene multiplies by its thickness.

        Returns
        -------
        list of Block
            The blocks, in the coordinates of the scene.
        """
        raise NotImplementedError

    def _stone(self, name: str, corners: Iterable[Point], **keys: Any) -> Block:
        """Return a movable block. The ``corners`` are relative to the generator's origin."""
        push = self.live_per_weight if any(self.live_per_weight) else self.live
        return self._block(name, {"vertices": corners}, live_per_weight=push, **keys)


class WeighedGenerator(Generator):
    """Base class of generators in the plane whose blocks have weights in proportion to their size.

    ``weight`` is the weight of a whole block, and ``unit_weight`` is the weight per unit area. A
    generator has one of the two keys.
    """

    weight: NonNegative | None = None
    unit_weight: NonNegative | None = None

    def _mistakes(self) -> Iterator[str]:
        yield from super()._mistakes()
        if (self.weight is None) == (self.unit_weight is None):
            yield "a generator needs exactly one of the keys 'weight' and 'unit_weight'"

    def _weighed_stone(
        self, name: str, corners: Iterable[Point], weight: float | None, area: float, thickness: float | None
    ) -> Block:
        """Return a movable block with the given weight.

        If ``weight`` is None, the weight follows from the generator's unit weight.
        """
        if weight is not None:
            return self._stone(name, corners, weight=weight)
        if thickness is None:
            return self._stone(name, corners, unit_weight=self.unit_weight)
        return self._stone(name, corners, weight=(self.unit_weight or 0.0) * area * thickness)


class SolidGenerator(AnyGenerator):
    """Base class of generators of blocks in space.

    Parameters
    ----------
    name: See :class:`AnyGenerator`.
    at, live_per_weight: See :class:`Generator`; each has three numbers.
    unit_weight: Weight of the blocks per unit volume.
    """

    kind: ClassVar[type[Body]] = Solid

    at: Vector = (0.0, 0.0, 0.0)
    live_per_weight: Vector = (0.0, 0.0, 0.0)
    unit_weight: NonNegative

    def blocks(self) -> list[Solid]:
        """Return the generated blocks, each with its weight and a live load in proportion to the weight.

        Returns
        -------
        list of Solid
            The blocks, in the coordinates of the scene.
        """
        raise NotImplementedError

    def _stone(self, name: str, *parts: Shape, **weight: Any) -> Solid:
        """Return a movable block.

        By default its weight is computed from its volume. ``weight`` and ``weight_at`` override this weight.
        """
        weight = weight or {"unit_weight": self.unit_weight}
        return self._block(name, *parts, live_per_weight=self.live_per_weight, **weight)


def polar(radius: float, angle: float, *z: float) -> Any:
    """Return the point with the given polar coordinates and an optional z. The angle is in radians."""
    return (radius * math.cos(angle), radius * math.sin(angle), *z)


def both(widths: float | tuple[float, float]) -> tuple[float, float]:
    """Return a pair of widths: repeat a single width, and return a pair unchanged."""
    return widths if isinstance(widths, tuple) else (widths, widths)


def cut(
    start: float, end: float, joints: Iterable[float], length: float, spare: Sequence[float] = ()
) -> list[tuple[float, float]]:
    """Divide a course from ``start`` to ``end`` into stones, and return the two ends of each stone.

    ``length`` is the length of a whole stone. ``joints`` are the joints of the bond, in ascending order. A
    joint is left out if its distance from an end is less than the length of a closer, the shortest cut stone.
    A piece that is longer than a stone and a closer is divided in two steps: first at the places ``spare``
    that are at least half a stone from joints, and then into equal stones.
    """

    def inner_places(places: Iterable[float], low: float, high: float, distance: float) -> list[float]:
        """Return the places from ``low`` to ``high`` that are at least ``distance * length`` from both."""
        distance *= length * (1 - _STONE_LENGTH_TOLERANCE)
        return [place for place in places if low + distance < place < high - distance]

    ends = [start, *inner_places(joints, start, end, CLOSER), end]
    long_pieces = [
        (left, right)
        for left, right in pairwise(ends)
        if right - left > length * (1 + CLOSER + _STONE_LENGTH_TOLERANCE)
    ]
    spare_joints = [place for run in long_pieces for place in inner_places(spare, *run, 0.5)]
    stones: list[tuple[float, float]] = []
    for low, high in pairwise(sorted([*ends, *spare_joints])):
        count = max(1, math.ceil((high - low) / length - CLOSER - _STONE_LENGTH_TOLERANCE))
        inner_joints = [low + (high - low) * number / count for number in range(1, count)]
        stones += pairwise([low, *inner_joints, high])
    return stones


def every(length: float, start: float, end: float) -> list[float]:
    """Return positions of joints from ``start`` up to ``end``, at intervals of ``length``."""
    return [
        start + number * length
        for number in range(math.floor((end - start) / length + _STONE_LENGTH_TOLERANCE) + 1)
    ]

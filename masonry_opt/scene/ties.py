"""Ties and props: forces on a line between two blocks, or a block and the ground, within limits."""

from __future__ import annotations

from collections.abc import Iterator

from masonry_opt.scene.blocks import Name, NonNegative, Positive, Record
from masonry_opt.scene.solids import PlaneOrSpaceVector

#: What ``between`` calls what does not move, unless a block that moves has this name.
GROUND = "ground"


class _Strut(Record):
    """What ties and props have in common."""

    between: tuple[Name, Name]
    at: tuple[PlaneOrSpaceVector, PlaneOrSpaceVector]
    strength: Positive | None = None
    name: Name | None = None

    def _mistakes(self) -> Iterator[str]:
        first, second = self.at
        if len(first) != len(second):
            yield "'at' needs two points of as many numbers each"
        if first == second:
            yield "'at' gives one point twice: give the two ends of its line"
        if self.between[0] == self.between[1]:
            yield "'between' needs two different blocks, or a block and \"ground\""


class Tie(_Strut):
    """A tie rod: a tension between its prestress and its strength, along the line of its two anchors.

    It may pass through blocks between its anchors, which it does not touch. It carries no shear.

    Raises CaseError if the anchors are one point, or the prestress exceeds the strength.

    Parameters
    ----------
    between: Names of the two blocks it is anchored in; ``"ground"`` is what does not move.
    at: Its two anchors, ``[x, y]`` or ``[x, y, z]``, each in its block.
    strength: Largest tension, a force (default: it never yields).
    prestress: Least tension, which it has however short it becomes (default 0).
    name: What results call it (default: the names of its blocks).
    """

    prestress: NonNegative = 0.0

    def _mistakes(self) -> Iterator[str]:
        yield from super()._mistakes()
        if self.strength is not None and self.prestress > self.strength:
            yield "'prestress' must not exceed 'strength'"


class Prop(_Strut):
    """A prop: a compression up to its strength, along the line of its two ends.

    Raises CaseError if the ends are one point.

    Parameters
    ----------
    between, at, name: As of a :class:`Tie`.
    strength: Largest compression, a force (default: it never yields).
    """

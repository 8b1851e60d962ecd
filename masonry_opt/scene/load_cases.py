"""Load cases: which loads of a scene act as dead and as live, by the names of their groups; earthquakes."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Annotated, Literal

from pydantic import Discriminator, Field, Tag

from masonry_opt.scene.blocks import Name, Number, Positive, Record, YesNo
from masonry_opt.scene.solids import Vector

Kind = Literal["dead", "live"]

#: Where an earthquake pushes: a side of the plane, an angle in plan in degrees, or a direction in space.
Push = Annotated[
    Annotated[Literal["left", "right"], Tag("<plane>")]
    | Annotated[Number, Tag("<one>")]
    | Annotated[Vector, Tag("<several>")],
    Discriminator(
        lambda value: (
            "<several>"
            if isinstance(value, list | tuple)
            else "<plane>"
            if isinstance(value, str)
            else "<one>"
        )
    ),
]


class Earthquake(Record):
    """A live load of the masses: λ times ``coefficient`` is the horizontal push over their weights.

    Every weight pushes where it acts, and of dead forces what is along gravity; of a :class:`Load` and
    :class:`EdgeLoad` its ``mass``, if that is given.

    Raises CaseError if a value is none of these.

    Parameters
    ----------
    direction: "left" or "right"; in space an angle in plan in degrees, from x towards y, or ``[x, y, z]``, of
        which the part square to gravity counts.
    vertical: The vertical part over the horizontal one: positive with gravity, negative against it.
    coefficient: Horizontal seismic coefficient that λ multiplies: by default 1, and λ is the coefficient of
        collapse; a design value makes λ the factor on it, to set beside those of other load cases.
    dead_as_mass: False: of dead forces, a block's own ``dead`` among them, nothing pushes but what is given
        as ``mass``.
    """

    direction: Push
    vertical: Number = 0.0
    coefficient: Positive = 1.0
    dead_as_mass: YesNo = True

    @property
    def vector(self) -> tuple[float, ...]:
        """Its direction in space before what is along gravity is taken away; () of a side of the plane."""
        if isinstance(self.direction, str):
            return ()
        if isinstance(self.direction, tuple):
            return self.direction
        angle = math.radians(self.direction)
        return math.cos(angle), math.sin(angle), 0.0

    def __str__(self) -> str:
        match self.direction:
            case str():
                push = f"to the {self.direction}"
            case tuple():
                push = f"towards [{', '.join(f'{part:g}' for part in self.direction)}]"
            case _:
                push = f"at {self.direction:g}° in plan"
        if self.coefficient != 1:
            push = f"{self.coefficient:g} × weights {push}"
        sense = "with" if self.vertical > 0 else "against"
        return f"{push}, and {abs(self.vertical):g} of that {sense} gravity" if self.vertical else push


class LoadCase(Record):
    """Factors of the loads that act together, by group.

    Groups are those that loads name, and "weight" (own weights of blocks), "fill" (that of fill), "dead" and
    "live" (loads given so, of blocks too, that name no group), and "axles" (live alone, for
    :func:`~masonry_opt.crossing`).

    Raises CaseError if nothing is live, both ``live`` and ``earthquake`` are given, or axles are dead, or
    pull.

    Parameters
    ----------
    name: Unique within the scene.
    dead: Factors by group of the loads that act as dead. "weight", "fill" and "dead" are 1 where they are not
        named, all others 0.
    live: Factors by group of the loads that λ scales.
    earthquake: In place of ``live``: :class:`Earthquake`. Masses count times the factor of their group in
        ``dead``.
    """

    name: Name
    dead: dict[Name, Number] = {}
    live: dict[Name, Number] = {}
    earthquake: Earthquake | None = None

    def _mistakes(self) -> Iterator[str]:
        if "axles" in self.dead:
            yield "'dead' names 'axles', which move: give them in 'live'"
        if self.live.get("axles", 0.0) < 0:
            yield "axles press down: give 'axles' in 'live' a positive factor"
        if any(self.live.values()) == (self.earthquake is not None):
            yield (
                "give 'live' or 'earthquake', not both: of both, λ is no one number"
                if self.earthquake
                else "nothing is live: give 'live = { live = 1 }', the factors of groups, or an 'earthquake'"
            )

    def factor(self, kind: Kind, group: str) -> float:
        """What a group's loads are multiplied by as dead or as live."""
        usual = 1.0 if kind == "dead" and group in ("weight", "fill", "dead") else 0.0
        factors = self.dead if kind == "dead" else self.live
        return factors.get(group, usual)

    @property
    def moves(self) -> bool:
        """Whether axles alone are live."""
        return {group for group, factor in self.live.items() if factor} == {"axles"}

    def __str__(self) -> str:
        if self.earthquake is not None:
            return f"earthquake {self.earthquake}"
        return ", ".join(f"{factor:g} × {group}" for group, factor in self.live.items() if factor)


LoadCases = Annotated[list[LoadCase], Field(alias="load_case")]

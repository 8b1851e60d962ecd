"""Loads on blocks by name and along edges, ties and props, earthquakes, and the cases that loads act in."""

import math
from collections.abc import Iterator
from typing import Annotated, Literal

from pydantic import Discriminator, Field, Tag

from masonry_opt.scene.blocks import Name, NonNegative, Number, Point, Positive, Record, YesNo
from masonry_opt.scene.solids import ONE_OR_SEVERAL, PlaneOrSpaceVector, Vector

Kind = Literal["dead", "live"]
KINDS: tuple[Kind, ...] = ("dead", "live")
#: By types of what says where an earthquake pushes, the kind that is meant.
_PUSHES = ((str, "<plane>"), ((list, tuple), "<several>"))
#: Where an earthquake pushes: a side of the plane, an angle in plan in degrees, or a direction in space.
Push = Annotated[
    Annotated[Literal["left", "right"], Tag("<plane>")]
    | Annotated[Number, Tag("<one>")]
    | Annotated[Vector, Tag("<several>")],
    Discriminator(lambda value: next((tag for kind, tag in _PUSHES if isinstance(value, kind)), "<one>")),
]
GROUPS = ("weight", "fill", "dead", "live", "axles")  #: No load may name them: see :class:`LoadCase`.
GROUND = "ground"  #: What ``between`` calls what does not move, unless a block that moves has this name.
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

    def gives(self, kind: Kind) -> bool:
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
    mass, group: As of :class:`Load`, the mass per unit length (default: a ``force``'s part along gravity; of
        a ``pressure`` none).
    """

    start: Annotated[Point, Field(alias="from")]
    end: Annotated[Point, Field(alias="to")]
    pressure: Pressure | None = None
    force: Point | None = None
    kind: Kind = "dead"
    mass: NonNegative | None = None
    group: Name | None = None

    def _mistakes(self) -> Iterator[str]:
        _refuse_group(self.group)
        if (self.pressure is None) == (self.force is None):
            yield "give 'pressure' or 'force'" + ("" if self.force is None else ", not both")
        if self.start == self.end:
            yield "'from' and 'to' are one point: give the two ends of the loaded line"


def _refuse_group(name: str | None) -> None:
    if name in GROUPS:
        raise ValueError(f"'group' \"{name}\" is a word of load cases: name it otherwise")


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
    dead_as_mass: False: of dead forces, a block's own ``dead`` among them, only what is ``mass`` pushes.
    """

    direction: Push
    vertical: Number = 0.0
    coefficient: Positive = 1.0
    dead_as_mass: YesNo = True

    @property
    def towards(self) -> str | tuple[float, ...]:
        """A side of the plane, or its direction in space before what is along gravity is taken away."""
        if not isinstance(self.direction, float):
            return self.direction
        angle = math.radians(self.direction)
        return math.cos(angle), math.sin(angle), 0.0

    def __str__(self) -> str:
        if isinstance(self.direction, str):
            push = f"to the {self.direction}"
        elif isinstance(self.direction, tuple):
            push = f"towards [{', '.join(f'{part:g}' for part in self.direction)}]"
        else:
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

    Raises CaseError if nothing is live, ``live`` and ``earthquake`` both are given, axles are dead, or pull.

    Parameters
    ----------
    name: Unique within the scene.
    dead: Factors by group of loads that act as dead: "weight", "fill" and "dead" 1 if not named, others 0.
    live: Factors by group of the loads that λ scales.
    earthquake: In place of ``live``: :class:`Earthquake`; masses count times their group's ``dead`` factor.
    pressure: Factor of both limits between which fills press.
    """

    name: Name
    dead: dict[Name, Number] = {}
    live: dict[Name, Number] = {}
    earthquake: Earthquake | None = None
    pressure: NonNegative = 1.0

    def _mistakes(self) -> Iterator[str]:
        if "axles" in self.dead:
            yield "'dead' names 'axles', which move: give them in 'live'"
        if self.live.get("axles", 0.0) < 0:
            yield "axles press down: give 'axles' in 'live' a positive factor"
        live = any(self.live.values())
        if live and self.earthquake:
            yield "give 'live' or 'earthquake', not both: of both, λ is no one number"
        elif not live and not self.earthquake:
            yield "nothing is live: give 'live = { live = 1 }', the factors of groups, or an 'earthquake'"

    def factor(self, kind: Kind, group: str) -> float:
        """What a group's loads are multiplied by as dead or as live."""
        usual = 1.0 if kind == "dead" and group in ("weight", "fill", "dead") else 0.0
        return (self.dead if kind == "dead" else self.live).get(group, usual)

    @property
    def moves(self) -> bool:
        """Whether axles alone are live."""
        return {group for group, factor in self.live.items() if factor} == {"axles"}

    def __str__(self) -> str:
        if self.earthquake is not None:
            return f"earthquake {self.earthquake}"
        return ", ".join(f"{factor:g} × {group}" for group, factor in self.live.items() if factor)

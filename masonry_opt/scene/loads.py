"""Define loads on blocks and along edges, ties and props, earthquakes, and load cases."""

import math
from collections.abc import Iterator
from typing import Annotated, Literal

from pydantic import Discriminator, Field, Tag

from masonry_opt.scene.blocks import Name, NonNegative, Number, Point, Positive, Record, YesNo
from masonry_opt.scene.solids import ONE_OR_SEVERAL, PlaneOrSpaceVector, Vector

Kind = Literal["dead", "live"]
LOAD_KINDS: tuple[Kind, ...] = ("dead", "live")
#: Tags for the alternative types of an earthquake's direction, by Python type.
_DIRECTION_TAGS = ((str, "<plane>"), ((list, tuple), "<several>"))
#: Direction of an earthquake: a side of the plane, an angle in plan in degrees, or a vector in space.
Push = Annotated[
    Annotated[Literal["left", "right"], Tag("<plane>")]
    | Annotated[Number, Tag("<one>")]
    | Annotated[Vector, Tag("<several>")],
    Discriminator(
        lambda value: next((tag for kind, tag in _DIRECTION_TAGS if isinstance(value, kind)), "<one>")
    ),
]
#: Load groups that exist in every scene, see :class:`LoadCase`. A load must not use these names as its group.
GROUPS = ("weight", "fill", "dead", "live", "axles")

#: Name of the fixed ground in the key ``between``, unless a movable block has this name.
GROUND = "ground"
Pressure = Annotated[Annotated[Number, Tag("<one>")] | Annotated[Point, Tag("<several>")], ONE_OR_SEVERAL]


class Load(Record):
    """Forces on one block, in addition to the forces in the block's own keys.

    Several loads on one block add up.

    Raises CaseError if a load is empty, gives a point without a force, or has both kinds of force in one
    group.

    Parameters
    ----------
    block: Name of a block that is not fixed.
    live: Live force ``[fx, fy]``, in space ``[fx, fy, fz]``, scaled by the load factor.
    dead: Dead force, in addition to the weight.
    at: The point where both forces act, ``[x, y]`` or ``[x, y, z]`` (default: the block's centroid).
    weight: In place of the block's own weight; at most once for each block.
    live_moment, dead_moment: Moments ``[mx, my, mz]`` on a :class:`Solid`, in addition to those of the
        forces.
    mass: A weight, as a force, that pushes in an earthquake at the point of the load and is no dead load
        itself. Default: the part along gravity of the forces that act as dead. 0: no mass.
    group: A name by which a :class:`LoadCase` refers to the load.
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
                yield "has live and dead forces in one 'group': split it into two loads"
            if not self.mass:
                yield ("'group' needs 'live', 'dead' or 'mass'; weights belong to group \"weight\"")
        if self.live is None and self.dead is None and not self.mass:
            if self.at is not None:
                yield "'at' needs a force: give 'live', 'dead' or 'mass'"
            if self.weight is None and not self.is_force:
                yield "has no force: give 'live', 'dead' or 'weight', or a 'mass'"

    def gives(self, kind: Kind) -> bool:
        """Return True if the load has a force or moment of the kind "dead" or "live"."""
        return getattr(self, kind) is not None or getattr(self, f"{kind}_moment") is not None

    @property
    def is_force(self) -> bool:
        """Return True if the load has a force or a moment, and not only a weight."""
        return self.gives("live") or self.gives("dead")


class EdgeLoad(Record):
    """Distributed load along a straight line, on all free edges of movable blocks on that line.

    Intensities are forces per unit length, or per unit area if the scene has a ``thickness``.

    Raises CaseError if the line has no length, or if both or neither of pressure and force are given.

    Parameters
    ----------
    start, end: The ends of the line, ``[x, y]``; in a case file ``from`` and ``to``.
    pressure: Intensity normal to the edges, into the blocks: one number, or the numbers at start and end of a
        linear pressure.
    force: Uniform intensity ``[fx, fy]`` in any direction, in place of ``pressure``.
    kind: "dead" (the default), or "live", which the load factor scales.
    mass, group: As in :class:`Load`, with the mass per unit length. Default: the part of a ``force`` along
        gravity; a ``pressure`` has none.
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
            yield "'from' and 'to' are the same point: give the two ends of the loaded line"


def _refuse_group(name: str | None) -> None:
    """Raise ValueError if a load's group has the name of a predefined group of load cases."""
    if name in GROUPS:
        raise ValueError(f"'group' \"{name}\" is reserved for load cases: choose another name")


class _Strut(Record):
    """Fields and rules that ties and props have in common."""

    between: tuple[Name, Name]
    at: tuple[PlaneOrSpaceVector, PlaneOrSpaceVector]
    strength: Positive | None = None
    name: Name | None = None

    def _mistakes(self) -> Iterator[str]:
        first, second = self.at
        if len(first) != len(second):
            yield "'at' needs two points with equal numbers of coordinates"
        if first == second:
            yield "'at' has the same point twice: give two distinct ends"
        if self.between[0] == self.between[1]:
            yield "'between' needs two different blocks, or a block and \"ground\""


class Tie(_Strut):
    """Tie rod with a tension between prestress and strength, along the line of its two anchors.

    It may pass through blocks between its anchors without touching them. It carries no shear.

    Raises CaseError if the anchors are one point, or the prestress exceeds the strength.

    Parameters
    ----------
    between: Names of the two blocks in which it is anchored; ``"ground"`` is the fixed ground.
    at: Its two anchors, ``[x, y]`` or ``[x, y, z]``, each in its block.
    strength: Largest tension, a force (default: it never yields).
    prestress: Least tension, which remains however much the tie shortens (default 0).
    name: Its name in results (default: the names of its blocks).
    """

    prestress: NonNegative = 0.0

    def _mistakes(self) -> Iterator[str]:
        yield from super()._mistakes()
        if self.strength is not None and self.prestress > self.strength:
            yield "'prestress' must not exceed 'strength'"


class Prop(_Strut):
    """Prop with a compression up to its strength, along the line of its two ends.

    Raises CaseError if the ends are one point.

    Parameters
    ----------
    between, at, name: As in :class:`Tie`.
    strength: Largest compression, a force (default: it never yields).
    """


class Earthquake(Record):
    """Live load of an earthquake: λ times ``coefficient`` is the horizontal push per unit of weight.

    Every weight pushes where it acts. Of dead forces the part along gravity pushes. A :class:`Load` or
    :class:`EdgeLoad` with a ``mass`` pushes with this mass instead.

    Raises CaseError if a value is wrong.

    Parameters
    ----------
    direction: "left" or "right"; in space an angle in plan in degrees, from x towards y, or a vector ``[x, y,
        z]``, of which the part perpendicular to gravity counts.
    vertical: Vertical push divided by the horizontal one: positive with gravity, negative against it.
    coefficient: Horizontal seismic coefficient that λ multiplies. With the default, 1, λ is the coefficient
        of collapse. With a design value λ is the factor on it, which can be compared with those of other load
        cases.
    dead_as_mass: False if dead forces, among them a block's own ``dead``, push only by their ``mass``.
    """

    direction: Push
    vertical: Number = 0.0
    coefficient: Positive = 1.0
    dead_as_mass: YesNo = True

    @property
    def towards(self) -> str | tuple[float, ...]:
        """Return the direction of the earthquake: a side of the plane, or a vector in space.

        The direction still includes its part along gravity, which has no effect.
        """
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
    """Load case: factors of the load groups that act together.

    Groups are those that loads name, and these:

    - "weight": weights of blocks.
    - "fill": weight of fill.
    - "dead" and "live": dead and live loads, of blocks too, that name no group.
    - "axles": axles, only in ``live``, for :func:`~masonry_opt.crossing`.

    Raises CaseError if nothing is live, if both ``live`` and ``earthquake`` are given, if axles are dead, or
    if their factor is negative.

    Parameters
    ----------
    name: Unique within the scene.
    dead: Factors of the groups that act as dead loads. If not named, "weight", "fill" and "dead" have factor
        1, all others 0.
    live: Factors of the groups that λ scales.
    earthquake: In place of ``live``: :class:`Earthquake`. Masses are multiplied by the ``dead`` factor of
        their group.
    pressure: Factor of both limits of the pressure of fills.
    """

    name: Name
    dead: dict[Name, Number] = {}
    live: dict[Name, Number] = {}
    earthquake: Earthquake | None = None
    pressure: NonNegative = 1.0

    def _mistakes(self) -> Iterator[str]:
        if "axles" in self.dead:
            yield "'dead' names 'axles', which are a moving live load: name them in 'live'"
        if self.live.get("axles", 0.0) < 0:
            yield "the factor of 'axles' in 'live' is negative: axles act downwards, give it above 0"
        live = any(self.live.values())
        if live and self.earthquake:
            yield "give 'live' or 'earthquake', not both: λ can scale only one of them"
        elif not live and not self.earthquake:
            yield "nothing is live: give 'live = { live = 1 }', the factors of groups, or an 'earthquake'"

    def factor(self, kind: Kind, group: str) -> float:
        """Return the factor of a load group that acts as dead or as live load."""
        usual = 1.0 if kind == "dead" and group in ("weight", "fill", "dead") else 0.0
        return (self.dead if kind == "dead" else self.live).get(group, usual)

    @property
    def moves(self) -> bool:
        """Return True if moving axles are the only live load of the load case."""
        return {group for group, factor in self.live.items() if factor} == {"axles"}

    def __str__(self) -> str:
        if self.earthquake is not None:
            return f"earthquake {self.earthquake}"
        return ", ".join(f"{factor:g} × {group}" for group, factor in self.live.items() if factor)

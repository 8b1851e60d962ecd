"""Define loads on blocks and along edges, ties and props, earthquakes, and load cases."""

import math
from collections.abc import Iterator
from typing import Annotated, Literal

from pydantic import Discriminator, Field, Tag

from masonry_opt.scene.blocks import Name, NonNegative, Number, Point, Positive, Record, YesNo
from masonry_opt.scene.solids import ONE_OR_SEVERAL, PlaneOrSpaceVector, Vector

Kind = Literal["dead", "live"]
LOAD_KINDS: tuple[Kind, ...] = ("dead", "live")
#: For each Python type of an earthquake's direction, the tag by which pydantic selects the validation. All
#: other types, such as numbers, have the tag "<one>".
_DIRECTION_TAGS = ((str, "<plane>"), ((list, tuple), "<several>"))
#: Direction of an earthquake: "left" or "right" in the plane. In space the direction is an angle in plan in
#: degrees, or a vector.
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

#: Unit vectors in plan at 0°, 90°, 180° and 270°.
_AXES_IN_PLAN = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (-1.0, 0.0, 0.0), (0.0, -1.0, 0.0))

Pressure = Annotated[Annotated[Number, Tag("<one>")] | Annotated[Point, Tag("<several>")], ONE_OR_SEVERAL]


class Load(Record):
    """Forces on one block, in addition to the forces in the block's own keys.

    Several loads on one block add up.

    Parameters
    ----------
    block: Name of a block that is not fixed.
    live: Live force ``[fx, fy]``, in space ``[fx, fy, fz]``, which the load factor multiplies.
    dead: Dead force, in addition to the weight.
    at: Point of application of both forces, ``[x, y]`` or ``[x, y, z]`` (default: the block's centroid).
    weight: Weight that replaces the block's own weight. At most one load of a block may have a weight.
    live_moment, dead_moment: Moments ``[mx, my, mz]`` on a :class:`Solid`, in addition to the moments of the
        forces.
    mass: Weight, as a force, that an earthquake multiplies to a horizontal force at the point of the load. It
        is not a dead load. By default it is the component along gravity of the forces that act as dead loads,
        and 0 if this component points against gravity. With 0 the load has no mass.
    group: A name by which a :class:`LoadCase` refers to the load.

    Raises
    ------
    CaseError
        If a load is empty, has a point but no force, or has dead and live forces in one group.
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
        if self.group is not None and self.has_force("live") == self.has_force("dead"):
            if self.has_force("live"):
                yield "a load with a 'group' cannot have both live and dead forces: split it into two loads"
            if not self.mass:
                yield (
                    "a load with a 'group' needs 'live', 'dead' or 'mass' "
                    "(a 'weight' always belongs to the group \"weight\")"
                )
        if self.live is None and self.dead is None and not self.mass:
            if self.at is not None:
                yield "'at' needs a force: give 'live', 'dead' or 'mass'"
            if self.weight is None and not self.is_force:
                yield "the load is empty: give 'live', 'dead', 'weight' or 'mass'"

    def has_force(self, kind: Kind) -> bool:
        """Return True if the load has a force or moment of the given kind, "dead" or "live".

        Parameters
        ----------
        kind: "dead" or "live".

        Returns
        -------
        bool
            True if the load acts.
        """
        return getattr(self, kind) is not None or getattr(self, f"{kind}_moment") is not None

    @property
    def is_force(self) -> bool:
        """Return True if the load has a force or a moment, and not only a weight."""
        return self.has_force("live") or self.has_force("dead")


class EdgeLoad(Record):
    """Distributed load on all free edges of movable blocks along a straight line.

    Intensities are forces per unit length, or per unit area if the scene has a ``thickness``.

    Parameters
    ----------
    start, end: The ends of the line, ``[x, y]``; in a case file ``from`` and ``to``.
    pressure: Intensity normal to the edges, into the blocks: one number, or the two values at start and end
        between which the pressure varies linearly.
    force: Uniform intensity ``[fx, fy]`` in any direction, in place of ``pressure``.
    kind: "dead" (the default), or "live", which the load factor scales.
    mass, group: As in :class:`Load`, with the mass per unit length. By default the mass is the component of
        ``force`` along gravity; a ``pressure`` has no mass.

    Raises
    ------
    CaseError
        If the line has no length, or if not exactly one of pressure and force is given.
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
            yield "an edge load needs exactly one of the keys 'pressure' and 'force'"
        if self.start == self.end:
            yield "'from' and 'to' are the same point: give the two ends of the loaded line"


def _refuse_group(name: str | None) -> None:
    """Raise ValueError if the group of a load has the name of a predefined load group."""
    if name in GROUPS:
        raise ValueError(f"'group' \"{name}\" is reserved for load cases: choose another name")


class _Strut(Record):
    """Base class of ties and props, with their common fields and rules."""

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
    """Tie rod between two anchors. Its tension is at least the prestress, and at most the strength.

    The tie may pass through blocks between its anchors without touching them. It carries no shear.

    Parameters
    ----------
    between: Names of the two blocks in which the tie is anchored; ``"ground"`` is the fixed ground.
    at: The two anchors, ``[x, y]`` or ``[x, y, z]``, each in its block.
    strength: Largest tension, a force (default: unlimited).
    prestress: Least tension, which does not decrease if the tie shortens (default 0).
    name: Name of the tie in results (default: the names of its blocks).

    Raises
    ------
    CaseError
        If the anchors are one point, or the prestress exceeds the strength.
    """

    prestress: NonNegative = 0.0

    def _mistakes(self) -> Iterator[str]:
        yield from super()._mistakes()
        if self.strength is not None and self.prestress > self.strength:
            yield "'prestress' must not exceed 'strength'"


class Prop(_Strut):
    """Prop along the line between two points. Its compression is at most its strength.

    Parameters
    ----------
    between, at, name: As in :class:`Tie`.
    strength: Largest compression, a force (default: unlimited).

    Raises
    ------
    CaseError
        If the two points are the same.
    """


class Earthquake(Record):
    """Live load of an earthquake: λ times ``coefficient`` is the horizontal force per unit weight.

    The horizontal force of each weight acts at the same point as the weight. The component of a dead force
    along gravity counts as a weight; a dead force against gravity has no mass. A :class:`Load` or
    :class:`EdgeLoad` with a ``mass`` uses this mass instead.

    Parameters
    ----------
    direction: "left" or "right"; in space an angle in plan in degrees, from x towards y, or a vector ``[x, y,
        z]``, of which only the component perpendicular to gravity is used.
    vertical: Vertical force divided by the horizontal force: positive with gravity, negative against gravity.
    coefficient: Horizontal seismic coefficient that λ multiplies. With the default, 1, λ is the seismic
        coefficient at collapse. With a design value, λ is a factor on the design value, which can be compared
        with the load factors of other load cases.
    dead_as_mass: True if dead forces, including a block's own ``dead``, count as weights. If False, only
        their ``mass`` does.

    Raises
    ------
    CaseError
        If the direction has another form, or if a value is out of range.
    """

    direction: Push
    vertical: Number = 0.0
    coefficient: Positive = 1.0
    dead_as_mass: YesNo = True

    @property
    def towards(self) -> str | tuple[float, ...]:
        """Return the direction of the earthquake: "left" or "right" in the plane, or a vector in space.

        The vector may have a component along gravity, which has no effect.
        """
        if not isinstance(self.direction, float):
            return self.direction
        quarter, remainder = divmod(self.direction % 360, 90)
        if remainder == 0:
            # Return exact axes, because cos 90° is 6e-17 in floating-point arithmetic. The remainder of a
            # tiny negative angle is 360°, so the index may be 4.
            return _AXES_IN_PLAN[int(quarter) % 4]
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
    """Load case: the load groups that act together, each with a factor.

    A load can name its group. In addition, these groups are predefined:

    - "weight": weights of blocks.
    - "fill": weight of fill.
    - "dead" and "live": dead and live loads without a named group, including the loads in blocks.
    - "axles": moving axles, allowed only in ``live``; see :func:`~masonry_opt.crossing`.

    Parameters
    ----------
    name: Name of the load case, unique within the scene.
    dead: Factors of the groups that act as dead loads. If not named, "weight", "fill" and "dead" have factor
        1, all others 0.
    live: Factors of the groups that λ scales.
    earthquake: In place of ``live``: :class:`Earthquake`. Masses are multiplied by the ``dead`` factor of
        their group.
    pressure: Factor of both limits of the pressure of fills.

    Raises
    ------
    CaseError
        If the load case has no live load, if both ``live`` and ``earthquake`` are given, if axles are named
        in ``dead``, or if the factor of axles is negative.
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
            yield "the factor of 'axles' in 'live' is negative: axle loads act downwards, so make it positive"
        live = any(self.live.values())
        if live and self.earthquake:
            yield "give 'live' or 'earthquake', not both: λ can scale only one of them"
        elif not live and not self.earthquake:
            yield "the load case has no live load: give factors ('live = { live = 1 }') or an 'earthquake'"

    def factor(self, kind: Kind, group: str) -> float:
        """Return the factor of a load group in the dead load or in the live load.

        Parameters
        ----------
        kind: "dead" or "live".
        group: Name of the group.

        Returns
        -------
        float
            The factor, 0 if the group does not act.
        """
        default = 1.0 if kind == "dead" and group in ("weight", "fill", "dead") else 0.0
        return (self.dead if kind == "dead" else self.live).get(group, default)

    @property
    def moves(self) -> bool:
        """Return True if moving axles are the only live load of the load case."""
        return {group for group, factor in self.live.items() if factor} == {"axles"}

    def __str__(self) -> str:
        if self.earthquake is not None:
            return f"earthquake {self.earthquake}"
        return ", ".join(f"{factor:g} × {group}" for group, factor in self.live.items() if factor)

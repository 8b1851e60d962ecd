"""Load cases: which loads of a scene act as dead and as live, by the names of their groups; earthquakes."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Annotated, Literal

from pydantic import BaseModel, Discriminator, Field, Tag, model_validator

from masonry_opt.errors import CaseError, OptionError
from masonry_opt.scene.blocks import Name, Number, Positive, Record, YesNo
from masonry_opt.scene.loads import GROUPS
from masonry_opt.scene.solids import Vector

if TYPE_CHECKING:
    from masonry_opt.scene.scene import Scene

#: Keys of a block that are live loads.
_LIVE = ("live", "live_per_weight", "live_moment")

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

    Parameters
    ----------
    direction:
        "left" or "right"; in space an angle in plan in degrees, from x towards y, or ``[x, y, z]``, of which
        the part square to gravity counts.
    vertical:
        The vertical part over the horizontal one: positive with gravity, negative against it.
    coefficient:
        Horizontal seismic coefficient that λ multiplies: by default 1, and λ is the coefficient of collapse;
        a design value makes λ the factor on it, to set beside those of other load cases.
    dead_as_mass:
        False: of dead forces, a block's own ``dead`` among them, nothing pushes but what is given as
        ``mass``.

    Raises
    ------
    CaseError
        If a value is none of these.
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

    Parameters
    ----------
    name:
        Unique within the scene.
    dead:
        Factors by group of the loads that act as dead. "weight", "fill" and "dead" are 1 where they are not
        named, all others 0.
    live:
        Factors by group of the loads that λ scales.
    earthquake:
        In place of ``live``: :class:`Earthquake`. Masses count times the factor of their group in ``dead``.

    Raises
    ------
    CaseError
        If nothing is live, both ``live`` and ``earthquake`` are given, or axles are dead, or pull.
    """

    name: Name
    dead: dict[Name, Number] = {}
    live: dict[Name, Number] = {}
    earthquake: Earthquake | None = None

    @model_validator(mode="after")
    def _has_one_live_load(self) -> LoadCase:
        if "axles" in self.dead:
            raise ValueError("'dead' names 'axles', which move: give them in 'live'")
        if self.live.get("axles", 0.0) < 0:
            raise ValueError("axles press down: give 'axles' in 'live' a positive factor")
        if any(self.live.values()) == (self.earthquake is not None):
            raise ValueError(
                "give 'live' or 'earthquake', not both: of both, λ is no one number"
                if self.earthquake
                else "nothing is live: give 'live = { live = 1 }', the factors of groups, or an 'earthquake'"
            )
        return self

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


def wrong_cases(scene: Scene) -> str | None:
    """What is wrong with the load cases of a scene, or with its earthquake."""
    groups = [load.group for load in scene.loads] + [load.group for load in scene.edge_loads]
    named = {group for group in groups if group is not None}
    known, seen = [*GROUPS, *sorted(named)], set[str]()
    quakes = [("'earthquake'", scene.earthquake)]
    for number, case in enumerate(scene.load_cases, start=1):
        where = f"load_case no. {number} ('{case.name}')"
        if case.name in seen:
            return f"{where}: the name is given twice: rename one"
        seen.add(case.name)
        for key in ("dead", "live"):
            if unknown := [group for group in getattr(case, key) if group not in known]:
                there = ", ".join(known)
                return f"{where}: '{key}' names group '{unknown[0]}', which no load has; there are: {there}"
        if "axles" in case.live and scene.dimension == 3:
            return f"{where}: 'live' names 'axles', which move over scenes in the plane: take them away"
        quakes.append((f"{where}: 'earthquake'", case.earthquake))
    for where, quake in quakes:
        if quake is not None and (mistake := _wrong_direction(scene, quake)):
            return f"{where}: {mistake}"
    if scene.tilt and (scene.load_cases or scene.earthquake):
        return "'tilt' is a live load of its own: take it, or the load cases and the earthquake, away"
    if scene.earthquake and scene.load_cases:
        return "'earthquake' is of a scene without load cases: give it within a [[load_case]]"
    if scene.earthquake and (live := _first_live_load(scene)):
        return (
            f"'earthquake' is the live load, and {live} is live too: take that away, or give the earthquake "
            "in a [[load_case]], where other loads are live only if it says so"
        )
    return None


def refuse_without_case(scene: Scene) -> None:
    """Raise OptionError if a scene has load cases and is in none of them: which loads act is not known."""
    if scene.load_cases and scene.load_case is None:
        raise OptionError(
            f"{scene.origin}: has load cases: name one of them, 'load_case' (--load-case): "
            f"{', '.join(case.name for case in scene.load_cases)} (in Python scene.in_case(name) is the "
            "scene in one, and mo.solve_cases solves all, as the command solve does)"
        )


def shaken(scene: Scene, quake: Earthquake) -> Scene:
    """The scene in an earthquake in place of all other live loads, dead loads those of its load case. Raises
    CaseError if the scene cannot be in that earthquake."""
    if case := scene.load_case:
        changed = scene.under(case.replace(live={}, earthquake=quake))
    else:
        # Beside other live loads, which no longer act, a scene that is checked takes none.
        changed = BaseModel.model_copy(scene, update={"earthquake": quake})
    if mistake := _wrong_direction(scene, quake):
        raise CaseError(f"{scene.origin}: 'earthquake': {mistake}")
    return changed


def _wrong_direction(scene: Scene, quake: Earthquake) -> str | None:
    if isinstance(quake.direction, str) == (scene.dimension == 3):
        needed = "an angle in plan or [x, y, z]" if scene.dimension == 3 else '"left" or "right"'
        return f"'direction' needs {needed}"
    if scene.sideways(quake.direction, quake.vector) is None:
        return "'direction' needs one that is not that of gravity"
    return None


def _first_live_load(scene: Scene) -> str | None:
    own = [f"block '{one.name}'" for one in scene.blocks if any(any(getattr(one, key, ())) for key in _LIVE)]
    own += [f"load no. {number}" for number, one in enumerate(scene.loads, start=1) if one.gives("live")]
    lines = enumerate(scene.edge_loads, start=1)
    return next(iter(own + [f"edge_load no. {number}" for number, one in lines if one.kind == "live"]), None)

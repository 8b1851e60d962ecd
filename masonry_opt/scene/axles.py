"""Axles that move along a road, and common sets of them."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Literal, NamedTuple

from masonry_opt.scene.blocks import Name, Positive, Record, RoadLine

#: Weight of a tonne, kN.
_TONNE = 9.81

#: Directions of travel.
TravelDirection = Literal["right", "left"]


class AxleSet(NamedTuple):
    """Distances between successive axles (m), their loads (kN), and where they stand."""

    distances: tuple[float, ...]
    loads: tuple[float, ...]
    source: str


_LM1 = (
    "EN 1991-2:2003, 4.3.2, load model 1, tandem system of lane {}, characteristic, without the uniform load"
)
_CS = "CS 454 (UK), table 7.3.1a, normal traffic, {}, without axle lift-off; a tonne is 9.81 kN"

#: Sets by name.
SETS = {
    **{
        f"LM1 lane {lane}": AxleSet((1.2,), (load, load), _LM1.format(lane))
        for lane, load in ((1, 300.0), (2, 200.0), (3, 100.0))
    },
    "LM2": AxleSet((), (400.0,), "EN 1991-2:2003, 4.3.3, load model 2, single axle, characteristic"),
    "LM71": AxleSet(
        (1.6, 1.6, 1.6),
        (250.0,) * 4,
        "EN 1991-2:2003, 6.3.2, load model 71 (UIC 702), its four axles without the uniform load",
    ),
    "CS 454 single": AxleSet((), (11.5 * _TONNE,), _CS.format("single axle of 11.5 t")),
    **{
        f"CS 454 double {apart} m": AxleSet(
            (apart,), (tonnes * _TONNE,) * 2, _CS.format(f"double axle bogie of 2 × {tonnes:g} t")
        )
        for apart, tonnes in ((1.0, 8.0), (1.3, 9.5), (1.8, 10.0))
    },
}


class Axles(Record):
    """A group of axles that moves along a road over a scene in the plane: see :func:`~masonry_opt.crossing`.

    Raises CaseError if loads are missing or not positive, distances are not one fewer, a set is unknown or
    given beside them, or the road does not run from left to right.

    Parameters
    ----------
    name: Unique among the groups of a scene.
    loads: Of each axle, straight down, the first axle first.
    distances: From each axle to the next behind it: one fewer than loads.
    set: In place of both, a common set by its name, in m and kN: ``SETS`` has them with their sources.
    factor: By which all loads are multiplied: a share of the width, a dynamic or a partial factor.
    road: Points of the road's line from left to right. Default: that of the scene's fills.
    travels: "right", "left" or "both" (the default), of which one is enough for a group that is the same from
        behind.
    """

    name: Name
    loads: list[Positive] = []
    distances: list[Positive] = []
    set: str | None = None
    factor: Positive = 1.0
    road: RoadLine | None = None
    travels: Literal["right", "left", "both"] = "both"

    def _mistakes(self) -> Iterator[str]:
        if self.set is not None:
            if self.loads or self.distances:
                yield "give 'set', or 'loads' and 'distances', not both"
            if self.set not in SETS:
                yield f"'set' \"{self.set}\" is unknown; known: {', '.join(SETS)}"
        elif not self.loads:
            yield "has no axle: give 'loads' and 'distances', or a 'set' by its name"
        elif len(self.distances) != len(self.loads) - 1:
            yield (
                f"'distances' are those between the axles, one fewer than 'loads': {len(self.loads)} loads "
                f"need {len(self.loads) - 1}, has {len(self.distances)}"
            )

    @property
    def group(self) -> AxleSet:
        """Its distances, loads (with the factor) and source."""
        given = SETS[self.set] if self.set else AxleSet(tuple(self.distances), tuple(self.loads), "")
        return given._replace(loads=tuple(self.factor * load for load in given.loads))

    @property
    def directions(self) -> tuple[TravelDirection, ...]:
        """Directions of travel that differ, of those asked for."""
        if self.travels != "both":
            return (self.travels,)
        distances, loads, _ = self.group
        same = distances == distances[::-1] and loads == loads[::-1]
        return ("right",) if same else ("right", "left")

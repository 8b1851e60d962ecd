"""The road over a scene in the plane: earth between it and blocks, and axles along it, with common sets."""

import math
from collections.abc import Iterator
from typing import Annotated, Any, Literal, NamedTuple

import numpy as np
from pydantic import BaseModel, Field, PlainValidator

from masonry_opt.scene.blocks import Name, Number, Positive, Record, RoadLine, YesNo

_TONNE = 9.81  #: Weight of a tonne, kN.
TravelDirection = Literal["right", "left"]  #: Directions of travel.


class AxleSet(NamedTuple):
    """Distances between successive axles (m), their loads (kN), and where they stand."""

    distances: tuple[float, ...]
    loads: tuple[float, ...]
    source: str


_LM1 = "EN 1991-2:2003, 4.3.2, load model 1, tandem system of {}, characteristic, without the uniform load"
_LM71 = "EN 1991-2:2003, 6.3.2, load model 71 (UIC 702), its four axles without the uniform load"
_CS = "CS 454 (UK), table 7.3.1a, normal traffic, {}, without axle lift-off; a tonne is 9.81 kN"

SETS = {
    "LM1 lane 1": AxleSet((1.2,), (300.0,) * 2, _LM1.format("lane 1")),
    "LM1 lane 2": AxleSet((1.2,), (200.0,) * 2, _LM1.format("lane 2")),
    "LM1 lane 3": AxleSet((1.2,), (100.0,) * 2, _LM1.format("lane 3")),
    "LM2": AxleSet((), (400.0,), "EN 1991-2:2003, 4.3.3, load model 2, single axle, characteristic"),
    "LM71": AxleSet((1.6,) * 3, (250.0,) * 4, _LM71),
    "CS 454 single": AxleSet((), (11.5 * _TONNE,), _CS.format("single axle of 11.5 t")),
    "CS 454 double 1.0 m": AxleSet((1.0,), (8.0 * _TONNE,) * 2, _CS.format("double axle bogie of 2 × 8 t")),
    "CS 454 double 1.3 m": AxleSet((1.3,), (9.5 * _TONNE,) * 2, _CS.format("double axle bogie of 2 × 9.5 t")),
    "CS 454 double 1.8 m": AxleSet((1.8,), (10.0 * _TONNE,) * 2, _CS.format("double axle bogie of 2 × 10 t")),
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
    factor: By which all loads are multiplied: a dynamic or a partial factor.
    width: Effective width of the bridge that carries them: the scene carries its ``thickness`` over that of
        each load (default: all). On roads commonly 1.5 m and the depth of fill, on railways 0.8 m and twice
        the depth below the sleeper (B. Harvey, "Available width, effective width, and transverse
        distribution", help.obvis.com, 2024, which names CS 454 and British Railways for them), no more than
        there is, and less where lanes or tracks lie side by side.
    road: Points of the road's line from left to right. Default: that of the scene's fills.
    travels: "right", "left" or "both" (the default); of a group that is the same from behind one is enough.
    """

    name: Name
    loads: list[Positive] = []
    distances: list[Positive] = []
    set: str | None = None
    factor: Positive = 1.0
    width: Positive | None = None
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
            count = f"{len(self.loads)} loads need {len(self.loads) - 1}, has {len(self.distances)}"
            yield f"'distances' are those between the axles, one fewer than 'loads': {count}"

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


def _spread(value: Any) -> float | bool:
    angle = isinstance(value, int | float) and value is not True and 0 < value < 90
    if angle or value is False:
        return float(value) if angle else value
    raise ValueError("must be an angle between 0 and 90 degrees, or false")


class Backing(Record):
    """The part of a :class:`Fill` below a line, such as rubble or concrete over the haunches of an arch.

    Raises CaseError if the line does not run from left to right, a value is out of range, or the share of the
    passive pressure lies below the active one.

    Parameters
    ----------
    line: Its upper line, ``[[x, y], ...]`` from left to right, not above the road. There is no
        backing beyond its ends, nor where blocks reach above it.
    unit_weight: As of the fill.
    friction_angle, mobilised: For its pressure, where the fill presses: as of the fill (default: the fill's).
    """

    line: RoadLine
    unit_weight: Positive
    friction_angle: Annotated[Number, Field(gt=0, lt=90)] | None = None
    mobilised: Annotated[Number, Field(gt=0, le=1)] | None = None


class Fill(Record):
    """Earth between blocks and the line of a road above them, in the plane.

    It lies on whatever edges are the first below the road, and beside the upright edges between these. Its
    weight is a dead load on them; loads on the road spread through it; and it presses against faces with
    what holds them best between its active limit and a share of its passive one.

    Raises CaseError if the road does not run from left to right, a value is out of range, or the share of the
    passive pressure lies below the active one.

    Parameters
    ----------
    road: The line of the road, ``[[x, y], ...]`` from left to right. The fill ends where it ends.
    unit_weight: Weight per unit area; per unit volume where the scene has a ``thickness``.
    friction_angle: φ in degrees, for its pressure: Rankine's K_a = tan²(45° - φ/2) and K_p = 1 / K_a.
    mobilised: The share m of the passive pressure that the fill may reach: pressure, horizontal, lies between
        K_a σ and m K_p σ, where σ is the unit weight times the depth below the road.
    weight: Whether the fill's weight acts on the blocks.
    spread: Angle to the vertical, in degrees, within which loads on the road spread; False: straight down.
    pressure: Whether it presses on faces. If not, ``friction_angle`` and ``mobilised`` are not needed.
    backing: The part of it below a line: :class:`Backing`. σ is then the weight of both above a point, and
        the coefficients are those of the zone in which the face lies; loads spread as in the fill.
    """

    road: RoadLine
    unit_weight: Positive
    friction_angle: Annotated[Number, Field(gt=0, lt=90)] | None = None
    mobilised: Annotated[Number, Field(gt=0, le=1)] | None = None
    weight: YesNo = True
    spread: Annotated[float | Literal[False], PlainValidator(_spread)] = 30.0
    pressure: YesNo = True
    backing: Backing | None = None

    def _mistakes(self) -> Iterator[str]:
        if self.pressure:
            for key in ("friction_angle", "mobilised"):
                if getattr(self, key) is None:
                    yield f"give '{key}', or 'pressure = false' for a fill that does not press"
            least, _, most = self.coefficients
            if least > most:
                yield f"'mobilised' times K_p, {most:.4g}, is below K_a, {least:.4g}: give a larger share"
        if self.backing:
            (_, backed), line, road = self.zones, np.array(self.backing.line), np.array(self.road)
            yield from (f"'backing': {mistake}" for mistake in backed._mistakes())
            x = np.unique([*line[:, 0], *road[:, 0]])
            x = x[(x >= max(line[0, 0], road[0, 0])) & (x <= min(line[-1, 0], road[-1, 0]))]
            if not len(x):
                yield "'backing': its 'line' lies beside the 'road': give both in one system of axes"
            if (np.interp(x, *line.T) > np.interp(x, *road.T)).any():
                yield "'backing': its 'line' lies above the 'road': end it there, or lower it"

    @property
    def zones(self) -> "tuple[Fill, ...]":
        """The fill, and its backing as a fill below its line, if it has one."""
        if self.backing is None:
            return (self,)
        own = {key: value for key, value in vars(self.backing).items() if key != "line" and value is not None}
        # Unchecked: what is wrong with it is said of the backing.
        return self, BaseModel.model_copy(self, update=own | {"road": self.backing.line, "backing": None})

    @property
    def coefficients(self) -> tuple[float, float, float]:
        """K_a, K_0 = 1 - sin φ (Jaky), and m K_p, of a fill that presses."""
        assert self.friction_angle is not None
        assert self.mobilised is not None
        active = math.tan(math.radians(45 - self.friction_angle / 2)) ** 2
        return active, 1 - math.sin(math.radians(self.friction_angle)), self.mobilised / active

"""Define the road over a scene in the plane: fill below it, and axles that move along it."""

import math
from collections.abc import Iterator
from typing import Annotated, Any, Literal, NamedTuple

import numpy as np
from pydantic import BaseModel, Field, PlainValidator

from masonry_opt.scene.blocks import Name, Number, Positive, Record, RoadLine, YesNo
from masonry_opt.scene.mistakes import instead_of

#: Weight of a tonne, in kN.
_TONNE = 9.81
#: Number of decimal places to which uniform loads are compared with their mirror images, to find out if a
#: group of axles is symmetric.
_DIGITS = 9
#: Friction angle of a fill, in degrees, below which a warning says that the value may be a tangent or an
#: angle in radians. Smaller angles are permitted, because undrained clay can have them. With a smaller limit,
#: steep angles in radians cause no warning (a right angle is 1.57 rad).
SMALL_FRICTION_ANGLE = 1.5
#: Directions of travel along a road.
TravelDirection = Literal["right", "left"]


class AxleSet(NamedTuple):
    """Distances and loads of successive axles, and the standard that defines them."""

    distances: tuple[float, ...]  #: distance from each axle to the next axle, in m
    loads: tuple[float, ...]  #: load of each axle, in kN
    source: str  #: the standard that defines the axle loads


_LM1 = "EN 1991-2:2003, 4.3.2, load model 1, tandem system of {}, characteristic, without the uniform load"
_LM71 = "EN 1991-2:2003, 6.3.2, load model 71 (UIC 702), its four axles without the uniform load"
_CS_SOURCE = "CS 454 (UK), table 7.3.1a, normal traffic, {}, without axle lift-off; a tonne weighs 9.81 kN"

SETS = {
    "LM1 lane 1": AxleSet((1.2,), (300.0,) * 2, _LM1.format("lane 1")),
    "LM1 lane 2": AxleSet((1.2,), (200.0,) * 2, _LM1.format("lane 2")),
    "LM1 lane 3": AxleSet((1.2,), (100.0,) * 2, _LM1.format("lane 3")),
    "LM2": AxleSet((), (400.0,), "EN 1991-2:2003, 4.3.3, load model 2, single axle, characteristic"),
    "LM71": AxleSet((1.6,) * 3, (250.0,) * 4, _LM71),
    "CS 454 single": AxleSet((), (11.5 * _TONNE,), _CS_SOURCE.format("single axle of 11.5 t")),
    "CS 454 double 1.0 m": AxleSet(
        (1.0,), (8.0 * _TONNE,) * 2, _CS_SOURCE.format("double axle bogie of 2 × 8 t")
    ),
    "CS 454 double 1.3 m": AxleSet(
        (1.3,), (9.5 * _TONNE,) * 2, _CS_SOURCE.format("double axle bogie of 2 × 9.5 t")
    ),
    "CS 454 double 1.8 m": AxleSet(
        (1.8,), (10.0 * _TONNE,) * 2, _CS_SOURCE.format("double axle bogie of 2 × 10 t")
    ),
}


class UniformLoad(Record):
    """Uniform load that moves with a group of axles, such as the load of a train behind its locomotive.

    Parameters
    ----------
    load: Load per unit length of the road, straight down, over the whole width that carries the axles.
    start, end: Distances from the first axle back to the two ends of the load, negative for an end ahead of
        the first axle. In a case file the keys are ``from`` and ``to``.

    Raises
    ------
    CaseError
        If the load is not positive, or if its end is not behind its start.
    """

    load: Positive
    start: Annotated[Number, Field(alias="from")]
    end: Annotated[Number, Field(alias="to")]

    def _mistakes(self) -> Iterator[str]:
        if self.start >= self.end:
            yield "'to' must be greater than 'from': both are distances behind the first axle"


class Axles(Record):
    """Group of axles that moves along a road over a plane scene; see :func:`~masonry_opt.crossing`.

    Parameters
    ----------
    name: Name of the group, unique within the scene.
    loads: Load of each axle, straight down, the first axle first.
    distances: Distance from each axle to the next axle behind it: one distance fewer than loads.
    set: In place of loads and distances, the name of a common set, in m and kN. The page
        "Axles" of the guide lists the sets with their sources.
    uniform: Uniform loads that move with the axles (:class:`UniformLoad`). A group without axles may have
        uniform loads only. Its position is then the point from which the distances of the uniform loads are
        measured.
    factor: Factor of all loads, including uniform loads, such as a dynamic factor or a partial factor.
    width: Effective width of the bridge that carries the axles. The scene carries the fraction ``thickness``
        / ``width`` of each load (default: all). On roads commonly 1.5 m plus the depth of fill, on railways
        0.8 m plus twice the depth below the sleeper (B. Harvey, "Available width, effective width, and
        transverse distribution", help.obvis.com, 2024, which names CS 454 and British Railways as sources).
        It is at most the width of the bridge, and less if lanes or tracks lie side by side.
    road: Points of the road's line from left to right. Default: the road of the scene's fills.
    travels: "right", "left" or "both" (the default). A symmetric group is moved in one direction only.

    Raises
    ------
    CaseError
        If loads are missing or not positive, if the number of distances is not one less than the number of
        loads, if a set is unknown or is given together with loads, or if the road does not run from left to
        right.
    """

    name: Name
    loads: list[Positive] = []
    distances: list[Positive] = []
    set: str | None = None
    uniform: list[UniformLoad] = []
    factor: Positive = 1.0
    width: Positive | None = None
    road: RoadLine | None = None
    travels: Literal["right", "left", "both"] = "both"

    def _mistakes(self) -> Iterator[str]:
        if self.set is not None:
            if self.loads or self.distances:
                yield "a group of axles needs either a 'set', or 'loads' and 'distances', but not both"
            if self.set not in SETS:
                yield f"'set' \"{self.set}\" is unknown{instead_of(self.set, SETS)}"
        elif not self.loads and (self.distances or not self.uniform):
            if self.uniform:
                yield "the group has no axle: remove 'distances', or give the 'loads' of the axles"
            else:
                yield "the group has no load: give 'loads' and 'distances', a 'set', or loads in 'uniform'"
        elif self.loads and len(self.distances) != len(self.loads) - 1:
            yield (
                f"{len(self.loads)} 'loads' need {len(self.loads) - 1} 'distances' between the axles "
                f"(found {len(self.distances)})"
            )

    @property
    def group(self) -> AxleSet:
        """Return the axle distances, the axle loads multiplied by ``factor``, and the source of both."""
        axle_set = SETS[self.set] if self.set else AxleSet(tuple(self.distances), tuple(self.loads), "")
        return axle_set._replace(loads=tuple(self.factor * load for load in axle_set.loads))

    @property
    def strips(self) -> np.ndarray:
        """Return a table with the load, the start and the end of each uniform load, shape (loads, 3).

        The loads contain the factor of the group. Start and end are distances behind the first axle.
        """
        rows = [(self.factor * strip.load, strip.start, strip.end) for strip in self.uniform]
        return np.array(rows).reshape(-1, 3)

    @property
    def directions(self) -> tuple[TravelDirection, ...]:
        """Return the directions of travel to analyse; for a symmetric group, one direction is enough."""
        if self.travels != "both":
            return (self.travels,)
        distances, loads, _ = self.group
        is_symmetric = distances == distances[::-1] and loads == loads[::-1] and self._has_symmetric_strips
        return ("right",) if is_symmetric else ("right", "left")

    @property
    def _has_symmetric_strips(self) -> bool:
        """Return True if the uniform loads equal their mirror image about the middle of the group."""
        strips = self.strips
        if not len(strips):
            return True
        distances = self.group.distances
        # The mirror axis is the middle of the axles or, without axles, the middle of the uniform loads.
        twice_the_centre = sum(distances) if self.group.loads else strips[:, 1].min() + strips[:, 2].max()
        mirrored_strips = np.column_stack([strips[:, 0], twice_the_centre - strips[:, 2:0:-1]])
        own_rows = np.array(sorted(strips.round(_DIGITS).tolist()))
        mirrored_rows = np.array(sorted(mirrored_strips.round(_DIGITS).tolist()))
        return bool(np.allclose(own_rows, mirrored_rows, rtol=0, atol=10.0 ** (1 - _DIGITS)))


def _parse_spread(value: Any) -> float | bool:
    """Return the angle of load spread in degrees, or False for loads that do not spread.

    Raises ValueError for any other value.
    """
    if value is False:
        return value
    if isinstance(value, int | float) and value is not True and 0 < value < 90:
        return float(value)
    raise ValueError("must be an angle between 0 and 90 degrees, or false")


class Backing(Record):
    """Lower part of a :class:`Fill`, below a line, such as rubble or concrete over arch haunches.

    Parameters
    ----------
    line: Upper line of the backing, ``[[x, y], ...]`` from left to right, not above the road. The backing
        does not extend beyond the ends of the line, and blocks above the line interrupt it.
    unit_weight: Weight per unit area, as in :class:`Fill`.
    friction_angle, mobilised: Properties of the earth pressure, as in :class:`Fill` (default: the values of
        the fill). They are needed only if the fill has ``pressure``.

    Raises
    ------
    CaseError
        If the line does not run from left to right, if a value is out of range, or if the share of the
        passive pressure is below the active pressure.
    """

    line: RoadLine
    unit_weight: Positive
    friction_angle: Annotated[Number, Field(ge=0, lt=90)] | None = None
    mobilised: Annotated[Number, Field(gt=0, le=1)] | None = None


class Fill(Record):
    """Earth fill between the blocks of a plane scene and the line of a road above them.

    The fill rests on the first edges below the road, and touches the upright faces between them. Its weight
    is a dead load on these edges. Loads on the road spread through the fill. The pressure on the upright
    faces is the most favourable for stability between the active pressure and a fraction of the passive
    pressure.

    Parameters
    ----------
    road: The line of the road, ``[[x, y], ...]`` from left to right. The fill ends where the road ends.
    unit_weight: Weight per unit area, or per unit volume if the scene has a ``thickness``.
    friction_angle: φ in degrees, for its pressure: Rankine's K_a = tan²(45° - φ/2) and K_p = 1 / K_a. With φ
        = 0 the fill presses like a fluid: ``mobilised`` must be 1, and the pressure is σ.
    mobilised: The fraction m of the passive pressure that the fill may reach. The horizontal pressure lies
        between K_a σ and m K_p σ, where σ is the unit weight times the depth below the road.
    weight: True if the fill's weight acts on the blocks.
    spread: Angle to the vertical, in degrees, within which loads on the road spread. False: loads act
        straight down.
    pressure: True if the fill exerts earth pressure on upright faces. If False, ``friction_angle`` and
        ``mobilised`` are not needed.
    backing: The part of the fill below a line: :class:`Backing`. σ is then the weight of fill and backing
        above a point. A face in the backing has the pressure coefficients of the backing. Loads spread at the
        same angle in fill and backing.

    Raises
    ------
    CaseError
        If the road does not run from left to right, if a value is out of range, or if the fraction of the
        passive pressure is below the active pressure.
    """

    road: RoadLine
    unit_weight: Positive
    friction_angle: Annotated[Number, Field(ge=0, lt=90)] | None = None
    mobilised: Annotated[Number, Field(gt=0, le=1)] | None = None
    weight: YesNo = True
    spread: Annotated[float | Literal[False], PlainValidator(_parse_spread)] = 30.0
    pressure: YesNo = True
    backing: Backing | None = None

    def _mistakes(self) -> Iterator[str]:
        if self.pressure:
            for key in ("friction_angle", "mobilised"):
                if getattr(self, key) is None:
                    yield f"a fill needs '{key}', or 'pressure = false' if it exerts no earth pressure"
            k_active, _, k_passive = self.coefficients
            if k_active > k_passive:
                yield (
                    f"'mobilised' times K_p is {k_passive:.4g}, below K_a = {k_active:.4g}: "
                    f"raise 'mobilised'{self._angle_advice()}"
                )
        if self.backing:
            backing_fill = self.zones[1]
            yield from (f"'backing': {mistake}" for mistake in backing_fill._mistakes())
            line = np.array(self.backing.line)
            road = np.array(self.road)
            x = np.unique([*line[:, 0], *road[:, 0]])
            x = x[(x >= max(line[0, 0], road[0, 0])) & (x <= min(line[-1, 0], road[-1, 0]))]
            if not len(x):
                yield (
                    "the 'line' of 'backing' and the 'road' have no x coordinate in common: "
                    "give both lines in the same coordinates"
                )
            if (np.interp(x, *line.T) > np.interp(x, *road.T)).any():
                yield "the 'line' of 'backing' rises above the 'road': lower it, or end it below the road"

    def _angle_advice(self) -> str:
        """Return advice to use degrees if the friction angle looks like a tangent, otherwise ""."""
        angle = self.friction_angle
        if not angle or angle >= SMALL_FRICTION_ANGLE:
            return ""
        tangent = math.degrees(math.atan(angle))
        return f", or give 'friction_angle' in degrees (atan {angle:g} = {tangent:.1f}°)"

    @property
    def zones(self) -> "tuple[Fill, ...]":
        """Return the fill and, if it has a backing, a second fill that represents the backing."""
        if self.backing is None:
            return (self,)
        backing_values = {
            key: value for key, value in vars(self.backing).items() if key != "line" and value is not None
        }
        # Do not validate the backing as a separate fill: `_mistakes` validates it, with messages that name
        # the backing.
        return self, BaseModel.model_copy(
            self, update=backing_values | {"road": self.backing.line, "backing": None}
        )

    @property
    def coefficients(self) -> tuple[float, float, float]:
        """Return the active, at-rest and mobilised passive coefficients of the earth pressure of a fill.

        They are K_a, K_0 = 1 - sin φ (Jaky) and m K_p, where m is ``mobilised``.
        """
        assert self.friction_angle is not None
        assert self.mobilised is not None
        active_coefficient = math.tan(math.radians(45 - self.friction_angle / 2)) ** 2
        return (
            active_coefficient,
            1 - math.sin(math.radians(self.friction_angle)),
            self.mobilised / active_coefficient,
        )

"""Define the ring of an arch, used by ``[arch]`` and ``[barrel]``, and the generator ``[arch]``."""

import math
from collections import Counter
from collections.abc import Callable, Iterator
from itertools import pairwise
from typing import Annotated, Literal, NamedTuple

import numpy as np
from pydantic import Field, Strict

from masonry_opt.errors import rounded
from masonry_opt.scene.blocks import Block, NonNegative, Number, Point, Positive, Record, YesNo, rectangle
from masonry_opt.scene.generator import AnyGenerator, Generator, polar

#: Relative difference below which two lengths count as equal, such as the rise and half the span of a
#: semicircle.
_ARCH_LENGTH_TOLERANCE = 1e-9
#: Largest ratio of the thickness of an arch to its span. A larger ratio raises an error, because one length
#: is probably in another unit, such as cm instead of m.
_GREATEST_THICKNESS = 3.0


class Stone(NamedTuple):
    """Shape and weight of a voussoir, skewback or abutment, relative to the origin of the arch."""

    name: str
    #: Corners in order. A voussoir has the inner and outer end of its first joint, then the outer and inner
    #: end of its second joint.
    corners: list[Point]
    area: float | None  #: area from which the weight is computed; None for a support
    weight_at: Point | None = None  #: point of application of a voussoir's weight
    back: Point | None = None  #: middle of a voussoir's outer edge
    area_ratio: float = 1.0  #: area from which the weight is computed, divided by the area of the polygon

    def mapped(self, point: Callable[[Point], Point]) -> "Stone":
        """Return a copy of the stone, mapped by the function ``point``, which transforms each point."""
        weight_at = self.weight_at and point(self.weight_at)
        back = self.back and point(self.back)
        return self._replace(corners=[*map(point, self.corners)], weight_at=weight_at, back=back)


class _Arc(NamedTuple):
    """Circular arc of an arch, or of the left half of a pointed arch.

    The direction of a joint is its angle in radians, seen from the centre of the arc.
    """

    centre: Point  #: centre of the circle
    inner: float  #: radius of the intrados
    radius: float  #: radius of the centreline
    first: float  #: direction of the first joint
    last: float  #: direction of the last joint; for a pointed arch, the last joint of the right half
    #: Angle in radians between the first and the last joint. For a pointed arch, it is the sum of the angles
    #: of both halves.
    swept: float


class ArchRing(AnyGenerator):
    """Arch of equal voussoirs with radial joints between fixed abutments, in the plane or in space.

    The arch is given by ``radius`` and ``angles``, or by ``span`` and ``rise``. With span and rise, the arch
    is a segment of a circle if ``rise`` is less than half the span, a semicircle if it is equal to half the
    span, and pointed if it is more. A pointed arch has two arcs with centres on the springing line, of inner
    radius (span²/4 + rise²)/span, that meet in a vertical joint.

    Parameters
    ----------
    radius: Radius of the centreline; the centre is the origin.
    angles: Directions of the first and the last joint, in degrees, counter-clockwise from the x axis. ``[180,
        0]`` is a semicircle whose voussoirs are counted from the left.
    span, rise: Span and rise of the intrados, above the line between its springing points. Voussoirs are
        counted from the left; a pointed arch has an even number of them.
    thickness: Radial thickness of the ring, less than twice the radius.
    voussoirs: Number of voussoirs.
    unit_weight: Weight per unit area, or per unit volume if the scene has a ``thickness``.
    weights: Area from which the weight is computed. "sector": the area between two arcs, at its centroid.
        "centreline": the area of an annular sector, concentrated along the centreline, as in many closed
        forms. "straight": the polygon with straight edges. In all cases, the shape of the block is the
        polygon.
    skewbacks: Width of a block at either end, between the sloping foot of the arch, a level bed at the height
        of the foot's inner end, and an upright back, with the arch's unit weight: for a segmental arch on
        columns.
    abutments: True for a fixed abutment at either end, under the skewbacks if there are any. Without
        abutments the arch is supported by other blocks.
    name: See :class:`~masonry_opt.scene.generator.AnyGenerator`.

    Raises
    ------
    CaseError
        If the dimensions do not describe an arch.
    """

    radius: Positive | None = None
    angles: tuple[Number, Number] | None = None
    span: Positive | None = None
    rise: Positive | None = None
    thickness: Positive
    voussoirs: Annotated[int, Strict(), Field(ge=1)]
    unit_weight: NonNegative
    weights: Literal["sector", "centreline", "straight"] = "sector"
    skewbacks: Positive | None = None
    abutments: YesNo = True

    def _mistakes(self) -> Iterator[str]:
        yield from super()._mistakes()
        by_angles, by_rise = (self.radius, self.angles), (self.span, self.rise)
        if (None in by_angles and None in by_rise) or (any(by_angles) and any(by_rise)):
            yield "an arch needs either 'radius' and 'angles', or 'span' and 'rise': give one of these pairs"
            return
        sweep = math.degrees(self._arc.swept)
        if not 0 < sweep < 360:
            yield f"the 'angles' of an arch must differ by more than 0° and less than 360° (found {sweep:g}°)"
        elif not sweep < 180 * self.voussoirs:
            yield (
                "each voussoir must span less than 180° to be a wedge "
                f"(found {sweep / self.voussoirs:g}°): raise the number of 'voussoirs'"
            )
        if self._is_pointed and self.voussoirs % 2:
            yield (
                "'rise' exceeds half of 'span', so the arch is pointed: "
                f"a pointed arch needs an even number of 'voussoirs' (found {self.voussoirs})"
            )
        radius = self._arc.radius
        if self.span is not None and self.thickness > _GREATEST_THICKNESS * self.span:
            yield (
                f"'thickness' is {rounded(self.thickness / self.span)} times the span "
                f"('thickness' = {self.thickness:g}): give all lengths in the same unit"
            )
        if not self.thickness < 2 * radius:
            yield f"'thickness' must be less than twice the radius {radius:g} (found {self.thickness:g})"
        yield from self._wrong_skewbacks()

    def _wrong_skewbacks(self) -> Iterator[str]:
        """Generate an error message if skewbacks of the given width do not fit the feet of the arch."""
        if self.skewbacks is None:
            return
        for angle, turn in self._end_joints:
            foot = self.thickness * -turn * math.cos(angle)
            up = math.sin(angle)
            if up <= _ARCH_LENGTH_TOLERANCE or foot < -_ARCH_LENGTH_TOLERANCE * self.thickness:
                yield (
                    "'skewbacks' are only for arches whose feet slope upwards to the outside: "
                    "remove 'skewbacks' if the feet are level"
                )
                return
            if self.skewbacks < foot * (1 - _ARCH_LENGTH_TOLERANCE):
                yield (
                    f"'skewbacks' must be at least as wide as the foot of the arch, {foot:g} "
                    f"(found {self.skewbacks:g})"
                )
                return

    @property
    def _is_pointed(self) -> bool:
        """Return True if the arch is pointed."""
        return bool(self.span and self.rise and self.rise > self.span / 2 * (1 + _ARCH_LENGTH_TOLERANCE))

    @property
    def _arc(self) -> _Arc:
        """Return the circular arc of the arch, from its radius and angles or from its span and rise."""
        if self.radius is not None and self.angles is not None:
            first, last = self.angles
            inner, sweep = self.radius - self.thickness / 2, math.radians(abs(last - first))
            return _Arc((0.0, 0.0), inner, self.radius, math.radians(first), math.radians(last), sweep)
        assert self.span is not None
        assert self.rise is not None
        half = self.span / 2
        inner = (half**2 + self.rise**2) / (self.span if self._is_pointed else 2 * self.rise)
        radius = inner + self.thickness / 2
        if self._is_pointed:
            return _Arc((inner - half, 0.0), inner, radius, math.pi, 0.0, 2 * math.acos(1 - half / inner))
        angle = math.asin(min(half / inner, 1.0))
        first, last = math.pi / 2 + angle, math.pi / 2 - angle
        return _Arc((0.0, self.rise - inner), inner, radius, first, last, first - last)

    @property
    def _end_joints(self) -> list[tuple[float, float]]:
        """Return, for each end joint, its direction in radians and the sign of rotations away from the arch.

        The sign is 1 if a counter-clockwise rotation about the centre leads away from the arch, and -1 if a
        clockwise rotation does.
        """
        first, last = self._arc.first, self._arc.last
        sign = math.copysign(1.0, last - first)
        return [(first, -sign), (last, sign)]

    def _stones(self) -> Iterator[Stone]:
        """Generate the voussoirs ``v1``, ``v2``, ..., then the skewbacks, then the abutments."""
        shapes = self._voussoirs()
        for number, shape in enumerate(shapes, start=1):
            yield shape._replace(name=f"v{number}")
        first, last, (begin, end) = shapes[0].corners, shapes[-1].corners, self._end_joints
        feet = [(first[0], first[1], *begin), (last[3], last[2], *end)]
        if self.skewbacks is not None:
            for number, (inner, outer, _, turn) in enumerate(feet, start=1):
                # A skewback is bounded by the sloping foot of the arch, a level bed and an upright back.
                back = inner[0] - turn * self.skewbacks
                area = (outer[1] - inner[1]) * (self.skewbacks - abs(outer[0] - inner[0]) / 2)
                corners = [inner, outer, (back, outer[1]), (back, inner[1])]
                yield Stone(f"skewback {number}", corners, area)
        for number, (inner, outer, angle, turn) in enumerate(feet if self.abutments else (), start=1):
            # Without skewbacks, an abutment is a square on the outer side of the springing.
            if self.skewbacks is None:
                x, y = -turn * self.thickness * math.sin(angle), turn * self.thickness * math.cos(angle)
                corners = [inner, outer, (outer[0] + x, outer[1] + y), (inner[0] + x, inner[1] + y)]
            else:  # with skewbacks, an abutment is a rectangle under a skewback
                left, right = sorted((inner[0], inner[0] - turn * self.skewbacks))
                corners = rectangle(left, right, inner[1] - self.thickness, inner[1])
            yield Stone(f"abutment {number}", corners, None)

    def _voussoirs(self) -> list[Stone]:
        """Return the voussoirs of the arch, without names."""
        arc, count = self._arc, self.voussoirs
        if self._is_pointed:
            joints = [math.pi - arc.swept / count * number for number in range(count // 2)]
            stones = [*(self._wedge(*pair) for pair in pairwise(joints)), self._half_key(joints[-1])]
        else:
            joints = [arc.first + (arc.last - arc.first) * number / count for number in range(count + 1)]
            stones = [self._wedge(*pair) for pair in pairwise(joints)]
        x, y = arc.centre
        stones = [stone.mapped(lambda point: (point[0] + x, point[1] + y)) for stone in stones]
        if self._is_pointed:
            mirrored_stones = [
                stone.mapped(lambda point: (-point[0], point[1])) for stone in reversed(stones)
            ]
            stones += [stone._replace(corners=stone.corners[::-1]) for stone in mirrored_stones]
        return stones

    def _wedge(self, begin: float, end: float) -> Stone:
        """Return a wedge-shaped voussoir between two radial joints with given directions, in radians.

        The points of the voussoir are relative to the centre of the arch.
        """
        radius, thickness, angle = self._arc.radius, self.thickness, self._arc.swept / self.voussoirs
        inner, outer, middle = radius - thickness / 2, radius + thickness / 2, (begin + end) / 2
        # The centroid of an annular sector is at the distance `mean * arc` from the centre. The formula for
        # `mean` equals 2/3 (outer³ - inner³) / (outer² - inner²), but avoids cancellation in thin rings.
        mean = radius + thickness**2 / (12 * radius)
        # `arc` is the ratio of the chord to the length of the arc.
        arc = 2 * math.sin(angle / 2) / angle
        area, centroid = {
            "sector": (angle * radius * thickness, mean * arc),
            "centreline": (angle * radius * thickness, radius * arc),
            "straight": (math.sin(angle) * radius * thickness, mean * math.cos(angle / 2)),
        }[self.weights]
        corners = [polar(inner, begin), polar(outer, begin), polar(outer, end), polar(inner, end)]
        back = polar(outer * math.cos(angle / 2), middle)
        drawn_area = math.sin(angle) * radius * thickness
        return Stone("", corners, area, polar(centroid, middle), back, area / drawn_area)

    def _half_key(self, begin: float) -> Stone:
        """Return the left half of a pointed arch's key: the voussoir left of the vertical joint at the crown.

        The points of the voussoir are relative to the centre of the arc.
        """
        inner = self._arc.inner
        plumb = -self._arc.centre[0]  # horizontal distance of the crown joint from the centre of the arc
        thickness = self.thickness
        weights = self.weights
        radius = inner + thickness / 2
        outer = inner + thickness
        crown = {distance: math.acos(plumb / distance) for distance in (inner, radius, outer)}
        corners = [polar(inner, begin), polar(outer, begin)]
        corners += [polar(outer, crown[outer]), polar(inner, crown[inner])]
        back = ((corners[1][0] + corners[2][0]) / 2, (corners[1][1] + corners[2][1]) / 2)
        points, next_points = np.array(corners), np.array([*corners[1:], corners[0]])
        cross = next_points[:, 0] * points[:, 1] - points[:, 0] * next_points[:, 1]  # corners go clockwise
        drawn_area = area = float(cross.sum()) / 2
        if weights == "centreline":
            angle = begin - crown[radius]
            area = angle * radius * thickness
            centroid = polar(radius * 2 * math.sin(angle / 2) / angle, begin - angle / 2)
            return Stone("", corners, area, centroid, back, _ratio(area, drawn_area))
        moment = (cross[:, None] * (points + next_points) / 6).sum(axis=0)
        if weights == "sector":
            # Add the circular segment between arc and chord at the outer edge, and subtract the circular
            # segment at the inner edge.
            for distance, sign in ((outer, 1.0), (inner, -1.0)):
                angle = begin - crown[distance]
                # A circular segment has the area r² (angle - sin(angle)) / 2. Its moment about the centre is
                # 2/3 r³ sin³(angle / 2).
                area += sign * distance**2 * (angle - math.sin(angle)) / 2
                size = sign * 2 / 3 * (distance * math.sin(angle / 2)) ** 3
                moment += polar(size, begin - angle / 2)
        # A stone with zero area has no centroid. Use the middle of its back, because the scene raises an
        # error for this stone later.
        centroid = tuple((moment / area).tolist()) if area else back
        return Stone("", corners, area, centroid, back, _ratio(area, drawn_area))


def _ratio(area: float, drawn_area: float) -> float:
    """Return ``area / drawn_area``, or 1 if ``drawn_area`` is zero."""
    return area / drawn_area if drawn_area else 1.0


class PointLoad(Record):
    """Live force on one voussoir, at the middle of its outer edge (the back).

    Parameters
    ----------
    voussoir: Number of the voussoir. Voussoir 1 is at the first of the arch's ``angles``, or at the left end
        of its ``span``.
    force: Force ``[fx, fy]``, which the load factor multiplies.

    Raises
    ------
    CaseError
        If the number of the voussoir is not a positive integer, or if the force is not two numbers.
    """

    voussoir: Annotated[int, Strict(), Field(ge=1)]
    force: Point


class Arch(ArchRing, Generator):
    """An arch in the plane.

    Parameters
    ----------
    radius, angles, span, rise, thickness, voussoirs, weights, skewbacks, abutments, unit_weight: See
        :class:`~masonry_opt.scene.arch.ArchRing`.
    point_loads: Live forces on single voussoirs (:class:`PointLoad`).
    name, at, live_per_weight, live: See :class:`~masonry_opt.scene.generator.Generator`. The origin is the
        centre of ``radius``, or the middle of ``span`` at the height of the feet's inner ends.

    Raises
    ------
    CaseError
        If the dimensions do not describe an arch, or if a point load names a voussoir that does not exist.
    """

    point_loads: list[PointLoad] = []

    def _mistakes(self) -> Iterator[str]:
        yield from super()._mistakes()
        for number, loads in Counter(load.voussoir for load in self.point_loads).items():
            if number > self.voussoirs:
                yield (
                    f"'point_loads' names voussoir {number}, "
                    f"but the voussoirs are numbered from 1 to {self.voussoirs}"
                )
            if loads > 1:
                yield f"'point_loads' has several loads on voussoir {number}: replace the loads by their sum"

    def blocks(self, thickness: float | None = None) -> list[Block]:
        """Return the voussoirs ``v1``, ``v2``, ..., then the numbered skewbacks, then the numbered abutments.

        The ``unit_weight`` of a block refers to its polygon. If ``weights`` uses the area between two arcs,
        the unit weight of a voussoir is scaled so that the polygon has the weight of that area.

        Parameters
        ----------
        thickness: As in :meth:`Generator.blocks <masonry_opt.scene.generator.Generator.blocks>`.

        Returns
        -------
        list of Block
            The blocks, in the coordinates of the scene.
        """
        forces = {f"v{load.voussoir}": load.force for load in self.point_loads if any(load.force)}
        blocks = []
        for name, corners, area, weight_at, back, area_ratio in self._stones():
            if area is None:
                blocks.append(self._block(name, {"vertices": corners}, fixed=True))
                continue
            live = {"live": forces[name], "live_at": back} if name in forces else {}
            if thickness is None:
                weight = {"unit_weight": self.unit_weight * area_ratio}
            else:
                weight = {"weight": self.unit_weight * area * thickness}
            blocks.append(self._stone(name, corners, weight_at=weight_at, **weight, **live))
        return blocks

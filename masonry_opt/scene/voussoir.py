"""Shapes of single voussoirs: their corners, area, and the points where weight and load act."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Literal

from masonry_opt.scene.blocks import Point

#: What of a voussoir weighs: the sector between two arcs, its centreline, or the polygon drawn.
Weights = Literal["sector", "centreline", "straight"]


@dataclass(frozen=True)
class Voussoir:
    """Corners of a voussoir (inner and outer at its first joint, outer and inner at its second), the area
    that weighs, where the weight acts, and the middle of its outer edge."""

    corners: tuple[Point, ...]
    area: float
    weight_at: Point
    back: Point

    def moved(self, x: float, y: float) -> Voussoir:
        return self._mapped(lambda p: (p[0] + x, p[1] + y))

    def mirrored(self) -> Voussoir:
        """The same on the other side of x = 0, its joints still in the order of the arch."""
        other = self._mapped(lambda p: (-p[0], p[1]))
        return replace(other, corners=other.corners[::-1])

    def _mapped(self, point: Callable[[Point], Point]) -> Voussoir:
        corners = tuple(map(point, self.corners))
        return Voussoir(corners, self.area, point(self.weight_at), point(self.back))


def wedge(
    radius: float, thickness: float, joints: tuple[float, float], angle: float, weights: Weights
) -> Voussoir:
    """A voussoir between two radial joints of a ring round the origin.

    Parameters
    ----------
    radius, thickness: of the centreline, and radial.
    joints: their directions, in radians.
    angle: between them, positive.
    weights: what weighs.
    """
    inner, outer = radius - thickness / 2, radius + thickness / 2
    (begin, end), middle = joints, sum(joints) / 2
    # Mean distance of an annulus's area from its centre, times what the angle leaves of it:
    # 2/3 (outer³ - inner³) / (outer² - inner²), divided out, as thin rings lose digits in it.
    mean = radius + thickness**2 / (12 * radius)
    arc = 2 * math.sin(angle / 2) / angle
    area, centroid = {
        "sector": (angle * radius * thickness, mean * arc),
        "centreline": (angle * radius * thickness, radius * arc),
        "straight": (math.sin(angle) * radius * thickness, mean * math.cos(angle / 2)),
    }[weights]
    return Voussoir(
        (_polar(inner, begin), _polar(outer, begin), _polar(outer, end), _polar(inner, end)),
        area,
        _polar(centroid, middle),
        _polar(outer * math.cos(angle / 2), middle),
    )


def half_key(inner: float, thickness: float, begin: float, plumb: float, weights: Weights) -> Voussoir:
    """The last voussoir of the left arc of a pointed arch, whose second joint is upright.

    Parameters
    ----------
    inner, thickness: radius of the arc's inner edge, and radial; its centre is the origin.
    begin: direction of the radial joint, in radians, more than that of the crown.
    plumb: x of the upright joint, less than 0.
    weights: what weighs.
    """
    radius, outer = inner + thickness / 2, inner + thickness
    crown = {distance: math.acos(plumb / distance) for distance in (inner, radius, outer)}
    ends = ((inner, begin), (outer, begin), (outer, crown[outer]), (inner, crown[inner]))
    corners = tuple(_polar(*end) for end in ends)
    back = ((corners[1][0] + corners[2][0]) / 2, (corners[1][1] + corners[2][1]) / 2)
    if weights == "centreline":
        angle = begin - crown[radius]
        distance = radius * 2 * math.sin(angle / 2) / angle
        return Voussoir(corners, angle * radius * thickness, _polar(distance, begin - angle / 2), back)
    area, moment_x, moment_y = _polygon(corners)
    if weights == "sector":
        # The arcs bulge: beyond the outer edge there is more, beyond the inner one less.
        for distance, sign in ((outer, 1.0), (inner, -1.0)):
            angle = begin - crown[distance]
            # Area of a circular segment, and 2/3 r³ sin³, its moment about the centre.
            moment = sign * 2 / 3 * (distance * math.sin(angle / 2)) ** 3
            area += sign * distance**2 * (angle - math.sin(angle)) / 2
            moment_x += moment * math.cos(begin - angle / 2)
            moment_y += moment * math.sin(begin - angle / 2)
    # Without any area it is refused, with what wants one.
    return Voussoir(corners, area, (moment_x / area, moment_y / area) if area else back, back)


def _polygon(corners: tuple[Point, ...]) -> tuple[float, float, float]:
    """Area of a polygon, and its first moments ∫ x and ∫ y; corners clockwise."""
    area = moment_x = moment_y = 0.0
    for (x0, y0), (x1, y1) in pairwise((*corners, corners[0])):
        cross = x1 * y0 - x0 * y1
        area += cross / 2
        moment_x += cross * (x0 + x1) / 6
        moment_y += cross * (y0 + y1) / 6
    return area, moment_x, moment_y


def _polar(radius: float, angle: float) -> Point:
    return radius * math.cos(angle), radius * math.sin(angle)

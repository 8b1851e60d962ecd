"""Earth between blocks and the line of a road."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Annotated, Any, Literal

from pydantic import Field, PlainValidator

from masonry_opt.scene.blocks import Number, Positive, Record, RoadLine, YesNo


def _spread(value: Any) -> float | bool:
    angle = isinstance(value, int | float) and value is not True and 0 < value < 90
    if angle or value is False:
        return float(value) if angle else value
    raise ValueError("must be an angle between 0 and 90 degrees, or false")


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
    friction_angle: φ of the fill in degrees, for its pressure: Rankine's K_a = tan²(45° - φ/2) and K_p = 1 /
        K_a.
    mobilised: The share m of the passive pressure that the fill may reach: pressure, horizontal, lies between
        K_a σ and m K_p σ, where σ is the unit weight times the depth below the road.
    weight: Whether the fill's weight acts on the blocks.
    spread: Angle to the vertical, in degrees, within which a load on the road spreads on its way down; or
        False: loads go straight down.
    pressure: Whether it presses on faces. If not, ``friction_angle`` and ``mobilised`` are not needed.
    """

    road: RoadLine
    unit_weight: Positive
    friction_angle: Annotated[Number, Field(gt=0, lt=90)] | None = None
    mobilised: Annotated[Number, Field(gt=0, le=1)] | None = None
    weight: YesNo = True
    spread: Annotated[float | Literal[False], PlainValidator(_spread)] = 30.0
    pressure: YesNo = True

    def _mistakes(self) -> Iterator[str]:
        if self.pressure:
            for key in ("friction_angle", "mobilised"):
                if getattr(self, key) is None:
                    yield f"give '{key}', or 'pressure = false' for a fill that does not press"
            active, _, passive = self.coefficients
            if active > passive:
                yield (
                    f"'mobilised' times K_p, {passive:.4g}, is below K_a, {active:.4g}: give a larger share"
                )

    @property
    def coefficients(self) -> tuple[float, float, float]:
        """K_a, K_0 = 1 - sin φ (Jaky), and m K_p, of a fill that presses."""
        assert self.friction_angle is not None
        assert self.mobilised is not None
        active = math.tan(math.radians(45 - self.friction_angle / 2)) ** 2
        return active, 1 - math.sin(math.radians(self.friction_angle)), self.mobilised / active

    @property
    def spread_tangent(self) -> float:
        """Tangent of the angle of spread; 0 where loads go straight down."""
        return math.tan(math.radians(self.spread))

"""Limits of acceptance: the residuals that an answer may have, and the other gates of the core."""

from collections.abc import Mapping
from dataclasses import dataclass, fields
from enum import StrEnum
from math import inf


class Kind(StrEnum):
    """Kinds of answer, by what can be demanded of them."""

    #: An optimum of eq. (9) or eq. (10).
    ASSOCIATIVE = "associative"
    #: The loop's: exact forces on its mechanism, or where there are none its last sub-problem. Shear limits
    #: of the latter come from the normal forces before (yield: a tenth of a block's weight on the walls of
    #: Table 1), and sliding contracts by 10⁻³ μ of its slip (flow).
    LOOP = "loop"
    #: The paper's loop, stopped by its own rule. Joints that do not slide may exceed yield by half of a
    #: block's forces: this is limited joint by joint.
    BARE_LOOP = "bare loop"
    #: An exact state but for its complementarity: faces that are not at yield move at small rates. The energy
    #: of these rates is some 1e-9 of λ on small scenes, and up to 1e-5 on façades.
    NEARLY_COMPLEMENTARY = "nearly complementary"
    #: The MPEC's: exact but for the complementarity of its last relaxation (by default some 1e-8).
    RELAXED = "relaxed"
    #: The incremental load factor: an exact state, or the last equilibrium of the load history with the
    #: motion of the collapse. Of the latter the equilibrium alone must meet limits; the motion is shown.
    INCREMENTAL = "incremental"
    #: A state of forces and a mechanism that meet every condition to rounding.
    EXACT = "exact"


@dataclass(frozen=True)
class Limits:
    """What an answer's residuals may be at most: those of its certificate, and block by block."""

    equilibrium: float
    yield_: float
    flow: float
    complementarity: float  #: the certificate's over |λ| (over ``SMALLEST`` at least)
    work: float  #: of forces out of balance, over the same
    block: float  #: force out of balance on any one block, over the largest that acts on it
    joint: float  #: violation of the true law at any one, over the largest force on the lesser of its blocks

    def as_dict(self) -> dict[str, float]:
        """The limits by the names that residuals have in reports."""
        return {field.name.rstrip("_"): getattr(self, field.name) for field in fields(self)}

    def failing(self, residuals: Mapping[str, float | None]) -> dict[str, float | None]:
        """Residuals that exceed their limits, and those that are missing or no numbers."""
        most = self.as_dict()
        return {name: value for name, value in residuals.items() if value is None or not value <= most[name]}


#: The table. Published associative load factors agree in four digits.
LIMITS: dict[Kind, Limits] = {
    Kind.ASSOCIATIVE: Limits(1e-4, 1e-4, 1e-4, 1e-4, work=1e-3, block=1e-3, joint=1e-3),
    Kind.LOOP: Limits(1e-3, 0.1, 1e-2, 1e-2, work=5e-2, block=5e-2, joint=0.5),
    Kind.BARE_LOOP: Limits(1e-2, inf, 5e-2, 5e-2, work=5e-2, block=5e-2, joint=1.0),
    Kind.NEARLY_COMPLEMENTARY: Limits(1e-8, 1e-8, 1e-8, 1e-4, work=1e-3, block=1e-3, joint=1e-3),
    Kind.RELAXED: Limits(1e-6, 1e-6, 1e-6, 1e-4, work=1e-3, block=1e-3, joint=1e-3),
    Kind.INCREMENTAL: Limits(1e-6, 1e-6, inf, inf, work=inf, block=1e-3, joint=1e-3),
    Kind.EXACT: Limits(1e-8, 1e-8, 1e-8, 1e-8, work=1e-3, block=1e-3, joint=1e-3),
}

#: Of the answers that ``check`` compares: the relative difference of load factors, and any residual.
AGREEMENT, DUALITY = 1e-7, 1e-6

#: Gates on the way to an answer, which must meet the table all the same. The energy of what moves without
#: being at yield, over |λ|, up to which the loop's forces and mechanism belong together (above it the loop
#: begins again); and the largest residual with which the state of a sub-problem bears its load factor out.
MOST_ENERGY, BORNE_OUT = 1e-3, 1e-3

#: Residual of an inequality that proves that no load factor exists. It then holds for all forces and motions
#: up to a hundred million times those that the loads and their work measure.
PROOF = 1e-8

#: Relative gap at which a bracket is closed; and how far λ may lie outside of certified bounds: four digits.
CLOSED, OUTSIDE = 1e-5, 1e-4

#: By how much a state's forces may exceed the limits below which a bound holds, relative and in median block
#: weights; and the residual of a point that certifies a bound, in units of the load.
BEYOND_LIMITS, FEASIBLE = 1e-6, 1e-11

#: Departure of a mechanism from associative flow over its power in median block weights, up to which a scene
#: falls whatever forces act in it that sum to less than a million such weights; and what is rounding.
DEPARTS, ROUNDING = 1e-6, 1e-11

MARGIN_ENERGY = 1e-4  #: Energy, in median block weights, by which a margin under dead load may be off.

#: Load factors below this are judged, and compared with each other, as if they were this large.
SMALLEST = 1e-2


def over_load_factor(energy: float, load_factor: float) -> float:
    """An energy in units of λ, such as the certificate's complementarity, as a share of |λ|."""
    return energy / max(abs(load_factor), SMALLEST)

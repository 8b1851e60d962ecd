"""When an answer is good enough: one table of limits on residuals, asked once of each answer."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, fields
from enum import StrEnum
from math import inf


class Kind(StrEnum):
    """Kinds of answer, by what can be demanded of them."""

    #: An optimum of eq. (9) or eq. (10).
    ASSOCIATIVE = "associative"
    #: The loop's: exact forces on a mechanism leave next to nothing (with rough sub-problems up to 1e-3 of
    #: complementarity). Where there are none it keeps its last sub-problem, which turns shear limits about
    #: the normal forces before: a tenth of a block's weight is what the published parameters leave on the
    #: walls of Table 1, and the small cohesion's share, taken off λ and not off the forces, some 1e-4 of
    #: equilibrium and complementarity. Sliding contracts by 10⁻³ μ of its slip by construction, and a slip
    #: may be ten times the largest block velocity: a long block that turns slips at a far joint.
    LOOP = "loop"
    #: The paper's loop, stopped by its own rule and without an exact end: it leaves up to some per cent, and
    #: at a joint that does not slide half of its block's forces, so that yield is limited joint by joint.
    BARE_LOOP = "bare loop"
    #: The one pass's: exact, but for what it leaves of complementarity: some 1e-9 on small scenes, up to 1e-5
    #: on façades, where no mechanism moves only faces that the forces found bring to yield.
    ONE_PASS = "one pass"
    #: The MPEC's: exact, but for what its last relaxation leaves of complementarity (by default some 1e-8).
    RELAXED = "relaxed"
    #: A state of forces and a mechanism that meet every condition to rounding.
    EXACT = "exact"


@dataclass(frozen=True)
class Limits:
    """What an answer's residuals may be at most.

    Attributes
    ----------
    equilibrium, yield_, flow: as the certificate has them.
    complementarity, work: energy of what moves without being at yield, and work of forces out of balance,
        over |λ| (over ``SMALLEST`` at least).
    block: force out of balance on any one block, over the largest that acts on it.
    joint: violation of the true law at any one joint, over the largest force on the lesser of its blocks.
    """

    equilibrium: float
    yield_: float
    flow: float
    complementarity: float
    work: float
    block: float
    joint: float

    def as_dict(self) -> dict[str, float]:
        """The limits by the names that residuals have in reports."""
        return {field.name.rstrip("_"): getattr(self, field.name) for field in fields(self)}

    def failing(self, residuals: Mapping[str, float | None]) -> dict[str, float | None]:
        """Those of the residuals that exceed their limits; one that is missing or no number does too."""
        most = self.as_dict()
        return {name: value for name, value in residuals.items() if value is None or not value <= most[name]}


#: The table. Four digits of λ are those in which published associative load factors agree.
LIMITS: dict[Kind, Limits] = {
    Kind.ASSOCIATIVE: Limits(1e-4, 1e-4, 1e-4, 1e-4, work=1e-3, block=1e-3, joint=1e-3),
    Kind.LOOP: Limits(1e-3, 0.1, 1e-2, 1e-2, work=5e-2, block=5e-2, joint=0.5),
    Kind.BARE_LOOP: Limits(1e-2, inf, 5e-2, 5e-2, work=5e-2, block=5e-2, joint=1.0),
    Kind.ONE_PASS: Limits(1e-8, 1e-8, 1e-8, 1e-4, work=1e-3, block=1e-3, joint=1e-3),
    Kind.RELAXED: Limits(1e-6, 1e-6, 1e-6, 1e-4, work=1e-3, block=1e-3, joint=1e-3),
    Kind.EXACT: Limits(1e-8, 1e-8, 1e-8, 1e-8, work=1e-3, block=1e-3, joint=1e-3),
}

#: Of the four answers to an associative problem that ``check`` compares: relative difference of their load
#: factors, and what any of their conditions may leave.
AGREEMENT, DUALITY = 1e-7, 1e-6

#: What decides on the way to an answer, which must meet the table all the same. Energy of what moves without
#: being at yield, over |λ|, up to which the loop's forces and mechanism belong together (else it begins
#: again); and the largest residual with which a sub-problem's state bears its load factor out.
MOST_ENERGY, BORNE_OUT = 1e-3, 1e-3

#: What an inequality that proves that no load factor exists may leave of its conditions: it then holds for
#: all forces, and motions, that are not a hundred million times larger than what the loads and their work
#: measure.
PROOF = 1e-8

#: Relative gap at which a bracket is closed; and how far λ may lie outside of certified bounds: the four
#: digits of the associative limits.
CLOSED, OUTSIDE = 1e-5, 1e-4

#: By how much a state's forces may exceed the limits below which a bound holds, relative and in median block
#: weights; and what a point that certifies a bound may leave of its equations, in units of the load.
BEYOND_LIMITS, FEASIBLE = 1e-6, 1e-11

#: That a scene stands, in median block weights. Forces of another scene show it with this room inside yield,
#: and this much out of balance: far less than the room, so that forces that leave nothing are near.
ROOM, UNBALANCED = 1e-5, 1e-8

#: Energy, in median block weights, that forces and mechanism of a margin under dead load may be apart: what
#: the margin may be off by.
MARGIN_ENERGY = 1e-4

#: Load factors below this are judged, and compared with each other, as if they were this large.
SMALLEST = 1e-2


def over_load_factor(energy: float, load_factor: float) -> float:
    """An energy in units of λ, such as the certificate's complementarity, as a share of |λ|."""
    return energy / max(abs(load_factor), SMALLEST)

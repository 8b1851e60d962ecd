"""Limits of acceptance: the residuals that an answer may have, and the other tolerances of the core."""

from collections.abc import Mapping
from dataclasses import dataclass, fields
from enum import StrEnum
from math import inf


class Kind(StrEnum):
    """Kinds of answer. The kind decides which limits the residuals of an answer must meet."""

    #: An optimum of eq. (9) or eq. (10).
    ASSOCIATIVE = "associative"
    #: Answer of the loop of linear programs: exact forces on its mechanism, or else its last sub-problem.
    #: A sub-problem takes its limits of shear from the normal forces of the sub-problem before. Its yield
    #: residual is therefore up to a tenth of a block's weight on the walls of Table 1. Joints that slide
    #: contract by 10⁻³ μ of their slip, which enters the flow residual.
    LOOP = "loop"
    #: Answer of the paper's loop, stopped by the paper's own rule. Joints that do not slide may exceed yield
    #: by half of the forces on a block. This violation is limited joint by joint.
    BARE_LOOP = "bare loop"
    #: An exact state except for its complementarity: faces that are not at yield move at small rates. The
    #: energy of these rates is about 1e-9 of λ on small scenes, and up to 1e-5 on façades.
    NEARLY_COMPLEMENTARY = "nearly complementary"
    #: Answer of the MPEC: exact except for the complementarity of its last relaxation (about 1e-8 by
    #: default).
    RELAXED = "relaxed"
    #: Answer of the incremental analysis: an exact state, or the last equilibrium of the load history with
    #: the motion of the collapse. Only the equilibrium must meet limits; the motion is shown.
    INCREMENTAL = "incremental"
    #: A state of forces and a mechanism that meet every condition up to rounding.
    EXACT = "exact"


@dataclass(frozen=True)
class Limits:
    """Largest residuals that an answer may have: those of its certificate, and those block by block."""

    equilibrium: float  #: limit of the certificate's ``equilibrium``
    yield_: float  #: limit of the certificate's ``yield_``
    flow: float  #: limit of the certificate's ``flow``
    #: Limit of the certificate's ``complementarity``, relative to |λ| or ``SMALLEST``, whichever is larger.
    complementarity: float
    #: Limit of the work of forces out of balance in units of λ, relative to |λ| or ``SMALLEST``.
    work: float
    block: float  #: force out of balance on any one block, relative to the largest force that acts on it
    #: Violation of the true yield conditions in any one joint. Of the two blocks of the joint, the one that
    #: carries less gives the unit: the largest force that acts on it.
    joint: float

    def as_dict(self) -> dict[str, float]:
        """Return the limits by the names that residuals have in reports."""
        return {field.name.rstrip("_"): getattr(self, field.name) for field in fields(self)}

    def failing(self, residuals: Mapping[str, float | None]) -> dict[str, float | None]:
        """Return the residuals that exceed their limits, that are missing, or that are NaN."""
        limits = self.as_dict()
        return {
            name: value for name, value in residuals.items() if value is None or not value <= limits[name]
        }


#: Limits by kind of answer. Published associative load factors agree in four digits.
LIMITS: dict[Kind, Limits] = {
    Kind.ASSOCIATIVE: Limits(1e-4, 1e-4, 1e-4, 1e-4, work=1e-3, block=1e-3, joint=1e-3),
    Kind.LOOP: Limits(1e-3, 0.1, 1e-2, 1e-2, work=5e-2, block=5e-2, joint=0.5),
    Kind.BARE_LOOP: Limits(1e-2, inf, 5e-2, 5e-2, work=5e-2, block=5e-2, joint=1.0),
    Kind.NEARLY_COMPLEMENTARY: Limits(1e-8, 1e-8, 1e-8, 1e-4, work=1e-3, block=1e-3, joint=1e-3),
    Kind.RELAXED: Limits(1e-6, 1e-6, 1e-6, 1e-4, work=1e-3, block=1e-3, joint=1e-3),
    Kind.INCREMENTAL: Limits(1e-6, 1e-6, inf, inf, work=inf, block=1e-3, joint=1e-3),
    Kind.EXACT: Limits(1e-8, 1e-8, 1e-8, 1e-8, work=1e-3, block=1e-3, joint=1e-3),
}

#: Largest relative difference of load factors with which the answers that ``check`` compares agree.
AGREEMENT = 1e-7

#: Largest residual that an answer of ``check`` may have.
DUALITY = 1e-6

#: Largest energy, over |λ|, of faces that move without being at yield, with which the loop's forces and its
#: mechanism belong together. Above it the loop begins again. The answer must meet ``LIMITS`` as well.
MOST_ENERGY = 1e-3

#: Largest residual with which the state of a sub-problem of the loop verifies its load factor. The answer
#: must meet ``LIMITS`` as well.
BORNE_OUT = 1e-3

#: Largest residual of an inequality that proves that no load factor exists. The proof then covers all forces
#: and motions up to a hundred million times the units of the residual: the loads and their work.
PROOF = 1e-8

#: Relative difference of λ and a lower bound at which the bracket is closed.
CLOSED = 1e-5

#: Relative distance by which λ may be outside of certified bounds: four digits agree.
OUTSIDE = 1e-4

#: Largest excess of a state's forces over the limits below which a bound is valid, relative and in median
#: block weights.
BEYOND_LIMITS = 1e-6

#: Largest residual of a point that certifies a bound, in units of the load.
FEASIBLE = 1e-11

#: Largest departure of a mechanism from associative flow, over its power in median block weights, with which
#: the mechanism shows that a scene falls. No forces whose sum is below a million such weights then prevent
#: the fall.
DEPARTS = 1e-6

#: Departure of a mechanism from associative flow that is rounding; also a slip or shear that is rounding.
ROUNDING = 1e-11

#: Largest energy, in median block weights, by which a margin under dead load may be wrong.
MARGIN_ENERGY = 1e-4

#: Smallest size of a load factor in relative differences and residuals. A smaller load factor counts as if it
#: had this size.
SMALLEST = 1e-2


def over_load_factor(energy: float, load_factor: float) -> float:
    """Return an energy in units of λ, such as the certificate's complementarity, as a share of |λ|."""
    return energy / max(abs(load_factor), SMALLEST)

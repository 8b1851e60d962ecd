"""Limits of acceptance: the residuals that an answer may have, and the other tolerances of the core."""

from collections.abc import Mapping
from dataclasses import dataclass, fields
from enum import StrEnum
from math import inf


class Kind(StrEnum):
    """Kinds of answers. The kind determines the limits that the residuals of an answer must not exceed."""

    #: An optimum of eq. (9) or eq. (10).
    ASSOCIATIVE = "associative"
    #: Answer of the sequence of linear programs (the loop). The answer is exact if forces with exact Coulomb
    #: friction fit the mechanism of the loop; otherwise the answer is the solution of the last sub-problem.
    #: Friction limits of a sub-problem are computed from the normal forces of the previous sub-problem. The
    #: yield residual therefore reaches a tenth of a block's weight on the walls of Table 1. Sliding joints
    #: contract by 10⁻³ μ times their slip, which adds to the flow residual.
    LOOP = "loop"
    #: Answer of the paper's loop with the paper's own stopping rule. In joints that do not slide, forces may
    #: violate the yield conditions by half of the largest force on a block. The violation has a limit for
    #: each joint.
    BARE_LOOP = "bare loop"
    #: A state that is exact except for its complementarity: inactive yield conditions have small rates. The
    #: energy of these rates is about 1e-9 of λ on small scenes, and up to 1e-5 on façades.
    NEARLY_COMPLEMENTARY = "nearly complementary"
    #: Answer of the MPEC (mathematical program with equilibrium constraints). The answer is exact except for
    #: the complementarity that the last relaxation permits (about 1e-8 by default).
    RELAXED = "relaxed"
    #: Answer of the incremental analysis: an exact state, or the last equilibrium of the load history with
    #: the motion of the collapse. Only residuals of forces have limits; residuals of the motion have none.
    INCREMENTAL = "incremental"
    #: A state whose forces and mechanism satisfy every condition up to rounding errors.
    EXACT = "exact"


@dataclass(frozen=True)
class Limits:
    """Largest residuals that an answer may have, for the whole scene and for each block and joint."""

    equilibrium: float  #: limit of the certificate's residual ``equilibrium``
    yield_: float  #: limit of the certificate's residual ``yield_``
    flow: float  #: limit of the certificate's residual ``flow``
    #: Limit of the certificate's residual ``complementarity``, divided by |λ| or by ``SMALLEST``, whichever
    #: is larger.
    complementarity: float
    #: Limit of the work of unbalanced forces in units of λ, divided by |λ| or by ``SMALLEST``, whichever is
    #: larger.
    work: float
    block: float  #: limit of a block's unbalanced force, relative to the largest force on the block
    #: Limit of the violation of the true yield conditions in a joint. The violation is divided by the largest
    #: force that acts on a block of the joint; of its two blocks, the less loaded one counts.
    joint: float

    def as_dict(self) -> dict[str, float]:
        """Return the limits in a dictionary, under the names of the residuals in reports."""
        return {field.name.rstrip("_"): getattr(self, field.name) for field in fields(self)}

    def failing(self, residuals: Mapping[str, float | None]) -> dict[str, float | None]:
        """Return the residuals that exceed their limits, that are missing, or that are NaN."""
        limits = self.as_dict()
        return {
            name: value for name, value in residuals.items() if value is None or not value <= limits[name]
        }


#: Limits of the residuals for each kind of answer. The limit 1e-4 of associative answers corresponds to the
#: four digits to which published load factors agree.
LIMITS: dict[Kind, Limits] = {
    Kind.ASSOCIATIVE: Limits(1e-4, 1e-4, 1e-4, 1e-4, work=1e-3, block=1e-3, joint=1e-3),
    Kind.LOOP: Limits(1e-3, 0.1, 1e-2, 1e-2, work=5e-2, block=5e-2, joint=0.5),
    Kind.BARE_LOOP: Limits(1e-2, inf, 5e-2, 5e-2, work=5e-2, block=5e-2, joint=1.0),
    Kind.NEARLY_COMPLEMENTARY: Limits(1e-8, 1e-8, 1e-8, 1e-4, work=1e-3, block=1e-3, joint=1e-3),
    Kind.RELAXED: Limits(1e-6, 1e-6, 1e-6, 1e-4, work=1e-3, block=1e-3, joint=1e-3),
    Kind.INCREMENTAL: Limits(1e-6, 1e-6, inf, inf, work=inf, block=1e-3, joint=1e-3),
    Kind.EXACT: Limits(1e-8, 1e-8, 1e-8, 1e-8, work=1e-3, block=1e-3, joint=1e-3),
}

#: Largest relative difference at which ``check`` counts two load factors as equal.
AGREEMENT = 1e-7

#: Largest residual of an answer that ``check`` accepts.
DUALITY = 1e-6

#: Largest violation of complementarity (z·p, divided by |λ|) at which the forces and the mechanism of method
#: "loop" count as one state. If the violation is larger, the method starts again. The answer must also meet
#: ``LIMITS``.
MOST_ENERGY = 1e-3

#: Largest residual at which the state of a sub-problem of the loop verifies the load factor of the
#: sub-problem. The answer must also meet ``LIMITS``.
BORNE_OUT = 1e-3

#: Largest residual of an inequality in a proof that no load factor exists. The proof then covers all forces
#: and motions up to 1e8 times the units of the residual, which are the loads and their work.
PROOF = 1e-8

#: Relative difference of λ and its lower bound below which the bracket counts as closed.
CLOSED = 1e-5

#: Largest relative distance of λ from the interval of its certified bounds. The value corresponds to four
#: equal digits.
OUTSIDE = 1e-4

#: Largest excess of forces over the limits that a bound assumes, relative to the limit and in median block
#: weights. A bound counts as valid for a state with a smaller excess.
BEYOND_LIMITS = 1e-6

#: Largest residual, in units of the load, of a point that counts as feasible and so certifies a bound.
FEASIBLE = 1e-11

#: Largest departure of a mechanism from associative flow, divided by the mechanism's power in median block
#: weights, at which the mechanism proves that a scene is unstable. Forces whose sum is below a million median
#: block weights then cannot prevent the fall.
DEPARTS = 1e-6

#: Size below which a departure from associative flow, a slip or a shear counts as rounding.
ROUNDING = 1e-11

#: Largest accepted error of the margin of stability under dead load: the work of median block weights over a
#: unit of length.
MARGIN_ENERGY = 1e-4

#: Smallest |λ| by which differences and residuals are divided. A smaller |λ| is replaced by this value.
SMALLEST = 1e-2


def over_load_factor(energy: float, load_factor: float) -> float:
    """Return an energy in units of λ divided by |λ|, or by ``SMALLEST`` if |λ| is smaller."""
    return energy / max(abs(load_factor), SMALLEST)

"""Limits of acceptance: the residuals that an answer may have, and the other tolerances of the core."""

from collections.abc import Mapping
from dataclasses import dataclass, fields
from enum import StrEnum
from math import inf


class Kind(StrEnum):
    """Kind of an answer, such as associative or exact. Each kind has its own largest accepted residuals."""

    #: Optimum of the associative problem: the static program, eq. (9), or the kinematic program, eq. (10).
    ASSOCIATIVE = "associative"
    #: Answer of the paper's sequence of linear programs (the loop). After the last sub-problem, the loop
    #: seeks forces that obey Coulomb friction and are compatible with a mechanism. If it finds none, the
    #: answer is the solution of the last sub-problem. ``LIMITS`` explains the errors of this solution.
    LOOP = "loop"
    #: Answer of the loop without the final search for Coulomb forces, as in the paper (option ``finish`` set
    #: to False). In joints that do not slide, forces may violate the yield conditions by up to the reference
    #: force that is defined at ``Limits.joint``.
    BARE_LOOP = "bare loop"
    #: State that is exact except for its complementarity: inactive yield conditions have small rates instead
    #: of zero rates. The energy Σ|z p| of these rates, relative to the work of the live load at collapse, is
    #: about 1e-9 on small scenes and up to 1e-5 on façades.
    NEARLY_COMPLEMENTARY = "nearly complementary"
    #: Answer of the MPEC (mathematical program with equilibrium constraints), exact except for the
    #: complementarity error that the last relaxation permits (about 1e-8 by default).
    RELAXED = "relaxed"
    #: Answer of the incremental analysis: either an exact state, or the last equilibrium of the load history
    #: together with the motion at collapse. Residuals that depend on the motion have no limits.
    INCREMENTAL = "incremental"
    #: State whose forces and mechanism satisfy every condition of the Coulomb law up to rounding errors.
    EXACT = "exact"


@dataclass(frozen=True)
class Limits:
    """Largest residuals that an answer may have, for the whole scene and for each block and joint."""

    equilibrium: float  #: largest accepted residual of equilibrium, ``Certificate.equilibrium``
    yield_: float  #: largest accepted violation of a yield condition, ``Certificate.yield_``
    flow: float  #: largest accepted departure from the flow rule, ``Certificate.flow``
    #: Largest accepted residual of complementarity, ``Certificate.complementarity``, divided by the larger of
    #: |λ| and ``SMALLEST`` (:mod:`~masonry_opt.problem.load_factor_scale`).
    complementarity: float
    #: Largest accepted work of the unbalanced forces, divided by the work of the live load and by the larger
    #: of |λ| and ``SMALLEST`` (:mod:`~masonry_opt.problem.load_factor_scale`).
    work: float
    block: float  #: largest accepted unbalanced force on a block, relative to the block's largest force
    #: Largest accepted violation of a joint's yield conditions under the exact friction law, relative to a
    #: reference force. For each of the joint's two blocks, take the largest force on the block. The reference
    #: force is the smaller of these two forces.
    joint: float

    def as_dict(self) -> dict[str, float]:
        """Return the largest accepted residuals as a dictionary, keyed by the names that reports use."""
        return {field.name.rstrip("_"): getattr(self, field.name) for field in fields(self)}

    def failing(self, residuals: Mapping[str, float | None]) -> dict[str, float | None]:
        """Return the residuals that exceed their limits, are missing or are NaN."""
        limits = self.as_dict()
        return {
            name: value for name, value in residuals.items() if value is None or not value <= limits[name]
        }


#: Limits of the residuals for each kind of answer.
LIMITS: dict[Kind, Limits] = {
    # The computed load factors agree with published ones to four digits, so associative answers have limits
    # of 1e-4.
    Kind.ASSOCIATIVE: Limits(1e-4, 1e-4, 1e-4, 1e-4, work=1e-3, block=1e-3, joint=1e-3),
    # The shear limits of a sub-problem are computed from the normal forces of the previous sub-problem. The
    # forces of a sub-problem may therefore violate the true friction law, by up to a tenth of the median
    # block weight on the walls of the paper's Table 1. In the last sub-problems, sliding joints contract by
    # 10⁻³ μ per unit slip, which violates the joints' own flow rule.
    Kind.LOOP: Limits(1e-3, 0.1, 1e-2, 1e-2, work=5e-2, block=5e-2, joint=0.5),
    Kind.BARE_LOOP: Limits(1e-2, inf, 5e-2, 5e-2, work=5e-2, block=5e-2, joint=1.0),
    Kind.NEARLY_COMPLEMENTARY: Limits(1e-8, 1e-8, 1e-8, 1e-4, work=1e-3, block=1e-3, joint=1e-3),
    Kind.RELAXED: Limits(1e-6, 1e-6, 1e-6, 1e-4, work=1e-3, block=1e-3, joint=1e-3),
    Kind.INCREMENTAL: Limits(1e-6, 1e-6, inf, inf, work=inf, block=1e-3, joint=1e-3),
    Kind.EXACT: Limits(1e-8, 1e-8, 1e-8, 1e-8, work=1e-3, block=1e-3, joint=1e-3),
}

#: Largest relative difference at which the command ``check`` counts two load factors as equal. With a larger
#: difference the check fails.
AGREEMENT = 1e-7

#: Largest residual at which the command ``check`` accepts a static or kinematic solution. The residuals are
#: defined at ``DualityReport.table``.
DUALITY = 1e-6

#: Largest violation of complementarity, Σ|z p| / |λ| (slacks times rates), at which the loop accepts forces
#: and mechanism as a collapse state. With a larger violation, the loop is repeated with other options. The
#: answer must also satisfy ``LIMITS``.
MOST_ENERGY = 1e-3

#: Largest residual of a sub-problem's state at which the loop accepts the sub-problem's load factor as
#: verified. The answer must also satisfy ``LIMITS``.
BORNE_OUT = 1e-3

#: Largest residual of a valid proof that no load factor exists, or that every multiple of the live load can
#: be carried. Residuals of forces are divided by the sum of the live loads Σ|f_L|. Residuals of a motion are
#: divided by the energy f_D·d − c·p that the motion releases. A proof that no load factor exists therefore
#: excludes only collapse states with limited forces and velocities. The limits are about 1e8 times the loads,
#: and about 1e8 times the mean velocity of the live load, f_L·d / Σ|f_L|.
PROOF = 1e-8

#: Largest relative difference between λ and its lower bound at which λ counts as proven to be the least load
#: factor.
PROVEN_GAP = 1e-5

#: Largest accepted distance of λ from the interval between its certified bounds, relative to the middle of
#: this interval. Up to this distance, λ agrees with the bounds in four digits.
LARGEST_BOUND_EXCESS = 1e-4

#: A lower bound that assumes force limits counts as valid if no force exceeds its limit by more than this
#: fraction of the limit plus this fraction of the median block weight.
BEYOND_LIMITS = 1e-6

#: Largest residual of the equations at which a point counts as feasible. The residual of equilibrium is in
#: units of the load, the residual of kinematics in units of the mean velocity of the live load. The objective
#: value of a feasible point is a certified bound on λ.
FEASIBILITY_TOLERANCE = 1e-11

#: A mechanism proves that a scene is unstable only if it almost satisfies the associative flow rule. The
#: violation, times the median block weight, must be at most this fraction of the mechanism's power. Only
#: joint forces with a sum above a million median block weights could then stop the mechanism.
LARGEST_FLOW_VIOLATION = 1e-6

#: Magnitude below which a slip rate, a shear force or a violation of the associative flow rule counts as a
#: rounding error. Motions are scaled so that all velocities are between −1 and 1, and forces are in the
#: problem's unit of force.
ROUNDING = 1e-11

#: Largest accepted error of the margin of stability under dead load. The unit is the work of a median block
#: weight over a unit of length.
MARGIN_ENERGY = 1e-4

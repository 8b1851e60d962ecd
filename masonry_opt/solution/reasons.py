"""Reasons for the end of an analysis, as codes with values. The package ``words`` makes sentences of them."""

from dataclasses import dataclass, field
from enum import StrEnum
from typing import Any

from masonry_opt.problem.problem import Problem


class Status(StrEnum):
    """Status in which an analysis ended. Only the first two statuses have a load factor."""

    OPTIMAL = "optimal"
    CONVERGED = "converged"
    ITERATION_LIMIT = "not converged: iteration limit"
    CYCLING = "not converged: cycling"
    NO_STATE = "not converged: a sub-problem has no equilibrium state"
    HOMOTOPY = "not converged: the relaxation could not be followed to its end"
    UNSTABLE = "unstable under dead load"
    STABLE = "stable"
    UNLIMITED = "unlimited: the live load cannot cause collapse"
    LOCKED = "unlimited with associative flow: dilatancy locks the blocks"
    JAMMED = "no limit was found: joints press ever harder"
    BELOW_ZERO = "no collapse state above zero was found"
    SOLVER_FAILED = "solver failed"
    TIME_LIMIT = "stopped by the time limit"

    @property
    def usable(self) -> bool:
        """True if there is a load factor."""
        return self in (Status.OPTIMAL, Status.CONVERGED)

    @property
    def unlimited(self) -> bool:
        """True if the method found no limit of the live load.

        UNLIMITED is proven. LOCKED is proven for associative flow alone, and JAMMED for no flow rule.
        """
        return self in (Status.UNLIMITED, Status.LOCKED, Status.JAMMED)

    @property
    def live_load_acts(self) -> bool:
        """True if the live load acts in the solution's state; False if the dead load acts alone."""
        return self not in (Status.UNSTABLE, Status.STABLE)


class Code(StrEnum):
    """Codes of reasons and warnings; the comment on each code lists the values of its message."""

    # Reason of a stable scene without live load. Values: ``unique``, True if
    # equilibrium alone fixes the joint forces; ``elastic``, True if the forces are those of elastic contacts
    # that come to rest under the dead load, False if a linear or cone program found the forces.
    CARRIED = "carried"
    # Value: ``blocks``, the blocks that fall. This code and the next ones state, for all methods, why no load
    # factor exists.
    FALLS = "falls"
    # Value: ``blocks``, the falling blocks that no joint supports from below.
    HANGS = "hangs"
    # Value: ``blocks``, the blocks that would fall even if no joint could slide.
    NO_FRICTION_HOLDS = "no friction holds"
    # Values: ``pairs``, the two blocks of each joint that slides; ``factor``, multiplier of all friction
    # coefficients with which the scene is stable (None if unknown); ``above``, the largest multiplier that is
    # known to be too small; ``hangs``, True if no joint supports one of the blocks from below.
    FRICTION_WOULD_HOLD = "friction would hold"
    STRENGTH_WOULD_HOLD = "strength would hold"
    # Values: ``word``, status of the last solver; ``ratio``, largest over smallest dead load of a block.
    DEAD_LOAD_UNDECIDED = "dead load undecided"
    # Values: ``load_factor``, λ of the withdrawn answer, or None; ``blocks``, the blocks that move.
    WEDGED = "wedged"
    # Value: ``load_factor``, λ (zero or less) of a collapse state that the scene does not reach from rest.
    BELOW_ZERO = "below zero"
    SOLVER_STOPPED = "solver stopped"  # Value: ``word``, status of the solver
    # Value: ``word``, status of a solver that returned an answer outside its tolerance.
    STOPPED_SHORT = "stopped short"
    DILATANCY_LOCKS = "dilatancy locks"
    NO_MECHANISM = "no mechanism"
    # Values: ``static_cuts`` and ``kinematic_cuts``, the numbers of both kinds of cuts in the proof.
    NO_COLLAPSE = "no collapse"
    CARRIES_ANY = "carries any"
    # Value: ``pairs``, the two blocks of each joint in self-stress.
    CLAMPED = "clamped"
    # Values: ``status`` of the analysis; ``pairs``, the two blocks of each joint that keeps the live load
    # from causing collapse.
    JOINTS = "joints"
    # Values: ``fixed``, True if equilibrium alone determines all forces, so that the load factor given is the
    # only one above zero; ``against``, True if the mechanism moves against the live load.
    NO_WORK = "no work"
    # Values: ``seconds``, the time limit; ``phase`` in which the limit was reached. If there is no answer:
    # ``carried``, the largest load factor that the load history has carried, or None; ``last``, λ of the last
    # step of another method, or None.
    TIME_LIMIT = "time limit"
    # Values: ``load_factor``, λ of the rejected answer; ``residuals`` that exceed their limits.
    NOT_CERTIFIED = "not certified"

    # The loop of linear programs. Value: ``by``, the excess of λ over the associative load factor.
    ABOVE_ASSOCIATIVE = "above associative"
    FLOW_RULE_IDLE = "flow rule idle"
    # Values: ``count``, the number of sub-problems; ``lowest`` and ``highest`` λ of the last sub-problems.
    STILL_CHANGES = "still changes"
    # Values: ``load_factor``, λ of the last sub-problem; ``count``, the number of sub-problems.
    GROWS = "grows"
    # Values: ``period``, the number of sub-problems in a cycle; ``lowest`` and ``highest`` λ in the cycle;
    # ``exact``, True if the loop ends with an exact state.
    REPEATS = "repeats"
    # Values: ``number`` of the failed sub-problem; ``word``, status of the solver.
    SUB_PROBLEM_FAILED = "sub-problem failed"
    # Value: ``number`` of the sub-problem that has no equilibrium state.
    SUB_PROBLEM_EMPTY = "sub-problem empty"
    # Values: ``first``, status of the first run; ``remedies``, the options that were changed in the repeated
    # runs; ``in_vain``, True if all repeated runs failed.
    BEGAN_AGAIN = "began again"
    # Value: ``load_factor``, lowest λ of a sub-problem whose own state verifies it; None without such a
    # sub-problem.
    LEAST_BORNE_OUT = "least borne out"

    # First code of the incremental analysis. Values: ``steps`` and ``jumps``, the numbers of load steps and
    # of jumps in a load history that ends in an exact state.
    COLLAPSE = "collapse"
    # Values: ``steps`` and ``jumps``, numbers as for "collapse"; ``carried`` and ``not_carried``, the load
    # factors between which equilibrium is lost.
    RANGE = "range"
    # Value: ``steps``, the number of load steps of a load history without an end.
    UNBOUNDED = "unbounded"
    # Values: ``word``, how the load history ended; ``steps``, the number of load steps; ``looped``, True if
    # the loop of linear programs also found no collapse; ``searched``, True if a search found no collapse
    # state.
    UNDECIDED = "undecided"
    # Value: ``carried``, the largest load factor of a load history without an end, which exceeds λ of the
    # answer.
    CARRIES_MORE = "carries more"
    DILATANCY_FALLS = "dilatancy falls"
    # Value: ``joints`` (in space ``contacts``), a number that is too large for a load history.
    NOT_COMPUTED = "incremental not computed"
    # Values: ``draws``, the number of random stiffnesses, and of random self-stresses; ``stiffness`` and
    # ``stress``, the range of the incremental load factor in each case, or None; ``without``, the number of
    # load histories without a collapse.
    SPREAD = "spread"
    # Values: ``states``, the number of load steps; ``jumps``, the number of jumps among the load steps.
    CURVE = "curve"

    # The MPEC. Value: ``epsilon``, the largest permitted product z p.
    LOCAL_MINIMUM = "local minimum"
    START_FAILED = "start failed"
    # Values: ``word``, status of IPOPT; ``epsilon`` of the program that failed.
    RELAXATION_STOPPED = "relaxation stopped"
    NOTHING_SOLVED = "nothing solved"

    # First code of the search for lower load factors. Values: ``candidates``, the number of starts;
    # ``count``, the number of different exact states found; ``least`` and ``most``, the smallest and largest
    # of their load factors.
    STATES_MET = "states met"
    # Value: ``candidates``, the number of starts, which all led to one load factor.
    FEW_STARTS = "few starts"
    # Values: ``candidates``, the number of starts; ``interrupted``, True if the user ended the search.
    SEARCHED = "searched"
    NOT_FOUND = "no exact state near the forces"
    NO_TIME = "no time"

    # First code of method "global". All its codes have the values ``bound``, the lower bound of λ;
    # ``load_factor``, λ of the answer; ``rates``, the largest sum of rates for which the bound is valid, or
    # None; ``forces``, True if the bound assumes a limit of normal forces.
    PROVEN = "proven"
    WITHIN_IMPOSED = "within imposed"
    TOUCHES_IMPOSED = "touches imposed"
    # An additional value is ``time_limit``, in seconds.
    OUT_OF_TIME = "out of time"
    # An additional value is ``time_limit``, in seconds.
    OUT_OF_TIME_WITHIN_IMPOSED = "out of time within imposed"
    NO_EXACT_STATE = "no exact state"  # Value: ``time_limit``, in seconds

    # First code of the finite motion of a mechanism after the onset of collapse. The codes name events of the
    # motion and reasons for its end.
    REACHES_ZERO = "reaches zero"
    # Value: ``pairs``, the two blocks of the joint.
    JOINT_CLOSES = "joint closes"
    JOINT_OPENS = "joint opens"  # Value: ``pairs``, the two blocks of the joint
    # Values: ``associative`` load factor, None if unlimited; ``pairs``, the two blocks of each joint that
    # slides at the onset of collapse; ``turning``, in space λ at which a single body rotates.
    NOT_HINGING = "not hinging"
    # Value: ``pairs``, the two blocks of each joint that slides.
    JOINTS_SLIDE = "joints slide"
    # Value: ``blocks``, the blocks that meet where there is no joint.
    BLOCKS_MEET = "blocks meet"
    LOCKS = "locks"
    BRANCHES = "branches"
    # Value: ``steps``, the number of states that were computed.
    STILL_CARRIES = "still carries"
    FORCES_UNDECIDED = "forces undecided"

    # Values: ``friction``; ``pairs``, the two blocks of each joint, empty for the default of all joints. This
    # code and the next ones warn about properties of the scene that look unintended.
    FRICTION_HIGH = "friction high"
    # Values: ``dilatancy``, ``friction``, ``pairs``.
    DILATANCY_LOW = "dilatancy low"
    # Value: ``blocks``, the supports without function.
    IDLE_SUPPORTS = "idle supports"
    # Value: ``pairs``, the two blocks of each joint that transfers friction only because of self-stress.
    HELD_BY_CLAMPING = "held by clamping"
    # Values: ``blocks``, the blocks far away; ``distance`` from all other blocks; ``size``, the extent of all
    # other blocks.
    FAR_AWAY = "far away"
    # Values: ``blocks`` with another unit weight; ``ratio``, unit weight of the first of them over the
    # median; ``median`` of all unit weights; ``per_area``, True if unit weights are per area (in the plane
    # without a thickness).
    WEIGHTS_DIFFER = "weights differ"
    # Values: ``fill``, number of the fill, from 1; ``backing``, True for the fill's backing and False for the
    # fill; ``unit_weight`` of the fill or backing; ``beside``, "blocks" or "fill", with which ``unit_weight``
    # is compared; ``other``, the unit weight of these blocks or this fill.
    FILL_WEIGHT_DIFFERS = "fill weight differs"
    # Values: ``kind``, "tie" or "prop"; ``name`` of the tie or prop; ``key``, "strength" or "prestress";
    # ``value`` of the strength or prestress; ``weight`` of a median block, or the sum of all dead loads if
    # the value is too large.
    STRENGTH_DIFFERS = "strength differs"
    # Values: ``pairs`` of blocks on both sides of a gap; ``widths`` of the gaps; ``option`` of the scene that
    # closes all gaps, "tolerance" or "contact_tolerance"; ``tolerance``, the value of that option.
    SMALL_GAPS = "small gaps"
    # Values: ``pairs`` of blocks that face each other, but have no joint because their sides are too short
    # for the tolerance; ``widths`` of the gaps between these blocks.
    LOST_JOINTS = "lost joints"
    # Values: ``pairs`` of blocks whose joint lies in a gap as wide as mortar, which a large tolerance closes;
    # ``widths`` of these gaps.
    BRIDGED_BY_TOLERANCE = "bridged by tolerance"
    # Values: ``pairs``, the two blocks of each joint that alignment rotated; ``turn``, the largest rotation,
    # in radians; ``tolerance`` of the scene.
    ALIGNED = "aligned"
    # Values: ``pairs``, the two blocks of each joint that is nearly parallel to another joint; ``angle``, the
    # largest angle between two such joints, in radians; ``tolerance`` that aligns these joints.
    NEARLY_PARALLEL = "nearly parallel"
    # Value: ``pairs``, the two blocks of each joint at which corners meet (in space, edges along each other).
    JOINT_AT_CORNERS = "joint at corners"
    # Value: ``pairs``, names of blocks that meet only at corners.
    CORNERS_MEET = "corners meet"
    # Value: ``pairs``, names of blocks in space that touch without a common normal.
    WITHOUT_NORMAL = "without normal"
    # Value: ``blocks``, names of solids whose faces were reversed.
    FACES_TURNED = "faces turned"
    # Values: ``pairs``, the two blocks of each joint at a corner; ``normal_forces`` of the joints, largest
    # first.
    CORNERS_BEAR = "corners bear"
    # Values: ``number`` of the edge load, from 1; ``length`` without effect.
    BARE_EDGE_LOAD = "bare edge load"
    AXLES_LEFT_OUT = "axles left out"  # Value: ``names`` of the groups of axles
    # Values: ``load``, "live" or "dead"; ``blocks`` with a force outside; ``distance`` of the first such
    # force from its block.
    ACTS_OUTSIDE = "acts outside"
    # Values: ``load``, "live" or "dead"; ``blocks`` with an unusual force; ``ratio`` of the force on the
    # first of them to its weight.
    FORCES_DIFFER = "forces differ"


#: Names of the values that are load factors, for each code. These values are converted when the live load is
#: scaled.
LOAD_FACTORS: dict[Code, tuple[str, ...]] = {
    Code.WEDGED: ("load_factor",),
    Code.BELOW_ZERO: ("load_factor",),
    Code.TIME_LIMIT: ("carried", "last"),
    Code.NOT_CERTIFIED: ("load_factor",),
    Code.STILL_CHANGES: ("lowest", "highest"),
    Code.GROWS: ("load_factor",),
    Code.REPEATS: ("lowest", "highest"),
    Code.LEAST_BORNE_OUT: ("load_factor",),
    Code.RANGE: ("carried", "not_carried"),
    Code.CARRIES_MORE: ("carried",),
    Code.STATES_MET: ("least", "most"),
}


@dataclass(frozen=True)
class Reason:
    """Reason or warning: a code, and the values that its message needs."""

    code: Code  #: the code
    #: Values of the reason by name; the comments in ``Code`` describe them.
    values: dict[str, Any] = field(default_factory=dict)

    def as_dict(self) -> dict[str, Any]:
        """Return the code and its values in one dictionary."""
        return {"code": str(self.code), **self.values}


def reason(code: Code, **values: Any) -> Reason:
    """Return a reason with the given code and values."""
    return Reason(code, values)


def size_of(problem: Problem) -> dict[str, int]:
    """Return the number of ``joints`` (in space, ``contacts``) of a problem, for the values of a reason."""
    return {problem.layout.called: problem.joints}

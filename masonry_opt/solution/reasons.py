"""Reasons for the end of an analysis, as codes with values. The package ``words`` makes sentences of them."""

from dataclasses import dataclass, field
from enum import StrEnum
from typing import Any

from masonry_opt.problem.problem import Problem


class Status(StrEnum):
    """Status of an analysis at its end; only the first two statuses come with a load factor."""

    OPTIMAL = "optimal"
    CONVERGED = "converged"
    ITERATION_LIMIT = "not converged: iteration limit"
    CYCLING = "not converged: cycling"
    NO_STATE = "not converged: a sub-problem has no equilibrium state"
    HOMOTOPY = "not converged: the relaxation could not be followed to its end"
    UNSTABLE = "unstable under dead load"
    STANDS = "stands under dead load"
    UNLIMITED = "unlimited: the live load cannot cause collapse"
    LOCKED = "unlimited with associative flow: dilatancy locks the blocks"
    JAMMED = "no limit was found: joints press ever harder"
    BELOW_ZERO = "no collapse state above zero was found"
    SOLVER_FAILED = "solver failed"

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
        return self not in (Status.UNSTABLE, Status.STANDS)


class Code(StrEnum):
    """Codes of reasons and warnings; the comment on each code lists the values of its message."""

    # First group of codes: reasons of all methods why no load factor exists. The only value of "falls" is
    # blocks, the blocks that fall.
    FALLS = "falls"  # blocks
    HANGS = "hangs"  # blocks: the blocks that fall and that no joint supports from below
    # blocks: the blocks that fall even if no joint can slide
    NO_FRICTION_HOLDS = "no friction holds"
    # pairs: blocks of the joints that slide; factor: multiplier of all friction with which the scene is
    # stable, None if unknown; above: the largest such multiplier with which the scene is known to fall;
    # hangs: True if one of the blocks has no support from below
    FRICTION_WOULD_HOLD = "friction would hold"
    STRENGTH_WOULD_HOLD = "strength would hold"
    DEAD_LOAD_UNDECIDED = "dead load undecided"  # word, ratio
    WEDGED = "wedged"  # load_factor: λ of the withdrawn answer, or None; blocks: blocks that move
    BELOW_ZERO = "below zero"  # load_factor: λ of a collapse state that the scene does not reach from rest
    SOLVER_STOPPED = "solver stopped"  # word: status of the solver
    STOPPED_SHORT = "stopped short"  # word: status of a solver that returned an answer outside its tolerance
    DILATANCY_LOCKS = "dilatancy locks"
    NO_MECHANISM = "no mechanism"
    # static_cuts, kinematic_cuts: numbers of static and of kinematic cuts in the proof
    NO_COLLAPSE = "no collapse"
    CARRIES_ANY = "carries any"
    CLAMPED = "clamped"  # pairs: blocks of the joints in self-stress
    # status: status of the analysis; pairs: blocks of the joints that keep the live load from causing
    # collapse
    JOINTS = "joints"
    # fixed: True if equilibrium alone determines all forces, so that no other load factor above zero is
    # possible; against: True if the mechanism moves against the live load
    NO_WORK = "no work"
    NOT_CERTIFIED = "not certified"  # load_factor, residuals

    # The loop of linear programs.
    ABOVE_ASSOCIATIVE = "above associative"  # by: excess of λ over the associative load factor
    FLOW_RULE_IDLE = "flow rule idle"
    # count: number of sub-problems; lowest, highest: smallest and largest λ of the last sub-problems
    STILL_CHANGES = "still changes"
    GROWS = "grows"  # load_factor: λ of the last sub-problem; count: number of sub-problems
    # period: number of sub-problems in a cycle; lowest, highest: smallest and largest λ in the cycle; exact:
    # True if the loop ends with an exact state
    REPEATS = "repeats"
    # number: index of the failed sub-problem; word: status of the solver
    SUB_PROBLEM_FAILED = "sub-problem failed"
    SUB_PROBLEM_EMPTY = "sub-problem empty"  # number: of the sub-problem
    # first: status of the first run; remedies: changes made in the repeated runs; in_vain: True if all
    # repeated runs failed
    BEGAN_AGAIN = "began again"
    # load_factor: lowest λ of a sub-problem that is verified by the state of the sub-problem; None without
    # such a sub-problem
    LEAST_BORNE_OUT = "least borne out"

    # First code of the incremental analysis. Its values are steps, jumps: numbers of load steps and of jumps
    # in a load history that ends in an exact state.
    COLLAPSE = "collapse"
    # steps, jumps: numbers of load steps and jumps; carried, not_carried: load factors between which
    # equilibrium is lost
    RANGE = "range"
    UNBOUNDED = "unbounded"  # steps: number of load steps of a load history without an end
    # word: description of the end of the load history; steps: number of load steps; looped: True if the loop
    # also found no collapse; searched: True if a search found none
    UNDECIDED = "undecided"
    # carried: largest load factor of a load history without an end, above that of the answer
    CARRIES_MORE = "carries more"
    DILATANCY_FALLS = "dilatancy falls"
    # joints (in space: contacts): number of joints or contacts, which is too large for a load history
    NOT_COMPUTED = "incremental not computed"
    # draws: number of random stiffnesses, and of random self-stresses; stiffness, stress: range of the
    # incremental load factor with random stiffnesses and with random self-stresses, or None; without: number
    # of load histories without an end
    SPREAD = "spread"
    CURVE = "curve"  # states, jumps: numbers of load steps and of jumps among them

    # The MPEC.
    LOCAL_MINIMUM = "local minimum"  # epsilon
    START_FAILED = "start failed"
    RELAXATION_STOPPED = "relaxation stopped"  # word, epsilon
    NOTHING_SOLVED = "nothing solved"

    # First code of the search for lower states. Its values are candidates: number of starts; count: number of
    # different exact states found; least, most: smallest and largest load factor of these states.
    STATES_MET = "states met"
    FEW_STARTS = "few starts"  # candidates: number of starts, which all led to one load factor
    SEARCHED = "searched"  # candidates: number of starts; interrupted: True if the user ended the search
    NOT_FOUND = "no exact state near the forces"
    NO_TIME = "no time"

    # First code of method "global". All its codes have the values bound: lower bound of λ; load_factor: λ of
    # the answer; rates: largest sum of rates for which the bound is valid, or None; forces: True if the bound
    # assumes a limit of normal forces.
    PROVEN = "proven"
    WITHIN_IMPOSED = "within imposed"
    TOUCHES_IMPOSED = "touches imposed"
    OUT_OF_TIME = "out of time"  # also time_limit
    OUT_OF_TIME_WITHIN_IMPOSED = "out of time within imposed"  # also time_limit
    NO_EXACT_STATE = "no exact state"  # time_limit

    # First code of the finite motion of a mechanism after the onset of collapse. The codes name events of the
    # motion and reasons for its end.
    REACHES_ZERO = "reaches zero"
    JOINT_CLOSES = "joint closes"  # pairs
    JOINT_OPENS = "joint opens"  # pairs
    # associative: associative load factor, None if unlimited; pairs: blocks of the joints that slide at the
    # onset of collapse; turning: in space, λ at which a single body turns
    NOT_HINGING = "not hinging"
    JOINTS_SLIDE = "joints slide"  # pairs
    BLOCKS_MEET = "blocks meet"  # blocks
    LOCKS = "locks"
    BRANCHES = "branches"
    STILL_CARRIES = "still carries"  # steps
    FORCES_UNDECIDED = "forces undecided"

    # First warning about a property of the scene that looks unintended. In all warnings, pairs are the blocks
    # of joints. In the first two warnings, no pairs mean the default values of all joints.
    FRICTION_HIGH = "friction high"  # friction, pairs
    DILATANCY_LOW = "dilatancy low"  # dilatancy, friction, pairs
    IDLE_SUPPORTS = "idle supports"  # blocks
    HELD_BY_CLAMPING = "held by clamping"  # pairs
    # blocks: blocks far away; distance: their distance from all other blocks; size: size of the group of all
    # other blocks
    FAR_AWAY = "far away"
    # blocks: blocks with another unit weight; ratio: unit weight of the first block over the median; median:
    # median of all unit weights; per_area: True if unit weights are per area (in the plane without a
    # thickness)
    WEIGHTS_DIFFER = "weights differ"
    # fill: number of the fill, from 1; backing: True if the fill's backing is meant; unit_weight: unit weight
    # of the fill or backing; beside: "blocks" or "fill", with which unit_weight is compared; other: unit
    # weight of these blocks or this fill
    FILL_WEIGHT_DIFFERS = "fill weight differs"
    # kind: "tie" or "prop"; name: its name; key: "strength" or "prestress"; value: its strength or prestress;
    # weight: weight of a median block, or the sum of all dead loads if the value is too large
    STRENGTH_DIFFERS = "strength differs"
    # pairs: blocks on both sides of a gap; widths: widths of the gaps; tolerance: tolerance that closes all
    # gaps and aligns the joints
    SMALL_GAPS = "small gaps"
    # pairs: blocks of the joints that alignment turned; turn: largest rotation, in radians; tolerance:
    # tolerance of the scene
    ALIGNED = "aligned"
    # pairs: blocks of joints that are nearly parallel to other joints; angle: the largest angle, in radians;
    # tolerance: tolerance that aligns these joints
    NEARLY_PARALLEL = "nearly parallel"
    CORNERS_MEET = "corners meet"  # pairs: names of blocks
    WITHOUT_NORMAL = "without normal"  # pairs: names of blocks in space
    FACES_TURNED = "faces turned"  # blocks: names of solids
    # pairs: blocks of the joints; normal_forces: normal force of each joint, largest first
    CORNERS_BEAR = "corners bear"
    BARE_EDGE_LOAD = "bare edge load"  # number: counted from 1; length
    AXLES_LEFT_OUT = "axles left out"  # names: names of the groups of axles
    # load: "live" or "dead"; blocks: blocks with a force outside; distance: distance of the first such force
    # from its block
    ACTS_OUTSIDE = "acts outside"
    # load: "live" or "dead"; blocks: blocks with an unusual force; ratio: force on the first block over its
    # weight
    FORCES_DIFFER = "forces differ"


#: Names of the values that are load factors, for each code. These values are converted when the live load is
#: scaled.
LOAD_FACTORS: dict[Code, tuple[str, ...]] = {
    Code.WEDGED: ("load_factor",),
    Code.BELOW_ZERO: ("load_factor",),
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
    #: Values under the names in the comments of ``Code``.
    values: dict[str, Any] = field(default_factory=dict)

    def as_dict(self) -> dict[str, Any]:
        """Return the code and its values in one dictionary."""
        return {"code": str(self.code), **self.values}


def reason(code: Code, **values: Any) -> Reason:
    """Return a reason with the given code and values."""
    return Reason(code, values)


def size_of(problem: Problem) -> dict[str, int]:
    """Return the number of ``joints`` of a problem (in space, of ``contacts``) as a value of a reason."""
    return {problem.layout.called: problem.joints}

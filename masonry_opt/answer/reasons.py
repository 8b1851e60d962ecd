"""Reasons for the end of an analysis, as codes with values. The package ``words`` makes sentences of them."""

from dataclasses import dataclass, field
from enum import StrEnum
from typing import Any

from masonry_opt.problem.problem import Problem


class Status(StrEnum):
    """End of an analysis; only the first two have a load factor."""

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
    """Codes of reasons and warnings; the comment at each code lists its values."""

    # All methods: reasons for which there is no load factor.
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
    WEDGED = "wedged"  # load_factor: None if none was looked for; blocks
    BELOW_ZERO = "below zero"  # load_factor: of a state that the scene does not reach from rest
    SOLVER_STOPPED = "solver stopped"  # word: status of the solver
    STOPPED_SHORT = "stopped short"  # word: status of a solver that missed its tolerance, but has an answer
    DILATANCY_LOCKS = "dilatancy locks"
    NO_MECHANISM = "no mechanism"
    NO_COLLAPSE = "no collapse"  # static_cuts, kinematic_cuts: numbers of cuts of the proof
    CARRIES_ANY = "carries any"
    CLAMPED = "clamped"  # pairs: blocks of the joints in self-stress
    # status; pairs: blocks of the joints that keep the live load from causing collapse
    JOINTS = "joints"
    # fixed: True if no other load factor above zero is possible, because equilibrium alone fixes all forces;
    # against: True if the mechanism moves against the live load
    NO_WORK = "no work"
    NOT_CERTIFIED = "not certified"  # load_factor, residuals

    # The loop of linear programs.
    ABOVE_ASSOCIATIVE = "above associative"  # by: excess over the associative load factor
    FLOW_RULE_IDLE = "flow rule idle"
    # count: number of sub-problems; lowest, highest: range of load factors of the last sub-problems
    STILL_CHANGES = "still changes"
    GROWS = "grows"  # load_factor: of the last sub-problem; count: number of sub-problems
    # period: number of sub-problems that repeat; lowest, highest: range of their load factors; exact: True if
    # the loop ends with an exact state
    REPEATS = "repeats"
    SUB_PROBLEM_FAILED = "sub-problem failed"  # number: of the sub-problem; word: status of the solver
    SUB_PROBLEM_EMPTY = "sub-problem empty"  # number: of the sub-problem
    # first: status of the first run; remedies: remedies of the runs that followed; in_vain: True if all
    # failed
    BEGAN_AGAIN = "began again"
    # load_factor: lowest load factor of a sub-problem that its own state verifies, or None
    LEAST_BORNE_OUT = "least borne out"

    # The incremental analysis.
    # steps, jumps: numbers of load steps and jumps of the load history, which ends in an exact state
    COLLAPSE = "collapse"
    # steps, jumps: numbers of load steps and jumps; carried, not_carried: load factors between which
    # equilibrium is lost
    RANGE = "range"
    UNBOUNDED = "unbounded"  # steps: number of load steps of a load history that has no end
    # word: end of the load history; steps: number of load steps; looped: True if the loop found no collapse
    # either; searched: True if a search found none
    UNDECIDED = "undecided"
    # carried: largest load factor of a load history without an end, above that of the answer
    CARRIES_MORE = "carries more"
    DILATANCY_FALLS = "dilatancy falls"
    # joints, in space contacts: their number, which is too large for a load history
    NOT_COMPUTED = "incremental not computed"
    # draws: number of random stiffnesses, and of random self-stresses; stiffness, stress: range of
    # incremental load factors with random stiffnesses, and with random self-stresses, or None; without:
    # number of load histories that reached no end
    SPREAD = "spread"
    CURVE = "curve"  # states, jumps: numbers of load steps and of jumps among them

    # The MPEC.
    LOCAL_MINIMUM = "local minimum"  # epsilon
    START_FAILED = "start failed"
    RELAXATION_STOPPED = "relaxation stopped"  # word, epsilon
    NOTHING_SOLVED = "nothing solved"

    # The search for lower states.
    # candidates: number of starts; count: number of different exact states found from these starts; least,
    # most: their smallest and largest load factor
    STATES_MET = "states met"
    FEW_STARTS = "few starts"  # candidates: number of starts after which all load factors agree
    SEARCHED = "searched"  # candidates: number of starts; interrupted: True if the user ended the search
    NOT_FOUND = "no exact state near the forces"
    NO_TIME = "no time"

    # The bracket of method "global".
    # Values of these codes: bound; load_factor; rates: sum of rates that the bound assumes, or None; forces:
    # True if the bound assumes a limit of normal forces.
    PROVEN = "proven"
    WITHIN_IMPOSED = "within imposed"
    TOUCHES_IMPOSED = "touches imposed"
    OUT_OF_TIME = "out of time"  # also time_limit
    OUT_OF_TIME_WITHIN_IMPOSED = "out of time within imposed"  # also time_limit
    NO_EXACT_STATE = "no exact state"  # time_limit

    # Finite motion after the onset of collapse: events on the path of a mechanism, and reasons for its end.
    REACHES_ZERO = "reaches zero"
    JOINT_CLOSES = "joint closes"  # pairs
    JOINT_OPENS = "joint opens"  # pairs
    # associative: load factor, None if unlimited; pairs: blocks of the joints that slide at the onset;
    # turning: in space, λ of the body that turns by itself
    NOT_HINGING = "not hinging"
    JOINTS_SLIDE = "joints slide"  # pairs
    BLOCKS_MEET = "blocks meet"  # blocks
    LOCKS = "locks"
    BRANCHES = "branches"
    STILL_CARRIES = "still carries"  # steps
    FORCES_UNDECIDED = "forces undecided"

    # Warnings about properties of the scene that look unintended.
    # Pairs name the blocks of joints; in the first two codes they are empty for the defaults of all joints.
    FRICTION_HIGH = "friction high"  # friction, pairs
    DILATANCY_LOW = "dilatancy low"  # dilatancy, friction, pairs
    IDLE_SUPPORTS = "idle supports"  # blocks
    HELD_BY_CLAMPING = "held by clamping"  # pairs
    FAR_AWAY = "far away"  # blocks; distance; size: size of all other blocks together
    # blocks; ratio: unit weight of the first block over the median of all; median; per_area: True if unit
    # weights are per area, as in the plane without a thickness
    WEIGHTS_DIFFER = "weights differ"
    # fill: number of the fill, counted from 1; backing: True if the unit weight is that of its backing;
    # unit_weight; beside: "blocks" or "fill", with which it is compared; other: their unit weight
    FILL_WEIGHT_DIFFERS = "fill weight differs"
    # kind: "tie" or "prop"; name; key: "strength" or "prestress"; value; weight: weight of a median block, or
    # for a value that is too large the sum of all dead loads
    STRENGTH_DIFFERS = "strength differs"
    # pairs: names of blocks; widths: width of the gap of each pair; tolerance: tolerance that closes all gaps
    # and aligns the joints
    SMALL_GAPS = "small gaps"
    # pairs: blocks of the joints that alignment turned; turn: largest rotation, in radians; tolerance
    ALIGNED = "aligned"
    # pairs: blocks of joints that are nearly parallel to other joints; angle: the largest angle, in radians;
    # tolerance: tolerance that aligns these joints
    NEARLY_PARALLEL = "nearly parallel"
    CORNERS_MEET = "corners meet"  # pairs: names of blocks
    WITHOUT_NORMAL = "without normal"  # pairs: names of blocks in space
    FACES_TURNED = "faces turned"  # blocks: names of solids
    CORNERS_BEAR = "corners bear"  # pairs: names of blocks; normal_forces: one for each pair, largest first
    BARE_EDGE_LOAD = "bare edge load"  # number: counted from 1; length
    AXLES_LEFT_OUT = "axles left out"  # names: names of the groups of axles
    # load: "live" or "dead"; blocks; distance: distance of the first force's point from its block
    ACTS_OUTSIDE = "acts outside"
    # load: "live" or "dead"; blocks; ratio: force on the first block over its weight
    FORCES_DIFFER = "forces differ"


#: Names of the values that are load factors, by code. They scale with the load that λ multiplies.
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
    """A code and the values that belong to it."""

    code: Code  #: the code
    values: dict[str, Any] = field(default_factory=dict)  #: values by the names that ``Code`` lists

    def as_dict(self) -> dict[str, Any]:
        """Return the code and its values in one dictionary."""
        return {"code": str(self.code), **self.values}


def reason(code: Code, **values: Any) -> Reason:
    """Return a reason with a code and values."""
    return Reason(code, values)


def size_of(problem: Problem) -> dict[str, int]:
    """Return the number of joints of a problem, by its name in reasons: ``joints``, in space ``contacts``."""
    return {problem.layout.called: problem.joints}

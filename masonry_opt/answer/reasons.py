"""Why an analysis ended as it did: codes with their values. Sentences are made of them in ``words``."""

from dataclasses import dataclass, field
from enum import StrEnum
from typing import Any

from masonry_opt.problem.problem import Problem


class Status(StrEnum):
    """How an analysis ended; only the first two come with a load factor."""

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
        """Whether there is a load factor to use."""
        return self in (Status.OPTIMAL, Status.CONVERGED)

    @property
    def unlimited(self) -> bool:
        """True if the method found no limit of the live load.

        UNLIMITED is proven. LOCKED is proven of associative flow alone, and JAMMED of no flow rule.
        """
        return self in (Status.UNLIMITED, Status.LOCKED, Status.JAMMED)

    @property
    def live_load_acts(self) -> bool:
        """Whether the live load acts on what was found, forces or a motion; else the dead load alone."""
        return self not in (Status.UNSTABLE, Status.STANDS)


class Code(StrEnum):
    """What can be said of how an analysis ended; beside each, its values."""

    # No load factor, of any method.
    FALLS = "falls"  # blocks
    HANGS = "hangs"  # blocks: those that fall and that no joint bears from below
    NO_FRICTION_HOLDS = "no friction holds"  # blocks: those that fall even where no joint can slide
    # pairs: the joints that slide; factor: on all friction, at which the scene stands, None if unknown;
    # above: the largest at which it is known to fall; hangs: whether any of the blocks does.
    FRICTION_WOULD_HOLD = "friction would hold"
    STRENGTH_WOULD_HOLD = "strength would hold"
    DEAD_LOAD_UNDECIDED = "dead load undecided"  # word, ratio
    WEDGED = "wedged"  # load_factor, None if none was looked for, blocks
    BELOW_ZERO = "below zero"  # load_factor: of a state that the scene is not in from rest
    SOLVER_STOPPED = "solver stopped"  # word
    STOPPED_SHORT = "stopped short"  # word: with an answer all the same
    DILATANCY_LOCKS = "dilatancy locks"
    NO_MECHANISM = "no mechanism"
    NO_COLLAPSE = "no collapse"  # static_cuts, kinematic_cuts: of the proof
    CARRIES_ANY = "carries any"
    CLAMPED = "clamped"  # pairs: the joints in self-stress
    JOINTS = "joints"  # status, pairs: the joints that keep the live load from causing collapse
    # fixed: whether statics fix all forces; against: whether the mechanism moves against the live load.
    NO_WORK = "no work"
    NOT_CERTIFIED = "not certified"  # load_factor, residuals

    # The loop.
    ABOVE_ASSOCIATIVE = "above associative"  # by
    FLOW_RULE_IDLE = "flow rule idle"
    STILL_CHANGES = "still changes"  # count, lowest, highest
    GROWS = "grows"  # load_factor, count
    REPEATS = "repeats"  # period, lowest, highest, exact: whether its last state is
    SUB_PROBLEM_FAILED = "sub-problem failed"  # number, word
    SUB_PROBLEM_EMPTY = "sub-problem empty"  # number
    BEGAN_AGAIN = "began again"  # first, remedies, in_vain
    LEAST_BORNE_OUT = "least borne out"  # load_factor, None if there is none

    # The incremental analysis.
    COLLAPSE = "collapse"  # steps, jumps: of the load history, which ends in an exact state
    # steps, jumps; carried, not_carried: load factors between which equilibrium is lost.
    RANGE = "range"
    UNBOUNDED = "unbounded"  # steps: of a load history that has no end
    # word, steps; looped: True if the loop found no collapse either; searched: True if a search found none.
    UNDECIDED = "undecided"
    DILATANCY_FALLS = "dilatancy falls"
    NOT_COMPUTED = "incremental not computed"  # joints, in space contacts: too many for a load history
    # draws: number of random stiffnesses, and of random self-stresses; stiffness, stress: the range of the
    # incremental load factors of each, or None; without: number of load histories that reached no end.
    SPREAD = "spread"
    CURVE = "curve"  # states, jumps: numbers of load steps and of jumps among them

    # The MPEC.
    LOCAL_MINIMUM = "local minimum"  # epsilon
    START_FAILED = "start failed"
    RELAXATION_STOPPED = "relaxation stopped"  # word, epsilon
    NOTHING_SOLVED = "nothing solved"

    # The refinement.
    # candidates, count: of different exact states among theirs; least, most: their load factors
    STATES_MET = "states met"
    FEW_STARTS = "few starts"  # candidates: starts after which all load factors agree
    SEARCHED = "searched"  # candidates, interrupted: whether by the user
    NOT_FOUND = "no exact state near the forces"
    NO_TIME = "no time"

    # The bracket.
    # Values: bound, load_factor; rates: the sum of rates that the bound assumes, None if none;
    # forces: whether it assumes a limit of normal forces.
    PROVEN = "proven"
    WITHIN_IMPOSED = "within imposed"
    TOUCHES_IMPOSED = "touches imposed"
    OUT_OF_TIME = "out of time"  # also time_limit
    OUT_OF_TIME_WITHIN_IMPOSED = "out of time within imposed"  # also time_limit
    NO_EXACT_STATE = "no exact state"  # time_limit

    # After the onset: what happens on the path of a mechanism, and why it ends.
    REACHES_ZERO = "reaches zero"
    JOINT_CLOSES = "joint closes"  # pairs
    JOINT_OPENS = "joint opens"  # pairs
    # associative: None if unlimited; pairs: joints that slide at the onset; turning: in space, λ of the body
    # that turns by itself.
    NOT_HINGING = "not hinging"
    JOINTS_SLIDE = "joints slide"  # pairs
    BLOCKS_MEET = "blocks meet"  # blocks
    LOCKS = "locks"
    BRANCHES = "branches"
    STILL_CARRIES = "still carries"  # steps
    FORCES_UNDECIDED = "forces undecided"

    # Warnings: what looks unintended. Pairs: the joints named, none where the defaults are meant.
    FRICTION_HIGH = "friction high"  # friction, pairs
    DILATANCY_LOW = "dilatancy low"  # dilatancy, friction, pairs
    IDLE_SUPPORTS = "idle supports"  # blocks
    HELD_BY_CLAMPING = "held by clamping"  # pairs
    FAR_AWAY = "far away"  # blocks, distance, size: of the rest
    # blocks; ratio: of the first one's unit weight to the median of all; median; per_area: True if unit
    # weights are per area, as in the plane without a thickness
    WEIGHTS_DIFFER = "weights differ"
    # fill: number of the fill, from 1; backing: True if the unit weight is that of its backing; unit_weight;
    # beside: what it is compared with, "blocks" or "fill"; other: the unit weight of the latter.
    FILL_WEIGHT_DIFFERS = "fill weight differs"
    # kind: "tie" or "prop", name, key: "strength" or "prestress", value; weight: of a median block, or if the
    # value is larger of all dead loads.
    STRENGTH_DIFFERS = "strength differs"
    # pairs: of blocks; widths: of the gap of each; tolerance: closes all gaps and aligns their joints
    SMALL_GAPS = "small gaps"
    # pairs: of blocks, at joints that alignment turned; turn: the largest, in radians; tolerance
    ALIGNED = "aligned"
    # pairs: of blocks, at joints nearly parallel to others; angle: the largest; tolerance: that aligns them
    NEARLY_PARALLEL = "nearly parallel"
    CORNERS_MEET = "corners meet"  # pairs: of blocks
    WITHOUT_NORMAL = "without normal"  # pairs: of blocks in space
    FACES_TURNED = "faces turned"  # blocks in space
    CORNERS_BEAR = "corners bear"  # pairs: of blocks; normal_forces: of each, largest first
    BARE_EDGE_LOAD = "bare edge load"  # number: counted from 1, length
    AXLES_LEFT_OUT = "axles left out"  # names: of the groups
    ACTS_OUTSIDE = "acts outside"  # load: 'live' or 'dead', blocks, distance: of the first one's point to it
    FORCES_DIFFER = "forces differ"  # load: 'live' or 'dead', blocks, ratio: of the first one's to weight


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
    Code.STATES_MET: ("least", "most"),
}


@dataclass(frozen=True)
class Reason:
    """A code and the values that belong to it."""

    code: Code
    values: dict[str, Any] = field(default_factory=dict)

    def as_dict(self) -> dict[str, Any]:
        """The code and its values in one table."""
        return {"code": str(self.code), **self.values}


def reason(code: Code, **values: Any) -> Reason:
    """A reason from its code and values."""
    return Reason(code, values)


def size_of(problem: Problem) -> dict[str, int]:
    """How many joints a problem has, as a value of a reason; in space they are ``contacts``, points."""
    return {problem.layout.called: problem.joints}

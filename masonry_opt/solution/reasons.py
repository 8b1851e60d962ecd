"""Reasons for the status of an analysis, as codes with values.

:mod:`masonry_opt.reporting.sentences` turns the codes into sentences.
"""

from dataclasses import dataclass, field
from enum import StrEnum
from typing import Any

from masonry_opt.problem.problem import Problem


class Status(StrEnum):
    """Status in which an analysis ends. Only OPTIMAL and CONVERGED have a load factor."""

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
        """True if, according to the method, the live load can grow without limit.

        UNLIMITED is proven for the joints' own flow rule, and LOCKED only for associative flow. JAMMED is not
        proven.
        """
        return self in (Status.UNLIMITED, Status.LOCKED, Status.JAMMED)

    @property
    def live_load_acts(self) -> bool:
        """True if the live load acts in the solution's state; False if the dead load acts alone."""
        return self not in (Status.UNSTABLE, Status.STABLE)


class Code(StrEnum):
    """Codes of reasons and warnings.

    The comment on each code states its meaning. Names in double backquotes are the values that its message
    needs.
    """

    # The scene has no live load and is stable. The value ``unique`` is True if equilibrium alone determines
    # the joint forces. The value ``elastic`` is True if elastic contacts determine the joint forces, and
    # False if a linear or cone program does.
    CARRIED = "carried"
    # The scene is unstable under its dead load. Value: ``blocks``, the names of the blocks that fall.
    FALLS = "falls"
    # Some of the falling blocks have no joint that supports them from below. Value: ``blocks``, the names of
    # the blocks without support.
    HANGS = "hangs"
    # The scene would be unstable even if no joint could slide. Value: ``blocks``, the falling blocks.
    NO_FRICTION_HOLDS = "no friction holds"
    # The scene would be stable with more friction. The value ``pairs`` lists the two blocks of each joint
    # that slides. The value ``factor`` is a sufficient multiplier of all friction coefficients, or None if
    # unknown; ``above`` is the largest multiplier that is known to be too small. The value ``hangs`` is True
    # if a falling block has no joint that supports it from below.
    FRICTION_WOULD_HOLD = "friction would hold"
    # The scene would be stable if no joint could crush. The message needs no values.
    STRENGTH_WOULD_HOLD = "strength would hold"
    # The scene would be stable if no tie or prop could yield. Value: ``names``, the ties and props that
    # yield, such as "tie 'rod'".
    TIES_WOULD_HOLD = "ties would hold"
    # Solvers could not decide whether the scene is stable. The value ``word`` is the status of the last
    # solver. The value ``ratio`` is the largest dead load of a block divided by the smallest.
    DEAD_LOAD_UNDECIDED = "dead load undecided"
    # The answer is withdrawn, because it needs forces between wedged blocks to carry the dead load, and such
    # forces do not arise under the joints' flow rule. The value ``load_factor`` is λ of the withdrawn answer,
    # or None. The value ``blocks`` lists the names of the blocks that move.
    WEDGED = "wedged"
    # The only collapse state that was found has a load factor of zero or less, although the scene reaches
    # equilibrium when the dead load is applied to blocks at rest. Value: ``load_factor``, λ of this state.
    BELOW_ZERO = "below zero"
    # A solver failed. Value: ``word``, status of the solver.
    SOLVER_STOPPED = "solver stopped"
    # A solver did not reach its tolerance. Value: ``word``, status of the solver.
    STOPPED_SHORT = "stopped short"
    # Dilatancy of sliding joints locks the blocks in associative flow. The message needs no values.
    DILATANCY_LOCKS = "dilatancy locks"
    # The live load does no positive work in any mechanism, so it cannot cause collapse. The message needs no
    # values.
    NO_MECHANISM = "no mechanism"
    # It is proven that no collapse state exists. The value ``static_cuts`` is the number of sets of yield
    # conditions that cannot all be at yield. The value ``kinematic_cuts`` is the number of sets in which at
    # least one condition must be at yield if the live load does work.
    NO_COLLAPSE = "no collapse"
    # It is proven that every multiple of the live load can be carried within the friction limits. The message
    # needs no values.
    CARRIES_ANY = "carries any"
    # Self-stress in some joints carries the live load. Value: ``pairs``, the two blocks of each such joint.
    CLAMPED = "clamped"
    # Joints prevent the live load from causing collapse. The value ``pairs`` lists the two blocks of each of
    # these joints, and ``status`` is the status of the analysis.
    JOINTS = "joints"
    # The live load does not drive the mechanism. The value ``fixed`` is True if equilibrium alone determines
    # all forces, so that the scene does not collapse at any other load factor above zero. The value
    # ``against`` is True if the live load does negative work in the mechanism.
    NO_WORK = "no work"
    # The time limit ended the analysis. Values:
    # - ``seconds``: the time limit.
    # - ``phase``: the phase in which the analysis was stopped.
    # - ``carried``: λ of the last load step if the time limit ended a load history; otherwise None.
    # - ``last``: λ of the last step if the time limit ended another method; otherwise None.
    # Both ``carried`` and ``last`` are None if the analysis has an answer.
    TIME_LIMIT = "time limit"
    # The answer is rejected because of its residuals. The value ``load_factor`` is λ of the answer. The value
    # ``residuals`` contains the residuals that exceed their limits, by name.
    NOT_CERTIFIED = "not certified"

    # The codes from here to LEAST_BORNE_OUT belong to the loop of linear programs.

    # The loop ended above the associative load factor, so the associative load factor is the result. Value:
    # ``by``, the difference of the two load factors.
    ABOVE_ASSOCIATIVE = "above associative"
    # The associative answer already satisfies the joints' own flow rule, so the loop stops. The message needs
    # no values.
    FLOW_RULE_IDLE = "flow rule idle"
    # λ still changed when the loop reached its last iteration. The value ``count`` is the number of
    # sub-problems that were solved. The values ``lowest`` and ``highest`` are the smallest and the largest λ
    # of the last ``LONGEST_PERIOD`` sub-problems (see ``methods/loop/run.py``).
    STILL_CHANGES = "still changes"
    # λ was still growing when the loop stopped. The value ``load_factor`` is λ of the last sub-problem. The
    # value ``count`` is the number of sub-problems.
    GROWS = "grows"
    # The load factors of the loop repeat in a cycle of ``period`` sub-problems, with values from ``lowest``
    # to ``highest``. The value ``exact`` is True if the loop ends with an exact state.
    REPEATS = "repeats"
    # The solver failed in a sub-problem (a linear program of the loop), or the first sub-problem has no
    # optimum. ``number`` is the number of the sub-problem, and ``word`` is the status of the solver.
    SUB_PROBLEM_FAILED = "sub-problem failed"
    # A linear program of the loop has no equilibrium state. The value ``number`` is the number of this
    # sub-problem.
    SUB_PROBLEM_EMPTY = "sub-problem empty"
    # The loop was repeated with other options. The value ``first`` is the status of the first run, and
    # ``remedies`` lists the changed options. The value ``in_vain`` is True if all repeated runs failed.
    BEGAN_AGAIN = "began again"
    # The loop did not converge. Value: ``load_factor``, the lowest load factor of a sub-problem whose state
    # satisfies the joints' own flow rule; None if no sub-problem has such a state.
    LEAST_BORNE_OUT = "least borne out"

    # The load history of the incremental analysis ends in an exact state. The values ``steps`` and ``jumps``
    # are the numbers of load steps and of jumps.
    COLLAPSE = "collapse"
    # Equilibrium is lost between the load factors ``carried`` and ``not_carried`` of a load history, but no
    # exact state was found nearby. The values ``steps`` and ``jumps`` are the numbers of load steps and of
    # jumps.
    RANGE = "range"
    # The contact forces grow with the live load in the load history, so no limit of the live load was
    # found. Value: ``steps``, the number of load steps.
    UNBOUNDED = "unbounded"
    # The load history led to no collapse state. The value ``word`` is a phrase that states how the history
    # ended. The value ``steps`` is the number of load steps. The value ``looped`` is True if the loop of
    # linear programs also found no collapse. The value ``searched`` is True if a later search for exact
    # collapse states also found none.
    UNDECIDED = "undecided"
    # The load history passes the λ of the answer without a collapse. Value: ``carried``, the largest load
    # factor that the load history reached.
    CARRIES_MORE = "carries more"
    # There is no load history, because the dilatancy falls with stress. The message needs no values.
    DILATANCY_FALLS = "dilatancy falls"
    # The scene is too large for a load history. The value ``joints`` (in space: ``contacts``) is the number
    # of its joints (in space: contact points).
    NOT_COMPUTED = "incremental not computed"
    # Load histories were repeated with random input: ``draws`` of them with random stiffness, and as many
    # with random self-stress. The values ``stiffness`` and ``stress`` are the ranges of the incremental load
    # factor in these two groups. A range is None if no load history of its group led to a collapse. The value
    # ``without`` is the number of load histories without a collapse.
    SPREAD = "spread"
    # The result contains a load–displacement curve of ``states`` load steps, ``jumps`` of which are jumps.
    CURVE = "curve"

    # The answer of the MPEC is a local minimum. Value: ``epsilon``, the largest permitted product of a slack
    # z and its rate p.
    LOCAL_MINIMUM = "local minimum"
    # The loop, which provides the start of the MPEC, failed.
    START_FAILED = "start failed"
    # IPOPT failed at a relaxation of the MPEC. The value ``word`` is the status of IPOPT. The value
    # ``epsilon`` is the largest product of a slack z and its rate p that this relaxation permits.
    RELAXATION_STOPPED = "relaxation stopped"
    # IPOPT failed at the first relaxation of the MPEC.
    NOTHING_SOLVED = "nothing solved"

    # The method found ``count`` different exact states with λ > 0 from ``candidates`` starts. Their load
    # factors range from ``least`` to ``most``.
    STATES_MET = "states met"
    # The lowest, the incremental and the associative load factor agree, but the number of starts was small.
    # Value: ``candidates``, the number of starts.
    FEW_STARTS = "few starts"
    # The search for lower load factors has ended after ``candidates`` starts. The value ``interrupted`` is
    # True if the user or the time limit ended the search.
    SEARCHED = "searched"
    # The search found no exact state near the forces from which it started.
    NOT_FOUND = "no exact state near the forces"
    # The time allowed by option ``search`` ended before the search found an exact state.
    NO_TIME = "no time"

    # The codes from here to OUT_OF_TIME_WITHIN_IMPOSED compare the answer with a lower bound on λ. PROVEN
    # belongs to methods "global" and "coulomb". All other codes in this range belong to method "global". Each
    # code has these four values:
    # - ``bound``: lower bound on λ.
    # - ``load_factor``: λ of the answer.
    # - ``rates``: largest sum of all slips and edge openings for which the bound is valid, or None if the
    #   method assumed no such limit.
    # - ``forces``: True if the method assumed a limit on normal forces.

    # The lower bound agrees with the lowest load factor, and was computed without assumed limits on rates and
    # forces. If a ``Proof`` proves the bound, the bound excludes only states within ``solution.proof.REACH``.
    PROVEN = "proven"
    # The lower bound agrees with the lowest load factor, but is valid only for states within the assumed
    # limits on rates and forces.
    WITHIN_IMPOSED = "within imposed"
    # The answer is not within the limits on rates or forces that the lower bound assumes, so nothing is
    # proven.
    TOUCHES_IMPOSED = "touches imposed"
    # The time limit was reached before the lower bound on λ agreed with the lowest load factor. Values: those
    # of PROVEN, and ``time_limit`` in seconds.
    OUT_OF_TIME = "out of time"
    # The time limit was reached before the lower bound on λ agreed with the lowest load factor. The lower
    # bound is valid only for states within the assumed limits on rates and forces. Values: those of
    # OUT_OF_TIME.
    OUT_OF_TIME_WITHIN_IMPOSED = "out of time within imposed"
    # The time limit was reached before an exact state was found, so no upper bound on λ is known. Value:
    # ``time_limit``, in seconds.
    NO_EXACT_STATE = "no exact state"

    # The codes from here to FORCES_UNDECIDED name events of the finite motion of a mechanism, or reasons for
    # its end.

    # λ has decreased to zero in the finite motion.
    REACHES_ZERO = "reaches zero"
    # An open joint closes in the finite motion. Value: ``pairs``, the two blocks of the joint.
    JOINT_CLOSES = "joint closes"
    # A closed joint opens in the finite motion. Value: ``pairs``, the two blocks of the joint.
    JOINT_OPENS = "joint opens"
    # No finite motion is computed, for one of three reasons:
    # - Joints slide at the onset of collapse.
    # - In the plane, λ is below the associative load factor, and the blocks cannot move about the hinges of
    #   the mechanism without slip.
    # - In space, one body rotates about an edge, and λ differs from the load factor ``turning``, because
    #   joints away from the edge resist the rotation.
    # Values:
    # - ``associative``: the associative load factor, or None if it is unlimited.
    # - ``pairs``: the two blocks of each joint that slides.
    # - ``slip`` (in the plane): the largest slip rate of a joint divided by the speed of the fastest corner.
    # - ``turning`` (in space): the load factor at which the moments of the live load and of all other loads
    #   about the edge of rotation are in equilibrium.
    NOT_HINGING = "not hinging"
    # Joints begin to slide in the finite motion. The value ``pairs`` lists the two blocks of each sliding
    # joint. In the plane, the value ``slip`` is the largest slip rate of a joint divided by the speed of the
    # fastest corner.
    JOINTS_SLIDE = "joints slide"
    # Two blocks without a joint between them touch in the finite motion. Value: ``blocks``, the names of the
    # two blocks.
    BLOCKS_MEET = "blocks meet"
    # Closed joints prevent any further motion of the mechanism.
    LOCKS = "locks"
    # Blocks have separated, and several motions are possible.
    BRANCHES = "branches"
    # λ is still above zero after the largest permitted number of states. Value: ``steps``, the number of
    # states.
    STILL_CARRIES = "still carries"
    # The solver did not solve the linear program for the forces in the next state.
    FORCES_UNDECIDED = "forces undecided"

    # All codes from here on are warnings about properties of the scene that look unintended.

    # The friction is larger than in any dry joint. The value ``pairs`` lists the two blocks of each joint; it
    # is empty if the default for all joints is too large. The value ``friction`` is the coefficient of the
    # first joint, or the default.
    FRICTION_HIGH = "friction high"
    # A friction angle in degrees is so small that it may be a friction coefficient. The values are those of
    # FRICTION_HIGH.
    FRICTION_LOW = "friction low"
    # The dilatancy is negative, and its magnitude is larger than the friction. The value ``pairs`` lists the
    # two blocks of each joint; it is empty if the default for all joints is wrong. The values ``dilatancy``
    # and ``friction`` are the two coefficients of the first joint, or the defaults.
    DILATANCY_LOW = "dilatancy low"
    # Some supports have no function, because no movable block, fill, tie or prop touches them. Value:
    # ``blocks``, the names of these supports.
    IDLE_SUPPORTS = "idle supports"
    # Some joints at supports resist by friction although no load presses their blocks together. Value:
    # ``pairs``, the two blocks of each such joint.
    HELD_BY_CLAMPING = "held by clamping"
    # Some blocks are far away from all other blocks. The value ``blocks`` lists the names of the blocks far
    # away. The value ``distance`` is the distance of the nearest group of these blocks from the box around
    # all other blocks. The value ``size`` is the diagonal of this box.
    FAR_AWAY = "far away"
    # Unit weights of blocks differ so much that some of them probably have a wrong unit. The value ``blocks``
    # lists the blocks with an unusual unit weight. The value ``median`` is the median of all unit weights,
    # and ``ratio`` is the unit weight of the first listed block divided by the median. The value ``per_area``
    # is True if unit weights are per area (in the plane without a thickness).
    WEIGHTS_DIFFER = "weights differ"
    # The unit weight of a fill or backing is so large or so small that its unit is probably wrong. The value
    # ``fill`` is the number of the fill, from 1, and ``backing`` is True for its backing. The value
    # ``unit_weight`` is the unit weight of this fill or backing. The value ``other`` is the median unit
    # weight of the blocks, or of all fills and backings if the blocks are weightless. The value ``beside``
    # is "blocks" or "fill", and states which of these two medians ``other`` is.
    FILL_WEIGHT_DIFFERS = "fill weight differs"
    # The friction angle of a fill or backing is so small that it may be a tangent, or an angle in radians.
    # The value ``fill`` is the number of the fill, from 1, and ``backing`` is True for its backing. The value
    # ``friction_angle`` is in degrees.
    FILL_ANGLE_LOW = "fill angle low"
    # The backing of a fill has no effect, because it touches no block. Either its upper line is below all
    # blocks, or blocks separate the backing from the road above the fill. Value: ``fill``, the number of the
    # fill, from 1.
    IDLE_BACKING = "idle backing"
    # The strength or prestress of a tie or prop is so small or so large that its unit is probably wrong. The
    # value ``kind`` is "tie" or "prop", ``name`` is its name, ``key`` is "strength" or "prestress", and
    # ``value`` is this force. The value ``weight`` is a force for comparison. It is the median block weight
    # if ``value`` is too small, and the sum of all dead loads if ``value`` is too large.
    STRENGTH_DIFFERS = "strength differs"
    # The unit of a strength or cohesion of joints seems not to match the units of the weights. The value
    # ``key`` is "strength" or "cohesion", and ``value`` is this strength or cohesion. The value ``weight`` is
    # a stress for comparison: the stress at the foot of a column of blocks. The column has the median unit
    # weight, and is as high as the largest dimension of the scene.
    STRESS_DIFFERS = "stress differs"
    # The unit weight of the blocks looks like a weight per cubic metre, but the scene is too large for
    # metres. The value ``extent`` is the largest dimension of the movable blocks, and ``unit_weight`` is the
    # median unit weight.
    LENGTHS_DIFFER = "lengths differ"
    # Small gaps between blocks carry no force. The values ``pairs`` and ``widths`` list the two blocks and
    # the width of each gap. The value ``option`` is the option of the scene that closes all gaps ("tolerance"
    # or "contact_tolerance"), and ``tolerance`` is the value to set.
    SMALL_GAPS = "small gaps"
    # Blocks face each other but have no joint, because their sides are too short compared with the option
    # ``tolerance`` of the scene. The values ``pairs`` and ``widths`` list the two blocks and the width of
    # each gap.
    LOST_JOINTS = "lost joints"
    # The option ``tolerance`` of the scene is so large that it closes gaps as wide as mortar joints. The
    # values ``pairs`` and ``widths`` list the two blocks and the width of each gap. The value ``aligning`` is
    # the ``tolerance`` that would make the sides of the gaps parallel. It is 0 in three cases:
    # - The present ``tolerance`` is sufficient.
    # - The angles are too large to be errors of the drawing.
    # - A sufficient ``tolerance`` would remove joints of solids.
    BRIDGED_BY_TOLERANCE = "bridged by tolerance"
    # The alignment rotated some joints. The value ``pairs`` lists the two blocks of each rotated joint. The
    # value ``turn`` is the largest rotation, in radians, and ``tolerance`` is the scene's tolerance.
    ALIGNED = "aligned"
    # Joints of one block are nearly parallel. Values:
    # - ``pairs``: the two blocks of each joint.
    # - ``angle``: the largest angle between two joints, in radians.
    # - ``scatter``: the ratio of the upper to the lower quartile of the angles.
    # - ``tolerance``: a setting of the scene's option ``tolerance`` with which the joints become parallel.
    NEARLY_PARALLEL = "nearly parallel"
    # At least half of the pairs of blocks that touch have several joints that are nearly parallel, because
    # the sides of the blocks are not flat. The value ``pairs`` lists these pairs of blocks. The values
    # ``angle`` and ``tolerance`` have the same meaning as for ``NEARLY_PARALLEL``.
    UNEVEN_SIDES = "uneven sides"
    # Two blocks have a joint although only their corners touch (in space, only parallel edges). Values:
    # - ``pairs``: the two blocks of each such joint.
    # - ``wedge``: the width of the widest gap that begins at such corners and is narrow enough to be mortar;
    #   0 if there is none.
    JOINT_AT_CORNERS = "joint at corners"
    # Blocks meet only at corners, without a joint. Value: ``pairs``, the names of these blocks.
    CORNERS_MEET = "corners meet"
    # Blocks in space touch without a common normal, so they have no joint. Value: ``pairs``, the names of
    # these blocks.
    WITHOUT_NORMAL = "without normal"
    # The order of the vertices was reversed in some faces of a solid. Value: ``blocks``, the names of the
    # solids.
    FACES_TURNED = "faces turned"
    # Corners press on edges of limited strength. The value ``pairs`` lists the two blocks of each joint at
    # such a corner. The value ``normal_forces`` lists the normal forces of the joints, largest first; it is
    # empty if the result has no load factor.
    CORNERS_BEAR = "corners bear"
    # A part of an edge load has no effect, because it is not on a free edge of a movable block. The value
    # ``number`` is the number of the edge load, from 1, and ``length`` is the length of the part.
    BARE_EDGE_LOAD = "bare edge load"
    # The scene was solved without its axles. Value: ``names``, the names of the groups of axles.
    AXLES_LEFT_OUT = "axles left out"
    # A force acts outside of its block. The value ``load`` is "live" or "dead". The value ``blocks`` lists
    # the blocks with a force outside. The value ``distance`` is the distance of the first of these forces
    # from its block.
    ACTS_OUTSIDE = "acts outside"
    # Forces on blocks are so large or so small compared with the weights that their unit is probably wrong.
    # The value ``load`` is "live" or "dead". The value ``blocks`` lists the blocks with an unusual force. The
    # value ``ratio`` is the force on the first of these blocks divided by its weight. A large force on a
    # light block is divided by the median weight instead.
    FORCES_DIFFER = "forces differ"
    # The gravitational acceleration of a kinematic check seems not to be in the case's unit of length.
    # The value ``gravity`` is the acceleration, ``extent`` is the largest dimension of the movable blocks,
    # and ``period`` is the secant period in seconds.
    GRAVITY_DIFFERS = "gravity differs"


#: Map from a reason code to the names of its values that are load factors. If a method solves a problem with
#: modified loads, it converts these values to load factors of the scene's own loads.
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
    """Reason or warning, as a code with the values that its message needs."""

    code: Code  #: code of the reason or warning
    #: Values of the reason by name. The page "Messages" of the guide lists all codes.
    values: dict[str, Any] = field(default_factory=dict)

    def as_dict(self) -> dict[str, Any]:
        """Return the code and its values in one dictionary."""
        return {"code": str(self.code), **self.values}


def reason(code: Code, **values: Any) -> Reason:
    """Return a reason with the given code and values."""
    return Reason(code, values)


def size_of(problem: Problem) -> dict[str, int]:
    """Return {"joints": number of joints}; in space, {"contacts": number of contact points}."""
    return {problem.layout.called: problem.joints}

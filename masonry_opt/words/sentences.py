"""Sentences from reason codes: the one place that writes how an analysis ended, and what looks unintended.

Sentences that advise another method or option depend on the method that ended, so that no advice is
impossible or followed already. Reasons without a method get advice that names the method too.
"""

from collections.abc import Callable, Sequence
from math import inf, radians, tan
from typing import Any

from masonry_opt.answer.reasons import Code, Reason, Status
from masonry_opt.answer.thresholds import PLATEAU
from masonry_opt.errors import counted, rounded_up
from masonry_opt.problem.faces import CHORDS, MISSED, Layout
from masonry_opt.scene.geometry import set_tolerance
from masonry_opt.words.names import blocks, do, pairs, verb

_FIXED = 1e10  #: From here on seven decimals are more digits than a double has.

#: Ratio of dead loads from which on they may be why nothing is borne out: it leaves solvers a digit or two.
_VERY_DIFFERENT = 1e7

#: How joints crush in all programs but the conic ones.
BY_CHORDS = f"{len(CHORDS.slope)} chords inside the parabola, at most {100 * MISSED:.2f} % below it"


def by_sides(layout: Layout) -> str:
    """How friction is limited by polygons in space."""
    missed = 100 * (1 - layout.factor)
    return f"by the polygon of {len(layout.senses)} sides inside the cone, at most {missed:.2g} % below it"


_RESIDUALS = {"work": "work of forces out of balance", "block": "equilibrium of one block"}
_RESIDUALS |= {"joint": "yield of one joint"}

_OF_JOINTS = {
    Status.LOCKED: "joints that slide but cannot open as associative flow demands",
    Status.UNLIMITED: "joints that carry the live load",
    Status.JAMMED: "joints whose normal forces grow most",
}

#: Methods whose user chooses the solver.
_SOLVER_IS_CHOSEN = frozenset({"static", "kinematic", "nonassociative"})

#: Remedies of the loop in words, by the option of the loop that they change.
_REMEDIES = {
    "sub_problems": "sub-problems solved accurately",
    "alpha": "a smaller slope of the shear limits",
    "beta": "more damping of the normal forces",
    "start": "a first sub-problem whose joints have cohesion in place of friction",
    "solver": "another solver",
}


def message(reasons: Sequence[Reason], method: str = "") -> str:
    """Return how an analysis by a method ended, as one sentence; see :func:`sentences`."""
    return "; ".join(sentences(reasons, method))


def sentences(reasons: Sequence[Reason], method: str = "") -> tuple[str, ...]:
    """Return a sentence for each reason.

    ``method`` is the name of the method that ended for these reasons; "" if it is not known.
    """
    return tuple(_sentence(reason, method) for reason in reasons)


def _sentence(reason: Reason, method: str) -> str:
    made, values = _SENTENCES[reason.code], {**reason.values, "method": method}
    return made.format(**values) if isinstance(made, str) else made(values)


def _by_loop(v: dict[str, Any], advice: str) -> str:
    """Return advice for the loop; a user of another method is told to take the loop first."""
    return advice if v["method"] == "nonassociative" else f"take method 'nonassociative' and {advice}"


def _try_another_solver(v: dict[str, Any]) -> str:
    if not v["method"] or v["method"] in _SOLVER_IS_CHOSEN:
        return "try another solver"
    return "try method 'nonassociative', whose solver can be chosen"


def numeral(value: float, spec: str) -> str:
    """A number in a format, without a sign if all its digits are zero, and with a power of ten where decimals
    would show more digits than it has."""
    if spec.endswith("f") and _FIXED <= abs(value) < inf:
        spec = f"{spec[:-1]}e"
    text = format(value + 0.0, spec)
    return text if any(digit in text.partition("e")[0] for digit in "123456789nf") else text.lstrip("+-")


def _slide(v: dict[str, Any]) -> str:
    return f"{pairs(v)} {verb(len(v['pairs']), 'slide')}" if v["pairs"] else "joints slide"


def _not_hinging(v: dict[str, Any]) -> str:
    """Return why no finite motion is followed: joints slide, or λ is not that of the hinging mechanism."""
    if v["pairs"]:
        return f"only mechanisms of hinges are followed, and at the onset {_slide(v)}"
    if "turning" in v:
        alone = numeral(v["turning"], ".6g")
        return f"λ is not that of the body that turns by itself ({alone}): other joints drag on it"
    most = "unlimited" if v["associative"] is None else numeral(v["associative"], ".6g")
    return (
        f"λ is below the associative load factor ({most}), and the capacity curve follows only the hinging "
        "mechanism of the associative solution: compute the curve with method 'static'"
    )


def _friction_would_hold(v: dict[str, Any]) -> str:
    slides = _slide(v)
    if v["factor"] is not None:
        much = f"with all friction at least {rounded_up(v['factor'])} times as high"
    elif v["above"] > 1:
        much = f"if they could not; even {v['above']:.4g} times the friction is not enough"
    else:
        much = "with enough friction"
    hangs = "only the friction of joints that bear nothing from below could hold what hangs,"
    return f"{slides}: {hangs if v['hangs'] else 'the scene would stand'} {much}"


def _states_met(v: dict[str, Any]) -> str:
    starts = counted(v["candidates"], "start")
    if v["count"] == 1:
        return f"one exact state was found from {starts}"
    most = numeral(v["most"], ".6g")
    return f"{v['count']} different exact states were found from {starts}, the highest at λ = {most}"


def _wedged(v: dict[str, Any]) -> str:
    support = f"; support what moves, {blocks(v['blocks'])}" if v["blocks"] else ""
    found, said = v["load_factor"], ""
    if found is not None:
        below = "below zero" if found < 0 else "and from rest there is none"
        said = f"the load factor found is {numeral(found, '.4g')}, {below}: "
    wedging = "the dead load is carried by wedging alone, which the joints' flow rule does not sustain"
    return f"{said}{wedging}{support}"


def _undecided(v: dict[str, Any]) -> str:
    undecided = "whether the scene stands under its dead load could not be decided"
    check = f"{_try_another_solver(v)}, or a little more friction"
    if v["ratio"] > _VERY_DIFFERENT:
        check = f"one block's dead load is {v['ratio']:.0e} times another's, so check units and weights"
    return f"{undecided}: neither forces nor a mechanism were verified ('{v['word']}'); {check}"


def _other_contacts(v: dict[str, Any]) -> str:
    times, word = max((v["softer"], "softer"), (1 / v["softer"], "stiffer"))
    return f"with contacts {times:.2g} times {word} λ changes by {v['change']:.2%}"


def _joints_or_points(v: dict[str, Any]) -> str:
    return counted(v["contacts"], "contact point") if "contacts" in v else counted(v["joints"], "joint")


def _ranged(ends: tuple[float, float] | None) -> str:
    return "none" if ends is None else "–".join(numeral(end, ".4g") for end in ends)


def _not_certified(v: dict[str, Any]) -> str:
    left = ", ".join(
        "the live load drives nothing" if value == inf else f"{_RESIDUALS.get(name, name)} {value:.1e}"
        for name, value in v["residuals"].items()
    )
    found = f"the load factor {numeral(v['load_factor'], '.6g')} is not verified by its certificate"
    sizes = "look for weights or lengths of very different size"
    return f"{found} ({left}): {_try_another_solver(v)}, and {sizes}"


def _on_the_way(v: dict[str, Any]) -> str:
    """Return the largest load factor of a load history, and how far λ fell before it."""
    said = "" if v["peak"] is None else f"; before that λ was as large as {numeral(v['peak'], '.6g')}"
    if v["deep_fall"] is not None:
        load_factor, share = v["deep_fall"]
        fell = f"by up to {share:.0%}, first from {numeral(load_factor, '.6g')}"
        said += f"; λ fell {fell}, where the scene may collapse already, and rose again"
    return said


def _repeats(v: dict[str, Any]) -> str:
    every = counted(v["period"], "sub-problem")
    repeats = f"the loop repeats itself every {every}, between load factors {_between(v)}"
    if v["exact"]:
        return f"{repeats}, and this state is exact"
    advice = _by_loop(v, "lower 'beta'")
    return f"{repeats}: {advice}"


def _began_again(v: dict[str, Any]) -> str:
    remedies = ", then with ".join(map(_remedy, v["remedies"]))
    words = f"the first run of the loop ended '{v['first']}', so the loop was run again with {remedies}"
    return f"{words}; no run came to an end" if v["in_vain"] else words


def _remedy(changed: str) -> str:
    """Return a changed option of the loop, such as "beta=0.3", in words."""
    option = changed.partition("=")[0]
    return f"{_REMEDIES[option]} ({changed})"


def _dilatancy_locks(v: dict[str, Any]) -> str:
    locks = (
        "with associative flow, joints that dilate as they slide lock the blocks, which then carry any "
        "multiple of the live load; with the joints' own dilatancy the blocks can move"
    )
    return locks if v["method"] in ("mcp", "refined") else f"{locks}: method 'mcp' looks for their collapse"


def _push_stopped(v: dict[str, Any]) -> str:
    ended = (
        f"the load history from rest led to no collapse state ({v['word']}; {counted(v['steps'], 'step')})"
    )
    if v["looped"]:
        ended += ", and the loop led to none"
        return (
            ended if v["method"] == "refined" else f"{ended}: method 'refined' with search=10 looks for one"
        )
    return f"{ended}: method 'mcp' looks for one in other ways" if v["method"] in ("", "compliant") else ended


def _bracket(v: dict[str, Any]) -> str:
    least, most = (max(v[of], 0.0) + 0.0 for of in ("bound", "load_factor"))  # what is less is rounding
    return f"{least:.6g} ≤ λ ≤ {most:.6g}"


def _imposed(v: dict[str, Any]) -> str:
    imposed = [] if v["rates"] is None else [f"slips and openings that sum to at most {v['rates']:g}"]
    imposed += ["normal forces up to ten times all loads"] if v["forces"] else []
    return f"{' and '.join(imposed)}, which had to be assumed"


def _between(v: dict[str, Any]) -> str:
    return f"{numeral(v['lowest'], '.6g')} and {numeral(v['highest'], '.6g')}"


def _curve(v: dict[str, Any]) -> str:
    missing = f" ({v['left_out']} more were not found)" if v["left_out"] else ""
    falls = ", does not fall"
    if v["peak"] - v["last"] > PLATEAU * v["peak"]:
        falls = f", falls from {numeral(v['peak'], '.4g')} to {numeral(v['last'], '.4g')}"
    return f"λ over displacement, in {counted(v['states'], 'state')}{missing}{falls}"


def _grown(v: dict[str, Any]) -> str:
    ends = "λ stays constant as blocks move on"
    if v["beyond"] is not None:
        ends = f"under λ = {numeral(v['beyond'], '.6g')} blocks do not come to rest"
    return f"the largest load that was carried as it grew, with contacts that remember slip; {ends}"


def _rounded(value: float) -> str:
    """Return a number of three significant digits, such as 18000."""
    return f"{float(f'{value:.3g}'):g}"


def _weights_differ(v: dict[str, Any]) -> str:
    own, median = _rounded(v["ratio"] * v["median"]), _rounded(v["median"])
    quantity = "weight per area" if v["per_area"] else "unit weight"
    said = f"the {quantity} of {blocks(v['blocks'])} is {own}"
    return f"{said}, the median of all blocks is {median}: give weights and lengths in one unit each"


def _fill_weight_differs(v: dict[str, Any]) -> str:
    own, other = _rounded(v["unit_weight"]), _rounded(v["other"])
    what = f"{'the backing of ' if v['backing'] else ''}fill no. {v['fill']}"
    return f"the unit weight of {what} is {own}, that of the {v['beside']} {other}: give both in one unit"


def _strength_differs(v: dict[str, Any]) -> str:
    own, weight = _rounded(v["value"]), _rounded(v["weight"])
    beside = "all dead loads together" if v["value"] > v["weight"] else "the median weight of a block"
    said = f"the {v['key']} of {v['kind']} '{v['name']}' is {own}, {beside} {weight}"
    return f"{said}: give forces and weights in one unit"


def _friction_high(v: dict[str, Any]) -> str:
    angle = v["friction"]
    meant = f": in degrees? tan {angle:g}° = {tan(radians(angle)):.3f}" if angle < 90 else ""
    return f"friction {angle:g} of {_where(v)} is more than dry joints have{meant}"


def _where(v: dict[str, Any]) -> str:
    """The joints named, or all those that are not."""
    return f"joint {pairs(v)}" if v["pairs"] else "[joints]"


def _small_gaps(v: dict[str, Any]) -> str:
    wide = [f"up to {rounded_up(width, 2)} wide" for width in v["widths"]]
    return (
        "blocks face each other across a small gap, which carries no force and may change λ a lot: "
        f"{pairs(v, wide)}; if they should touch, {set_tolerance(v['tolerance'])}, which closes the gaps and "
        "makes nearly parallel joints parallel"
    )


def _corners_bear(v: dict[str, Any]) -> str:
    forces = [f"{force:.4g}" for force in v["normal_forces"]]
    where = f"crushing at {pairs(v)} may cause a collapse that no load causes here"
    if forces:
        where = f"at collapse they press with the forces in brackets, {pairs(v, forces)}"
    limits = "'strength' limits no force where a corner stands on an edge"
    return f"{limits}, so check by hand that these corners do not crush: {where}"


#: By code: a text with values in braces, or what makes one of the values.
_SENTENCES: dict[Code, str | Callable[[dict[str, Any]], str]] = {
    Code.FALLS: lambda v: f"the dead load alone moves {blocks(v['blocks'])}: support what falls",
    Code.HANGS: lambda v: f"{do(v, 'hang')}: no joint bears from below",
    Code.NO_FRICTION_HOLDS: lambda v: f"no friction can hold {blocks(v['blocks'])}",
    Code.FRICTION_WOULD_HOLD: _friction_would_hold,
    Code.STRENGTH_WOULD_HOLD: "joints crush: with more 'strength' the scene would stand",
    Code.DEAD_LOAD_UNDECIDED: _undecided,
    Code.WEDGED: _wedged,
    Code.BELOW_ZERO: lambda v: (
        f"an exact state has λ = {numeral(min(v['load_factor'], 0.0), '.4g')}, not above zero: the scene "
        "carries its dead load from rest, but would fall by itself with the forces of that state"
    ),
    Code.STOPPED_SHORT: (
        "the solver stopped short of its tolerance ('{word}'): the certificate says what is left"
    ),
    Code.SOLVER_STOPPED: lambda v: f"the solver stopped with '{v['word']}': {_try_another_solver(v)}",
    Code.DILATANCY_LOCKS: _dilatancy_locks,
    Code.NO_MECHANISM: (
        "no mechanism lets the live load do work, so the scene carries any multiple of it: "
        "check the direction of 'live' and which blocks carry it"
    ),
    Code.NO_COLLAPSE: lambda v: (
        "proven: no load factor λ ≥ 0 exists; in every mechanism in which the live load does work, some "
        f"moving joints cannot yield together ({counted(v['static_cuts'], 'set')} of yield conditions that "
        f"exclude each other and {counted(v['kinematic_cuts'], 'set')} of which one must move prove it)"
    ),
    Code.CARRIES_ANY: (
        "proven: forces within friction carry any multiple of the live load; not proven: that no collapse "
        "state exists, because a mechanism exists"
    ),
    Code.CLAMPED: lambda v: (
        f"by self-stress that no load causes, these joints carry the live load in both directions: {pairs(v)}"
    ),
    Code.JOINTS: lambda v: f"{_OF_JOINTS[v['status']]}: {pairs(v)}",
    Code.NO_WORK: lambda v: (
        "permanent forces (dead load, prestress, earth pressure) drive the mechanism, "
        "once the live load, which "
        + ("resists it" if v["against"] else "does no work in it")
        + ", has taken enough pressure off the joints"
        + ("; equilibrium alone fixes all forces, so no other λ above zero is possible" if v["fixed"] else "")
    ),
    Code.NOT_CERTIFIED: _not_certified,
    Code.ABOVE_ASSOCIATIVE: "ended {by:.1e} above the associative bound, reported here",
    Code.FLOW_RULE_IDLE: lambda v: (
        "the associative answer already obeys the joints' own flow rule; to look for a lower one, "
        + _by_loop(v, "set option 'always'")
    ),
    Code.STILL_CHANGES: lambda v: (
        f"λ still changes after {counted(v['count'], 'sub-problem')}, lately between {_between(v)}: "
        + _by_loop(v, "raise 'max_iterations', or lower 'beta'")
    ),
    Code.GROWS: lambda v: (
        f"the loop found no limit: λ is {v['load_factor']:.3g} after {counted(v['count'], 'sub-problem')} "
        "and grows on, because joints that press ever harder hold the blocks; real joints would crush first: "
        "check the direction of 'live', the supports and the friction"
    ),
    Code.REPEATS: _repeats,
    Code.SUB_PROBLEM_FAILED: lambda v: (
        f"sub-problem {v['number']} ended with '{v['word']}': {_try_another_solver(v)}"
    ),
    Code.SUB_PROBLEM_EMPTY: lambda v: (
        f"sub-problem {v['number']} has no equilibrium state, because contacts that lost their normal force "
        "have locked: " + _by_loop(v, "lower 'alpha', or choose an interior-point solver")
    ),
    Code.BEGAN_AGAIN: _began_again,
    Code.LEAST_BORNE_OUT: lambda v: (
        "no load factor of a sub-problem is verified by its own state"
        if v["load_factor"] is None
        else f"the lowest load factor that its own state verifies is {numeral(v['load_factor'], '.6g')}"
    ),
    Code.PUSH_STOPPED: _push_stopped,
    Code.DILATANCY_FALLS: "not computed, because dilatancy falls with stress: only the loop can follow it",
    Code.PLATEAU: lambda v: (
        f"in {counted(v['steps'], 'step')}, with contacts that give by {v['give']:.0e} of the motion; "
        + _other_contacts(v)
    ),
    Code.NO_PLATEAU: lambda v: (
        "uncertain: " + ("softer contacts have no state" if v["change"] is None else _other_contacts(v))
    ),
    Code.RAY: lambda v: (
        f"the live load was raised from rest in {counted(v['steps'], 'step')} "
        f"until displacements grew without limit{_on_the_way(v)}"
    ),
    Code.LEVEL: lambda v: (
        f"the load–displacement curve levels off after {counted(v['steps'], 'step')}: λ is constant while "
        "the displacement grows tenfold" + _on_the_way(v)
    ),
    Code.JAMS: lambda v: (
        f"no collapse in a load history of {counted(v['steps'], 'step')}: λ keeps growing, as joints press "
        "ever harder"
    ),
    Code.NOT_EXPECTED: lambda v: (
        f"not computed for {_joints_or_points(v)}: method 'compliant' computes it, and takes long"
    ),
    Code.CURVE: _curve,
    Code.SPREAD: lambda v: (
        f"incremental λ of {counted(v['draws'], 'draw')} each: {_ranged(v['stiffness'])} with other "
        f"stiffness of contacts, {_ranged(v['stress'])} from other self-stress"
        + (f" ({v['without']} of these load histories led to no collapse)" if v["without"] else "")
    ),
    Code.GROWN: _grown,
    Code.LOCAL_MINIMUM: "a local minimum, complementary to within ε = {epsilon:.0e}",
    Code.START_FAILED: "the loop to start from failed",
    Code.RELAXATION_STOPPED: "IPOPT ended with '{word}' at ε = {epsilon:.0e}",
    Code.NOTHING_SOLVED: "no relaxation was solved: give a smaller 'epsilon', or a result as 'start'",
    Code.STATES_MET: _states_met,
    Code.FEW_STARTS: lambda v: (
        f"all load factors agree, which proves little after {counted(v['candidates'], 'start')}, because "
        "equilibrium does not fix the forces"
    ),
    Code.SEARCHED: lambda v: (
        f"lower states were searched for from {counted(v['candidates'], 'start')}"
        + (" until the search was interrupted" if v["interrupted"] else "")
    ),
    Code.NOT_REFINED: "not refined: no exact state was found",
    Code.NO_TIME: "not refined: the time was over before an exact state was found: raise 'search'",
    Code.PROVEN: lambda v: f"proven least: {_bracket(v)}",
    Code.WITHIN_IMPOSED: lambda v: f"proven least of all states with {_imposed(v)}: {_bracket(v)}",
    Code.TOUCHES_IMPOSED: lambda v: f"nothing is proven: the answer exceeds {_imposed(v)}",
    Code.OUT_OF_TIME: lambda v: (
        f"not proven least; bounds of the least λ after {v['time_limit']:g} s: {_bracket(v)}"
    ),
    Code.OUT_OF_TIME_WITHIN_IMPOSED: lambda v: (
        f"not proven least; bounds after {v['time_limit']:g} s, for states with {_imposed(v)}: {_bracket(v)}"
    ),
    Code.NO_EXACT_STATE: "no exact state was found within {time_limit:g} s: raise 'time_limit'",
    Code.REACHES_ZERO: "λ has come down to zero: the masonry falls by itself from here",
    Code.JOINT_CLOSES: lambda v: f"the joint between {pairs(v)} closes",
    Code.JOINT_OPENS: lambda v: f"the joint between {pairs(v)} opens",
    Code.NOT_HINGING: _not_hinging,
    Code.JOINTS_SLIDE: lambda v: f"{_slide(v)} from here on: no finite motion is followed",
    Code.BLOCKS_MEET: lambda v: f"{do(v, 'meet')} where there is no joint",
    Code.LOCKS: "the mechanism locks: from here on it has no motion of finite size",
    Code.BRANCHES: "several motions are possible from here on: blocks have come free",
    Code.STILL_CARRIES: lambda v: f"λ is not at zero after {counted(v['steps'], 'state')}",
    Code.FORCES_UNDECIDED: "HiGHS did not find the forces of the next state: ask for other states ('steps')",
    Code.FRICTION_HIGH: _friction_high,
    Code.DILATANCY_LOW: lambda v: (
        f"'dilatancy' {v['dilatancy']:g} of {_where(v)} is below minus its friction, {v['friction']:g}: "
        "sliding would close the joint by more than friction resists; is its sign meant?"
    ),
    Code.IDLE_SUPPORTS: lambda v: (
        f"{blocks(v['blocks'])}, fixed, {verb(len(v['blocks']), 'touch')} no block that can move, "
        "and no tie or prop ends there: close the gap if blocks should rest there"
    ),
    Code.HELD_BY_CLAMPING: lambda v: (
        f"blocks are held between supports by joints that no load presses together, {pairs(v)}: give the "
        "load that clamps them, or set their friction to 0"
    ),
    Code.FAR_AWAY: lambda v: (
        f"{do(v, 'stand')} {v['distance']:.3g} away from the rest, whose size is {v['size']:.3g}: are the "
        "coordinates in one unit?"
    ),
    Code.SMALL_GAPS: _small_gaps,
    Code.ALIGNED: lambda v: (
        f"joints were turned by up to {v['turn']:.2g} rad to be parallel or square to others within the "
        f"tolerance, {v['tolerance']:.3g}: {pairs(v)}; if they are meant to be wedges, lower 'tolerance'"
    ),
    Code.NEARLY_PARALLEL: lambda v: (
        f"joints of one block are up to {v['angle']:.2g} rad off parallel, a wedge that must lift a block to "
        f"slide: {pairs(v)}; if they are meant to be parallel, {set_tolerance(v['tolerance'])}"
    ),
    Code.CORNERS_MEET: lambda v: (
        f"{pairs(v)} meet at corners only, where no joint holds them: a joint needs an edge of a block"
    ),
    Code.WITHOUT_NORMAL: lambda v: (
        f"{pairs(v)} meet corner on corner, corner on edge or edge along edge, where there is no normal and "
        "no joint holds them: a joint needs a face of one of the blocks, or edges that cross"
    ),
    Code.FACES_TURNED: lambda v: (
        f"faces of {blocks(v['blocks'])} list their corners in different senses; all were turned outwards: "
        "check the order of the corners"
    ),
    Code.CORNERS_BEAR: _corners_bear,
    Code.BARE_EDGE_LOAD: (
        "edge_load no. {number} meets no free edge of a movable block along {length:.4g} of its "
        "length, where it does nothing"
    ),
    Code.AXLES_LEFT_OUT: lambda v: (
        f"axles {', '.join(repr(name) for name in v['names'])} are left out, as they move: see 'crossing'"
        if v["names"]
        else "axles, which the load case names, are left out, as they move: see 'crossing'"
    ),
    Code.WEIGHTS_DIFFER: _weights_differ,
    Code.FILL_WEIGHT_DIFFERS: _fill_weight_differs,
    Code.STRENGTH_DIFFERS: _strength_differs,
    Code.ACTS_OUTSIDE: lambda v: (
        f"the {v['load']} force of {blocks(v['blocks'])} acts {v['distance']:.3g} outside of the block: is "
        f"'{v['load']}_at' (of a load: 'at') in the scene's coordinates?"
    ),
    Code.FORCES_DIFFER: lambda v: (
        f"the {v['load']} force on {blocks(v['blocks'])} is {v['ratio']:.3g} times the weight there: are "
        "forces and weights in one unit?"
    ),
}

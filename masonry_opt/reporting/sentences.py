"""Write sentences from reason codes: how an analysis ended, and which inputs look unintended.

Advice depends on the method of the analysis: no sentence recommends an option that the method lacks, or the
method itself. If the method is not known, the advice names one. Sentences on inputs are in
:mod:`~.reporting.inputs`.
"""

from collections.abc import Callable, Sequence
from math import inf
from typing import Any

from masonry_opt.errors import counted, rounded, rounded_up
from masonry_opt.reporting.inputs import INPUT_SENTENCES
from masonry_opt.reporting.names import blocks, do, pairs, some, verb
from masonry_opt.solution.reasons import Code, Reason, Status
from masonry_opt.solution.thresholds import SLIDES

#: Numbers of at least this size are printed with a power of ten instead of decimals. Decimals would show more
#: digits than a floating-point number has.
_LARGEST_WITH_DECIMALS = 1e10

#: If the ratio of the largest to the smallest dead load of a block exceeds this value, a message names the
#: ratio as the reason for undecided stability. At this ratio, the answers of solvers have only one or two
#: correct digits.
_VERY_DIFFERENT = 1e7

#: Names of residuals in messages, by the key of the residual.
_RESIDUAL_NAMES = {
    "work": "work of forces out of balance",
    "block": "equilibrium of one block",
    "joint": "yield of one joint",
}

#: Description of the joints that a message lists, by the status of the result.
_JOINT_DESCRIPTIONS = {
    Status.LOCKED: "joints that slide but cannot open, although associative flow requires that they open",
    Status.UNLIMITED: "joints that carry the live load",
    Status.JAMMED: "joints whose normal forces grow most with the live load",
}

#: Methods that let the user choose the solver.
_SOLVER_IS_CHOSEN = frozenset({"static", "kinematic", "nonassociative"})

#: Options that may be changed before the loop of linear programs is run again, with a description of each
#: change.
_REMEDIES = {
    "sub_problems": "sub-problems solved accurately",
    "alpha": "a smaller slope of the shear limits",
    "beta": "more damping of the normal forces",
    "start": "a first sub-problem whose joints have cohesion in place of friction",
    "solver": "another solver",
}


def message(reasons: Sequence[Reason], method: str = "") -> str:
    """Return the sentences of :func:`sentences` as one text, with semicolons between them."""
    return "; ".join(sentences(reasons, method))


def sentences(reasons: Sequence[Reason], method: str = "") -> tuple[str, ...]:
    """Return the sentences that describe the reasons of a result, one for each reason.

    ``method`` is the name of the method that ended for these reasons; "" if it is not known.
    """
    return tuple(_sentence(reason, method) for reason in reasons)


def _sentence(reason: Reason, method: str) -> str:
    """Return the sentence that describes one reason; see :func:`sentences`."""
    template = _SENTENCES[reason.code]
    values = {**reason.values, "method": method}
    return template.format(**values) if isinstance(template, str) else template(values)


def _by_loop(v: dict[str, Any], advice: str) -> str:
    """Return advice on options of method "nonassociative", and to use this method if another was used.

    ``advice`` names the options to change.
    """
    return advice if v["method"] == "nonassociative" else f"use method 'nonassociative' and {advice}"


def _try_another_solver(v: dict[str, Any]) -> str:
    """Return the advice to choose another solver, or a method whose solver can be chosen."""
    if not v["method"] or v["method"] in _SOLVER_IS_CHOSEN:
        return "try another solver"
    return "try method 'nonassociative', whose solver can be chosen"


def numeral(value: float, spec: str) -> str:
    """Return a number as text (a numeral), in a format such as ".6g".

    A number that rounds to zero has neither sign nor exponent. Large numbers have an exponent, no decimals.
    """
    if spec.endswith("f") and _LARGEST_WITH_DECIMALS <= abs(value) < inf:
        spec = f"{spec[:-1]}e"
    text = format(value + 0.0, spec)
    digits, power, _ = text.partition("e")
    if any(digit in digits for digit in "123456789nf"):
        return text
    return "0" if power else text.lstrip("+-")


def _carried(v: dict[str, Any]) -> str:
    """Return a sentence about the forces that carry the dead load of a stable scene.

    The sentence says if other forces can carry the dead load too.
    """
    if v["unique"]:
        return "equilibrium alone fixes the resultants of all joints"
    many = "one of many sets of forces that carry the dead load"
    if v["elastic"]:
        return f"the forces shown were computed with elastic contacts and are {many}"
    return f"the forces shown were computed by optimisation, may contain self-stress, and are {many}"


def _slide(v: dict[str, Any]) -> str:
    """Return a clause that says which joints slide, by name if the names are known."""
    return f"{pairs(v)} {verb(len(v['pairs']), 'slide')}" if v["pairs"] else "joints slide"


def _slip(v: dict[str, Any]) -> str:
    """Return a clause with the largest slip, and the slip up to which a joint counts as a hinge.

    The text is "" in space.
    """
    if "slip" not in v:
        return ""
    slip, most = numeral(100 * v["slip"], ".2g"), numeral(100 * SLIDES, "g")
    return (
        f": the largest slip is {slip} % of the speed of the fastest corner "
        f"(a joint with a slip of up to {most} % counts as a hinge)"
    )


def _slides_on(v: dict[str, Any]) -> str:
    """Return the sentence that a capacity curve ends because joints begin to slide."""
    return f"the capacity curve cannot follow sliding mechanisms, and from here on {_slide(v)}{_slip(v)}"


def _not_hinging(v: dict[str, Any]) -> str:
    """Return the reason why no finite motion is computed, such as joints that slide."""
    if v["pairs"]:
        return f"only hinging mechanisms can be followed, but at the onset of collapse {_slide(v)}{_slip(v)}"
    if "turning" in v:
        alone = numeral(v["turning"], ".6g")
        return (
            "joints away from the edge of rotation resist the mechanism: λ differs from "
            f"{alone}, the load factor for a rotation without this resistance"
        )
    most = "unlimited" if v["associative"] is None else numeral(v["associative"], ".6g")
    return (
        f"λ is below the associative load factor ({most}), but the capacity curve can follow only the "
        "associative mechanism: compute the curve with method 'static'"
    )


def _friction_would_hold(v: dict[str, Any]) -> str:
    """Return the sentence about a scene that is stable only with more friction.

    The sentence names the joints that slide, and the friction that would make the scene stable.
    """
    slides = _slide(v)
    if v["factor"] is not None:
        condition = f"if the friction of all joints were at least {rounded_up(v['factor'])} times as high"
    elif v["above"] > 1:
        condition = (
            f"if these joints could not slide; {v['above']:.4g} times the friction is still not enough for "
            "stability"
        )
    else:
        condition = "with enough friction"
    hangs = "the hanging blocks, which only friction can support,"
    return f"{slides}: {hangs if v['hangs'] else 'the scene'} would be stable {condition}"


def _states_met(v: dict[str, Any]) -> str:
    """Return a sentence with the number of starts of the search and the number of exact states found."""
    starts = counted(v["candidates"], "start")
    if v["count"] == 1:
        return f"one exact state was found from {starts}"
    most = numeral(v["most"], ".6g")
    return f"{v['count']} different exact states were found from {starts}, the highest at λ = {most}"


def _wedged(v: dict[str, Any]) -> str:
    """Return the sentence about a dead load that only wedged blocks could carry, and name a remedy."""
    support = f"; support {blocks(v['blocks'])}" if v["blocks"] else ""
    load_factor = v["load_factor"]
    prefix = ""
    if load_factor is not None:
        below = "which is below zero" if load_factor < 0 else "but no load factor exists from rest"
        prefix = f"the load factor found is {numeral(load_factor, '.4g')}, {below}: "
    return (
        f"{prefix}only forces between wedged blocks could carry the dead load, but such forces do not arise "
        f"under the flow rule of the joints{support}"
    )


def _undecided(v: dict[str, Any]) -> str:
    """Return the sentence about a scene whose stability is undecided, and name the inputs to check."""
    check = f"{_try_another_solver(v)}, or increase friction a little"
    if v["ratio"] > _VERY_DIFFERENT:
        check = f"check units and weights, as dead loads of blocks differ by a factor of {v['ratio']:.0e}"
    return (
        "it is undecided whether the scene is stable under its dead load: neither forces nor a mechanism "
        f"were verified ('{v['word']}'); {check}"
    )


def _joints_or_points(v: dict[str, Any]) -> str:
    """Return the number of joints (in space, of contact points) as text such as "12 joints"."""
    return counted(v["contacts"], "contact point") if "contacts" in v else counted(v["joints"], "joint")


def _ranged(ends: tuple[float, float] | None) -> str:
    """Return a range of load factors as text; "none" if the range is None."""
    return "none" if ends is None else "–".join(numeral(end, ".4g") for end in ends)


def _not_certified(v: dict[str, Any]) -> str:
    """Return the sentence about a load factor whose residuals exceed their limits, and name a remedy."""
    residuals = ", ".join(
        "the live load does no work" if value == inf else f"{_RESIDUAL_NAMES.get(name, name)} {value:.1e}"
        for name, value in v["residuals"].items()
    )
    return (
        f"the load factor {numeral(v['load_factor'], '.6g')} is not certified: residuals exceed their limits "
        f"({residuals}): {_try_another_solver(v)}, and check for weights or lengths of very different size"
    )


def _jumps(v: dict[str, Any]) -> str:
    """Return the number of jumps of a load history as text, such as " with 2 jumps"; "" without jumps."""
    return f" with {counted(v['jumps'], 'jump')}" if v["jumps"] else ""


def _repeats(v: dict[str, Any]) -> str:
    """Return the sentence about a loop that repeats a cycle of sub-problems.

    If the state is not exact, the sentence names a remedy.
    """
    period = counted(v["period"], "sub-problem")
    repeats = f"the loop of linear programs repeats a cycle of {period}, with λ between {_between(v)}"
    if v["exact"]:
        return f"{repeats}, and ends with an exact state"
    return f"{repeats}: " + _by_loop(v, "lower 'beta'")


def _began_again(v: dict[str, Any]) -> str:
    """Return a sentence that names the options that were changed to run the loop of linear programs again."""
    remedies = ", then with ".join(map(_remedy, v["remedies"]))
    words = f"the loop of linear programs ended as '{v['first']}' and was run again with {remedies}"
    return f"{words}; no run converged" if v["in_vain"] else words


def _remedy(changed: str) -> str:
    """Describe a changed option, such as "more damping of the normal forces (beta=0.3)"."""
    option = changed.partition("=")[0]
    return f"{_REMEDIES[option]} ({changed})"


def _dilatancy_locks(v: dict[str, Any]) -> str:
    """Return the sentence about dilatant joints that lock the blocks under associative flow."""
    locks = (
        "with associative flow, sliding joints dilate and lock the blocks, which then carry any "
        "multiple of the live load; with the joints' own dilatancy the blocks can move"
    )
    return (
        locks if v["method"] == "coulomb" else f"{locks}: use method 'coulomb' to look for a collapse state"
    )


def _time_limit(v: dict[str, Any]) -> str:
    """Return the sentence about an analysis that the time limit ended, and name the last phase.

    The sentence also names λ of the last step, if it is known.
    """
    ended = f"the time limit of {v['seconds']:g} s ended the analysis (in step: {v['phase']})"
    if v["carried"] is not None:
        carried = (
            f"the live load was increased from zero to λ = {numeral(v['carried'], '.6g')} without a collapse"
        )
        return f"{ended}; {carried}: raise the time limit"
    if v["last"] is not None:
        last = f"the last step reached λ = {numeral(v['last'], '.6g')}, an intermediate value, not a result"
        return f"{ended}; {last}: raise the time limit"
    return f"{ended}: raise the time limit"


def _undecided_history(v: dict[str, Any]) -> str:
    """Return the sentence about a load history that led to no collapse state, and name a remedy."""
    steps = counted(v["steps"], "step")
    history = f"the load history from rest ({v['word']}; {steps})"
    if v["looped"]:
        ended = f"neither {history} nor the loop of linear programs led to a collapse state"
        return ended if v["searched"] else f"{ended}: set option search=10 to look for a collapse state"
    ended = f"{history} led to no collapse state"
    if v["method"] not in ("", "incremental"):
        return ended
    larger = "set a larger value in mo.IncrementalSettings, or " if "setting" in v["word"] else ""
    remedy = "use method 'coulomb', which also searches for a collapse state by other algorithms"
    return f"{ended}: {larger}{remedy}"


def _bracket(v: dict[str, Any]) -> str:
    """Return the bracket of the least load factor as inequalities, such as "1.2 ≤ λ ≤ 1.3"."""
    # Rounding errors can make a bound negative; zero replaces it. Adding 0.0 removes the sign of a zero.
    least, most = (max(v[bound], 0.0) + 0.0 for bound in ("bound", "load_factor"))
    return f"{least:.6g} ≤ λ ≤ {most:.6g}"


def _imposed(v: dict[str, Any]) -> str:
    """Return the bounds on rates and forces that method "global" assumes, as text."""
    limits = [] if v["rates"] is None else [f"a sum of all slips and edge openings of at most {v['rates']:g}"]
    limits += ["normal forces of at most ten times the sum of all loads"] if v["forces"] else []
    return f"{' and '.join(limits)} (assumed limits)"


def _between(v: dict[str, Any]) -> str:
    """Return the lowest and the highest load factor of the last sub-problems, such as "1.2 and 1.3"."""
    return f"{numeral(v['lowest'], '.6g')} and {numeral(v['highest'], '.6g')}"


#: Sentence for each reason code. A sentence is a format string for the values of the reason, or a function of
#: these values.
_SENTENCES: dict[Code, str | Callable[[dict[str, Any]], str]] = {
    Code.CARRIED: _carried,
    Code.FALLS: lambda v: f"the dead load alone moves {blocks(v['blocks'])}: support the falling blocks",
    Code.HANGS: lambda v: (
        f"{do(v, 'hang')}: no joint supports {'it' if len(v['blocks']) == 1 else 'them'} from below"
    ),
    Code.NO_FRICTION_HOLDS: lambda v: f"no friction can hold {blocks(v['blocks'])}",
    Code.FRICTION_WOULD_HOLD: _friction_would_hold,
    Code.STRENGTH_WOULD_HOLD: "joints crush: with more 'strength' the scene would be stable",
    Code.TIES_WOULD_HOLD: lambda v: (
        f"{some(v['names'])} {verb(len(v['names']), 'yield')}: with more 'strength' the scene would be stable"
    ),
    Code.DEAD_LOAD_UNDECIDED: _undecided,
    Code.WEDGED: _wedged,
    Code.BELOW_ZERO: lambda v: (
        f"an exact state has λ = {numeral(min(v['load_factor'], 0.0), '.4g')}: with the joint forces of this "
        "state the scene would fall without live load, but from rest it is stable under its dead load"
    ),
    Code.STOPPED_SHORT: (
        "the solver stopped before it reached its tolerance ('{word}'): check the residuals of the "
        "certificate"
    ),
    Code.SOLVER_STOPPED: lambda v: f"the solver stopped with '{v['word']}': {_try_another_solver(v)}",
    Code.DILATANCY_LOCKS: _dilatancy_locks,
    Code.NO_MECHANISM: (
        "no mechanism lets the live load do work, so the scene carries any multiple of the live load: check "
        "the direction of 'live', and the blocks on which it acts"
    ),
    Code.NO_COLLAPSE: lambda v: (
        "proven: no load factor λ ≥ 0 exists, because every mechanism in which the live load does work needs "
        f"joints that cannot yield together; the proof consists of {counted(v['static_cuts'], 'static set')} "
        f"of conditions that cannot yield together, and {counted(v['kinematic_cuts'], 'kinematic set')} of "
        "conditions of which at least one must yield"
    ),
    Code.CARRIES_ANY: (
        "proven: for every multiple of the live load, joint forces within the friction limits exist that "
        "carry the load; the scene may collapse with other joint forces, because a mechanism exists"
    ),
    Code.CLAMPED: lambda v: (
        "self-stress, which no load causes, lets these joints carry the live load in both directions (λ and "
        f"−λ): {pairs(v)}"
    ),
    Code.JOINTS: lambda v: f"{_JOINT_DESCRIPTIONS[v['status']]}: {pairs(v)}",
    Code.NO_WORK: lambda v: (
        "permanent forces (dead load, prestress, earth pressure) drive the mechanism; the live load only "
        f"reduces the pressure on joints, and {'resists' if v['against'] else 'does no work in'} the "
        "mechanism"
        + ("; equilibrium alone fixes all forces, so no other λ above zero is possible" if v["fixed"] else "")
    ),
    Code.TIME_LIMIT: _time_limit,
    Code.NOT_CERTIFIED: _not_certified,
    Code.ABOVE_ASSOCIATIVE: (
        "the loop of linear programs ended {by:.1e} above the associative load factor, which is an upper "
        "bound on λ; the associative load factor is reported instead"
    ),
    Code.FLOW_RULE_IDLE: lambda v: (
        "the associative answer also obeys the joints' own flow rule, so its load factor is valid, but a "
        "lower load factor may exist; to look for it: " + _by_loop(v, "set option 'always'")
    ),
    Code.STILL_CHANGES: lambda v: (
        f"λ still changes after {counted(v['count'], 'sub-problem')}, most recently between {_between(v)}: "
        + _by_loop(v, "raise 'max_iterations', or lower 'beta'")
    ),
    Code.GROWS: lambda v: (
        f"λ still grows after {counted(v['count'], 'sub-problem')} of the loop of linear programs "
        f"(λ = {rounded(v['load_factor'])}), because the compression of joints grows with the load; real "
        "joints would crush: check the direction of 'live', the supports and the friction"
    ),
    Code.REPEATS: _repeats,
    Code.SUB_PROBLEM_FAILED: lambda v: (
        f"sub-problem {v['number']} ended with '{v['word']}': {_try_another_solver(v)}"
    ),
    Code.SUB_PROBLEM_EMPTY: lambda v: (
        f"sub-problem {v['number']} has no equilibrium state, because contacts without normal force in the "
        "previous sub-problem can now carry almost no force: "
        + _by_loop(v, "lower 'alpha', or choose an interior-point solver")
    ),
    Code.BEGAN_AGAIN: _began_again,
    Code.LEAST_BORNE_OUT: lambda v: (
        "no load factor of a sub-problem is verified"
        if v["load_factor"] is None
        else f"the lowest verified load factor of a sub-problem is {numeral(v['load_factor'], '.6g')}"
    ),
    Code.UNDECIDED: _undecided_history,
    Code.CARRIES_MORE: lambda v: (
        f"the live load grows from zero to λ = {numeral(v['carried'], '.6g')} without a collapse: a collapse "
        "state with a lower λ exists, but the load history does not lead to this state"
    ),
    Code.DILATANCY_FALLS: (
        "no load history was computed, because only the loop of linear programs supports dilatancy that "
        "falls with stress"
    ),
    Code.COLLAPSE: lambda v: (
        f"the live load was increased from zero in {counted(v['steps'], 'step')}{_jumps(v)}, up to an exact "
        "collapse state"
    ),
    Code.RANGE: lambda v: (
        f"the live load was increased from zero in {counted(v['steps'], 'step')}{_jumps(v)}: equilibrium is "
        f"lost between λ = {numeral(v['carried'], '.6g')} and {numeral(v['not_carried'], '.6g')}"
    ),
    Code.UNBOUNDED: lambda v: (
        "no collapse occurs from rest: the compression of joints grows with the live load, so the joints "
        f"carry any multiple of the live load (proven by {counted(v['steps'], 'step')} of the load history)"
    ),
    Code.NOT_COMPUTED: lambda v: (
        f"no load history was computed, because this would take long for {_joints_or_points(v)}: to compute "
        "the load history anyway, use method 'incremental'"
    ),
    Code.CURVE: lambda v: (
        f"load–displacement curve under an increasing load, in {counted(v['states'], 'load step')}"
        + (
            f"; {counted(v['jumps'], 'jump')} to another equilibrium, under constant load"
            if v["jumps"]
            else ""
        )
    ),
    Code.SPREAD: lambda v: (
        f"the incremental λ is {_ranged(v['stiffness'])} with random stiffness of contacts, and "
        f"{_ranged(v['stress'])} with random self-stress, in {counted(v['draws'], 'draw')} each"
        + (f" ({v['without']} of these load histories led to no collapse)" if v["without"] else "")
    ),
    Code.LOCAL_MINIMUM: (
        "the answer is a local minimum, in which each product of slack and rate is at most ε = {epsilon:.0e}"
    ),
    Code.START_FAILED: "the MPEC relaxation could not start, because the loop of linear programs failed",
    Code.RELAXATION_STOPPED: "the MPEC relaxation failed: IPOPT ended with '{word}' at ε = {epsilon:.0e}",
    Code.NOTHING_SOLVED: (
        "IPOPT failed at the first ε of the MPEC relaxation: set a smaller first ε with 'epsilon', or set "
        "'start' to the result of an earlier analysis of the scene"
    ),
    Code.STATES_MET: _states_met,
    Code.FEW_STARTS: lambda v: (
        "the lowest, incremental and associative load factors agree, but the analysis made only "
        f"{counted(v['candidates'], 'start')}; a collapse state with a lower load factor may exist, because "
        "equilibrium alone does not determine the forces"
    ),
    Code.SEARCHED: lambda v: (
        f"the search for states with a lower λ used {counted(v['candidates'], 'start')}"
        + (" until the search was interrupted" if v["interrupted"] else "")
    ),
    Code.NOT_FOUND: "the search found no exact state",
    Code.NO_TIME: "the search ended before an exact state was found: allow more seconds with option 'search'",
    Code.PROVEN: lambda v: f"the least λ is proven: {_bracket(v)}",
    Code.WITHIN_IMPOSED: lambda v: f"the least λ of all states with {_imposed(v)} is proven: {_bracket(v)}",
    Code.TOUCHES_IMPOSED: lambda v: (
        f"nothing is proven, because the lower bound is valid only for states with {_imposed(v)}, and the "
        "collapse state exceeds the assumed limits"
    ),
    Code.OUT_OF_TIME: lambda v: (
        f"the least λ is not proven; its bounds after {v['time_limit']:g} s are {_bracket(v)}"
    ),
    Code.OUT_OF_TIME_WITHIN_IMPOSED: lambda v: (
        f"the least λ is not proven; its bounds after {v['time_limit']:g} s, among states with "
        f"{_imposed(v)}, are {_bracket(v)}"
    ),
    Code.NO_EXACT_STATE: "no exact state was found within {time_limit:g} s: raise 'time_limit'",
    Code.REACHES_ZERO: "λ has decreased to zero: from here on the masonry falls without live load",
    Code.JOINT_CLOSES: lambda v: f"the joint between {pairs(v)} closes",
    Code.JOINT_OPENS: lambda v: f"the joint between {pairs(v)} opens",
    Code.NOT_HINGING: _not_hinging,
    Code.JOINTS_SLIDE: _slides_on,
    Code.BLOCKS_MEET: lambda v: f"{do(v, 'meet')} where there is no joint",
    Code.LOCKS: "the mechanism locks: from here on no finite motion is possible",
    Code.BRANCHES: "several motions are possible from here on, because blocks have become free",
    Code.STILL_CARRIES: lambda v: (
        f"λ has not decreased to zero after {counted(v['steps'], 'state')}: use fewer 'steps', so that each "
        "step is longer"
    ),
    Code.FORCES_UNDECIDED: (
        "the solver failed at the linear program for the forces in the next state: use another number of "
        "'steps' or, if the drawing is a survey, set its 'tolerance'"
    ),
    **INPUT_SENTENCES,
}

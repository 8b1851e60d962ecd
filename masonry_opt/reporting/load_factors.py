"""Name the load factors of a result, with a remark on each: the table at the head of every summary."""

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from masonry_opt.errors import counted
from masonry_opt.reporting.linear_laws import by_sides
from masonry_opt.reporting.sentences import message, numeral, sentences
from masonry_opt.solution.acceptance import LIMITS, Kind
from masonry_opt.solution.outcome import Outcome
from masonry_opt.solution.reasons import Code, Status

LOWEST = "lowest found"  #: Name of the load factor of an exact state, if no state with a lower λ is known.
#: Name of the load factor of an exact state, if it is proven that no state has a lower λ.
LEAST = "least, proven"
#: Name of the load factor of a crossing, if it is proven to be the least at the worst of the solved
#: positions. Nothing is proven for positions that were not solved.
LEAST_AT_POSITION = "least at this position, proven"
#: Name of the load factor of a crossing that was stopped by the user or by the time limit.
LEAST_SO_FAR = "the least at the positions solved so far"
#: Name of the load factor of a state that is not exact. The name is also used for an exact state whose λ is
#: larger than λ at the end of the load history.
STATE_FOUND = "found"
INCREMENTAL = "incremental"  #: Name of the largest load factor of the load history.
#: Name of the load factor that the moving blocks still carry after the collapse begins. The name is used if
#: this load factor is smaller than the incremental load factor.
AFTER_INCREMENTAL = "after incremental collapse"
ASSOCIATIVE = "associative"  #: Name of the load factor of classical limit analysis.

_METHOD_WITH_SEARCH = "coulomb"  #: Name of the method that has the option ``search``.

#: Reason codes for sentences about a lower bound on the load factors of all states.
_BOUND_CODES = (
    *(Code.PROVEN, Code.WITHIN_IMPOSED, Code.TOUCHES_IMPOSED),
    *(Code.OUT_OF_TIME, Code.OUT_OF_TIME_WITHIN_IMPOSED),
)

#: Reason codes of a search that began from a state specified by the user and found no exact state.
_FAILED_SEARCH_CODES = (Code.NOT_FOUND, Code.NO_TIME)

#: Remarks on the incremental load factor, by the reason for which the load history ended.
_HISTORY_END_REMARKS = {
    Code.NO_WORK: "collapse in which the live load does no work",
}
#: Remark on an incremental load factor whose load history ended with the loss of equilibrium.
_EQUILIBRIUM_LOST = "equilibrium is lost as the live load grows from zero"
#: Remark on possible states with a lower λ, for results of method "incremental".
_LOWER_MAY_EXIST = "collapse states with a lower load factor may exist (method 'coulomb' looks for them)"
#: Remark on the incremental load factor, if a method other than "incremental" reports it because no exact
#: state was found.
_NO_EXACT_STATE = "no exact collapse state was found, but exact states may exist below this load factor"

#: Meaning of each name of a load factor. Sweeps and samples print these meanings below their results.
_LOAD_FACTOR_MEANINGS = {
    LOWEST: "exact collapse states that are not proven to have the least load factors",
    LEAST: "exact collapse states, proven to have the least load factors",
    LEAST_AT_POSITION: (
        "exact collapse states, proven to have the least load factor for the axles at the worst of the "
        "solved positions; λ may be less at positions that were not solved"
    ),
    LEAST_SO_FAR: "the crossing ended early, so λ may be less at positions that were not solved",
    STATE_FOUND: (
        "collapse states that are not exact, or whose λ is larger than at the end of the load history"
    ),
    INCREMENTAL: (
        "equilibrium is lost as the live load grows from zero; collapse states with a lower load factor may "
        "exist"
    ),
    AFTER_INCREMENTAL: (
        "after equilibrium is lost at a larger load factor, the moving blocks still carry this load factor; "
        "collapse states with a lower load factor may exist"
    ),
    ASSOCIATIVE: "upper bounds, by classical limit analysis",
}

#: Remark on a load factor if equilibrium alone fixes all forces (see :mod:`masonry_opt.solution.only_state`).
_ONLY_LOAD_FACTOR = "equilibrium alone fixes all forces, so no other λ above zero is possible"

_NAME_WIDTH = 15  #: Width of the column of names in characters; the longest name has 13 letters.


@dataclass(frozen=True)
class LoadFactorLine:
    """Row of the table of load factors."""

    name: str
    #: Value of the load factor. If it does not exist, the value is None and the remark states the reason.
    load_factor: float | None
    remark: str  #: text that states the kind of collapse state, and whether a lower load factor is possible


def load_factor_lines(result: Outcome) -> tuple[LoadFactorLine, ...]:
    """Return the rows of the table of load factors, first the load factor that the method itself computes.

    A scene that is unstable under dead load has no rows.
    """
    if result.status is Status.UNSTABLE:
        return ()
    if result.kind is Kind.ASSOCIATIVE and result.load_factor is None:
        return ()
    lines = []
    if result.load_factor is not None and result.kind is not Kind.INCREMENTAL:
        lines.append(_own_line(result))
    why_not = why_not_incremental(result)
    if result.incremental is not None:
        lines.append(_incremental_line(result))
    elif why_not and result.load_factor is not None:
        lines.append(LoadFactorLine(INCREMENTAL, None, why_not))
    if result.associative is not None and result.kind is not Kind.ASSOCIATIVE:
        lines.append(LoadFactorLine(ASSOCIATIVE, result.associative, _upper_bound(result)))
    return tuple(lines)


def why_not_incremental(result: Outcome) -> str:
    """Return the reason why the incremental load factor does not exist, as a sentence.

    The text is empty if the load factor exists, or if the reasons of the result include those of the load
    history.
    """
    codes = {reason.code for reason in result.reasons}
    known = all(reason.code in codes for reason in result.incremental_reasons)
    if known or result.incremental is not None:
        return ""
    return message(result.incremental_reasons, result.method)


def load_factor_table(result: Outcome) -> str:
    """Return the table of load factors as lines of text with a heading, or "" if no load factor is known."""
    lines = load_factor_lines(result)
    if not lines:
        return ""
    values = [value_text(result, line) for line in lines]
    width = max(map(len, values))
    rows = [
        f"  {line.name:<{_NAME_WIDTH}}{value:<{width}}   {line.remark}"
        for line, value in zip(lines, values, strict=True)
    ]
    return "\n".join([_heading(result), *rows])


def value_text(result: Outcome, line: LoadFactorLine) -> str:
    """Return a load factor as text with six digits; if the ground is tilted, add the angle in degrees.

    If the load factor does not exist, the text is "none".
    """
    if line.load_factor is None:
        return "none"
    value = factor_text(result, line.load_factor)
    if result.assembly.scene.tilt is None:
        return value
    return f"{value} ({numeral(np.degrees(np.arctan(line.load_factor)), '.4f')}°)"


def factor_text(result: Outcome, load_factor: float) -> str:
    """Return a load factor as text with six digits; a value of the size of rounding errors becomes "0"."""
    return numeral(0.0 if is_rounding_error(result, load_factor) else load_factor, ".6g")


def is_rounding_error(result: Outcome, load_factor: float) -> bool:
    """Return True if the magnitude of a load factor is at most that of a rounding error."""
    return abs(load_factor) <= result.assembly.problem.load_factor_scale.zero


def own_name(result: Outcome) -> str:
    """Return the name of the load factor that the method itself computes.

    The table of load factors also has the load factors of other analyses, for comparison.
    """
    if result.kind is Kind.ASSOCIATIVE:
        return ASSOCIATIVE
    if result.kind is Kind.INCREMENTAL:
        return AFTER_INCREMENTAL if _carries_less_after_collapse(result) else INCREMENTAL
    if known_least(result):
        return LEAST
    return LOWEST if result.exact and not load_history_ends_lower(result) else STATE_FOUND


def named_factor(result: Outcome, name: str | None = None) -> str:
    """Return the load factor that the method itself computes, with its name; the status if λ does not exist.

    ``name`` replaces the name of the load factor, for the worst position of a crossing.
    """
    if result.load_factor is None:
        return str(result.status)
    return f"λ = {factor_text(result, result.load_factor)} ({name or own_name(result)})"


def meaning(names: Iterable[str]) -> str:
    """Return the names of load factors as one text without repetitions, each with its meaning in brackets."""
    return "; ".join(f"{name} ({_LOAD_FACTOR_MEANINGS[name]})" for name in dict.fromkeys(names))


def certainty(result: Outcome) -> str:
    """Return the remark on the method's load factor, such as that it is an upper bound.

    The text is empty if there is no load factor.
    """
    return "" if result.load_factor is None else _own_line(result).remark


def known_least(result: Outcome) -> str:
    """Return a sentence that explains why no state has a lower load factor than the answer.

    The text is empty if this is not proven.
    """
    if result.solution.has(Code.PROVEN) and not _falls_by_itself(result):
        return "exact collapse state; proven: no state has a lower load factor"
    if result.solution.is_only_state and result.exact and not _falls_by_itself(result):
        return f"exact collapse state; {_ONLY_LOAD_FACTOR}"
    if not result.assembly.problem.flow_is_associative or result.kind is Kind.INCREMENTAL:
        return ""
    if result.kind is not Kind.ASSOCIATIVE and not result.exact:
        return ""
    law = f" with friction {friction_law(result)}" if "polygon" in result.friction_law else ""
    return (
        f"exact collapse state{law}; all joints follow associative flow, so no state has a lower load factor"
    )


def friction_law(result: Outcome) -> str:
    """Return a phrase that says how friction is limited, such as "limited by the friction cone"."""
    if "polygon" in result.friction_law:
        return f"limited {by_sides(result.assembly.problem.layout)}"
    return f"limited by the friction {result.friction_law}" if result.friction_law else "unlimited"


def _heading(result: Outcome) -> str:
    """Return the heading of the table of load factors, with the direction of a tilted ground."""
    heading = "load factor λ" if result.load_factor is not None else "other load factors λ"
    tilt = result.assembly.scene.tilt
    if tilt is None:
        return heading
    side = f"to the {tilt}" if isinstance(tilt, str) else f"towards [{', '.join(f'{x:g}' for x in tilt)}]"
    return f"{heading} (the ground is tilted {side} by atan λ)"


def _own_line(result: Outcome) -> LoadFactorLine:
    """Return the table row of the load factor that the method itself computes.

    This load factor must not be None. For method "incremental", the row always contains the incremental load
    factor.
    """
    name = own_name(result)
    if name in (INCREMENTAL, AFTER_INCREMENTAL):
        return _incremental_line(result)
    if name == ASSOCIATIVE:
        return LoadFactorLine(name, result.load_factor, known_least(result) or _associative_remark(result))
    return LoadFactorLine(name, result.load_factor, known_least(result) or _coulomb_remark(result))


def _upper_bound(result: Outcome) -> str:
    """Return the remark that an associative load factor is an upper bound.

    If chords replace the crushing parabola, the remark says so.
    """
    for_chords = " for chords of the crushing parabola" if result.crushing == "chords" else ""
    return f"upper bound{for_chords} (classical limit analysis)"


def _associative_remark(result: Outcome) -> str:
    """Return the remark on an associative load factor: it is an upper bound, and its state may be exact."""
    if result.exact:
        exact = "it is also an exact collapse state with Coulomb friction"
        return f"{_upper_bound(result)}; {exact}, {_not_proven(result)}"
    missed = _missed(result)
    if missed:
        return "; ".join([_upper_bound(result), *missed])
    return (
        f"{_upper_bound(result)}; if joints slide without opening, collapse may occur at a lower load "
        "factor, which method 'coulomb' computes"
    )


def _incremental_line(result: Outcome) -> LoadFactorLine:
    """Return the table row of the incremental load factor. This load factor must not be None."""
    remark = _incremental_remark(result)
    if result.kind is Kind.INCREMENTAL:
        lower = _LOWER_MAY_EXIST if result.method == "incremental" else _NO_EXACT_STATE
        remark = f"{remark}; {lower}"
    return LoadFactorLine(INCREMENTAL, result.incremental, remark)


def _incremental_remark(result: Outcome) -> str:
    """Return the remark on how equilibrium is lost, and on the load factor after the collapse begins."""
    state = result.solution.at_incremental
    assert state is not None
    remark = next(
        (words for code, words in _HISTORY_END_REMARKS.items() if state.has(code)), _EQUILIBRIUM_LOST
    )
    if state.has(Code.RANGE):
        carried, not_carried = (
            factor_text(result, state.values_of(Code.RANGE)[name]) for name in ("carried", "not_carried")
        )
        remark = f"equilibrium is lost between λ = {carried} and {not_carried} as the live load grows"
    if state.peak is None:
        return remark
    if result.end is None:
        return f"{remark}; after the collapse begins, the blocks continue to move even without live load"
    end = factor_text(result, result.end)
    return f"{remark}; after the collapse begins, the moving blocks carry only λ = {end}"


def _coulomb_remark(result: Outcome) -> str:
    """Return the remark on a Coulomb state: whether it is exact, and whether a lower λ is possible."""
    return "; ".join([state_found(result), *_missed(result), *_lower_states(result)])


def _missed(result: Outcome) -> list[str]:
    """Return a list with the sentence that a search found no exact state, or [] if no search failed.

    The search began from a state that the user specified.
    """
    return list(sentences([reason for reason in result.reasons if reason.code in _FAILED_SEARCH_CODES]))


def state_found(result: Outcome) -> str:
    """Return a phrase about the collapse state, such as "exact collapse state, from 3 starts"."""
    return _state(result) + _starts(result)


def _state(result: Outcome) -> str:
    """Return a phrase about the kind of the collapse state, such as "exact collapse state".

    For a state that is not exact, the phrase names the residuals above their limits, or the polygons that
    limit friction.
    """
    if result.exact:
        return "exact collapse state"
    residuals = _certificate_residuals(result)
    above = LIMITS[Kind.EXACT].failing(residuals)
    if not above and "polygon" in result.friction_law:
        return f"collapse state with friction {friction_law(result)}"
    named = ", ".join(f"{name} {numeral(residuals[name], '.1e')}" for name in above)
    return f"collapse state that is not exact: its residuals are too large{f' ({named})' if named else ''}"


def _certificate_residuals(result: Outcome) -> dict[str, float]:
    """Return the residuals of the answer's certificate by name; an empty dict if there is no answer.

    Complementarity is divided by |λ|.
    """
    answer = result.solution.answer
    return {} if answer is None else {name: answer.residuals[name] for name in answer.certificate.as_dict()}


def _starts(result: Outcome) -> str:
    """Return the number of starts of the analysis as text, such as ", from 3 starts"; "" if unknown.

    If the starts led to several different exact states, the text also contains the number of these states.
    """
    solution = result.solution
    if solution.starts is None:
        return ""
    starts = counted(solution.starts, "start")
    if solution.exact_states is None or solution.exact_states < 2:
        return f", from {starts}"
    return f", the lowest of {solution.exact_states} different exact states from {starts}"


def _lower_states(result: Outcome) -> list[str]:
    """Return phrases about states with a lower load factor, such as "not proven to be the least"."""
    phrases = list(sentences([reason for reason in result.reasons if reason.code in _BOUND_CODES]))
    if result.solution.is_only_state:
        phrases = [_ONLY_LOAD_FACTOR]
    elif not phrases:
        few_starts = [reason for reason in result.reasons if reason.code is Code.FEW_STARTS]
        phrases = [*sentences(few_starts), _not_proven(result)]
    if load_history_ends_lower(result):
        phrases.append("the load history ends in a state with a lower load factor")
    if _falls_by_itself(result):
        phrases += sentences([reason for reason in result.reasons if reason.code is Code.BELOW_ZERO])
    return phrases


def _not_proven(result: Outcome) -> str:
    """Return the phrase "not proven to be the least", with a remark on the search for lower load factors."""
    return f"not proven to be the least{search_remark(result, 'lower load factors')}"


def search_remark(result: Outcome, states: str) -> str:
    """Return the end of a sentence: how a search for states ended, or how to start the search.

    ``states`` is the object of the search, such as "lower load factors".
    """
    if result.time_limit_reached:
        seconds = result.solution.values_of(Code.TIME_LIMIT)["seconds"]
        return f": the time limit of {seconds:g} s ended the search for {states}"
    if result.solution.interrupted:
        return ": the search was interrupted"
    if result.solution.has(Code.SEARCHED):
        return f": a longer search may find {states}"
    if result.assembly.problem.dilatancy_depends_on_stress:
        return ""
    return search_advice(result.method, states)


def search_advice(method: str, states: str) -> str:
    """Return the end of a sentence: the option that starts a search for states.

    Only the default method has the option ``search``, so the advice names this method if another method was
    used. ``states`` is the object of the search, such as "lower load factors".
    """
    option = (
        "option search=10"
        if method == _METHOD_WITH_SEARCH
        else f"--method {_METHOD_WITH_SEARCH} -o search=10"
    )
    return f" ({option} looks for {states})"


def _carries_less_after_collapse(result: Outcome) -> bool:
    """Return True if λ after the collapse begins is less than the incremental load factor."""
    at_end, largest = result.load_factor, result.incremental
    if at_end is None or largest is None:
        return False
    return not result.assembly.problem.load_factor_scale.equal(at_end, largest)


def load_history_ends_lower(result: Outcome) -> bool:
    """Return True if the load history ends in a state with a lower load factor than the answer."""
    end = result.incremental if result.end is None else result.end
    if end is None or result.load_factor is None or result.kind is Kind.INCREMENTAL:
        return False
    scale = result.assembly.problem.load_factor_scale
    return end < result.load_factor and not scale.equal(end, result.load_factor)


def _falls_by_itself(result: Outcome) -> bool:
    """Return True if an exact state other than the answer has λ ≤ 0: the scene may fall without live load.

    With the joint forces of that state, the scene falls without live load.
    """
    return result.solution.below_zero <= result.assembly.problem.load_factor_scale.zero

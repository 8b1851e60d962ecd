"""Printed lines of a crossing: the worst position, the loads at collapse, and the certainty of λ."""

from masonry_opt.errors import counted
from masonry_opt.reporting.linear_laws import BY_CHORDS
from masonry_opt.reporting.load_factors import certainty
from masonry_opt.reporting.names import some
from masonry_opt.reporting.sentences import numeral
from masonry_opt.reporting.summary import crushing
from masonry_opt.result import Result
from masonry_opt.studies.crossing.assessment import assessment_text, capacity_text
from masonry_opt.studies.crossing.load_factors import CrossingLoadFactors
from masonry_opt.studies.crossing.search import Passage

#: Relative tolerance of the least load factor of a crossing. The associative search ends when its proven
#: lower bound is less than this fraction below the least λ found. Load factors that differ by less than this
#: fraction count as equal.
WITHIN = 1e-3
#: Printed reason why a Coulomb load factor is less than the associative load factor.
_BY_FRICTION = "because joints with Coulomb friction slide without opening"


def facts(answer: CrossingLoadFactors) -> dict[str, str]:
    """Return the printed lines of a crossing, as a dict from the label of each line to its text."""
    worst = answer.worst
    lines = {"case": worst.case, "method": worst.method} | _ended_early(answer) | _load_case_facts(answer)
    missing_cases = some([*map(repr, answer.not_crossed)])
    required = {}
    if answer.required_factor is not None:
        required["required"] = assessment_text(answer, answer.required_factor)
    if answer.least is None:
        lines["status"] = f"{worst.status}: {worst.message}"
        return lines | required | ({"not crossed": missing_cases} if missing_cases else {})
    lines |= _worst_facts(answer, answer.least.passage, required) | _associative_facts(answer)
    if answer.undecided:
        template = "{position:.6g} ('{axles}', {direction}"
        template += ", in '{load_case}')" if len(answer.by_case) > 1 else ")"
        undecided = answer.undecided_at
        positions = answer.printed_positions([place["position"] for place in undecided])
        places = some(
            [
                template.format(**place | {"position": x})
                for place, x in zip(undecided, positions, strict=True)
            ]
        )
        count = counted(answer.undecided, "position")
        lines["undecided"] = f"the least λ is uncertain, because λ could not be computed at {count}: {places}"
    return lines


def _ended_early(answer: CrossingLoadFactors) -> dict[str, str]:
    """Return the printed line that says why a crossing ended early; empty if it did not end early."""
    if not answer.interrupted or answer.least is None:
        return {}
    missing_cases = some([*map(repr, answer.not_crossed)])
    not_reached = f"; load cases that were not reached: {missing_cases}" if missing_cases else ""
    label, by = "interrupted", ""
    if answer.time_limit is not None:
        label, by = "stopped", f"by the time limit of {answer.time_limit:g} s; "
    return {label: f"{by}λ may be less at positions that were not solved{not_reached}"}


def _load_case_facts(answer: CrossingLoadFactors) -> dict[str, str]:
    """Return the printed lines on the governing load case, other load cases, and load cases without axles."""
    worst, lines = answer.worst, dict[str, str]()
    if worst.load_case is not None:
        governs = ", governs" if len(answer.by_case) - len(answer.not_crossed) > 1 else ""
        lines["load case"] = f"'{worst.load_case}'{governs}: {worst.assembly.scene.load_case}"
    other_cases = []
    for name, load_factor in answer.by_case.items():
        if name not in (worst.load_case, *answer.not_crossed):
            other_cases.append(f"'{name}' {'none' if load_factor is None else numeral(load_factor, '.6f')}")
    if other_cases:
        lines["other cases"] = f"least λ {', '.join(other_cases)}"
    if answer.left_out:
        names = some([*map(repr, answer.left_out)])
        lines["left out"] = f"use 'solve' for the load cases without axles: {names}"
    return lines


def _worst_facts(answer: CrossingLoadFactors, passage: Passage, required: dict[str, str]) -> dict[str, str]:
    """Return the printed lines on the worst position of a passage.

    ``required`` is the line on the required load factor, if there is one.
    """
    worst, group = answer.worst, passage.axles
    governing = "none: any load is carried" if worst.solution.carries_any_load else str(worst.status)
    if worst.load_factor is not None:
        governing = f"{numeral(worst.load_factor, '.6f')} ({answer.load_factor_name})"
    source = f" ({group.group.source})" if group.group.source else ""
    lines = {"λ so far" if answer.interrupted else "governing λ": governing}
    capacity = capacity_text(answer)
    if capacity:
        lines["at collapse"] = capacity
    lines |= required | {"certainty": _certainty(answer), "crushing": _crushing(answer)}
    lines = {label: words for label, words in lines.items() if words}
    lines["position"] = _where(answer)
    lines["axles"] = f"'{answer.axles}', travelling {answer.direction}{source}"
    if group.width:
        share = f"{passage.across:.4g}"
        lines["width"] = (
            f"the scene carries {share} of each load: thickness of the scene divided by effective width "
            f"{group.width:g}"
        )
    lines["solved"] = f"at {counted(len(answer.governing), 'position')}"
    if answer.resolution:
        spacing = numeral(answer.resolution, ".3g")
        lines["solved"] += f"; near the worst position, solved positions are at most {spacing} apart"
    if answer.bound is None:
        lines["solved"] += "; λ may be less between positions"
    if passage.assembly.problem.live.any():
        lines["other loads"] = "λ also multiplies the other live loads of the scene"
    return lines


def _certainty(answer: CrossingLoadFactors) -> str:
    """Return a remark on λ at the worst position, such as that λ is an upper bound; "" without λ.

    If no lower bound along the road is proven, the text says that it applies to the worst position only.
    """
    words = certainty(answer.worst)
    return f"at this position: {words}" if words and answer.bound is None else words


def _crushing(answer: CrossingLoadFactors) -> str:
    """Return a text on the crushing law of joints: the parabola itself, or chords inside the parabola.

    For chords, the text also states the associative λ with the parabola, or why this λ is unknown. The text
    is empty if no joint has a limited strength.
    """
    if answer.by_parabola is None:
        law = crushing(answer.worst)
        missing = f"; at this position, the associative λ with the parabola is unknown: {answer.no_parabola}"
        return law + missing if answer.no_parabola else law
    known = f"λ and the associative λ are limited by {BY_CHORDS}"
    chords = answer.worst.associative
    more = "" if not chords else f", {answer.by_parabola / chords - 1:.2%} more than with chords"
    return (
        f"{known}; with the parabola itself, the associative λ at this position is "
        f"{numeral(answer.by_parabola, '.6f')}{more}"
    )


def _where(answer: CrossingLoadFactors) -> str:
    """Return a text with the positions of the axles and of the uniform loads at the worst position."""
    parts = []
    if answer.at:
        first, *others = (numeral(x, ".6g") for x in answer.printed_positions(answer.at))
        parts.append(f"axles at x = {first}{' (first)' if others else ''}{''.join(f', {x}' for x in others)}")
    for start, end in map(answer.printed_positions, answer.uniform_at):
        parts.append(f"uniform load from x = {numeral(start, '.6g')} to {numeral(end, '.6g')}")
    return "; ".join(parts)


def _associative_facts(answer: CrossingLoadFactors) -> dict[str, str]:
    """Return the printed lines that compare the answer with classical limit analysis (associative flow)."""
    worst, lines = answer.worst, dict[str, str]()
    if answer.passages[0].associative_trials is not None:
        if worst.associative is not None and worst.load_factor is not None:
            value = numeral(worst.associative, ".6f")
            for_chords = " with chords inside the crushing parabola" if worst.crushing == "chords" else ""
            lines["associative"] = (
                f"{value} is the associative load factor{for_chords} at this position, an upper bound on λ; "
                f"λ is {_difference(worst.load_factor, worst.associative)}"
            )
        return lines
    first_look = _first_look(answer)
    if first_look:
        lines["first look"] = first_look
    if answer.bound is not None:
        law = f", with crushing by the {worst.crushing}" if worst.crushing else ""
        proven = "proven lower bound on the associative load factor along the whole road"
        lower = "Coulomb friction may lower λ below this bound"
        if worst.crushing:
            lower = "Coulomb friction and chords inside the crushing parabola may lower λ below this bound"
        lines["bound"] = f"{numeral(answer.bound, '.6f')}: {proven}{law}; {lower}"
    return lines


def _first_look(answer: CrossingLoadFactors) -> str:
    """Return a text that compares λ of the default method with the associative λ at the worst position.

    If the default method has no result, the text states the reason. If the default method did not solve the
    worst position at all, the text is empty.

    The load factor is compared with the associative load factor by the same crushing law. If the default
    method uses chords inside the parabola, the chords may also make its load factor less than the answer.
    """
    default = answer.default
    if default is None:
        return answer.no_default and f"not compared with the default method: {answer.no_default}"
    subject = f"method '{default.method}', the default, finds"
    associative, law = answer.load_factor, ""
    if default.crushing != answer.worst.crushing:
        associative = default.associative
        law = " by the same law"
    if default.load_factor is None or associative is None:
        return f"{subject} at the worst position: {default.status}"
    at = f"λ = {numeral(default.load_factor, '.6f')} at the worst position"
    if default.time_limit_reached:
        at += ", when the time limit ended the search"
    difference = _difference(default.load_factor, associative, law)
    chords = _less_by_chords(answer, default) if law else ""
    return f"{subject} {at}{chords}: {difference}; λ may be less at other positions"


def _difference(load_factor: float, associative: float, law: str = "") -> str:
    """Return a text on how much a Coulomb load factor is below the associative load factor, and why.

    ``law`` is a text that names the common law of crushing, such as " by the same law".
    """
    difference = 1 - load_factor / associative if associative > 0 else 0.0
    named = f"the associative load factor{law}"
    if difference <= WITHIN:
        return f"the same as {named}"
    return f"{difference:.2%} less than {named}, {_BY_FRICTION}"


def _less_by_chords(answer: CrossingLoadFactors, default: Result) -> str:
    """Return a text on how much the chords of the crushing parabola lower the associative load factor."""
    by_chords, by_parabola = default.associative, answer.load_factor
    law = f", with crushing by {default.crushing}"
    if by_chords is None or by_parabola is None or by_parabola <= 0:
        return law
    share = 1 - by_chords / by_parabola
    return f"{law} (chords inside the {answer.worst.crushing} lower λ by {share:.2%})"

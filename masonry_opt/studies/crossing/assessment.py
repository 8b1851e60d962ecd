"""Assessment of a crossing: the loads at collapse, and the comparison with a required load factor."""

import math
from collections.abc import Iterable
from enum import StrEnum
from typing import NamedTuple

from masonry_opt.errors import OptionError
from masonry_opt.reporting.sentences import numeral
from masonry_opt.solution.thresholds import same
from masonry_opt.studies.crossing.load_factors import CrossingLoadFactors


class AssessmentOutcome(StrEnum):
    """Outcome of the comparison of a load factor with the required load factor."""

    PASSED = "passed"
    FAILED = "failed"
    UNDECIDED = "not decided"


class Assessment(NamedTuple):
    """Comparison of the load factors of a crossing with the required load factor."""

    outcome: AssessmentOutcome
    load_factor: float | None  #: load factor that is compared; None if it is unlimited or not known
    #: Name of the compared load factor. If the outcome is undecided, or if no load factor is compared, the
    #: text is the reason for the outcome instead.
    why: str


def refuse_required_factor(value: object) -> None:
    """Raise OptionError if a required load factor is neither None nor a positive number."""
    if value is None:
        return
    if isinstance(value, bool) or not isinstance(value, int | float) or not 0 < value < math.inf:
        raise OptionError(f"required_factor must be a number above 0, such as 3.4 (found {value!r})")


def assessed(answer: CrossingLoadFactors, required: float) -> Assessment:
    """Compare the least known load factor of a crossing with a required load factor.

    - A scene that is unstable under its dead load fails.
    - The least known load factor is the least of three values: the load factor of the answer, its proven
      lower bound, and the load factor of the default method at the worst position. If it is less than the
      required load factor, the scene fails.
    - Otherwise the scene passes, unless positions are undecided or were not solved: the outcome is then
      undecided.
    """
    worst = answer.worst
    if answer.least is None and worst.solution.d is not None:
        return Assessment(AssessmentOutcome.FAILED, None, "the scene is unstable under its dead load")
    named = {f"governing λ, an upper bound by method '{worst.method}'": answer.load_factor}
    if answer.bound is not None:
        named["proven lower bound for associative flow"] = answer.bound
    if answer.default is not None and answer.default.load_factor is not None:
        named[f"upper bound by method '{answer.default.method}' at the worst position"] = (
            answer.default.load_factor
        )
    known = {name: value for name, value in named.items() if value is not None}
    least = min(known.values(), default=None)
    # If the load factor of the answer equals a bound, name the bound, which comes later in the dict.
    name = next((name for name, value in reversed(known.items()) if value == least), "")
    if least is not None and least < required and not same(least, required):
        return Assessment(AssessmentOutcome.FAILED, least, name)
    if answer.interrupted:
        by_limit = "the time limit ended the crossing"
        why = by_limit if answer.time_limit_reached else "the crossing was interrupted"
        return Assessment(AssessmentOutcome.UNDECIDED, least, why)
    if answer.least is None:
        return Assessment(
            AssessmentOutcome.UNDECIDED, None, "it is unknown whether the scene carries its dead load"
        )
    if answer.undecided:
        return Assessment(AssessmentOutcome.UNDECIDED, least, "positions are undecided")
    if least is None:
        return Assessment(AssessmentOutcome.PASSED, None, "any load is carried")
    return Assessment(AssessmentOutcome.PASSED, least, name)


def assessment_text(answer: CrossingLoadFactors, required: float) -> str:
    """Return a text that compares λ with a required load factor, such as "λ ≥ 3.4: passed, ..."."""
    outcome, load_factor, why = assessed(answer, required)
    head = f"λ ≥ {numeral(required, '.6g')}: {outcome}"
    if load_factor is None or outcome is AssessmentOutcome.UNDECIDED:
        return f"{head}, because {why}"
    ratio = numeral(load_factor / required, ".3f")
    return f"{head}, {numeral(load_factor, '.6f')} is {ratio} times as much ({why})"


def capacity_text(answer: CrossingLoadFactors) -> str:
    """Return the loads at collapse as text, or an empty string if there is no load factor."""
    load_factor, trials = answer.load_factor, answer.least
    if load_factor is None or trials is None:
        return ""
    parts = []
    if answer.axle_loads:
        loads, capacity = _listed(answer.axle_loads), _listed(answer.capacity)
        parts.append(f"axle loads {capacity} = λ × {loads}")
    if answer.uniform_loads:
        uniform = _listed(load_factor * load for load in answer.uniform_loads)
        parts.append(f"uniform loads {uniform} per unit length = λ × {_listed(answer.uniform_loads)}")
    factors = []
    if trials.passage.axles.factor != 1:
        factors.append(f"{trials.passage.axles.factor:g} of the group")
    case = trials.passage.case_factor
    if case != 1:
        factors.append(f"{case:g} of the load case")
    included = f" (with the factor {' and '.join(factors)})" if factors else ""
    return f"in the force unit of the case: {'; '.join(parts)}{included}"


def _listed(values: Iterable[float]) -> str:
    """Return numbers as text. If all numbers are equal, the text is short, such as "3 × 120"."""
    numbers = [numeral(value, ".6g") for value in values]
    if len(numbers) > 1 and len({*numbers}) == 1:
        return f"{len(numbers)} × {numbers[0]}"
    return ", ".join(numbers)

"""Assessment of a crossing: the loads at collapse, and the comparison with a required load factor."""

import math
from collections.abc import Iterable
from enum import StrEnum
from typing import NamedTuple

from masonry_opt.errors import OptionError
from masonry_opt.problem.load_factor_scale import LoadFactorScale
from masonry_opt.reporting.load_factors import known_least
from masonry_opt.reporting.names import FORCE_UNIT
from masonry_opt.reporting.sentences import numeral
from masonry_opt.result import Result
from masonry_opt.studies.crossing.load_factors import CrossingLoadFactors


class AssessmentOutcome(StrEnum):
    """Outcome of the comparison of a load factor with the required load factor."""

    PASSED = "passed"
    FAILED = "failed"
    UNDECIDED = "not decided"


class Assessment(NamedTuple):
    """Comparison of the load factors of a crossing with the required load factor."""

    outcome: AssessmentOutcome
    #: Load factor that is compared with the required load factor; None if it is unlimited or unknown.
    load_factor: float | None
    #: Description of the load factor that decides the outcome, such as "proven lower bound for associative
    #: flow". If no load factor decides the outcome, the text is the reason for the outcome.
    why: str


def refuse_required_factor(value: object) -> None:
    """Raise OptionError if a required load factor is neither None nor a positive number."""
    if value is None:
        return
    if isinstance(value, bool) or not isinstance(value, int | float) or not 0 < value < math.inf:
        raise OptionError(f"required_factor must be a number above 0, such as 3.4 (found {value!r})")


def assessed(answer: CrossingLoadFactors, required: float) -> Assessment:
    """Compare the lowest load factor of a crossing with a required one, and return the assessment.

    - A scene that is unstable under its dead load fails.
    - A scene fails if an upper bound is less than the required load factor: the load factor of the answer, or
      the load factor of the default method at the worst position. Load factors that were computed with chords
      inside the crushing parabola are no upper bounds.
    - A scene also fails if a load factor with chords is so low that chords do not explain it: see
      :func:`_raised_by_parabola` and the assumption there.
    - The outcome is undecided if positions are undecided or were not solved, or if the proven lower bound is
      less than the required load factor. It is also undecided if only a load factor with chords is less than
      the required one.
    - Otherwise the scene passes.
    """
    worst = answer.worst
    if answer.least is None and worst.solution.d is not None:
        return Assessment(AssessmentOutcome.FAILED, None, "the scene is unstable under its dead load")
    upper = _upper_bounds(answer)
    for bounds in (upper, _raised_by_parabola(answer)):
        if bounds and _is_below(min(bounds.values()), required):
            name, least = _last_of_least(bounds)
            return Assessment(AssessmentOutcome.FAILED, least, name)
    why = _why_undecided(answer, required)
    if why:
        return Assessment(AssessmentOutcome.UNDECIDED, min(upper.values(), default=None), why)
    known = upper | _by_chords(answer)
    if answer.bound is not None:
        known["proven lower bound on the associative load factor"] = answer.bound
    if not known:
        return Assessment(AssessmentOutcome.PASSED, None, "any load is carried")
    name, least = _last_of_least(known)
    return Assessment(AssessmentOutcome.PASSED, least, name)


def _is_below(load_factor: float, required: float) -> bool:
    """Return True if a load factor is less than the required one by more than a rounding error."""
    return LoadFactorScale(min(1.0, required)).is_distinctly_lower(load_factor, required)


def _last_of_least(named: dict[str, float]) -> tuple[str, float]:
    """Return the name and the value of the least load factor in ``named``.

    If several load factors are equally low, the last of them is returned.
    """
    least = min(named.values())
    return next((name, value) for name, value in reversed(named.items()) if value == least)


def _upper_bounds(answer: CrossingLoadFactors) -> dict[str, float]:
    """Return the upper bounds on the least load factor of a crossing, by name.

    The load factors of :func:`_by_chords` are left out, because they are no upper bounds.
    """
    worst, default, bounds = answer.worst, answer.default, dict[str, float]()
    if worst.load_factor is not None and worst.crushing != "chords":
        kind = "proven to be the least λ at the worst position" if known_least(worst) else "an upper bound"
        bounds[f"governing λ by method '{worst.method}', {kind}"] = worst.load_factor
    if default is not None and default.load_factor is not None and default.crushing != "chords":
        name = f"upper bound by method '{default.method}' at the worst position"
        bounds[name] = default.load_factor
    if answer.by_parabola is not None:
        bounds["associative λ with the crushing parabola, an upper bound on λ"] = answer.by_parabola
    return bounds


def _solved_by_chords(answer: CrossingLoadFactors) -> list[tuple[Result, float]]:
    """Return the results at the worst position whose crushing law uses chords, and their load factors.

    They are results of the chosen method and of the default method. Results without a load factor are left
    out.
    """
    results = [result for result in (answer.worst, answer.default) if result is not None]
    return [
        (result, result.load_factor)
        for result in results
        if result.load_factor is not None and result.crushing == "chords"
    ]


def _by_chords(answer: CrossingLoadFactors) -> dict[str, float]:
    """Return the load factors at the worst position that were computed with chords for crushing, by name.

    They are load factors of the chosen method and of the default method. They are no upper bounds on the load
    factor with the crushing parabola.
    """
    return {
        (
            f"λ by method '{result.method}' at the worst position, "
            "with chords instead of the crushing parabola"
        ): load_factor
        for result, load_factor in _solved_by_chords(answer)
    }


def _raised_by_parabola(answer: CrossingLoadFactors) -> dict[str, float]:
    """Return estimates of load factors with the crushing parabola, from load factors with chords, by name.

    Each load factor with chords is multiplied by a ratio: the associative load factor with the parabola,
    divided by the associative load factor with chords, both at the worst position. The product is an upper
    estimate under the assumption that the parabola raises λ of the method by at most this ratio. The
    assumption is exact for associative methods, and not proven for Coulomb friction. A load factor is left
    out if one of its two associative load factors is not known.
    """
    worst, raised = answer.worst, dict[str, float]()
    by_parabola = worst.load_factor if worst.crushing == "parabola" else answer.by_parabola
    for result, load_factor in _solved_by_chords(answer):
        associative = result.associative
        if by_parabola is None or associative is None or associative <= 0:
            continue
        ratio = max(1.0, by_parabola / associative)
        name = (
            f"λ = {numeral(load_factor, '.6f')} by method '{result.method}' with chords, multiplied by "
            f"{numeral(ratio, '.6f')}: the crushing parabola raises the associative λ by this factor, and is "
            "assumed to raise other values of λ by at most this factor"
        )
        raised[name] = load_factor * ratio
    return raised


def _why_undecided(answer: CrossingLoadFactors, required: float) -> str:
    """Return the reason why the comparison with the required load factor is undecided; "" if it is decided.

    The upper bounds on the load factor must not be less than the required load factor.
    """
    if answer.interrupted:
        by_limit = "the time limit ended the crossing"
        return by_limit if answer.time_limit_reached else "the crossing was interrupted"
    if answer.least is None:
        return "it is unknown whether the scene carries its dead load"
    if answer.undecided:
        return "λ could not be computed at some positions"
    bound, by_chords = answer.bound, _by_chords(answer)
    if by_chords and _is_below(min(by_chords.values()), required):
        name, least = _last_of_least(by_chords)
        below = f"{numeral(least, '.6f')} is below it ({name})"
        missing = (
            f"; the associative λ with the parabola is unknown: {answer.no_parabola}"
            if answer.no_parabola
            else ""
        )
        return f"{below}, but the crushing parabola may permit a larger λ{missing}"
    if bound is not None and _is_below(bound, required):
        return (
            f"the required load factor is between the proven lower bound {numeral(bound, '.6f')} and the "
            "governing λ, even with the smallest permitted distance between solved positions"
        )
    return ""


def assessment_text(answer: CrossingLoadFactors, required: float) -> str:
    """Return a text that compares λ with a required load factor, such as "λ ≥ 3.4: passed, ..."."""
    outcome, load_factor, why = assessed(answer, required)
    head = f"λ ≥ {numeral(required, '.6g')}: {outcome}"
    if load_factor is None or outcome is AssessmentOutcome.UNDECIDED:
        return f"{head}, because {why}"
    ratio = numeral(load_factor / required, ".3f")
    return f"{head}, {numeral(load_factor, '.6f')} is {ratio} times the required load factor ({why})"


def capacity_text(answer: CrossingLoadFactors) -> str:
    """Return the loads at collapse as text; empty if there is no load factor or the crossing ended early."""
    load_factor, trials = answer.load_factor, answer.least
    if load_factor is None or trials is None or answer.interrupted:
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
    return f"loads {FORCE_UNIT}: {'; '.join(parts)}{included}"


def _listed(values: Iterable[float]) -> str:
    """Return numbers as text. If all numbers are equal, the text is short, such as "3 × 120"."""
    numbers = [numeral(value, ".6g") for value in values]
    if len(numbers) > 1 and len({*numbers}) == 1:
        return f"{len(numbers)} × {numbers[0]}"
    return ", ".join(numbers)

"""The verdict on a run, by its certificate and by what is known of its scene: bounds, claims by hand, and the
lowest exact Coulomb state."""

import tomllib
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any, NamedTuple

from masonry_opt.answer.acceptance import LIMITS, OUTSIDE, SMALLEST, Kind
from masonry_opt.answer.infeasibility import Existence
from masonry_opt.answer.reasons import Status
from masonry_opt.answer.thresholds import SAME, is_lower
from masonry_opt.errors import CaseError
from masonry_opt.methods.registry import METHODS
from masonry_opt.studies.compare.accuracy import CertifiedBounds
from masonry_opt.studies.compare.runs import CaseScene, by_sides, residuals_over_limit
from masonry_opt.studies.runner import FINISHED, REFUSED

#: The kinds of answer that can be exact: in the loop's, sliding may contract.
_EXACT_KINDS = (Kind.ONE_PASS, Kind.RELAXED, Kind.EXACT)

#: The two questions: the load factor with normal flow, and with Coulomb's.
ASSOCIATIVE, COULOMB = "associative", "Coulomb"

#: Claims of an analysis on a scene: that it has a load factor, or why it has none. Every other end (not
#: converged, solver failed, a limit) concerns the method alone.
ANSWER = "answer"
CLAIMS = (ANSWER, REFUSED, Status.UNSTABLE, Status.UNLIMITED, Status.LOCKED, Status.JAMMED)

#: Verdicts, best first. The first two are a success; only the first is drawn as a point of time and error.
#: certified: a load factor whose certificate holds, not contradicted by what is known of the scene.
#: named correctly: no load factor, and the right reason why the scene has none, or a proof that it has none.
#: failed but said so: no answer (not converged, solver failed, a limit), or a reason that nobody can confirm.
#: wrong: a load factor whose certificate fails, or that is known to be false, or a false reason.
CERTIFIED, NAMED, FAILED, WRONG = "certified", "named correctly", "failed but said so", "wrong"
VERDICTS = (CERTIFIED, NAMED, FAILED, WRONG)

JUDGED = ("question", "verdict", "reason", "error", "below")  #: Columns of what is said of a run.
GAP_FLOOR = SAME  #: Gaps to the best exact Coulomb state below this count as none, and are drawn there.


class BestKnown(NamedTuple):
    """The lowest exact load factor of a scene, and the method that found it."""

    load_factor: float
    method: str


def best_known(scenes: Iterable[CaseScene], folder: Path) -> dict[str, BestKnown]:
    """The lowest exact states known of scenes, by name, from best_known.toml in a folder, if there; none of a
    changed scene. Raises CaseError if the file is not as those of the package."""
    registry, found = folder / "best_known.toml", dict[str, BestKnown]()
    try:
        entries = tomllib.loads(registry.read_text("utf-8")) if registry.exists() else {}
        for scene in scenes:
            entry = entries.get(f"{scene.name}.toml")
            if entry is not None and entry["content"] == scene.content:
                found[scene.name] = BestKnown(float(entry["load_factor"]), str(entry["method"]))
    except (OSError, ValueError, KeyError, TypeError) as error:
        raise CaseError(f"{registry}: needs content, load_factor and method of each scene: {error}") from None
    return found


def lowest_exact(rows: Iterable[dict[str, Any]], known: Mapping[str, BestKnown]) -> dict[str, BestKnown]:
    """The lowest exact Coulomb states, by scene name: those known, or of runs, in space by the cone. A single
    pass ends in any exact state: it counts only where a low one is known or was searched for."""
    able = (row for row in rows if row["load_factor"] is not None and row["kind"] in _EXACT_KINDS)
    exact = [row for row in able if not by_sides(row) and not residuals_over_limit(row, Kind.EXACT)]
    low = {*known, *(row["scene"] for row in exact if row["kind"] != Kind.ONE_PASS)}
    best = dict(known)
    for row in exact:
        scene, found = row["scene"], row["load_factor"]
        if scene in low and (scene not in best or is_lower(found, best[scene].load_factor)):
            best[scene] = BestKnown(found, row["method"])
    return best


def known_claims(question: str, bounds: CertifiedBounds, expected: Mapping[str, str]) -> dict[str, bool]:
    """Whether each claim is right, by bounds of the associative load factor, or as derived by hand (the
    failure atlas); unknown ones are left out. The bounds decide the associative question. Coulomb's law has
    the same states of equilibrium within yield: if the dead load has none, the scene does not stand; if their
    load factors are bounded, λ is limited. It has other mechanisms, so nothing else follows."""
    if question in expected:
        return {claim: claim == expected[question] for claim in CLAIMS}
    right: tuple[str, ...] = ()
    if bounds.unstable:
        right = (Status.UNSTABLE,)
    elif question == COULOMB:
        false = (Status.UNLIMITED, Status.LOCKED, Status.JAMMED) if bounds.finite else ()
        return dict.fromkeys(false, False)
    elif bounds.finite:
        right = (ANSWER,)
    elif bounds.unlimited:
        right = (Status.UNLIMITED, Status.LOCKED)
    return {claim: claim in right for claim in CLAIMS if claim != REFUSED} if right else {}


def question_of(method: str) -> str:
    """The λ that a method computes."""
    return ASSOCIATIVE if METHODS[method].associative else COULOMB


def judge(
    row: dict[str, Any], bounds: CertifiedBounds | None, best: BestKnown | None, expected: Mapping[str, str]
) -> dict[str, Any]:
    """Verdict and errors of one run, by name (see :func:`known_claims` for ``expected``). ``verdict``: one of
    VERDICTS. ``reason``: why, in words; "" if it is certified. ``error``: relative distance of λ from the
    middle of the bounds (half their width at least) or from the best exact Coulomb state (GAP_FLOOR at
    least). ``below``: whether λ is below that state. A missing number is None.

    The bounds are those with crushing by chords, and in space by cones: not applied to a run with the
    parabola; of one by the sides of cones the lower does not hold, nor that λ is unlimited.
    """
    question, bounds = question_of(row["method"]), bounds or CertifiedBounds()
    if row["crushing"] == "parabola" or (by_sides(row) and not bounds.finite):
        bounds = CertifiedBounds()
    known = known_claims(question, bounds, expected)
    verdict, reason = _verdict(row, bounds, known)
    load_factor, error, below = row["load_factor"], None, False
    if load_factor is not None and question == ASSOCIATIVE and bounds.finite:
        error = max(abs(_relative(load_factor, bounds.middle)), bounds.width / 2, 1e-16)
    elif load_factor is not None and question == COULOMB and best is not None:
        gap = _relative(load_factor, best.load_factor)
        error, below = max(abs(gap), GAP_FLOOR), gap < -GAP_FLOOR
    return dict(zip(JUDGED, (question, verdict, reason, error, below), strict=True))


def _verdict(row: dict[str, Any], bounds: CertifiedBounds, known: Mapping[str, bool]) -> tuple[str, str]:
    """The verdict, and why, in words; "" if it is certified."""
    load_factor, ended = row["load_factor"], row["ended"]
    claim = ended if ended != FINISHED else row["status"] if load_factor is None else ANSWER
    said = ": ".join(map(str, filter(None, [row["status"] if ended == FINISHED else ended, row["message"]])))
    if known.get(claim) is False:
        right = " or ".join(claim for claim in CLAIMS if known.get(claim))
        return WRONG, f"{said} (right: {right or 'not this'})"
    if claim != ANSWER:
        named = known.get(claim) or (row["existence"] and Existence(row["existence"]).proven)
        return (NAMED if named else FAILED), said
    if over := residuals_over_limit(row):
        limits = LIMITS[Kind(row["kind"])].as_dict()
        large = [f"{name} {of:.1e} > {limits[name]:.0e}" for name, of in over.items() if of is not None]
        return WRONG, ", ".join(large) or "no certificate"
    if bounds.finite:
        margin = OUTSIDE * max(abs(bounds.middle), SMALLEST)
        if load_factor > bounds.upper + margin:
            return WRONG, "λ above its certified bound"
        # States of Coulomb's law, and within sides, are states of eq. (9): they have the upper bound alone.
        both = question_of(row["method"]) == ASSOCIATIVE and not by_sides(row)
        if both and load_factor < bounds.lower - margin:
            return WRONG, "λ below its certified bound"
    return CERTIFIED, ""


def _relative(load_factor: float, to: float) -> float:
    return (load_factor - to) / max(abs(to), SMALLEST)

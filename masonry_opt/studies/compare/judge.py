"""Verdicts on the runs of a comparison, and their summary: medians, Pareto fronts, rates of success."""

import tomllib
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pandas as pd

from masonry_opt.brief import brief
from masonry_opt.errors import CaseError, counted, printable
from masonry_opt.files import image_source
from masonry_opt.methods.registry import METHODS
from masonry_opt.problem.load_factor_scale import EQUALITY_TOLERANCE, LoadFactorScale
from masonry_opt.reporting.names import warning_lines
from masonry_opt.solution.acceptance import LARGEST_BOUND_EXCESS, LIMITS, Kind
from masonry_opt.solution.answer import Existence
from masonry_opt.solution.reasons import Status
from masonry_opt.studies.compare.accuracy import CertifiedBounds
from masonry_opt.studies.compare.runs import (
    CERTIFICATE_RESIDUALS,
    COMPARISON_COLUMNS,
    CaseScene,
    RunLimits,
    RunPlan,
)
from masonry_opt.studies.runner import FINISHED
from masonry_opt.studies.writing import in_words, notebook_html

#: Kinds of answers that can be exact collapse states. Answers of the paper's loop of linear programs are
#: excluded, because their sliding joints may contract, which violates the flow rule.
_EXACT_KINDS = (Kind.NEARLY_COMPLEMENTARY, Kind.RELAXED, Kind.EXACT)

ASSOCIATIVE = "associative"  #: Value of column "question" for load factors with associative flow.
COULOMB = "Coulomb"  #: Value of column "question" for load factors with the joints' own dilatancy.

ANSWER = "answer"  #: Claim of a run: it has found a load factor of its scene.
#: Claims of a run about its scene that can be true or false: a load factor, or the reason why no load factor
#: exists. A run that ends in another way (not converged, solver failed, limit exceeded) makes no claim.
CLAIMS = (ANSWER, Status.UNSTABLE, Status.UNLIMITED, Status.LOCKED, Status.JAMMED)

CERTIFIED = "certified"  #: Verdict on a run whose load factor is certified.
REASON_NAMED = "named correctly"  #: Verdict on a run that states correctly why no load factor exists.
FAILED = "reported failure"  #: Verdict on a run that makes no claim about its scene.
WRONG = "wrong"  #: Verdict on a run whose claim is false.
#: Verdicts from best to worst. The first two verdicts count as success.
VERDICTS = (
    CERTIFIED,
    REASON_NAMED,
    FAILED,
    WRONG,
)

JUDGED = ("question", "verdict", "reason", "error", "below")  #: Columns of the verdict on a run.
#: Relative gaps to the best exact Coulomb state count as zero if they are smaller than this value. Charts
#: draw such gaps at this value.
GAP_FLOOR = EQUALITY_TOLERANCE

_PAIR_COLUMNS = ["method", "model", "solver", "tolerance"]  #: Columns that identify a ``Pair``.
#: Columns of a summary that contain the median over the repeats of a run.
_MEDIANS = ["time", "build_seconds", "compile_seconds", "solve_seconds", "read_seconds", "peak_memory"]
_COUNTS = ["lp_solves", "nlp_solves", "iterations"]  #: Columns of a summary that are counts.
#: Columns of a summary that are numbers.
_NUMBERS = [
    *_MEDIANS,
    *_COUNTS,
    *CERTIFICATE_RESIDUALS,
    "tolerance",
    "error",
    "load_factor",
    "bound",
    "joints",
    "blocks",
]
#: All columns of a summary, in order.
_SUMMARY = [
    *("scene", "pair", *_PAIR_COLUMNS, "question", "verdict", "reason", "load_factor", "error", "below"),
    *(*_MEDIANS, *_COUNTS, "repeats", "joints", "blocks", *CERTIFICATE_RESIDUALS),
    *("bound", "ended", "status", "kind", "message"),
]

#: Columns of the table of success rates, in addition to the columns method, model and solver.
SUCCESS = ["tolerance", "success", *VERDICTS, "time", "largest error", "peak_memory"]
#: Headings of those table columns whose heading is not the column's name.
HEADINGS = {
    "time": "median time (s)",
    "peak_memory": "peak (MB)",
    "pair": "method · model · solver",
    "reason": "why",
    "lp_solves": "LPs",
}
#: Columns of the printed table of success rates. The table fits into lines of 100 characters, so it has fewer
#: columns than the table on the HTML page.
PRINTED = ("method", "model", "solver", "tolerance", "success", *VERDICTS, "time", "largest error")
#: Headings of the printed table, for columns whose heading differs from the column's name.
PRINTED_HEADINGS = {"tolerance": "tol.", REASON_NAMED: "named", FAILED: "failed", "time": "time (s)"}
#: Formats of numbers by column.
NUMBER_FORMATS = {
    "success": "{:.0%}",
    "load_factor": "{:.9g}",
    "time": "{:.3g}",
    "peak_memory": "{:.0f}",
    **dict.fromkeys(("error", "largest error"), "{:.1e}"),
    **dict.fromkeys(("tolerance", *CERTIFICATE_RESIDUALS), "{:.0e}"),
}

#: Duration in seconds above which a run is not repeated, because long times vary little.
REPEATED_BELOW = 5.0


class BestKnown(NamedTuple):
    """Lowest known exact load factor of a scene, and the method that found it."""

    load_factor: float
    method: str


def best_known(scenes: Iterable[CaseScene], folder: Path) -> dict[str, BestKnown]:
    """Read best_known.toml in a folder, and return the lowest known exact state of each scene, by scene name.

    Entries of scenes whose content has changed since are omitted. Raises CaseError if the file has another
    form.
    """
    registry = folder / "best_known.toml"
    best: dict[str, BestKnown] = {}
    try:
        entries = tomllib.loads(registry.read_text("utf-8")) if registry.exists() else {}
        for scene in scenes:
            entry = entries.get(f"{scene.name}.toml")
            if entry is not None and entry["content"] == scene.content:
                best[scene.name] = BestKnown(float(entry["load_factor"]), str(entry["method"]))
    except (OSError, ValueError, KeyError, TypeError) as error:
        raise CaseError(
            f"{registry}: the entry of each scene needs the keys content, load_factor and method: {error}"
        ) from None
    return best


def chart_name(question: str) -> str:
    """Return the name of the chart of time against error, for associative or Coulomb load factors."""
    return f"time_error_{question.lower()}"


def lowest_exact(rows: Iterable[dict[str, Any]], known: Mapping[str, BestKnown]) -> dict[str, BestKnown]:
    """Return, by scene name, the exact Coulomb state with the lowest λ, from known states and runs.

    In space only runs with the friction cone are used. The state of a nearly complementary run need not be a
    low one, so it is used only if the scene has a known state, or a state of another kind of run.
    """
    candidates = (row for row in rows if row["load_factor"] is not None and row["kind"] in _EXACT_KINDS)
    exact = [row for row in candidates if not _by_sides(row) and not residuals_over_limit(row, Kind.EXACT)]
    searched = {*known, *(row["scene"] for row in exact if row["kind"] != Kind.NEARLY_COMPLEMENTARY)}
    best = dict(known)
    for row in exact:
        scene, load_factor = row["scene"], row["load_factor"]
        if scene in searched and (
            scene not in best or _scale(row).is_lower(load_factor, best[scene].load_factor)
        ):
            best[scene] = BestKnown(load_factor, row["method"])
    return best


def _known_claims(question: str, bounds: CertifiedBounds) -> dict[str, bool]:
    """Return the claims about a scene that are proven or refuted by bounds on its associative λ.

    The result is a dict with the claims as keys: a proven claim has the value True, a refuted claim False.
    For associative flow the bounds decide all claims. Coulomb friction has the same admissible states of
    equilibrium, but other mechanisms. For Coulomb friction only two conclusions are possible:

    - If no admissible state carries the dead load, the scene is unstable.
    - If the load factors of admissible states are bounded, the scene does not carry any load.
    """
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
    return {claim: claim in right for claim in CLAIMS} if right else {}


def question_of(method: str) -> str:
    """Return the kind of load factor that a method computes: ASSOCIATIVE or COULOMB."""
    return ASSOCIATIVE if METHODS[method].associative else COULOMB


def claim_of(row: Mapping[Any, Any]) -> str:
    """Return the claim of a run about its scene (one of CLAIMS) or, without a claim, how the run ended."""
    if row["ended"] != FINISHED:
        return row["ended"]
    return row["status"] if pd.isna(row["load_factor"]) else ANSWER


def judge(row: dict[str, Any], bounds: CertifiedBounds | None, best: BestKnown | None) -> dict[str, Any]:
    """Return the verdict on one run and the error of its load factor, by column name (see ``JUDGED``).

    - ``question``: ASSOCIATIVE or COULOMB.
    - ``verdict``: one of VERDICTS.
    - ``reason``: reason of the verdict, as text; "" if the answer is certified.
    - ``error``: for associative load factors, the relative distance of λ from the middle of the bounds, at
      least half of their width. For Coulomb load factors, the relative distance from the best exact state,
      at least GAP_FLOOR. None if it is unknown.
    - ``below``: True if λ is below the best exact state.

    The bounds are valid for crushing by chords, and in space for friction cones. They are not applied to a
    run with the parabola of crushing. For a run with polygons inside the friction cones, neither the lower
    bound nor a proof of unlimited λ is applied.
    """
    question, bounds = question_of(row["method"]), bounds or CertifiedBounds()
    if row["crushing"] == "parabola" or (_by_sides(row) and not bounds.finite):
        bounds = CertifiedBounds()
    verdict, reason = _verdict(row, bounds, _known_claims(question, bounds))
    load_factor, error, below = row["load_factor"], None, False
    if load_factor is not None and question == ASSOCIATIVE and bounds.finite:
        error = max(abs(_relative(row, bounds.middle)), bounds.width / 2, 1e-16)
    elif load_factor is not None and question == COULOMB and best is not None:
        gap = _relative(row, best.load_factor)
        error, below = max(abs(gap), GAP_FLOOR), gap < -GAP_FLOOR
    return dict(zip(JUDGED, (question, verdict, reason, error, below), strict=True))


def _verdict(row: dict[str, Any], bounds: CertifiedBounds, known: Mapping[str, bool]) -> tuple[str, str]:
    """Return the verdict on a run, and the reason for the verdict as text ("" if the answer is certified)."""
    load_factor, claim = row["load_factor"], claim_of(row)
    end = row["status"] if row["ended"] == FINISHED else row["ended"]
    statement = f"{end}: {row['message']}" if row["message"] else str(end)
    if known.get(claim) is False:
        right = " or ".join(claim for claim in CLAIMS if known.get(claim))
        return WRONG, f"{statement} (right: {right or 'not this'})"
    if claim != ANSWER:
        named = known.get(claim) or (row["existence"] and Existence(row["existence"]).proven)
        return (REASON_NAMED if named else FAILED), statement
    residuals = residuals_over_limit(row)
    if residuals:
        limits = LIMITS[Kind(row["kind"])].as_dict()
        large = [
            f"{name} {value:.1e} > {limits[name]:.0e}"
            for name, value in residuals.items()
            if value is not None
        ]
        return WRONG, ", ".join(large) or "no certificate"
    if bounds.finite:
        margin = LARGEST_BOUND_EXCESS * _scale(row).divisor(bounds.middle)
        if load_factor > bounds.upper + margin:
            return WRONG, "λ above its certified bound"
        # The lower bound is valid only for the associative λ, the maximum of eq. (9). Coulomb states, and
        # states with polygons inside the friction cones, may have a smaller λ.
        has_lower_bound = question_of(row["method"]) == ASSOCIATIVE and not _by_sides(row)
        if has_lower_bound and load_factor < bounds.lower - margin:
            return WRONG, "λ below its certified bound"
    return CERTIFIED, ""


def _by_sides(row: Mapping[Any, Any]) -> bool:
    """Return True if a run limits friction in space by polygons inside the friction cones."""
    return "polygon" in row["friction_law"]


def residuals_over_limit(row: Mapping[Any, Any], kind: Kind | None = None) -> dict[str, float | None]:
    """Return the residuals of a run that exceed the limits for the run's kind of answer.

    The argument ``kind`` replaces the kind of the answer.

    A residual that is missing or NaN counts as exceeding the limits.
    """
    residuals = {name: row[name] for name in CERTIFICATE_RESIDUALS}
    energy = residuals["complementarity"]
    if energy is not None:
        residuals["complementarity"] = energy / _scale(row).divisor(row["load_factor"])
    return LIMITS[kind or Kind(row["kind"])].failing(residuals)


def _relative(row: Mapping[Any, Any], reference: float) -> float:
    """Return the relative difference of a run's load factor from a reference value."""
    difference: float = row["load_factor"] - reference
    return difference / _scale(row).divisor(reference)


def _scale(row: Mapping[Any, Any]) -> LoadFactorScale:
    """Return the scale for comparing the load factor of a finished run with other load factors."""
    return LoadFactorScale(row["load_factor_unit"])


def summary(
    rows: Iterable[dict[str, Any]], bounds: Mapping[str, CertifiedBounds], best: Mapping[str, BestKnown]
) -> pd.DataFrame:
    """Return a table of median times and worst verdicts, with one row for each scene and ``Pair``.

    A ``Pair`` is a combination of method, modelling language, solver and tolerance. Medians and worst
    verdicts are those of the repeats of a run.

    The column ``time`` is the time of the solve in seconds, without the steps that all pairs have in common:
    reading the scene and checking its dead load.

    Parameters
    ----------
    rows: Rows of runs.
    bounds, best: Certified bounds and best known states by scene name.
    """
    judged = []
    for row in rows:
        shared = (row["scene_seconds"] or 0.0) + (row["dead_load_seconds"] or 0.0)
        verdict = judge(row, bounds.get(row["scene"]), best.get(row["scene"]))
        judged.append(row | {"time": row["wall"] - shared} | verdict)
    frame = pd.DataFrame(judged, columns=[*COMPARISON_COLUMNS, "time", *JUDGED])
    frame["pair"] = frame["method"] + " · " + frame["model"] + " · " + frame["solver"]
    frame[_NUMBERS] = frame[_NUMBERS].astype(float)
    repeats = frame.groupby(["scene", *_PAIR_COLUMNS], dropna=False, sort=False)
    frame["of"], frame["badness"] = repeats.ngroup(), frame["verdict"].map(VERDICTS.index)
    frame["repeats"] = repeats["scene"].transform("size")
    frame[_MEDIANS] = repeats[_MEDIANS].transform("median")
    worst = frame.sort_values(["of", "badness"], kind="stable").drop_duplicates("of", keep="last")
    return worst[_SUMMARY].reset_index(drop=True)


def answers(frame: pd.DataFrame) -> pd.DataFrame:
    """Return the best run of each method on each scene, ranked by verdict, error and time.

    Errors up to ``EQUALITY_TOLERANCE`` count as equal. A load factor below the best exact state counts as
    exact.
    """
    error = frame["error"].mask(frame["below"].astype(bool), 0.0).clip(lower=EQUALITY_TOLERANCE)
    order = frame.assign(rank=frame["verdict"].map(VERDICTS.index), far=error)
    first = order.sort_values(["rank", "far", "time"], kind="stable").drop_duplicates(["scene", "method"])
    return first.drop(columns=["rank", "far"])


def pareto(frame: pd.DataFrame) -> pd.DataFrame:
    """Return the certified rows on the Pareto front of time and error, in the order of time."""
    known = frame[(frame["verdict"] == CERTIFIED) & frame["error"].notna()]
    known = known.sort_values(["time", "error"])
    return known[known["error"] < known["error"].cummin().shift(fill_value=np.inf)]


def success(frame: pd.DataFrame) -> pd.DataFrame:
    """Return a table that counts the verdicts over all scenes, with one row for each ``Pair``.

    The column ``success`` is the fraction of scenes with a certified load factor, or with the correct reason
    why no load factor exists. The median time and the largest error are those of certified answers, and
    ``peak_memory`` (MB) is the largest of all runs.
    """
    ended = {verdict: frame["verdict"] == verdict for verdict in VERDICTS}
    of_certified = {name: frame[name].where(ended[CERTIFIED]) for name in ("time", "error")}
    marked = frame.assign(**ended, success=ended[CERTIFIED] | ended[REASON_NAMED], **of_certified)
    columns: dict[str, Any] = {verdict: (verdict, "sum") for verdict in VERDICTS}
    columns |= {"scenes": ("scene", "size"), "success": ("success", "mean"), "time": ("time", "median")}
    columns |= {"largest error": ("error", "max"), "peak_memory": ("peak_memory", "max")}
    return marked.groupby(["pair", *_PAIR_COLUMNS], dropna=False, sort=False).agg(**columns).reset_index()


@dataclass(frozen=True)
class Comparison:
    """Results of a comparison. ``print`` shows the table of success rates, the notes and the warnings."""

    scenes: tuple[CaseScene, ...]
    plan: RunPlan
    limits: RunLimits
    bounds: dict[str, CertifiedBounds]  #: bounds on the associative load factor, by scene name
    best: dict[str, BestKnown]  #: lowest known exact Coulomb states, by scene name
    #: Table with one row for each run: its method and solver, verdict, load factor, residuals, time and size.
    results: pd.DataFrame
    #: Table with one row for each scene and each combination of method, modelling language, solver and
    #: tolerance.
    summary: pd.DataFrame
    notes: tuple[str, ...] = ()  #: remarks, one line each
    interrupted: bool = False  #: True if runs are missing
    warnings: tuple[str, ...] = ()  #: warnings about damaged lines of the journal and about unusual inputs
    #: Paths of the written files: tables, charts and the report.
    files: tuple[Path, ...] = field(default=(), repr=False, compare=False)

    __repr__ = brief

    @property
    def notebook_table(self) -> pd.DataFrame:
        """Table of success rates, formatted as text, that a notebook displays."""
        return in_words(success(self.summary), NUMBER_FORMATS, PRINTED).rename(columns=PRINTED_HEADINGS)

    def _repr_html_(self) -> str:
        """Return HTML for a notebook: notes and warnings, the table of success rates, and the first chart."""
        charts = [file.read_bytes() for file in self.files if file.suffix == ".svg" and file.is_file()]
        source = image_source(charts[0], "svg") if charts else ""
        words = "\n".join([*self.notes, *warning_lines(self.warnings)])
        return notebook_html(printable(words), self.notebook_table, source)

    def __str__(self) -> str:
        """Return the table of success rates, the omitted combinations, the notes and the warnings as text."""
        lines = []
        if len(self.summary):
            lines += [self.notebook_table.to_string(index=False), ""]
            scenes = counted(len(self.scenes), "scene")
            lines += [
                f"the table covers {scenes}; "
                "success is the share of runs with a certified load factor or a correct reason"
            ]
            lines += ["named: the run has no load factor, and names the correct reason"]
            lines += [
                "failed: the run reports that it has no answer; wrong: the reported answer or reason is wrong"
            ]
            lines += ["time and largest error include only certified answers"]
            lines += [
                f"time: median of {counted(self.limits.repeats, 'run')}; "
                f"a run that takes over {REPEATED_BELOW:g} s is not repeated"
            ]
        if self.plan.left_out:
            lines.append("\nnot applicable:")
            lines += [f"  {' · '.join(names)}: {reason}" for *names, reason in self.plan.left_out]
        if self.notes:
            lines += ["\nnotes:", *(f"  {note}" for note in self.notes)]
        return printable("\n".join([*lines, *warning_lines(self.warnings)]))

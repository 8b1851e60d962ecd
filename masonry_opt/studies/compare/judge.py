"""Verdicts on runs, and what a comparison found: medians, Pareto fronts, success."""

import tomllib
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pandas as pd

from masonry_opt.answer.acceptance import LIMITS, OUTSIDE, SMALLEST, Kind, over_load_factor
from masonry_opt.answer.answer import Existence
from masonry_opt.answer.reasons import Status
from masonry_opt.answer.thresholds import SAME, is_lower
from masonry_opt.errors import CaseError, counted, printable
from masonry_opt.files import image_source
from masonry_opt.methods.registry import METHODS
from masonry_opt.studies.compare.accuracy import CertifiedBounds
from masonry_opt.studies.compare.runs import COLUMNS, RESIDUALS, CaseScene, RunLimits, RunPlan
from masonry_opt.studies.runner import FINISHED
from masonry_opt.studies.writing import in_words, notebook_html
from masonry_opt.words.names import warning_lines

#: The kinds of answer that can be exact: in the loop's, sliding may contract.
_EXACT_KINDS = (Kind.NEARLY_COMPLEMENTARY, Kind.RELAXED, Kind.EXACT)

#: The two questions: the load factor with normal flow, and with Coulomb's.
ASSOCIATIVE, COULOMB = "associative", "Coulomb"

#: Claims of an analysis on a scene: that it has a load factor, or why it has none. Every other end (not
#: converged, solver failed, a limit) concerns the method alone.
ANSWER = "answer"
CLAIMS = (ANSWER, Status.UNSTABLE, Status.UNLIMITED, Status.LOCKED, Status.JAMMED)

#: Verdicts, best first: the page says what they mean. The first two are a success; only the first is drawn as
#: a point of time and error.
CERTIFIED, NAMED, FAILED, WRONG = "certified", "named correctly", "failed but said so", "wrong"
VERDICTS = (CERTIFIED, NAMED, FAILED, WRONG)

JUDGED = ("question", "verdict", "reason", "error", "below")  #: Columns of what is said of a run.
GAP_FLOOR = SAME  #: Gaps to the best exact Coulomb state below this count as none, and are drawn there.

_PAIR = ["method", "model", "solver", "tolerance"]
#: Numbers of a summary that are medians of the repeats.
_MEDIANS = ["time", "build_seconds", "compile_seconds", "solve_seconds", "read_seconds", "peak_memory"]
_COUNTS = ["lp_solves", "nlp_solves", "iterations"]
#: Numbers of a run, and columns of a summary.
_NUMBERS = [*_MEDIANS, *_COUNTS, *RESIDUALS, "tolerance", "error", "load_factor", "bound", "joints", "blocks"]
_SUMMARY = ["scene", "pair", *_PAIR, "question", "verdict", "reason", "load_factor", "error", "below"]
_SUMMARY += [*_MEDIANS, *_COUNTS, "repeats", "joints", "blocks", *RESIDUALS]
_SUMMARY += ["bound", "ended", "status", "kind", "message"]

#: Columns of the success table; headings that are not the columns' names; how numbers are written there.
SUCCESS = ["tolerance", "success", *VERDICTS, "time", "largest error", "peak_memory"]
HEADINGS = {"time": "median time (s)", "peak_memory": "peak (MB)", "pair": "method · model · solver"}
HEADINGS |= {"reason": "why", "lp_solves": "LPs"}
#: Columns of the printed table, and its headings: they fit into 100 columns of a terminal. The page has more.
PRINTED = ("method", "model", "solver", "tolerance", "success", *VERDICTS, "time", "largest error")
PRINTED_HEADINGS = {"tolerance": "tol.", NAMED: "named", FAILED: "failed", "time": "time (s)"}
FORMATS = {"success": "{:.0%}", "load_factor": "{:.9g}", "time": "{:.3g}", "peak_memory": "{:.0f}"}
FORMATS |= dict.fromkeys(("error", "largest error"), "{:.1e}")
FORMATS |= dict.fromkeys(("tolerance", *RESIDUALS), "{:.0e}")

REPEATED_BELOW = 5.0  #: Runs that take longer (seconds) are not repeated: their scatter is relatively small.


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


def chart_name(question: str) -> str:
    """Return the name of the chart of time against error for a question."""
    return f"time_error_{question.lower()}"


def lowest_exact(rows: Iterable[dict[str, Any]], known: Mapping[str, BestKnown]) -> dict[str, BestKnown]:
    """Return the lowest exact Coulomb state of each scene, by the name of the scene.

    The states are the known ones and those of runs, in space with friction by the cone. A state that is exact
    but for its complementarity counts only for scenes that have another state.
    """
    able = (row for row in rows if row["load_factor"] is not None and row["kind"] in _EXACT_KINDS)
    exact = [row for row in able if not _by_sides(row) and not residuals_over_limit(row, Kind.EXACT)]
    low = {*known, *(row["scene"] for row in exact if row["kind"] != Kind.NEARLY_COMPLEMENTARY)}
    best = dict(known)
    for row in exact:
        scene, found = row["scene"], row["load_factor"]
        if scene in low and (scene not in best or is_lower(found, best[scene].load_factor)):
            best[scene] = BestKnown(found, row["method"])
    return best


def _known_claims(question: str, bounds: CertifiedBounds) -> dict[str, bool]:
    """Whether each claim is right, by bounds of the associative load factor; unknown ones are left out. The
    bounds decide the associative question. Coulomb's law has the same states of equilibrium within yield: if
    the dead load has none, the scene does not stand; if their load factors are bounded, λ is limited. It has
    other mechanisms, so nothing else follows."""
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
    """The λ that a method computes."""
    return ASSOCIATIVE if METHODS[method].associative else COULOMB


def claim_of(row: Mapping[Any, Any]) -> str:
    """What a run claims of its scene: one of CLAIMS, or another end."""
    if row["ended"] != FINISHED:
        return row["ended"]
    return row["status"] if pd.isna(row["load_factor"]) else ANSWER


def judge(row: dict[str, Any], bounds: CertifiedBounds | None, best: BestKnown | None) -> dict[str, Any]:
    """Verdict and errors of one run, by name. ``verdict``: one of VERDICTS. ``reason``: why, in words; "" if
    it is certified. ``error``: relative distance of λ from the middle of the bounds (half their width at
    least) or from the best exact Coulomb state (GAP_FLOOR at least). ``below``: whether λ is below that
    state. A missing number is None.

    The bounds are those with crushing by chords, and in space by cones: not applied to a run with the
    parabola; of one by the sides of cones the lower does not hold, nor that λ is unlimited.
    """
    question, bounds = question_of(row["method"]), bounds or CertifiedBounds()
    if row["crushing"] == "parabola" or (_by_sides(row) and not bounds.finite):
        bounds = CertifiedBounds()
    verdict, reason = _verdict(row, bounds, _known_claims(question, bounds))
    load_factor, error, below = row["load_factor"], None, False
    if load_factor is not None and question == ASSOCIATIVE and bounds.finite:
        error = max(abs(_relative(load_factor, bounds.middle)), bounds.width / 2, 1e-16)
    elif load_factor is not None and question == COULOMB and best is not None:
        gap = _relative(load_factor, best.load_factor)
        error, below = max(abs(gap), GAP_FLOOR), gap < -GAP_FLOOR
    return dict(zip(JUDGED, (question, verdict, reason, error, below), strict=True))


def _verdict(row: dict[str, Any], bounds: CertifiedBounds, known: Mapping[str, bool]) -> tuple[str, str]:
    """The verdict, and why, in words; "" if it is certified."""
    load_factor, claim = row["load_factor"], claim_of(row)
    end = row["status"] if row["ended"] == FINISHED else row["ended"]
    said = f"{end}: {row['message']}" if row["message"] else str(end)
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
        both = question_of(row["method"]) == ASSOCIATIVE and not _by_sides(row)
        if both and load_factor < bounds.lower - margin:
            return WRONG, "λ below its certified bound"
    return CERTIFIED, ""


def _by_sides(row: Mapping[Any, Any]) -> bool:
    """Whether friction in space is limited by sides inside the cone."""
    return "polygon" in row["friction_law"]


def residuals_over_limit(row: Mapping[Any, Any], kind: Kind | None = None) -> dict[str, float | None]:
    """Residuals of a row with a load factor that exceed the limits of its kind of answer, or of another
    ``kind``; a residual that is missing or NaN exceeds them too."""
    left = {name: row[name] for name in RESIDUALS}
    if (energy := left["complementarity"]) is not None:
        left["complementarity"] = over_load_factor(energy, row["load_factor"])
    return LIMITS[kind or Kind(row["kind"])].failing(left)


def _relative(load_factor: float, to: float) -> float:
    return (load_factor - to) / max(abs(to), SMALLEST)


def summary(
    rows: Iterable[dict[str, Any]], bounds: Mapping[str, CertifiedBounds], best: Mapping[str, BestKnown]
) -> pd.DataFrame:
    """One row a scene and pair: medians of the repeats' times, and the worst verdict of the repeats.
    ``bounds`` and ``best`` are by scene name. ``time``: seconds of the solve without the parts that all pairs
    share: reading the scene, checking its dead load."""
    judged = []
    for row in rows:
        shared = (row["scene_seconds"] or 0.0) + (row["dead_load_seconds"] or 0.0)
        verdict = judge(row, bounds.get(row["scene"]), best.get(row["scene"]))
        judged.append(row | {"time": row["wall"] - shared} | verdict)
    frame = pd.DataFrame(judged, columns=[*COLUMNS, "time", *JUDGED])
    frame["pair"] = frame["method"] + " · " + frame["model"] + " · " + frame["solver"]
    frame[_NUMBERS] = frame[_NUMBERS].astype(float)
    repeats = frame.groupby(["scene", *_PAIR], dropna=False, sort=False)
    frame["of"], frame["badness"] = repeats.ngroup(), frame["verdict"].map(VERDICTS.index)
    frame["repeats"] = repeats["scene"].transform("size")
    frame[_MEDIANS] = repeats[_MEDIANS].transform("median")
    worst = frame.sort_values(["of", "badness"], kind="stable").drop_duplicates("of", keep="last")
    return worst[_SUMMARY].reset_index(drop=True)


def answers(frame: pd.DataFrame) -> pd.DataFrame:
    """The best run of each method on each scene: by verdict, then by error (within SAME; none below the best
    exact state), then by time."""
    error = frame["error"].mask(frame["below"].astype(bool), 0.0).clip(lower=SAME)
    order = frame.assign(rank=frame["verdict"].map(VERDICTS.index), far=error)
    first = order.sort_values(["rank", "far", "time"], kind="stable").drop_duplicates(["scene", "method"])
    return first.drop(columns=["rank", "far"])


def pareto(frame: pd.DataFrame) -> pd.DataFrame:
    """The certified rows that no other such row beats in both time and error, quickest first."""
    known = frame[(frame["verdict"] == CERTIFIED) & frame["error"].notna()]
    known = known.sort_values(["time", "error"])
    return known[known["error"] < known["error"].cummin().shift(fill_value=np.inf)]


def success(frame: pd.DataFrame) -> pd.DataFrame:
    """How the scenes ended, one row a pair and tolerance. ``success``: share that is certified or named
    correctly. Median time and largest error are those of the certified answers; peak_memory (MB) of all."""
    ended = {verdict: frame["verdict"] == verdict for verdict in VERDICTS}
    of_certified = {name: frame[name].where(ended[CERTIFIED]) for name in ("time", "error")}
    marked = frame.assign(**ended, success=ended[CERTIFIED] | ended[NAMED], **of_certified)
    columns: dict[str, Any] = {verdict: (verdict, "sum") for verdict in VERDICTS}
    columns |= {"scenes": ("scene", "size"), "success": ("success", "mean"), "time": ("time", "median")}
    columns |= {"largest error": ("error", "max"), "peak_memory": ("peak_memory", "max")}
    return marked.groupby(["pair", *_PAIR], dropna=False, sort=False).agg(**columns).reset_index()


@dataclass(frozen=True)
class Comparison:
    """Results of a comparison; ``print`` shows the report."""

    scenes: tuple[CaseScene, ...]
    plan: RunPlan
    limits: RunLimits
    bounds: dict[str, CertifiedBounds]  #: of the associative load factor, by scene name
    best: dict[str, BestKnown]  #: lowest exact Coulomb state known, by scene name
    results: pd.DataFrame  #: one row a run (see :data:`~.runs.COLUMNS`)
    summary: pd.DataFrame  #: one row a scene and pair (see :func:`summary`)
    notes: tuple[str, ...] = ()  #: further remarks, a line each
    interrupted: bool = False  #: whether runs are missing
    warnings: tuple[str, ...] = ()  #: damaged lines of the journal, and what looks unintended in the scenes
    #: What was written: tables, charts, the report.
    files: tuple[Path, ...] = field(default=(), repr=False, compare=False)

    @property
    def told(self) -> pd.DataFrame:
        """The success table, in words."""
        return in_words(success(self.summary), FORMATS, PRINTED).rename(columns=PRINTED_HEADINGS)

    def _repr_html_(self) -> str:
        """What a notebook shows: notes and warnings, the success table, the first chart."""
        charts = [file.read_bytes() for file in self.files if file.suffix == ".svg" and file.is_file()]
        source = image_source(charts[0], "svg") if charts else ""
        words = "\n".join([*self.notes, *warning_lines(self.warnings)])
        return notebook_html(printable(words), self.told, source)

    def __str__(self) -> str:
        """Return the success table, the combinations left out, notes and warnings."""
        lines = []
        if len(self.summary):
            median = f"median of {counted(self.limits.repeats, 'run')}"
            long = f"one run where it takes over {REPEATED_BELOW:g} s"
            lines += [self.told.to_string(index=False), ""]
            lines += [f"{counted(len(self.scenes), 'scene')}; success: share that is certified or named"]
            lines += ["named: no load factor exists, and the run gives the right reason"]
            lines += ["failed: the run has no answer, and says so; wrong: the answer or the reason is wrong"]
            lines += [f"time ({median}; {long}) and largest error: of the certified answers"]
        if self.plan.left_out:
            lines.append("\nnot applicable:")
            lines += [f"  {' · '.join(names)}: {reason}" for *names, reason in self.plan.left_out]
        if self.notes:
            lines += ["\nnotes:", *(f"  {note}" for note in self.notes)]
        return printable("\n".join([*lines, *warning_lines(self.warnings)]))

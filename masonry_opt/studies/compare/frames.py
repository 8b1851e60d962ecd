"""What a comparison found, and the tables behind its charts and reports: medians, Pareto fronts, success."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from masonry_opt.answer.thresholds import SAME
from masonry_opt.errors import counted, printable
from masonry_opt.files import image_source
from masonry_opt.studies.compare import judge
from masonry_opt.studies.compare.accuracy import CertifiedBounds
from masonry_opt.studies.compare.runs import COLUMNS, RESIDUALS, CaseScene, RunPlan
from masonry_opt.studies.writing import in_words, notebook_html

_PAIR = ["method", "model", "solver", "tolerance"]

#: Numbers of a summary that are medians of the repeats.
_MEDIANS = ["time", "build_seconds", "compile_seconds", "solve_seconds", "read_seconds", "peak_memory"]
_COUNTS = ["lp_solves", "nlp_solves", "iterations"]

#: Numbers of a run, and columns of a summary.
_NUMBERS = [*_MEDIANS, *_COUNTS, *RESIDUALS, "tolerance", "error", "load_factor", "bound", "joints", "blocks"]
_SUMMARY = ["scene", "pair", *_PAIR, "question", "verdict", "reason", "load_factor", "error", "below"]
_SUMMARY += [*_MEDIANS, *_COUNTS, "repeats", "joints", "blocks", *RESIDUALS]
_SUMMARY += ["bound", "ended", "status", "kind", "message"]

#: Columns of the success table, and headings that are not their names.
SUCCESS = ["tolerance", "success", *judge.VERDICTS, "time", "largest error", "peak_memory"]
HEADINGS = {"time": "median time (s)", "peak_memory": "peak (MB)"}

#: How numbers are written, by column.
FORMATS = {"success": "{:.0%}", "load_factor": "{:.9g}", "time": "{:.3g}", "peak_memory": "{:.0f}"}
FORMATS |= dict.fromkeys(("error", "largest error"), "{:.1e}")
FORMATS |= dict.fromkeys(("tolerance", *RESIDUALS), "{:.0e}")

REPEATED_BELOW = 5.0  #: Runs that take longer (seconds) are not repeated: their scatter is relatively small.


def summary(
    rows: Iterable[dict[str, Any]],
    bounds: Mapping[str, CertifiedBounds],
    best: Mapping[str, judge.BestKnown],
    expected: Mapping[str, Mapping[str, str]],
) -> pd.DataFrame:
    """One row a scene and pair: medians of the repeats' times, and the worst verdict of the repeats.
    ``bounds``, ``best`` and ``expected`` are by scene name (see :func:`~.judge.judge`). ``time``: seconds of
    the solve without the parts that all pairs share: reading the scene, checking its dead load."""
    judged = []
    for row in rows:
        shared = (row["scene_seconds"] or 0.0) + (row["dead_load_seconds"] or 0.0)
        scene = row["scene"]
        verdict = judge.judge(row, bounds.get(scene), best.get(scene), expected.get(scene, {}))
        judged.append(row | {"time": row["wall"] - shared} | verdict)
    frame = pd.DataFrame(judged, columns=[*COLUMNS, "time", *judge.JUDGED])
    frame["pair"] = frame["method"] + " · " + frame["model"] + " · " + frame["solver"]
    frame[_NUMBERS] = frame[_NUMBERS].astype(float)
    repeats = frame.groupby(["scene", *_PAIR], dropna=False, sort=False)
    frame["of"], frame["badness"] = repeats.ngroup(), frame["verdict"].map(judge.VERDICTS.index)
    frame["repeats"] = repeats["scene"].transform("size")
    frame[_MEDIANS] = repeats[_MEDIANS].transform("median")
    worst = frame.sort_values(["of", "badness"], kind="stable").drop_duplicates("of", keep="last")
    return worst[_SUMMARY].reset_index(drop=True)


def answers(frame: pd.DataFrame) -> pd.DataFrame:
    """The best run of each method on each scene: by verdict, then by error (within SAME; none below the best
    exact state), then by time."""
    error = frame["error"].mask(frame["below"].astype(bool), 0.0).clip(lower=SAME)
    order = frame.assign(rank=frame["verdict"].map(judge.VERDICTS.index), far=error)
    first = order.sort_values(["rank", "far", "time"], kind="stable").drop_duplicates(["scene", "method"])
    return first.drop(columns=["rank", "far"])


def pareto(frame: pd.DataFrame) -> pd.DataFrame:
    """The certified rows that no other such row beats in both time and error, quickest first."""
    known = frame[(frame["verdict"] == judge.CERTIFIED) & frame["error"].notna()]
    known = known.sort_values(["time", "error"])
    return known[known["error"] < known["error"].cummin().shift(fill_value=np.inf)]


def success(frame: pd.DataFrame) -> pd.DataFrame:
    """How the scenes ended, one row a pair and tolerance. ``success``: share that is certified or named
    correctly. Median time and largest error are those of the certified answers; peak_memory (MB) of all."""
    ended = {verdict: frame["verdict"] == verdict for verdict in judge.VERDICTS}
    of_certified = {name: frame[name].where(ended[judge.CERTIFIED]) for name in ("time", "error")}
    marked = frame.assign(**ended, success=ended[judge.CERTIFIED] | ended[judge.NAMED], **of_certified)
    columns: dict[str, Any] = {verdict: (verdict, "sum") for verdict in judge.VERDICTS}
    columns |= {"scenes": ("scene", "size"), "success": ("success", "mean"), "time": ("time", "median")}
    columns |= {"largest error": ("error", "max"), "peak_memory": ("peak_memory", "max")}
    return marked.groupby(["pair", *_PAIR], dropna=False, sort=False).agg(**columns).reset_index()


@dataclass(frozen=True)
class RunLimits:
    """Seconds and MB that a run may take, and how often it is repeated."""

    time: float = 60.0
    memory: float = 4000.0
    repeats: int = 3


@dataclass(frozen=True)
class Comparison:
    """Results of a comparison; ``print`` shows the report."""

    scenes: tuple[CaseScene, ...]
    plan: RunPlan
    limits: RunLimits
    bounds: dict[str, CertifiedBounds]  #: of the associative load factor, by scene name
    best: dict[str, judge.BestKnown]  #: lowest exact Coulomb state known, by scene name
    results: pd.DataFrame  #: one row a run (see :data:`~.runs.COLUMNS`)
    summary: pd.DataFrame  #: one row a scene and pair (see :func:`summary`)
    notes: tuple[str, ...] = ()  #: further remarks, a line each
    interrupted: bool = False  #: whether runs are missing
    #: What was written: tables, charts, the report.
    files: tuple[Path, ...] = field(default=(), repr=False, compare=False)

    @property
    def told(self) -> pd.DataFrame:
        """The success table, in words."""
        columns = ("method", "model", "solver", "tolerance", "scenes", *SUCCESS[1:])
        return in_words(success(self.summary), FORMATS, columns).rename(columns=HEADINGS)

    def _repr_html_(self) -> str:
        """What a notebook shows: notes, the success table, the first chart."""
        charts = [file.read_bytes() for file in self.files if file.suffix == ".svg" and file.is_file()]
        source = image_source(charts[0], "svg") if charts else ""
        return notebook_html(printable("\n".join(self.notes)), self.told, source)

    def __str__(self) -> str:
        """The success table, combinations left out, notes."""
        lines = []
        if len(self.summary):
            lines += [
                self.told.to_string(index=False),
                f"\n{counted(len(self.scenes), 'scene')}; success: certified or named correctly;",
                "median time and largest error: of the certified answers, each a median of "
                f"{counted(self.limits.repeats, 'run')} (of one where a run takes over {REPEATED_BELOW:g} s)",
            ]
        if self.plan.left_out:
            lines.append("\nnot applicable:")
            lines += [f"  {' · '.join(names)}: {reason}" for *names, reason in self.plan.left_out]
        if self.notes:
            lines += ["\nnotes:", *(f"  {note}" for note in self.notes)]
        return printable("\n".join(lines))

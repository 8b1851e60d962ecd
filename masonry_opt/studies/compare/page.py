"""The report as one HTML file that needs no network: load factors by scene and method, charts, tables."""

from collections.abc import Mapping, Sequence
from typing import Any

import pandas as pd

from masonry_opt.answer.acceptance import LIMITS, OUTSIDE
from masonry_opt.studies.charts import NamedChart, script
from masonry_opt.studies.compare import frames, judge
from masonry_opt.studies.compare.frames import REPEATED_BELOW, Comparison
from masonry_opt.studies.compare.runs import RESIDUALS
from masonry_opt.studies.journal import machine, versions
from masonry_opt.studies.runner import FINISHED
from masonry_opt.studies.writing import frame_table, render, table
from masonry_opt.words.sentences import numeral

#: Columns of the table of runs, and headings that are not their names.
_RUNS = ["scene", "pair", "load_factor", "tolerance", "verdict", "error", "time", "reason"]
_RUNS += ["iterations", "lp_solves", "peak_memory", "blocks", "joints", *RESIDUALS]
_HEADINGS = {"pair": "method · model · solver", "load_factor": "λ", "reason": "why", "lp_solves": "LPs"}
_HEADINGS |= frames.HEADINGS


def page(comparison: Comparison, charts: Sequence[NamedChart]) -> str:
    """The report of a comparison, its charts inside."""
    summary = comparison.summary
    about = machine() | {f"version of {name}": release for name, release in versions().items()}
    tables: dict[str, Any] = dict.fromkeys(("success", "runs"))
    if len(summary):
        ended, columns = frames.success(summary), ("pair", *frames.SUCCESS)
        tables["success"] = frame_table(ended, frames.FORMATS, columns, **_HEADINGS)
        tables["runs"] = frame_table(summary, frames.FORMATS, _RUNS, **_HEADINGS)
    residuals = [
        (kind, *(f"{limit.as_dict()[name]:g}" for name in RESIDUALS)) for kind, limit in LIMITS.items()
    ]
    return render(
        "comparison.html",
        title="Comparison of methods and solvers",
        answers=load_factors(comparison),
        comparison=comparison,
        **tables,
        charts=charts,
        script=script(),
        left_out=table(("method", "model", "solver", "why"), comparison.plan.left_out),
        residuals=table(("", *RESIDUALS), residuals, RESIDUALS),
        outside=f"{OUTSIDE:g}",
        gap_floor=f"{judge.GAP_FLOOR:g}",
        repeated_below=f"{REPEATED_BELOW:g}",
        about=table(("", ""), [*about.items()]),
    )


def load_factors(comparison: Comparison) -> dict[str, Any]:
    """The table of load factors: of each scene what is known, and the answers of the methods of the plan."""
    summary = comparison.summary
    answers = frames.answers(summary).to_dict("records") if len(summary) else []
    told = {(row["scene"], row["method"]): _answer(row) for row in answers}
    methods = dict.fromkeys(pair.method for pair in comparison.plan.pairs)
    known = {name: _lambda(of.middle) for name, of in comparison.bounds.items() if of.finite}
    best = {name: f"{_lambda(of.load_factor)}, {of.method}" for name, of in comparison.best.items()}
    rows = [
        [name, known.get(name, "–"), best.get(name, "–")]
        + [told.get((name, method), "not run") for method in methods]
        for name in (scene.name for scene in comparison.scenes)
    ]
    headings = [f"{judge.question_of(method)} λ, {method}" for method in methods]
    return table(["scene", "associative λ, certified", "lowest exact Coulomb λ", *headings], rows)


def _answer(row: Mapping[Any, Any]) -> str:
    """λ with its error or gap, or why there is none; and the seconds."""
    seconds = f"{row['time']:.2g} s"
    given = "" if pd.isna(row["load_factor"]) else _lambda(row["load_factor"])
    if row["verdict"] != judge.CERTIFIED:
        # An analysis that ended by itself said its status, and explained it in a message.
        why = row["reason"].replace(f": {row['message']}", "") if row["ended"] == FINISHED else row["reason"]
        return f"{row['verdict']}: {f'λ {given}: ' * bool(given)}{why}; {seconds}"
    if pd.isna(row["error"]):
        return f"{given}; {seconds}"
    if row["question"] == judge.ASSOCIATIVE:
        return f"{given}; error {row['error']:.0e}; {seconds}"
    gap = 0.0 if row["error"] <= judge.GAP_FLOOR else -row["error"] if row["below"] else row["error"]
    return f"{given}; gap {100 * gap:{'+.2g' if gap else 'g'}} %; {seconds}"


def _lambda(value: float) -> str:
    """A load factor in five digits, zeros too: those of a row are read against each other."""
    return numeral(value, "#.5g").removesuffix(".")

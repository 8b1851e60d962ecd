"""The page of a comparison, an HTML file that needs no network: load factors, charts, tables."""

import math
from collections.abc import Mapping, Sequence
from itertools import cycle
from typing import Any

import numpy as np
import pandas as pd

from masonry_opt.answer.acceptance import LIMITS, OUTSIDE
from masonry_opt.drawing.colours import SERIES
from masonry_opt.methods.registry import METHODS
from masonry_opt.studies.charts import NamedChart, alt, legend, script
from masonry_opt.studies.compare import judge
from masonry_opt.studies.compare.runs import RESIDUALS
from masonry_opt.studies.runner import FINISHED, MEMORY_LIMIT, TIME_LIMIT
from masonry_opt.studies.writing import frame_table, in_words, machine, render, table, versions
from masonry_opt.words.sentences import numeral

#: Columns of the table of runs.
_RUNS = ["scene", "pair", "load_factor", "tolerance", "verdict", "error", "time", "reason"]
_RUNS += ["iterations", "lp_solves", "peak_memory", "blocks", "joints", *RESIDUALS]
#: Letters of runs not certified, by verdict or limit; and what they mean, if not that.
_LETTERS = {TIME_LIMIT: "T", MEMORY_LIMIT: "M", judge.WRONG: "W", judge.NAMED: "N", judge.FAILED: "F"}
_MEANS = {"N": "no load factor, and the right reason why"}

#: By question: the error's name in a title, and at its axis.
_ERRORS = {
    judge.ASSOCIATIVE: ("error", "relative error of λ (against certified bounds)"),
    judge.COULOMB: ("gap to the best exact state", "relative gap to the best exact state known"),
}
_GREY = "#777777"  #: Of what stands behind the marks.
_STEPS = 7  #: Most steps between the ticks of a logarithmic axis.
#: Columns in the tooltip of a mark, and their names there.
_TOLD = ("scene", "pair", "tolerance", "verdict", "reason", "error", "yield", "iterations")
_RENAMED = {"load_factor": "λ", "time": "seconds", "peak_memory": "MB"}

#: Solvers and methods chosen in the legends stand out.
_CHOSEN = [alt.selection_point(name=field, fields=[field], bind="legend") for field in ("engine", "method")]
_FADED = alt.when(_CHOSEN[0], _CHOSEN[1]).then(alt.value(1)).otherwise(alt.value(0.1))


def charts(summary: pd.DataFrame) -> list[NamedChart]:
    """Every chart of a summary (see :func:`~.judge.summary`) that has errors to show."""
    asked = {*summary["question"][summary["error"].notna()]}
    return [_time_error(summary, of) for of in _ERRORS if of in asked]


def _time_error(summary: pd.DataFrame, question: str) -> NamedChart:
    """Time against error, a panel a scene that has any; runs not certified are letters in a band on top."""
    summary = summary.assign(engine=summary["model"] + " · " + summary["solver"])
    rows = summary[summary["question"] == question]
    rows = rows[rows["scene"].isin(rows["scene"][rows["error"].notna()])]
    certified = rows["verdict"] == judge.CERTIFIED
    limited = (rows["verdict"] == judge.FAILED) & rows["ended"].isin((TIME_LIMIT, MEMORY_LIMIT))
    low, high = _decades(rows[certified]["error"])
    first, last = _decades(rows["time"])
    band = high * 10**0.3
    top = band * (band / low) ** 0.22
    # A logarithmic axis has no zero: it stands at the least error shown. Letters at near times must not
    # overlap: they stand at three heights in turn.
    turn = (rows[~certified].groupby("scene").cumcount() % 3).reindex(rows.index)
    in_band = band * (top / band) ** (0.15 + 0.25 * turn)
    front = [judge.pareto(frame).index for _, frame in rows.groupby("scene")]
    colours = dict(zip(summary["engine"].unique(), cycle(SERIES), strict=False))
    marks = in_words(rows, judge.FORMATS, (*_TOLD, *_RENAMED)).rename(columns=_RENAMED).set_index(rows.index)
    marks = marks.assign(
        time=rows["time"],
        height=rows["error"].clip(low).where(certified, in_band),
        engine=rows["engine"],
        method=rows["method"],
        colour=rows["engine"].map(colours),
        letter=rows["ended"].where(limited, rows["verdict"]).map(_LETTERS).fillna(""),
        rung=rows["tolerance"],
        front=rows.index.isin(np.concatenate(front)),
        below=certified & rows["below"],
    )
    shown = {what: letter for what, letter in _LETTERS.items() if letter in {*marks["letter"]}}
    notes = [f"{letter}: {_MEANS.get(letter, what)}" for what, letter in shown.items()]
    what, label = _ERRORS[question]
    if question == judge.COULOMB and math.isclose(low, judge.GAP_FLOOR):
        notes.append(f"gaps below {low:g} are none, drawn there")
    notes.append("grey steps: Pareto front")
    if marks["below"].any():
        notes.append("grey triangles: below the best exact state (|gap|)")
    x = _log(alt.X("time:Q"), "time (s)", (first / 1.25, last * 1.25), (first, last))
    places = {"x": x, "y": _log(alt.Y("height:Q"), label, (low / 3, top), (low, high))}
    of_layers = ("datum.letter === ''", "datum.front", "datum.below", "datum.letter !== ''")
    known, steps, below, letters = (alt.Chart().transform_filter(which) for which in of_layers)
    once = alt.Chart().transform_aggregate(rows="count()")
    told = [alt.Tooltip(f"{column}:N") for column in (*_TOLD, *_RENAMED.values())]
    raw = alt.Color("colour:N", scale=None)
    words = {"x": alt.value(5), "y": alt.value(9), "text": alt.value("not certified")}
    lines = {"color": raw, "detail": "pair:N", "opacity": _FADED, "order": "rung:Q"}
    # Of the only layer with a legend: of several its names could not be chosen.
    coded = {"color": alt.Color("engine:N", scale=alt.Scale(domain=[*colours], range=[*colours.values()]))}
    coded |= {"shape": alt.Shape("method:N", sort=[*METHODS], **legend(certified.any()))}
    coded |= {"opacity": _FADED, "tooltip": told}
    lettered = {"text": "letter:N", "color": raw, "opacity": _FADED, "tooltip": told}
    layers = [
        once.mark_rect(color="#EDEDED").encode(y=alt.datum(band), y2=alt.datum(top)),
        once.mark_text(align="left", color=_GREY).encode(**words),
        steps.mark_line(interpolate="step-after", color=_GREY).encode(**places),
        known.mark_line(strokeWidth=1.2).encode(**places, **lines),
        below.mark_point(shape="triangle-down", filled=True, size=160, color=_GREY).encode(**places),
        known.mark_point(size=80, filled=True).encode(**places, **coded).add_params(*_CHOSEN),
        letters.mark_text(fontWeight="bold", fontSize=13).encode(**places, **lettered),
    ]
    title = f"{question.capitalize()} λ: time against {what}"
    chart = alt.layer(*layers, data=marks)
    return NamedChart(judge.chart_name(question), title, chart, "; ".join(notes), "scene")


def _decades(values: pd.Series) -> tuple[float, float]:
    """Whole decades, one at least, that hold the positive values."""
    known = values[values > 0]
    if known.empty:
        return 1e-9, 1.0
    low, high = math.floor(math.log10(known.min())), math.ceil(math.log10(known.max()) + 1e-9)
    return 10.0**low, 10.0 ** max(high, low + 1)


def _log(channel: Any, label: str, ends: tuple[float, float], decades: tuple[float, float]) -> Any:
    """A channel on a logarithmic axis between two ends, with ticks at some powers of ten."""
    first, last = (round(math.log10(end)) for end in decades)
    powers = [10.0**power for power in range(first, last + 1, math.ceil((last - first) / _STEPS))]
    return channel.scale(type="log", domain=ends, nice=False).axis(title=label, values=powers, format="~e")


def page(comparison: judge.Comparison, charts: Sequence[NamedChart]) -> str:
    """The report of a comparison, its charts inside."""
    summary = comparison.summary
    about = machine() | {f"version of {name}": release for name, release in versions().items()}
    ended, columns = judge.success(summary), ("pair", *judge.SUCCESS)
    residuals = [(kind, *(f"{of.as_dict()[name]:g}" for name in RESIDUALS)) for kind, of in LIMITS.items()]
    numbers = {"outside": OUTSIDE, "gap_floor": judge.GAP_FLOOR, "repeated_below": judge.REPEATED_BELOW}
    return render(
        "comparison.html",
        title="Comparison of methods and solvers",
        answers=load_factors(comparison),
        comparison=comparison,
        success=frame_table(ended, judge.FORMATS, columns, **judge.HEADINGS),
        runs=frame_table(summary, judge.FORMATS, _RUNS, **judge.HEADINGS),
        charts=charts,
        script=script(),
        left_out=table(("method", "model", "solver", "why"), comparison.plan.left_out),
        residuals=table(("", *RESIDUALS), residuals, RESIDUALS),
        about=table(("", ""), [*about.items()]),
        **{name: f"{value:g}" for name, value in numbers.items()},
    )


def load_factors(comparison: judge.Comparison) -> dict[str, Any]:
    """The table of load factors: of each scene what is known, and the answers of the methods of the plan."""
    answers = judge.answers(comparison.summary).to_dict("records")
    told = {(row["scene"], row["method"]): _answer(row) for row in answers}
    methods = dict.fromkeys(pair.method for pair in comparison.plan.pairs)
    known = {name: _lambda(of.middle) for name, of in comparison.bounds.items() if of.finite}
    best = {name: f"{_lambda(of.load_factor)}, {of.method}" for name, of in comparison.best.items()}
    rows = []
    for name in (scene.name for scene in comparison.scenes):
        found = (told.get((name, method), "not run") for method in methods)
        rows.append([name, known.get(name, "–"), best.get(name, "–"), *found])
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

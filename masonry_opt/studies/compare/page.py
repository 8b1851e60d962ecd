"""Page of a comparison: load factors, charts and tables, as an HTML file that works offline."""

import math
from collections.abc import Mapping, Sequence
from itertools import cycle
from typing import Any

import numpy as np
import pandas as pd

from masonry_opt.drawing.colours import SERIES
from masonry_opt.methods.registry import METHODS
from masonry_opt.reporting.sentences import numeral
from masonry_opt.solution.acceptance import LARGEST_BOUND_EXCESS, LIMITS
from masonry_opt.studies.charts import NamedChart, alt, legend, script
from masonry_opt.studies.compare import judge
from masonry_opt.studies.compare.runs import CERTIFICATE_RESIDUALS
from masonry_opt.studies.runner import FINISHED, MEMORY_LIMIT, TIME_LIMIT
from masonry_opt.studies.writing import frame_table, in_words, machine, render, table, versions

#: Columns of the table of runs.
_RUNS = [
    *("scene", "pair", "load_factor", "tolerance", "verdict", "error", "time", "reason"),
    *("iterations", "lp_solves", "peak_memory", "blocks", "joints", *CERTIFICATE_RESIDUALS),
]
#: Letters with which charts mark runs whose answer is not certified. The key is the limit that the run
#: exceeded or, if the run ended within its limits, the verdict on the run.
_ENDING_LETTERS = {
    TIME_LIMIT: "T",
    MEMORY_LIMIT: "M",
    judge.WRONG: "W",
    judge.REASON_NAMED: "N",
    judge.FAILED: "F",
}
#: Explanations of letters in the notes on charts. All other letters are explained by their keys in
#: ``_ENDING_LETTERS``.
_LETTER_MEANINGS = {"N": "the scene has no load factor, and the run states the correct reason"}

#: Name of the error in chart titles, and title of the error axis, for each kind of load factor.
_ERRORS = {
    judge.ASSOCIATIVE: ("error", "relative error of λ (against certified bounds)"),
    judge.COULOMB: ("gap to the best exact state", "relative gap of λ to the best state"),
}
_GREY = "#777777"  #: Colour of the lines, triangles and texts that charts draw behind the marks of runs.
_MOST_TICKS = 7  #: Largest number of intervals between the ticks of a logarithmic axis.
#: Columns in the tooltip of a mark.
_TOOLTIP = ("scene", "pair", "tolerance", "verdict", "reason", "error", "yield", "iterations")
#: Map from a column of the table to its name in the tooltip of a mark.
_RENAMED = {"load_factor": "λ", "time": "seconds", "peak_memory": "MB"}

#: Selections of solvers and methods: a click on a legend entry fades the marks of all other entries.
_SELECTIONS = [
    alt.selection_point(name=field, fields=[field], bind="legend") for field in ("engine", "method")
]
_OPACITY = alt.when(_SELECTIONS[0], _SELECTIONS[1]).then(alt.value(1)).otherwise(alt.value(0.1))


def charts(summary: pd.DataFrame) -> list[NamedChart]:
    """Return the charts of time against error: one for associative and one for Coulomb load factors."""
    with_errors = {*summary["question"][summary["error"].notna()]}
    return [_time_error(summary, question) for question in _ERRORS if question in with_errors]


def _time_error(summary: pd.DataFrame, question: str) -> NamedChart:
    """Return the chart of time against error for one kind of load factor, with a panel for each scene.

    Runs without a certified answer are marked by letters in a band at the top.
    """
    summary = summary.assign(engine=summary["model"] + " · " + summary["solver"])
    rows = summary[summary["question"] == question]
    rows = rows[rows["scene"].isin(rows["scene"][rows["error"].notna()])]
    certified = rows["verdict"] == judge.CERTIFIED
    limited = (rows["verdict"] == judge.FAILED) & rows["ended"].isin((TIME_LIMIT, MEMORY_LIMIT))
    low, high = _decades(rows[certified]["error"])
    first, last = _decades(rows["time"])
    band = high * 10**0.3
    top = band * (band / low) ** 0.22
    # Letters are drawn at three alternating heights, so that letters at nearly equal times do not overlap.
    level = (rows[~certified].groupby("scene").cumcount() % 3).reindex(rows.index)
    in_band = band * (top / band) ** (0.15 + 0.25 * level)
    front = [judge.pareto(frame).index for _, frame in rows.groupby("scene")]
    colours = dict(zip(summary["engine"].unique(), cycle(SERIES), strict=False))
    texts = in_words(rows, judge.NUMBER_FORMATS, (*_TOOLTIP, *_RENAMED)).rename(columns=_RENAMED)
    marks = texts.set_index(rows.index).assign(
        time=rows["time"],
        # A logarithmic axis has no zero, so errors of zero are drawn at the lowest error on the axis.
        height=rows["error"].clip(low).where(certified, in_band),
        engine=rows["engine"],
        method=rows["method"],
        colour=rows["engine"].map(colours),
        letter=rows["ended"].where(limited, rows["verdict"]).map(_ENDING_LETTERS).fillna(""),
        rung=rows["tolerance"],
        front=rows.index.isin(np.concatenate(front)),
        below=certified & rows["below"],
    )
    shown = {ending: letter for ending, letter in _ENDING_LETTERS.items() if letter in {*marks["letter"]}}
    notes = [f"{letter}: {_LETTER_MEANINGS.get(letter, ending)}" for ending, letter in shown.items()]
    error_name, label = _ERRORS[question]
    if question == judge.COULOMB and math.isclose(low, judge.GAP_FLOOR):
        notes.append(
            f"relative gaps below {low:g} count as zero; they are drawn at this value, because a logarithmic "
            "axis has no zero"
        )
    notes.append("grey steps: Pareto front")
    if marks["below"].any():
        notes.append(
            "grey triangles: λ of the run is lower than λ of the best known exact state; the gap is the "
            "relative difference"
        )
    x = _log(alt.X("time:Q"), "time (s)", (first / 1.25, last * 1.25), (first, last))
    places = {"x": x, "y": _log(alt.Y("height:Q"), label, (low / 3, top), (low, high))}
    filters = ("datum.letter === ''", "datum.front", "datum.below", "datum.letter !== ''")
    known, steps, below, letters = (alt.Chart().transform_filter(condition) for condition in filters)
    once = alt.Chart().transform_aggregate(rows="count()")  # one mark for each panel
    tooltip = [alt.Tooltip(f"{column}:N") for column in (*_TOOLTIP, *_RENAMED.values())]
    raw = alt.Color("colour:N", scale=None)
    caption = {"x": alt.value(5), "y": alt.value(9), "text": alt.value("not certified")}
    lines = {"color": raw, "detail": "pair:N", "opacity": _OPACITY, "order": "rung:Q"}
    # Only the layer of point marks has a legend, because a click cannot select the entries of a legend that
    # several layers share.
    drawn = {engine: colour for engine, colour in colours.items() if engine in {*rows["engine"]}}
    coded = {"color": alt.Color("engine:N", scale=alt.Scale(domain=[*drawn], range=[*drawn.values()]))}
    coded |= {"shape": alt.Shape("method:N", sort=[*METHODS], **legend(certified.any()))}
    coded |= {"opacity": _OPACITY, "tooltip": tooltip}
    lettered = {"text": "letter:N", "color": raw, "opacity": _OPACITY, "tooltip": tooltip}
    layers = [
        once.mark_rect(color="#EDEDED").encode(y=alt.datum(band), y2=alt.datum(top)),
        once.mark_text(align="left", color=_GREY).encode(**caption),
        steps.mark_line(interpolate="step-after", color=_GREY).encode(**places),
        known.mark_line(strokeWidth=1.2).encode(**places, **lines),
        below.mark_point(shape="triangle-down", filled=True, size=160, color=_GREY).encode(**places),
        known.mark_point(size=80, filled=True).encode(**places, **coded).add_params(*_SELECTIONS),
        letters.mark_text(fontWeight="bold", fontSize=13).encode(**places, **lettered),
    ]
    title = f"{question.capitalize()} λ: time against {error_name}"
    chart = alt.layer(*layers, data=marks)
    return NamedChart(judge.chart_name(question), title, chart, "; ".join(notes), "scene")


def _decades(values: pd.Series) -> tuple[float, float]:
    """Return two powers of ten that enclose all positive values."""
    known = values[values > 0]
    if known.empty:
        return 1e-9, 1.0
    low, high = math.floor(math.log10(known.min())), math.ceil(math.log10(known.max()) + 1e-9)
    return 10.0**low, 10.0 ** max(high, low + 1)


def _log(channel: Any, label: str, ends: tuple[float, float], decades: tuple[float, float]) -> Any:
    """Return a chart channel with a logarithmic axis that has ticks at powers of ten.

    ``ends`` are the limits of the axis, and ``decades`` are the lowest and the highest power of ten for
    ticks. If the ticks would have more than ``_MOST_TICKS`` intervals, powers of ten are skipped.
    """
    first, last = (round(math.log10(end)) for end in decades)
    step = math.ceil((last - first) / _MOST_TICKS)
    powers = [10.0**power for power in range(first, last + 1, step)]
    return channel.scale(type="log", domain=ends, nice=False).axis(title=label, values=powers, format="~e")


def page(comparison: judge.Comparison, charts: Sequence[NamedChart]) -> str:
    """Return the page of a comparison as HTML, with its charts."""
    summary = comparison.summary
    about = machine() | {f"version of {name}": release for name, release in versions().items()}
    success, columns = judge.success(summary), ("pair", *judge.SUCCESS)
    residuals = [
        (kind, *(f"{limits.as_dict()[name]:g}" for name in CERTIFICATE_RESIDUALS))
        for kind, limits in LIMITS.items()
    ]
    numbers = {
        "outside": LARGEST_BOUND_EXCESS,
        "gap_floor": judge.GAP_FLOOR,
        "repeated_below": judge.REPEATED_BELOW,
    }
    return render(
        "comparison.html",
        title="Comparison of methods and solvers",
        answers=load_factors(comparison),
        comparison=comparison,
        success=frame_table(success, judge.NUMBER_FORMATS, columns, **judge.HEADINGS),
        runs=frame_table(summary, judge.NUMBER_FORMATS, _RUNS, **judge.HEADINGS),
        charts=charts,
        script=script(),
        left_out=table(("method", "model", "solver", "why"), comparison.plan.left_out),
        residuals=table(("", *CERTIFICATE_RESIDUALS), residuals, CERTIFICATE_RESIDUALS),
        about=table(("", ""), [*about.items()]),
        **{name: f"{value:g}" for name, value in numbers.items()},
    )


def load_factors(comparison: judge.Comparison) -> dict[str, Any]:
    """Return the table of load factors: known values and the best answer of each method, by scene."""
    answers = judge.answers(comparison.summary).to_dict("records")
    texts = {(row["scene"], row["method"]): _answer(row) for row in answers}
    methods = dict.fromkeys(pair.method for pair in comparison.plan.pairs)
    certified = {name: _lambda(bounds.middle) for name, bounds in comparison.bounds.items() if bounds.finite}
    best = {name: f"{_lambda(state.load_factor)}, {state.method}" for name, state in comparison.best.items()}
    rows = []
    for name in (scene.name for scene in comparison.scenes):
        by_method = (texts.get((name, method), "not run") for method in methods)
        rows.append([name, certified.get(name, "–"), best.get(name, "–"), *by_method])
    headings = [f"{judge.question_of(method)} λ, {method}" for method in methods]
    return table(["scene", "associative λ, certified", "lowest exact Coulomb λ", *headings], rows)


def _answer(row: Mapping[Any, Any]) -> str:
    """Return a short text on a run: λ with its error, or the verdict with its reason, and the solve time.

    The error of a Coulomb load factor is its gap to the best exact state. The verdict and its reason replace
    the error if λ is unknown or not certified.
    """
    seconds = f"{row['time']:.2g} s"
    load_factor = "" if pd.isna(row["load_factor"]) else _lambda(row["load_factor"])
    if row["verdict"] != judge.CERTIFIED:
        # The reason of a finished run repeats the message of the run. Remove the message to shorten the text.
        why = row["reason"].replace(f": {row['message']}", "") if row["ended"] == FINISHED else row["reason"]
        return f"{row['verdict']}: {f'λ {load_factor}: ' if load_factor else ''}{why}; {seconds}"
    if pd.isna(row["error"]):
        return f"{load_factor}; {seconds}"
    if row["question"] == judge.ASSOCIATIVE:
        return f"{load_factor}; error {row['error']:.0e}; {seconds}"
    if row["error"] <= judge.GAP_FLOOR:
        return f"{load_factor}; gap 0 %; {seconds}"
    gap = -row["error"] if row["below"] else row["error"]
    return f"{load_factor}; gap {100 * gap:+.2g} %; {seconds}"


def _lambda(value: float) -> str:
    """Return a load factor as text with five digits, including trailing zeros."""
    return numeral(value, "#.5g").removesuffix(".")

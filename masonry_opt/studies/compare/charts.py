"""The charts of a comparison, from its frames alone."""

from __future__ import annotations

import json
import math
from collections.abc import Iterable, Mapping
from itertools import cycle
from typing import Any

import numpy as np
import pandas as pd

from masonry_opt.drawing.colours import SERIES
from masonry_opt.errors import counted
from masonry_opt.methods.registry import METHODS
from masonry_opt.studies.charts import NamedChart, alt
from masonry_opt.studies.compare import frames, judge
from masonry_opt.studies.runner import MEMORY_LIMIT, TIME_LIMIT
from masonry_opt.studies.writing import in_words

GREY = "#777777"

#: Shapes of marks of methods in the order of the registry; the last is for states below the best.
SHAPES = ["circle", "square", "triangle-up", "diamond", "M0-1L.3-.4 1-.3.5.2.6 1 0 .6-.6 1-.5.2-1-.3-.3-.4Z"]
SHAPES += ["cross", "triangle-right", "triangle-down"]

#: Letters of runs that are not certified, and what they stand for.
_LETTERS = {
    "T": "time limit",
    "M": "memory limit",
    "W": "wrong",
    "N": "no load factor, and the right reason why",
    "F": "failed but said so",
}

#: By question: the error's name in a title, and at its axis.
_ERRORS = {
    judge.ASSOCIATIVE: ("error", "relative error of λ (against certified bounds)"),
    judge.COULOMB: ("gap to the best exact state", "relative gap to the best exact state known"),
}

_VERDICT_COLOURS = dict(zip(judge.VERDICTS, (SERIES[2], SERIES[5], "#BBBBBB", SERIES[1]), strict=True))

#: Share of a bar that has room for its count.
_LABELLED = 0.03

#: Most steps between the ticks of a logarithmic axis.
_STEPS = 7

_SUPERSCRIPTS = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")

#: Columns in the tooltip of a mark, and their names there.
_TOLD = ("scene", "pair", "tolerance", "verdict", "error", "violation", "iterations")
_RENAMED = {"load_factor": "λ", "time": "seconds", "peak_memory": "MB"}

#: Pairs chosen in the legend stand out.
_CHOSEN = alt.selection_point(name="chosen", fields=["pair"], bind="legend")
_FADED = alt.when(_CHOSEN).then(alt.value(1)).otherwise(alt.value(0.1))


def charts(summary: pd.DataFrame) -> list[NamedChart]:
    """Every chart of a summary (see :func:`~.frames.summary`); none of an empty one."""
    if summary.empty:
        return []
    asked = {*summary["question"]}
    return [_success(summary), *(_time_error(summary, of) for of in _ERRORS if of in asked)]


def _time_error(summary: pd.DataFrame, question: str) -> NamedChart:
    """Time against error, a panel a scene; runs that are not certified are letters in a band at the top."""
    rows = summary[summary["question"] == question]
    certified = rows["verdict"] == judge.CERTIFIED
    low, high = _decades(rows[certified]["error"])
    first, last = _decades(rows["time"])
    band = high * 10**0.3
    top = band * (band / low) ** 0.22
    # A logarithmic axis has no zero: it stands at the least error shown. Letters at near times must not
    # overlap: they stand at three heights in turn.
    turn = (rows[~certified].groupby("scene").cumcount() % 3).reindex(rows.index)
    in_band = band * (top / band) ** (0.15 + 0.25 * turn)
    front = [frames.pareto(frame).index for _, frame in rows.groupby("scene")]
    looks = _looks(summary, rows["pair"])
    records = rows.to_dict("records")
    verdicts = [f"{row['verdict']} {row['reason']}".strip() for row in records]
    marks = in_words(rows.assign(verdict=verdicts), frames.FORMATS, (*_TOLD, *_RENAMED))
    marks = marks.rename(columns=_RENAMED).set_index(rows.index)
    marks["letter"] = [_letter(row) for row in records]
    marks = marks.assign(
        time=rows["time"],
        height=rows["error"].clip(low).where(certified, in_band),
        colour=rows["pair"].map(looks.set_index("pair")["stroke"]),
        broken=rows["pair"].map(looks.set_index("pair")["broken"]),
        rung=rows["tolerance"],
        front=rows.index.isin(np.concatenate(front)),
        below=certified & rows["below"],
    )
    notes = [f"{letter}: {_LETTERS[letter]}" for letter in dict.fromkeys(marks["letter"]) if letter]
    what, label = _ERRORS[question]
    ticks = _powers(low, high)
    if question == judge.COULOMB and math.isclose(low, judge.GAP_FLOOR):
        ticks[low] = f"≤ {ticks[low]}"
        notes.append(f"gaps below {low:g} are none, drawn there")
    notes.append("grey steps: Pareto front")
    if marks["below"].any():
        notes.append("grey triangles: below the best exact state (|gap|)")
    places = {
        "x": _log(alt.X("time:Q"), "time (s)", (first / 1.25, last * 1.25), _powers(first, last)),
        "y": _log(alt.Y("height:Q"), label, (low / 3, top), ticks),
    }
    known, steps, below, letters = (
        alt.Chart().transform_filter(which)
        for which in ("datum.letter === ''", "datum.front", "datum.below", "datum.letter !== ''")
    )
    once, told = alt.Chart().transform_aggregate(rows="count()"), _tooltip((*_TOLD, *_RENAMED.values()))

    def by(channel: Any, look: str) -> Any:
        """Pairs told apart by their looks."""
        return channel("pair:N", scale=alt.Scale(domain=[*looks["pair"]], range=[*looks[look]]))

    layers = [
        once.mark_rect(color="#EDEDED").encode(y=alt.datum(band), y2=alt.datum(top)),
        once.mark_text(align="left", color=GREY).encode(
            x=alt.value(5), y=alt.value(9), text=alt.value("not certified")
        ),
        steps.mark_line(interpolate="step-after", color=GREY).encode(**places),
        known.mark_line(strokeWidth=1.2).encode(
            **places,
            color=alt.Color("colour:N", scale=None),
            strokeDash=alt.when("datum.broken").then(alt.value([4, 3])).otherwise(alt.value([1, 0])),
            detail="pair:N",
            opacity=_FADED,
            order="rung:Q",
        ),
        below.mark_point(shape=SHAPES[-1], fill=GREY, stroke=GREY).encode(**places),
        # The only layer with a legend: of several its names could not be chosen.
        known.mark_point(size=80, opacity=1)
        .encode(
            **places,
            stroke=by(alt.Stroke, "stroke"),
            fill=by(alt.Fill, "fill"),
            shape=by(alt.Shape, "shape"),
            opacity=_FADED,
            tooltip=told,
        )
        .add_params(_CHOSEN),
        letters.mark_text(fontWeight="bold", fontSize=13).encode(
            **places, text="letter:N", color=alt.Color("colour:N", scale=None), opacity=_FADED, tooltip=told
        ),
    ]
    title = f"{question.capitalize()} λ: time against {what}"
    chart = alt.layer(*layers, data=marks)
    return NamedChart(f"time_error_{question.lower()}", title, chart, "; ".join(notes), "scene")


def _success(summary: pd.DataFrame) -> NamedChart:
    """How the scenes ended, a bar a pair and tolerance."""
    table = frames.success(summary)
    least, most = int(table["scenes"].min()), int(table["scenes"].max())
    # After an interrupt some pairs lack scenes.
    scenes = counted(most, "scene") if least == most else f"{least} to {most} scenes"
    rungs = zip(table["pair"], table["tolerance"], strict=True)
    # In two lines, to leave room beside them on a narrow screen.
    table["row"] = [
        f"{pair}{'' if pd.isna(rung) else f' · {rung:.0e}'}".replace(" · ", "\n", 1) for pair, rung in rungs
    ]
    two_lines = alt.Axis(labelExpr="split(datum.label, '\\n')", labelLimit=0)
    row = alt.Y("row:N", sort=None, title=None, scale=alt.Scale(domain=[*table["row"]]), axis=two_lines)
    bars = table.melt(["row", "scenes"], [*_VERDICT_COLOURS], "verdict", "count")
    bars["order"] = bars["verdict"].map([*_VERDICT_COLOURS].index)
    wide = bars["count"] >= _LABELLED * bars["scenes"]
    bars["text"] = bars["count"].astype(str).where(wide & (bars["count"] > 0), "")
    verdict = alt.Scale(domain=[*_VERDICT_COLOURS], range=[*_VERDICT_COLOURS.values()])
    share = alt.X("count:Q", stack="normalize", title="scenes", axis=alt.Axis(format="%", tickCount=3))
    all_bars = alt.Chart(bars).encode(y=row, order="order:O", tooltip=_tooltip(("row", "verdict", "count")))
    counts = all_bars.mark_text().encode(
        x=alt.X("count:Q", stack="normalize", bandPosition=0.5), text="text:N", detail="verdict:N"
    )
    colour = alt.Color("verdict:N", scale=verdict, legend=alt.Legend(columns=1))
    ended = (all_bars.mark_bar().encode(x=share, color=colour) + counts).properties(height=34 * len(table))
    return NamedChart("success", "How the scenes ended", ended, f"{scenes}, counts in the bars")


def _looks(summary: pd.DataFrame, pairs: pd.Series) -> pd.DataFrame:
    """Looks of each pair drawn: the colour of its solver, the shape of its method; marks are full and lines
    whole for CVXPY, else open and broken."""
    runs = summary[summary["pair"].isin(pairs)].drop_duplicates("pair")
    looks = runs[["pair"]].assign(broken=runs["model"] != "cvxpy")
    colours = dict(zip(summary["solver"].unique(), cycle(SERIES), strict=False))
    looks["stroke"] = runs["solver"].map(colours)
    looks["fill"] = looks["stroke"].mask(looks["broken"], "white")
    return looks.assign(shape=runs["method"].map(dict(zip(METHODS, cycle(SHAPES), strict=False))))


def _tooltip(columns: Iterable[str]) -> list[Any]:
    return [alt.Tooltip(f"{column}:N") for column in columns]


def _letter(row: Mapping[Any, Any]) -> str:
    """The letter of a row; "" if it is certified."""
    if row["verdict"] != judge.FAILED:
        return {judge.CERTIFIED: "", judge.WRONG: "W"}.get(row["verdict"], "N")
    return {TIME_LIMIT: "T", MEMORY_LIMIT: "M"}.get(row["ended"], "F")


def _decades(values: pd.Series) -> tuple[float, float]:
    """Whole decades, one at least, that hold the positive values."""
    known = values[values > 0]
    if known.empty:
        return 1e-9, 1.0
    low, high = math.floor(math.log10(known.min())), math.ceil(math.log10(known.max()) + 1e-9)
    return 10.0**low, 10.0 ** max(high, low + 1)


def _log(channel: Any, label: str, ends: tuple[float, float], ticks: dict[float, str]) -> Any:
    """A channel on a logarithmic axis between two ends, with the text of each tick."""
    text = f"{json.dumps([*ticks.values()])}[indexof({json.dumps([*ticks])}, datum.value)]"
    drawn = channel.scale(type="log", domain=ends, nice=False)
    return drawn.axis(title=label, values=[*ticks], labelExpr=text)


def _powers(low: float, high: float) -> dict[float, str]:
    """Ticks at powers of ten, no more than can be read."""
    first, last = round(math.log10(low)), round(math.log10(high))
    powers = range(first, last + 1, math.ceil((last - first) / _STEPS))
    return {10.0**power: f"10{str(power).translate(_SUPERSCRIPTS)}" for power in powers}

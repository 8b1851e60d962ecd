"""The charts of a comparison, from its frames alone."""

import math
from collections.abc import Mapping
from itertools import cycle
from typing import Any

import numpy as np
import pandas as pd

from masonry_opt.drawing.colours import SERIES
from masonry_opt.methods.registry import METHODS
from masonry_opt.studies.charts import NamedChart, alt, legend
from masonry_opt.studies.compare import frames, judge
from masonry_opt.studies.runner import MEMORY_LIMIT, TIME_LIMIT
from masonry_opt.studies.writing import in_words

GREY = "#777777"

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

#: Most steps between the ticks of a logarithmic axis.
_STEPS = 7

#: Columns in the tooltip of a mark, and their names there.
_TOLD = ("scene", "pair", "tolerance", "verdict", "reason", "error", "yield", "iterations")
_RENAMED = {"load_factor": "λ", "time": "seconds", "peak_memory": "MB"}

#: Solvers and methods chosen in the legends stand out.
_CHOSEN = [alt.selection_point(name=field, fields=[field], bind="legend") for field in ("engine", "method")]
_FADED = alt.when(_CHOSEN[0], _CHOSEN[1]).then(alt.value(1)).otherwise(alt.value(0.1))


def charts(summary: pd.DataFrame) -> list[NamedChart]:
    """Every chart of a summary (see :func:`~.frames.summary`) that has errors to show."""
    if summary.empty:
        return []
    asked = {*summary["question"][summary["error"].notna()]}
    return [_time_error(summary, of) for of in _ERRORS if of in asked]


def _time_error(summary: pd.DataFrame, question: str) -> NamedChart:
    """Time against error, a panel a scene that has any; runs that are not certified are letters in a band at
    the top."""
    summary = summary.assign(engine=summary["model"] + " · " + summary["solver"])
    rows = summary[summary["question"] == question]
    rows = rows[rows["scene"].isin(rows["scene"][rows["error"].notna()])]
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
    colours = dict(zip(summary["engine"].unique(), cycle(SERIES), strict=False))
    marks = in_words(rows, frames.FORMATS, (*_TOLD, *_RENAMED)).rename(columns=_RENAMED).set_index(rows.index)
    marks = marks.assign(
        time=rows["time"],
        height=rows["error"].clip(low).where(certified, in_band),
        engine=rows["engine"],
        method=rows["method"],
        colour=rows["engine"].map(colours),
        letter=[_letter(row) for row in rows.to_dict("records")],
        rung=rows["tolerance"],
        front=rows.index.isin(np.concatenate(front)),
        below=certified & rows["below"],
    )
    notes = [f"{letter}: {_LETTERS[letter]}" for letter in dict.fromkeys(marks["letter"]) if letter]
    what, label = _ERRORS[question]
    if question == judge.COULOMB and math.isclose(low, judge.GAP_FLOOR):
        notes.append(f"gaps below {low:g} are none, drawn there")
    notes.append("grey steps: Pareto front")
    if marks["below"].any():
        notes.append("grey triangles: below the best exact state (|gap|)")
    places = {
        "x": _log(alt.X("time:Q"), "time (s)", (first / 1.25, last * 1.25), (first, last)),
        "y": _log(alt.Y("height:Q"), label, (low / 3, top), (low, high)),
    }
    known, steps, below, letters = (
        alt.Chart().transform_filter(which)
        for which in ("datum.letter === ''", "datum.front", "datum.below", "datum.letter !== ''")
    )
    once = alt.Chart().transform_aggregate(rows="count()")
    told = [alt.Tooltip(f"{column}:N") for column in (*_TOLD, *_RENAMED.values())]
    raw = alt.Color("colour:N", scale=None)
    layers = [
        once.mark_rect(color="#EDEDED").encode(y=alt.datum(band), y2=alt.datum(top)),
        once.mark_text(align="left", color=GREY).encode(
            x=alt.value(5), y=alt.value(9), text=alt.value("not certified")
        ),
        steps.mark_line(interpolate="step-after", color=GREY).encode(**places),
        known.mark_line(strokeWidth=1.2).encode(
            **places, color=raw, detail="pair:N", opacity=_FADED, order="rung:Q"
        ),
        below.mark_point(shape="triangle-down", filled=True, size=160, color=GREY).encode(**places),
        # The only layer with a legend: of several its names could not be chosen.
        known.mark_point(size=80, filled=True)
        .encode(
            **places,
            color=alt.Color("engine:N", scale=alt.Scale(domain=[*colours], range=[*colours.values()])),
            shape=alt.Shape("method:N", sort=[*METHODS], **legend(certified.any())),
            opacity=_FADED,
            tooltip=told,
        )
        .add_params(*_CHOSEN),
        letters.mark_text(fontWeight="bold", fontSize=13).encode(
            **places, text="letter:N", color=raw, opacity=_FADED, tooltip=told
        ),
    ]
    title = f"{question.capitalize()} λ: time against {what}"
    chart = alt.layer(*layers, data=marks)
    return NamedChart(f"time_error_{question.lower()}", title, chart, "; ".join(notes), "scene")


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


def _log(channel: Any, label: str, ends: tuple[float, float], decades: tuple[float, float]) -> Any:
    """A channel on a logarithmic axis between two ends, with ticks at some powers of ten."""
    first, last = (round(math.log10(end)) for end in decades)
    powers = [10.0**power for power in range(first, last + 1, math.ceil((last - first) / _STEPS))]
    return channel.scale(type="log", domain=ends, nice=False).axis(title=label, values=powers, format="~e")

"""Charts of sweeps and samples.

A sweep of one number is λ against that number: a mark for each mechanism, dashes for the incremental load
factor, the least ringed, and values far above the others as numbers above the axis. A sweep of two numbers
is a heat map. A sample has the fragility curve, and a chart of what matters; ``sure`` is the confidence.
"""

from collections.abc import Sequence
from typing import Any

import numpy as np
import pandas as pd
from numpy.typing import ArrayLike

from masonry_opt.answer.thresholds import ZERO
from masonry_opt.drawing.colours import CRUSHES, HINGES, LIVE, MARKED, SEPARATES, SERIES, SLIDES
from masonry_opt.studies.charts import NamedChart, alt, axis, legend
from masonry_opt.studies.many.runs import HEAT_MAP, INCREMENTAL_COLUMN, at_least, chart_names, ends

#: Colour and mark of each mechanism. Joints have the same in pictures.
_LOOKS = {
    "sliding": (SLIDES, "square"),
    "hinging": (HINGES, "circle"),
    "crushing": (CRUSHES, "cross"),
    "mixed": (MARKED, "triangle-up"),
    "separating": (SEPARATES, "diamond"),
    "none": (LIVE, "triangle-down"),
}
#: Colour and mark of a run without a load factor, and mark of a value off the axis.
_DARK, _CROSS, _UP = "#333333", "M-.8-.8L.8.8M.8-.8L-.8.8", "triangle-up"
_MOST_LINES = 7  #: Values of the second number that have a line each.
_MOST_NAMED = 6  #: Values off the axis that are written.
#: Titles of axes of numbers that have a symbol.
_SYMBOLS = {
    "joints.friction": "friction μ = tan φ",
    "joints.friction_angle": "friction angle φ [°]",
    "joints.dilatancy": "dilatancy tan φ₀",
    "joints.dilatancy_angle": "dilatancy angle φ₀ [°]",
    "joints.cohesion": "cohesion c",
}
#: A load factor so many times the greatest of the others is left off the axis: at most this share of all, or
#: one of three or more.
_FAR, _FEW = 10.0, 0.25
_LABEL = "load factor λ"  #: The axis of load factors.
_MARGIN = 24  #: Pixels above and below the values, for those off the axis and for runs without a load factor.
_SHOWN = 15  #: Most numbers drawn that are shown, those that matter most.
#: The loads that a sample tells of, with how names of their columns begin; and their colours.
_LOADS = {"lowest found": "", "incremental": INCREMENTAL_COLUMN}
_COLOURS = alt.Scale(range=[*SERIES[: len(_LOADS)]])
#: Entry of the legend, and notes.
_OFF, _RING, _DASHED = "off the axis: λ as written", "ringed: smallest", "dashes: incremental λ"


def drawings(frame: pd.DataFrame, names: Sequence[str]) -> list[NamedChart]:
    """λ against the first of one or two numbers, or against each of more; of two numbers also a map."""
    found = [against(frame, names, name) for name in (names if len(names) > 2 else names[:1])]
    # A map has no place for an infinite value of friction.
    finite = np.isfinite(frame[list(names)].to_numpy(float)).all()
    if len(names) == 2 and finite and frame["load_factor"].notna().any():
        found.append(heat_map(frame, names[0], names[1]))
    return found


def against(frame: pd.DataFrame, names: Sequence[str], name: str) -> NamedChart:
    """λ against one number: a line, or of two numbers a line for each value of the second; else points."""
    far = off_axis(np.r_[frame["load_factor"], frame["incremental"]])
    off, failed = far[: len(frame)], frame["load_factor"].isna()
    on_axis = ~failed & ~off
    incremental, same = (
        frame["incremental"].mask(far[len(frame) :]),
        frame["incremental"].equals(frame["load_factor"]),
    )
    series = mechanism = frame["mechanism"].fillna("none")
    looks = {kind: look for kind, look in _LOOKS.items() if kind in {*mechanism[on_axis]}}
    lines = len(names) == 2 and frame[names[1]].nunique() <= _MOST_LINES
    if lines:
        series = names[1] + " = " + frame[names[1]].map("{:g}".format)
        looks = {line: (colour, "circle") for line, colour in zip(series.unique(), SERIES, strict=False)}
    status = "no load factor: " + frame["status"].astype(str)
    looks |= dict.fromkeys(status[failed].unique(), (_DARK, _CROSS))
    looks |= {_OFF: (_DARK, _UP)} if off.any() else {}

    least_ones = at_least(frame)
    marks = frame[["status"]].assign(
        mechanism=mechanism,
        at=frame[name].astype(float),
        line=series,
        series=series.mask(failed, status).mask(off, _OFF),
        λ=frame["load_factor"],
        incremental=incremental,
        least=least_ones & (least_ones.sum() < frame["load_factor"].count()),
    )
    known, beside = marks[on_axis], marks[incremental.notna() & (not same)]
    x = alt.X("at:Q", scale=alt.Scale(zero=False, nice=False, padding=12), axis=alt.Axis(title=_label(name)))
    scale = alt.Scale(domain=ends(np.r_[known["λ"], incremental]), nice=False, zero=False, padding=_MARGIN)
    # Without a format Vega writes as many digits as its own ticks would need: .32 and .28 as 0.3.
    upwards = {"scale": scale, "axis": alt.Axis(title=_LABEL, format=".6~g", labels=len(known) > 0)}
    y = alt.Y("λ:Q", **upwards)
    colours, shapes = (alt.Scale(domain=[*looks], range=[*of]) for of in zip(*looks.values(), strict=True))
    found = alt.Chart(known).encode(x=x, y=y)
    dashed = alt.Chart(beside).encode(x=x, y=alt.Y("incremental:Q", **upwards))
    stroke: Any = alt.Stroke("line:N", scale=colours) if lines else alt.value(_DARK)
    if lines or len(names) == 1:
        layers = [found.mark_line(strokeWidth=1.2).encode(stroke=stroke)]
        layers.append(dashed.mark_line(strokeWidth=1.2, strokeDash=[6, 3]).encode(stroke=stroke))
    else:
        layers = [dashed.mark_point(color=_DARK, shape="stroke")]
    # Runs without a load factor stand at the foot, values off the axis at the head.
    at_foot, at_head = alt.value(alt.expr(f"height - {_MARGIN / 2}")), alt.value(_MARGIN / 2)
    told = [alt.Tooltip("at:Q", title=name), "λ:N", "mechanism:N", "status:N"]
    look = {"fill": alt.Fill("series:N", scale=colours), "stroke": alt.Stroke("series:N", scale=colours)}
    look |= {"shape": alt.Shape("series:N", scale=shapes), "tooltip": told}
    for rows, place in ((known, y), (marks[failed], at_foot), (marks[off], at_head)):
        layers.append(alt.Chart(rows).mark_point(size=45, opacity=1).encode(x=x, y=place, **look))
    layers.append(alt.Chart(marks[marks["least"]]).mark_point(size=220, color=_DARK).encode(x=x, y=y))
    # Many values side by side would overlap: only the greatest is written then.
    written = marks[off] if off.sum() <= _MOST_NAMED else marks[off].nlargest(1, "λ")
    text = alt.Chart(written).mark_text(color=_DARK, dy=-_MARGIN)
    layers.append(text.encode(x=x, y=at_head, text=alt.Text("λ:Q", format=".4~g")))
    file = chart_names(names)[[*names].index(name)]
    notes = [note for note, there in ((_RING, marks["least"].any()), (_DASHED, len(beside))) if there]
    notes += _names_of_load_factors(frame)
    return NamedChart(file, f"{_LABEL} against {_label(name)}", alt.layer(*layers), "; ".join(notes))


def heat_map(frame: pd.DataFrame, across: str, up: str) -> NamedChart:
    """λ over two numbers as colours; grey where there is no load factor."""
    off, missing = off_axis(frame["load_factor"]), frame["load_factor"].isna().any()
    least = at_least(frame) & (frame["load_factor"].nunique() > 1)
    cells = frame[[across, up, "load_factor", "status"]].set_axis(["x", "y", "λ", "status"], axis=1)
    number = alt.Axis(format=".4~g", formatType="number", labelAngle=0)
    x = alt.X("x:O", title=_label(across), axis=number)
    y = alt.Y("y:O", title=_label(up), axis=number, sort="descending")
    of_colours = alt.Legend(title=_LABEL, orient="bottom", direction="horizontal", gradientLength=200)
    scale = alt.Scale(scheme="viridis", domain=ends(frame["load_factor"][~off]), clamp=True)
    told = [alt.Tooltip("x:O", title=across), alt.Tooltip("y:O", title=up), "λ:N", "status:N"]
    tiles = (alt.Chart(of).mark_rect(color="#CCCCCC") for of in (cells, cells.dropna(subset=["λ"])))
    every, found = (tile.encode(x, y, tooltip=told) for tile in tiles)
    ring = alt.Chart(cells[least]).mark_point(size=90, filled=True, fill="white", stroke=_DARK, opacity=1)
    notes = [_RING] if least.any() else []
    notes += ["values far above the others have the last colour"] if off.any() else []
    notes += ["grey: no load factor"] if missing else []
    coloured = found.encode(fill=alt.Fill("λ:Q", scale=scale, legend=of_colours))
    chart = (every + coloured + ring.encode(x, y)).properties(height=300)
    notes += _names_of_load_factors(frame)
    return NamedChart(HEAT_MAP, f"{_LABEL} over two numbers", chart, "; ".join(notes))


def _names_of_load_factors(frame: pd.DataFrame) -> list[str]:
    """Return a note that names the load factors of the runs; none if no run has one."""
    names = frame.loc[frame["load_factor"].notna(), "which"].unique()
    return [f"λ: {', '.join(names)}"] if len(names) else []


def off_axis(load_factors: ArrayLike) -> np.ndarray:
    """Whether each load factor is far above the others and so left off the axis; shape (n,)."""
    values = np.asarray(load_factors, dtype=float)
    rising = np.sort(values[np.isfinite(values)])
    greatest = np.maximum.accumulate(np.abs(rising))
    few = max(int(_FEW * len(rising)), len(rising) >= 3)
    far = (greatest[:-1] > ZERO) & (rising[1:] >= _FAR * greatest[:-1])
    far[: max(0, len(far) - few)] = False
    return values >= rising[1:][far].min() if far.any() else np.zeros(len(values), dtype=bool)


def _label(name: str) -> str:
    return _SYMBOLS.get(name, name)


def _by_load(frame: pd.DataFrame) -> pd.DataFrame:
    """Return rows of the lowest λ, then of the incremental λ if known and different; ``of`` names them."""
    key, *names = (name for name in map(str, frame) if not name.startswith(INCREMENTAL_COLUMN))
    found, beside = (frame[[key, *(begin + name for name in names)]] for begin in _LOADS.values())
    beside = beside.set_axis([key, *names], axis=1)
    parts = [found] if found.equals(beside) else [found, beside]
    rows = pd.concat([part.assign(of=of) for of, part in zip(_LOADS, parts, strict=False)], ignore_index=True)
    return rows.dropna(subset=names[:1])


def fragility(title: str, curve: pd.DataFrame, sure: str) -> NamedChart:
    """Probability of collapse against load, with its interval."""
    share, curve = axis("probability of collapse", 0, 1.02), _by_load(curve)
    along = alt.Chart(curve).encode(
        x=alt.X("load:Q", **axis(_LABEL, *curve["load"].agg(["min", "max"]))),
        color=alt.Color("of:N", scale=_COLOURS),
        tooltip=["of:N", *(alt.Tooltip(f"{name}:Q", format=".4f") for name in curve if name != "of")],
    )
    band = along.mark_area(opacity=0.25, interpolate="step-after")
    line = along.mark_line(strokeWidth=2, interpolate="step-after")
    chart = band.encode(y=alt.Y("lower:Q", **share), y2="upper:Q")
    chart += line.encode(strokeDash=alt.StrokeDash("of:N", legend=None), y=alt.Y("probability:Q", **share))
    return NamedChart("fragility", f"Fragility, {title}", chart, f"line: share of runs; band: {sure}")


def sensitivity(title: str, correlations: pd.DataFrame, sure: str) -> NamedChart:
    """Rank correlations, strongest on top."""
    found = correlations.dropna(thresh=4)
    shown = _by_load(found.head(_SHOWN))
    # Marks of correlations whose interval holds zero are hollow.
    shown = shown.assign(certain=(shown["lower"] > 0) | (shown["upper"] < 0))
    x, colours = axis("rank correlation with λ", -1.05, 1.05), {"scale": _COLOURS} | legend(len(shown))
    rows = alt.Chart(shown).encode(
        y=alt.Y("parameter:N", sort=None, title=None, axis=alt.Axis(labelLimit=190)),
        yOffset=alt.YOffset("of:N", sort=[*_LOADS]),
        stroke=alt.Stroke("of:N", **colours),
        tooltip=["parameter:N", "of:N", *(f"{name}:Q" for name in ("rank_correlation", "lower", "upper"))],
    )
    marks = rows.mark_point(size=60, opacity=1).encode(
        x=alt.X("rank_correlation:Q", **x),
        shape=alt.Shape("of:N", legend=None),
        fill=alt.when("datum.certain").then(alt.Fill("of:N", **colours)).otherwise(alt.value("white")),
    )
    limits = rows.mark_rule(strokeWidth=1.5).encode(x=alt.X("lower:Q", **x), x2="upper:Q")
    left_out = f", the first {_SHOWN} of {len(found)}" if len(found) > _SHOWN else ""
    if found.empty:
        left_out = ": nothing drawn matters"
    chart = (limits + marks).properties(height=28 * max(len(found.head(_SHOWN)), 2))
    notes = f"{sure} that all intervals of a load hold; hollow: may be none"
    return NamedChart("sensitivity", f"What matters, {title}{left_out}", chart, notes)

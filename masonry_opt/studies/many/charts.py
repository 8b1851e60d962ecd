"""Charts of a sweep: λ against one number, with a mark for each mechanism, and dashes for the load to
expect; a heat map of two numbers. The least is ringed. A value far above the others stands at the head of the
axis, as a number.

Charts of a sample: how its load factors are distributed, the fragility curve, and what matters, of the lowest
found and of the load to expect; ``sure`` says with what confidence.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.ticker import MaxNLocator
from numpy.typing import ArrayLike

from masonry_opt.answer.thresholds import ZERO
from masonry_opt.drawing.colours import CRUSHES, HINGES, LIVE, MARKED, SEPARATES, SERIES, SLIDES
from masonry_opt.studies.charts import NamedChart, alt, axis
from masonry_opt.studies.many.runs import (
    CRUSHING,
    EXPECTED,
    HINGING,
    MIXED,
    NONE,
    SEPARATING,
    SLIDING,
    at_least,
    ends,
)

#: Colour and mark of each mechanism. Joints have the same in pictures.
_LOOKS = {
    SLIDING: (SLIDES, "square"),
    HINGING: (HINGES, "circle"),
    CRUSHING: (CRUSHES, "cross"),
    MIXED: (MARKED, "triangle-up"),
    SEPARATING: (SEPARATES, "diamond"),
    NONE: (LIVE, "triangle-down"),
}

#: Colour and mark of a run without a load factor, and mark of a value off the axis.
_DARK, _CROSS, _UP = "#333333", "M-.8-.8L.8.8M.8-.8L-.8.8", "triangle-up"

#: Most values of the second number that have a line each, and most values off the axis that are written.
_MOST_LINES, _MOST_NAMED = 7, 6

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

#: The axis of load factors.
_LABEL = "load factor λ"

#: Colours of strips, and of cells without a load factor.
_PALE, _GREY = "#EBEBEB", "#CCCCCC"

#: Shares of the chart's height: a row of crosses, the strip of values off the axis, and the least space above
#: and below the values.
_ROW, _HEAD, _PADDING = 0.04, 0.1, 0.05

#: Most numbers drawn that are shown, those that matter most.
_SHOWN = 15

#: Edges of bars of a load factor that does not change.
_BARS = 12

#: The loads that a sample tells of: how names of their columns begin, colours, dashes, marks.
_LOADS = {"lowest found": ("", SERIES[0], [1, 0], "circle")}
_LOADS |= {"to expect": (EXPECTED, SERIES[1], [6, 3], "diamond")}

#: Entry of the legend, and notes.
_OFF, _RING, _DASHED = "off the axis: λ as written", "ringed: least", "dashes: load to expect"


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
    far = off_axis(np.r_[frame["load_factor"], frame["expected"]])
    off, failed = far[: len(frame)], frame["load_factor"].isna()
    expected, same = frame["expected"].mask(far[len(frame) :]), frame["expected"].equals(frame["load_factor"])
    lines = len(names) == 2 and frame[names[1]].nunique() <= _MOST_LINES
    series = frame["mechanism"].fillna(NONE)
    looks = {
        mechanism: look for mechanism, look in _LOOKS.items() if (series[~failed & ~off] == mechanism).any()
    }
    if lines:
        series = names[1] + " = " + frame[names[1]].map("{:g}".format)
        looks = {line: (colour, "circle") for line, colour in zip(series.unique(), SERIES, strict=False)}
    status = "no load factor: " + frame["status"].astype(str)
    looks |= dict.fromkeys(status[failed].unique(), (_DARK, _CROSS))
    looks |= {_OFF: (_DARK, _UP)} if off.any() else {}

    # Values lie between two strips: at the foot rows of crosses for runs without a load factor, at the head
    # values off the axis.
    rows = frame.loc[failed, "status"].nunique()
    foot = _ROW * (rows + 0.5) if rows else 0.0
    known = np.r_[frame["load_factor"][~off], expected]
    least, greatest = ends(known)
    height = (greatest - least) / (1 - foot - 2 * _PADDING - _HEAD * off.any())
    low, high = least - (foot + _PADDING) * height, greatest + (_PADDING + _HEAD * off.any()) * height
    aside = _PADDING * height
    shown = [] if np.isnan(known).all() else ticks(least - aside, greatest + aside)
    strips = [(low, low + foot * height)] * bool(rows) + [(high - _HEAD * height, high)] * bool(off.any())

    in_row = low + height * _ROW * (pd.factorize(frame["status"].where(failed))[0] + 0.75)
    least_ones = at_least(frame)
    marks = frame[["status", "mechanism"]].fillna({"mechanism": NONE})
    marks = marks.assign(
        at=frame[name].astype(float),
        height=frame["load_factor"].mask(failed, in_row).mask(off, high - 0.75 * _HEAD * height),
        line=series,
        series=series.mask(failed, status).mask(off, _OFF),
        λ=frame["load_factor"],
        expected=expected,
        least=least_ones & (least_ones.sum() < frame["load_factor"].count()),
    )
    x = alt.X("at:Q", scale=alt.Scale(zero=False, nice=False, padding=12), axis=alt.Axis(title=_label(name)))
    # Without a format Vega writes as many digits as its own ticks would need: .32 and .28 as 0.3.
    upwards = axis(_LABEL, low, high, values=shown, format=".6~g")
    y = alt.Y("height:Q", **upwards)
    colours, shapes = (alt.Scale(domain=[*looks], range=[*of]) for of in zip(*looks.values(), strict=True))
    layers = [
        alt.Chart(pd.DataFrame(strips, columns=["from", "to"]))
        .mark_rect(color=_PALE)
        .encode(y=alt.Y("from:Q", **upwards), y2="to:Q")
    ]
    found = alt.Chart(marks[~failed]).encode(x=x, y=y)
    beside = alt.Chart(marks[expected.notna() & (not same)])
    beside = beside.encode(x=x, y=alt.Y("expected:Q", **upwards))
    if lines:
        stroke = alt.Stroke("line:N", scale=colours)
        layers.append(found.mark_line(strokeWidth=1.2).encode(stroke=stroke))
        layers.append(beside.mark_line(strokeWidth=1.2, strokeDash=[6, 3]).encode(stroke=stroke))
    elif len(names) == 1:
        layers.append(found.mark_line(color="#999999", strokeWidth=1))
        layers.append(beside.mark_line(color=_DARK, strokeWidth=1, strokeDash=[6, 3]))
    else:
        layers.append(beside.mark_point(color=_DARK, shape="stroke"))
    points = alt.Chart(marks).mark_point(size=45, opacity=1)
    layers += [
        points.encode(
            x=x,
            y=y,
            tooltip=[alt.Tooltip("at:Q", title=name), "λ:N", "mechanism:N", "status:N"],
            fill=alt.Fill("series:N", scale=colours),
            stroke=alt.Stroke("series:N", scale=colours),
            shape=alt.Shape("series:N", scale=shapes),
        ),
        alt.Chart(marks[marks["least"]]).mark_point(size=220, color=_DARK).encode(x=x, y=y),
    ]
    # Many values side by side would overlap: only the greatest is written then.
    written = marks[off] if off.sum() <= _MOST_NAMED else marks[off].nlargest(1, "λ")
    layers.append(_written(written, x, y, dy=-10))
    file = "load_factor" if len(names) <= 2 else f"load_factor_{[*names].index(name) + 1}"
    notes = [note for note, of in ((_RING, marks[marks["least"]]), (_DASHED, beside.data)) if len(of)]
    return NamedChart(file, f"{_LABEL} against {_label(name)}", alt.layer(*layers), "; ".join(notes))


def _written(cells: pd.DataFrame, x: Any, y: Any, **place: Any) -> Any:
    text = alt.Text("λ:Q", format=".4~g")
    return alt.Chart(cells).mark_text(color=_DARK, **place).encode(x=x, y=y, text=text)


def heat_map(frame: pd.DataFrame, across: str, up: str) -> NamedChart:
    """λ over two numbers as colours; grey where there is no load factor."""
    off = off_axis(frame["load_factor"])
    least, greatest = ends(frame["load_factor"][~off])
    cells = frame[[across, up]].astype(float).set_axis(["x", "y"], axis=1)
    cells = cells.assign(λ=frame["load_factor"], status=frame["status"])
    axes = {}
    for side, name in (("x", across), ("y", up)):
        middles = np.unique(cells[side])
        edges = _edges(middles)
        place = np.searchsorted(middles, cells[side])
        cells[f"{side}0"], cells[f"{side}1"] = edges[place], edges[place + 1]
        axes[side] = axis(_label(name), edges[0], edges[-1], grid=False)
    x, y = alt.X("x:Q", **axes["x"]), alt.Y("y:Q", **axes["y"])
    legend = alt.Legend(title=_LABEL, orient="bottom", direction="horizontal", gradientLength=200)
    scale = alt.Scale(scheme="viridis", domain=(least, greatest))
    cells["colour"] = np.where(cells["λ"].isna(), _GREY, "white")
    told = [alt.Tooltip("x:Q", title=across), alt.Tooltip("y:Q", title=up), "λ:N", "status:N"]
    squares = {"x": alt.X("x0:Q", **axes["x"]), "x2": "x1:Q", "y": alt.Y("y0:Q", **axes["y"]), "y2": "y1:Q"}
    shown = cells["λ"].notna() & ~off
    low = cells[at_least(frame) & (frame["load_factor"].nunique() > 1)]
    ring = alt.Chart(low).mark_point(size=90, filled=True, fill="white", stroke=_DARK, opacity=1)
    empty, full = (
        alt.Chart(cells[which]).mark_rect().encode(**squares, tooltip=told) for which in (~shown, shown)
    )
    chart = alt.layer(
        empty.encode(color=alt.Color("colour:N", scale=None)),
        full.encode(fill=alt.Fill("λ:Q", scale=scale, legend=legend)),
        ring.encode(x=x, y=y),
        _written(cells[off], x, y),
    )
    notes = [_RING] if len(low) else []
    notes += ["white: above the scale, λ as written"] if off.any() else []
    notes += ["grey: no load factor"] if cells["λ"].isna().any() else []
    return NamedChart("heat_map", f"{_LABEL} over two numbers", chart, "; ".join(notes))


def _edges(middles: np.ndarray) -> np.ndarray:
    """Edges of cells from their middles, shape (n,) to (n + 1,)."""
    if len(middles) == 1:
        half = abs(middles[0]) * 0.05 or 0.5
        return middles[0] + np.array([-half, half])
    between = (middles[1:] + middles[:-1]) / 2
    return np.r_[2 * middles[0] - between[0], between, 2 * middles[-1] - between[-1]]


def off_axis(load_factors: ArrayLike) -> np.ndarray:
    """Whether each load factor is far above the others and so left off the axis; shape (n,)."""
    values = np.asarray(load_factors, dtype=float)
    rising = np.sort(values[np.isfinite(values)])
    greatest = np.maximum.accumulate(np.abs(rising))
    few = max(int(_FEW * len(rising)), len(rising) >= 3)
    for first in range(len(rising) - few, len(rising)):
        if first and greatest[first - 1] > ZERO and rising[first] >= _FAR * greatest[first - 1]:
            return values >= rising[first]
    return np.zeros(len(values), dtype=bool)


def ticks(least: float, greatest: float, whole: bool = False) -> list[float]:
    """A few round numbers between two ends; ``whole``: only integers."""
    values = np.asarray(MaxNLocator(6, integer=whole).tick_values(least, greatest))
    return values[(values >= least) & (values <= greatest)].tolist()


def _label(name: str) -> str:
    return _SYMBOLS.get(name, name)


def _by_load(frame: pd.DataFrame) -> pd.DataFrame:
    """Rows of what was found, then of what is to expect if known and not the same, told apart by ``of``."""
    key, *names = (name for name in map(str, frame) if not name.startswith(EXPECTED))
    found, beside = (frame[[key, *(begin + name for name in names)]] for begin, *_ in _LOADS.values())
    beside = beside.set_axis([key, *names], axis=1)
    parts = [found] if found.equals(beside) else [found, beside]
    rows = pd.concat([part.assign(of=of) for of, part in zip(_LOADS, parts, strict=False)], ignore_index=True)
    return rows.dropna(subset=names[:1])


def _looks(rows: pd.DataFrame, *channels: Any, **symbol: Any) -> list[Any]:
    """Channels that tell the loads apart, with a legend where there are several."""
    legend = alt.Legend(**symbol) if rows["of"].nunique() > 1 else None
    _, colours, dashes, shapes = zip(*_LOADS.values(), strict=True)
    ranges = {alt.StrokeDash: dashes, alt.Shape: shapes}
    return [
        of("of:N", scale=alt.Scale(domain=[*_LOADS], range=ranges.get(of, colours)), legend=legend)
        for of in channels
    ]


def distribution(title: str, loads: Sequence[np.ndarray], marks: pd.DataFrame, sure: str) -> NamedChart:
    """Histograms of load factors and of loads to expect, with quantiles (``marks``) and their intervals."""
    found = [values[np.isfinite(values)] for values in loads]
    finite = np.concatenate(found)
    least, greatest = ends(finite)
    # A load factor that hardly changes has the axis' least length, and bars over it.
    changes = len(finite) and (least, greatest) == (finite.min(), finite.max())
    edges = np.histogram_bin_edges(finite, "auto") if changes else np.linspace(least, greatest, _BARS)
    runs = {of: np.histogram(values, edges)[0] for of, values in zip(_LOADS, found, strict=True)}
    bars = pd.DataFrame(runs | {"from": edges[:-1], "to": edges[1:]})
    bars = bars.melt(["from", "to"], var_name="of", value_name="runs")
    top = max(int(bars["runs"].max()), 1)
    marks = _by_load(marks)
    bars = bars[bars["of"].isin(marks["of"])]
    marks = marks[np.isfinite(marks["value"])].copy()
    marks["lower"], marks["upper"] = (
        marks[end].where(np.isfinite(marks[end]), marks["value"]) for end in ("lower", "upper")
    )
    # Each on a line of its own above the bars, those farthest out on top: quantiles may lie close together.
    aside = (marks["value"] - (least + greatest) / 2).abs().sort_values()
    marks = marks.loc[aside.index].reset_index(drop=True)
    marks["height"] = top * (1.06 + 0.09 * marks.index)
    marks["text"] = [f"{row.probability:.0%}: {row.value:.4f}" for row in marks.itertuples()]
    left = marks["value"] <= (least + greatest) / 2
    marks["beside"] = marks["upper"].where(left, marks["lower"])
    margin = 0.05 * (greatest - least)
    x = axis(_LABEL, least - margin, greatest + margin)
    y = axis("runs", 0, (1.09 + 0.09 * len(marks)) * top, values=ticks(0, top, whole=True), format="d")
    colour = _looks(marks, alt.Color)
    told = ["of:N", "text:N", "lower:Q", "upper:Q"]
    quantiles = alt.Chart(marks).encode(*colour, y=alt.Y("height:Q", **y), tooltip=told)
    texts = [
        alt.Chart(marks[side])
        .mark_text(align=align, dx=6 if align == "left" else -6)
        .encode(*colour, x=alt.X("beside:Q", **x), y=alt.Y("height:Q", **y), text="text:N")
        for side, align in ((left, "left"), (~left, "right"))
    ]
    bars = alt.Chart(bars).mark_bar(opacity=0.5, stroke="white")
    bars = bars.encode(*colour, x=alt.X("from:Q", **x), x2="to:Q", y=alt.Y("runs:Q", **y), y2=alt.datum(0))
    interval = quantiles.mark_rule(strokeWidth=5, opacity=0.45)
    line = quantiles.mark_rule(strokeWidth=1.5)
    chart = alt.layer(
        bars.encode(tooltip=["of:N", "from:Q", "to:Q", "runs:Q"]),
        interval.encode(x=alt.X("lower:Q", **x), x2="upper:Q"),
        line.encode(x=alt.X("value:Q", **x), y2=alt.datum(0)),
        *texts,
    )
    return NamedChart("distribution", f"Load factors, {title}", chart, f"quantiles, with {sure}")


def fragility(title: str, curve: pd.DataFrame, sure: str) -> NamedChart:
    """Probability of collapse against load, with its interval."""
    share, curve = axis("probability of collapse", 0, 1.02), _by_load(curve)
    along = alt.Chart(curve).encode(
        x=alt.X("load:Q", **axis(_LABEL, *curve["load"].agg(["min", "max"]))),
        tooltip=["of:N", *(alt.Tooltip(f"{name}:Q", format=".4f") for name in curve if name != "of")],
    )
    looks = _looks(curve, alt.Color, alt.StrokeDash, symbolType="stroke", symbolSize=600, symbolOpacity=1)
    band = along.mark_area(opacity=0.25, interpolate="step-after")
    band = band.encode(looks[0], y=alt.Y("lower:Q", **share), y2="upper:Q")
    line = along.mark_line(strokeWidth=2, interpolate="step-after")
    chart = band + line.encode(*looks, y=alt.Y("probability:Q", **share))
    return NamedChart("fragility", f"Fragility, {title}", chart, f"line: share of runs; band: {sure}")


def sensitivity(title: str, correlations: pd.DataFrame, sure: str) -> NamedChart:
    """Rank correlations, strongest on top."""
    found = correlations.dropna(thresh=4)
    shown = _by_load(found.head(_SHOWN)).copy()
    # Marks of correlations whose interval holds zero are hollow.
    certain = (shown["lower"] > 0) | (shown["upper"] < 0)
    colours = shown["of"].map({of: colour for of, (_, colour, *_) in _LOADS.items()})
    shown["fill"] = colours.where(certain, "white")
    x = axis("rank correlation with λ", -1.05, 1.05)
    rows = alt.Chart(shown).encode(
        y=alt.Y("parameter:N", sort=None, title=None, axis=alt.Axis(labelLimit=190)),
        yOffset=alt.YOffset("of:N", sort=[*_LOADS]),
        tooltip=["parameter:N", "of:N", *(f"{name}:Q" for name in ("rank_correlation", "lower", "upper"))],
    )
    looks = _looks(shown, alt.Stroke, alt.Shape, symbolFillColor="white")
    marks = rows.mark_point(size=60, opacity=1).encode(
        *looks, x=alt.X("rank_correlation:Q", **x), fill=alt.Fill("fill:N", scale=None)
    )
    limits = rows.mark_rule(strokeWidth=1.5).encode(looks[0], x=alt.X("lower:Q", **x), x2="upper:Q")
    left_out = f", the first {_SHOWN} of {len(found)}" if len(found) > _SHOWN else ""
    if found.empty:
        left_out = ": nothing drawn matters"
    chart = (limits + marks).properties(height=28 * max(len(found.head(_SHOWN)), 2))
    notes = f"{sure} that all intervals of a load hold; hollow: may be none"
    return NamedChart("sensitivity", f"What matters, {title}{left_out}", chart, notes)

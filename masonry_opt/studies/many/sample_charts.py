"""Charts of a sample: how its load factors are distributed, the fragility curve, and what matters; ``sure``
says with what confidence."""

from __future__ import annotations

import numpy as np
import pandas as pd

from masonry_opt.drawing.colours import SERIES
from masonry_opt.studies.charts import NamedChart, alt, axis
from masonry_opt.studies.load_factor_axis import LABEL, ends, ticks

#: Most numbers drawn that are shown, those that matter most.
_SHOWN = 15

#: Edges of bars of a load factor that does not change.
_BARS = 12

_RUNS, _MARKS = SERIES[0], SERIES[1]


def distribution(title: str, load_factors: np.ndarray, marks: pd.DataFrame, sure: str) -> NamedChart:
    """Histogram of load factors, with quantiles (``marks``) and their intervals."""
    finite = load_factors[np.isfinite(load_factors)]
    least, greatest = ends(finite)
    # A load factor that hardly changes has the axis' least length, and bars over it.
    changes = len(finite) and (least, greatest) == (finite.min(), finite.max())
    edges = np.histogram_bin_edges(finite, "auto") if changes else np.linspace(least, greatest, _BARS)
    runs, _ = np.histogram(finite, edges)
    top = max(int(runs.max()), 1)
    bars = alt.Chart(pd.DataFrame({"from": edges[:-1], "to": edges[1:], "runs": runs}))
    marks = marks[np.isfinite(marks["value"])].reset_index(drop=True)
    marks["lower"], marks["upper"] = (
        marks[end].where(np.isfinite(marks[end]), marks["value"]) for end in ("lower", "upper")
    )
    # Each on a line of its own above the bars: quantiles may lie close together.
    marks["height"] = top * (1.06 + 0.09 * marks.index)
    marks["text"] = [f"{row.probability:.0%}: {row.value:.4f}" for row in marks.itertuples()]
    left = marks["value"] <= (least + greatest) / 2
    marks["beside"] = marks["upper"].where(left, marks["lower"])
    margin = 0.05 * (greatest - least)
    x = axis(LABEL, least - margin, greatest + margin)
    y = axis("runs", 0, 1.36 * top, values=ticks(0, top, whole=True), format="d")
    quantiles = alt.Chart(marks).encode(y=alt.Y("height:Q", **y), tooltip=["text:N", "lower:Q", "upper:Q"])
    texts = [
        alt.Chart(marks[side])
        .mark_text(align=align, dx=6 if align == "left" else -6)
        .encode(x=alt.X("beside:Q", **x), y=alt.Y("height:Q", **y), text="text:N")
        for side, align in ((left, "left"), (~left, "right"))
    ]
    bars = bars.mark_bar(color=_RUNS, opacity=0.55, stroke="white")
    bars = bars.encode(x=alt.X("from:Q", **x), x2="to:Q", y=alt.Y("runs:Q", **y), y2=alt.datum(0))
    interval = quantiles.mark_rule(color=_MARKS, strokeWidth=5, opacity=0.45)
    line = quantiles.mark_rule(color=_MARKS, strokeWidth=1.5)
    chart = alt.layer(
        bars.encode(tooltip=["from:Q", "to:Q", "runs:Q"]),
        interval.encode(x=alt.X("lower:Q", **x), x2="upper:Q"),
        line.encode(x=alt.X("value:Q", **x), y2=alt.datum(0)),
        *texts,
    )
    notes = f"quantiles, with {sure}"
    return NamedChart("distribution", f"Load factors, {title}", chart, notes)


def fragility(title: str, curve: pd.DataFrame, sure: str) -> NamedChart:
    """Probability of collapse against load, with its interval."""
    share = axis("probability of collapse", 0, 1.02)
    along = alt.Chart(curve).encode(
        x=alt.X("load:Q", **axis(LABEL, *curve["load"].agg(["min", "max"]))),
        tooltip=[
            alt.Tooltip(f"{name}:Q", format=".4f") for name in ("load", "probability", "lower", "upper")
        ],
    )
    band = along.mark_area(color=_RUNS, opacity=0.25, interpolate="step-after")
    line = along.mark_line(color=_RUNS, strokeWidth=2, interpolate="step-after")
    chart = alt.layer(
        band.encode(y=alt.Y("lower:Q", **share), y2="upper:Q"), line.encode(y=alt.Y("probability:Q", **share))
    )
    notes = f"line: share of runs; band: {sure}"
    return NamedChart("fragility", f"Fragility, {title}", chart, notes)


def sensitivity(title: str, correlations: pd.DataFrame, sure: str) -> NamedChart:
    """Rank correlations, strongest on top."""
    found = correlations.dropna()
    shown = found.head(_SHOWN).copy()
    # Correlations whose interval holds zero are pale.
    certain = (shown["lower"] > 0) | (shown["upper"] < 0)
    shown["colour"] = np.where(certain, _RUNS, "#BBBBBB")
    x = axis("rank correlation with λ", -1.05, 1.05)
    rows = alt.Chart(shown).encode(
        y=alt.Y("parameter:N", sort=None, title=None, axis=alt.Axis(labelLimit=190)),
        tooltip=["parameter:N", *(f"{name}:Q" for name in ("rank_correlation", "lower", "upper"))],
    )
    bars = rows.mark_bar(opacity=0.7).encode(
        x=alt.X("rank_correlation:Q", **x), color=alt.Color("colour:N", scale=None)
    )
    chart = bars + rows.mark_rule().encode(x=alt.X("lower:Q", **x), x2="upper:Q")
    left_out = f", the first {len(shown)} of {len(found)}" if len(found) > len(shown) else ""
    if found.empty:
        left_out = ": nothing drawn matters"
    chart = chart.properties(height=28 * max(len(shown), 2))
    notes = f"{sure} that all intervals hold; grey: may be none"
    return NamedChart("sensitivity", f"What matters, {title}{left_out}", chart, notes)

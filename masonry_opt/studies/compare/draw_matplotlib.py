"""A chart as a matplotlib figure, for paper."""

from __future__ import annotations

import math

from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import NullLocator, PercentFormatter

from masonry_opt.studies.compare.charts import MARKERS, Axis, Bars, Chart, Series

_MARKERS = dict(zip(MARKERS, "os^D*Phv", strict=True))

_COLUMNS = 4

#: Panels of a picture: more are too small to read. The page has every one.
_PANELS = 24

#: Share of a bar that has room for its count.
_LABELLED = 0.02


def draw(chart: Chart | Bars) -> Figure:
    """The figure of a chart."""
    return _bars(chart) if isinstance(chart, Bars) else _panels(chart)


def _panels(chart: Chart) -> Figure:
    panels = [*chart.panels.items()][:_PANELS]
    columns = min(_COLUMNS, len(panels))
    rows = math.ceil(len(panels) / columns)
    # Wide enough for two columns of legend even with one panel.
    size = (max(3.4 * columns, 8.5), max(3.1 * rows + 2.0, 6.0))
    figure = Figure(figsize=size, layout="constrained")
    listed: set[str] = set()
    for at, (title, drawn) in enumerate(panels):
        axes = figure.add_subplot(rows, columns, at + 1)
        for series in drawn:
            _draw(axes, series, "_" if series.name in listed else series.name)
            listed.add(series.name)
        _set_axis(axes, "x", chart.x, labelled=at >= len(panels) - columns)
        _set_axis(axes, "y", chart.y, labelled=at % columns == 0)
        axes.grid(color="0.9", linewidth=0.5)
        axes.set_title(title, fontsize=9, parse_math=False)
        if chart.band is not None:
            axes.axhspan(chart.band, chart.y.limits[1], color="0.93", zorder=0)
            axes.text(0.02, 0.985, "not certified", transform=axes.transAxes, fontsize=7, va="top")
    left_out = "" if len(panels) == len(chart.panels) else f" (first {_PANELS} of {len(chart.panels)} scenes)"
    figure.suptitle(chart.title + left_out, fontsize=12)
    figure.supylabel(chart.y.label, fontsize=9)
    if listed:
        _list_series(figure, chart.notes, max(2, columns))
    return figure


def _list_series(figure: Figure, notes: str, columns: int) -> None:
    """The legend, below, headed by the notes."""
    figure.legend(
        title=notes, loc="outside lower center", ncols=columns, fontsize=8, title_fontsize=8, frameon=False
    )


def _draw(axes: Axes, series: Series, label: str) -> None:
    x, y, steps = [*series.x], [*series.y], series.line == "steps"
    for *place, letter in zip(x, y, series.letters, strict=False):
        axes.plot(*place, marker=f"${letter}$", markersize=5, linestyle="", color=series.colour)
    if series.letters:
        return
    axes.plot(
        x,
        y,
        label=label,
        color=series.colour,
        marker=_MARKERS.get(series.marker, ""),
        markerfacecolor=series.colour if series.filled else "white",
        markevery=max(1, len(x) // 4) if steps else 1,
        linestyle=("-" if series.filled else "--") if series.line else "",
        linewidth=1.2 if steps else 0.7,
        drawstyle="steps-post" if steps else "default",
        zorder=3 if series.marker else 2,
    )


def _set_axis(axes: Axes, which: str, axis: Axis, labelled: bool = True) -> None:
    axes.set(**{f"{which}scale": "log" if axis.log else "linear", f"{which}lim": axis.limits})
    drawn = axes.xaxis if which == "x" else axes.yaxis
    drawn.set_minor_locator(NullLocator())
    drawn.set_ticks([*axis.ticks], [*axis.ticks.values()] if labelled else [""] * len(axis.ticks))
    if which == "x" and labelled:
        axes.set_xlabel(axis.label, fontsize=9)
    axes.tick_params(labelsize=8)


def _bars(chart: Bars) -> Figure:
    figure = Figure(figsize=(11, 1.9 + 0.3 * len(chart.labels)), layout="constrained")
    bars, times = figure.subplots(1, 2, sharey=True, width_ratios=(3, 1.3))
    rows = range(len(chart.labels))
    totals = [sum(counts) for counts in zip(*(counts for _, _, counts in chart.parts), strict=True)]
    left = [0.0] * len(rows)
    for name, colour, counts in chart.parts:
        shares = [count / total for count, total in zip(counts, totals, strict=True)]
        drawn = bars.barh(chart.labels, shares, left=left, color=colour, label=name, height=0.8)
        written = [
            str(count) if share >= _LABELLED else "" for count, share in zip(counts, shares, strict=True)
        ]
        bars.bar_label(drawn, written, label_type="center", fontsize=7)
        left = [start + share for start, share in zip(left, shares, strict=True)]
    bars.set_xlim(0, 1)
    bars.xaxis.set_major_formatter(PercentFormatter(1.0))
    bars.set_xlabel("scenes", fontsize=9)
    bars.set_ylim(len(rows) - 0.4, -0.6)
    low, median, high = zip(*chart.times, strict=True)
    times.hlines(rows, low, high, color="0.6", linewidth=2)
    times.plot(median, rows, "o", color="black", markersize=4)
    for row, time in enumerate(median):
        if math.isfinite(time):
            place = times.get_yaxis_transform()
            times.text(1.02, row, f"{time:.2g} s", transform=place, fontsize=7, va="center")
    times.grid(axis="x", color="0.9", linewidth=0.5)
    _set_axis(times, "x", chart.time)
    times.tick_params(axis="y", length=0)
    for axes in (bars, times):
        axes.tick_params(labelsize=8)
    figure.suptitle(chart.title, fontsize=12)
    _list_series(figure, chart.notes, len(chart.parts))
    return figure

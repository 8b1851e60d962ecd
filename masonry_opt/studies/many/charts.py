"""Charts of a sweep: λ against one number, mechanisms named where they change; a heat map of two. The least
is ringed; what would press all others into the foot of the axis stands at its head, with its value."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path

import numpy as np
import pandas as pd
from matplotlib import colormaps
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Patch, Rectangle

from masonry_opt.report.colours import CRUSHES, HINGES, LIVE, MARKED, SEPARATES, SLIDES
from masonry_opt.studies.chart_files import chart_files
from masonry_opt.studies.load_factor_axis import LABEL, ends, off_axis
from masonry_opt.studies.many.mechanism import CRUSHING, HINGING, MIXED, NONE, SEPARATING, SLIDING
from masonry_opt.studies.many.words import at_least
from masonry_opt.studies.palette import COLOURS
from masonry_opt.studies.writing import write_files

#: Colour and mark of each mechanism: that of the joints that give it its name, in pictures too.
_LOOKS = {
    SLIDING: (SLIDES, "s"),
    HINGING: (HINGES, "o"),
    CRUSHING: (CRUSHES, "P"),
    MIXED: (MARKED, "^"),
    SEPARATING: (SEPARATES, "D"),
    NONE: (LIVE, "v"),
}

#: Values of the second number up to which each has a line of its own; stretches of one mechanism up to which
#: each is named in the chart.
_MOST_LINES, _MOST_NAMED = 7, 6

#: What names are called beside the name itself, where they are many.
_SYMBOLS = {
    "joints.friction": "friction μ = tan φ",
    "joints.friction_angle": "friction angle φ [°]",
    "joints.dilatancy": "dilatancy tan φ₀",
    "joints.dilatancy_angle": "dilatancy angle φ₀ [°]",
    "joints.cohesion": "cohesion c",
}

#: Cells without a load factor.
_GREY = "0.8"

#: Height of a row of crosses, of the strip of values off the axis, and least space above and below the
#: values, as shares of the chart.
_ROW, _HEAD, _PADDING = 0.04, 0.1, 0.05

#: What legends say.
_OFF, _RING = "off the axis: λ as written", "least"


def write_charts(frame: pd.DataFrame, names: Sequence[str], folder: Path) -> list[Path]:
    """Write what a sweep over these names shows, as PNG and SVG; returns the files.

    Raises OutputError if one cannot be written.
    """
    figures = {"load_factor": against(frame, names)}
    # A map has no place for an infinite value, such as of friction.
    finite = np.isfinite(frame[list(names)].to_numpy(float)).all()
    if len(names) == 2 and finite and frame["load_factor"].notna().any():
        figures["heat_map"] = heat_map(frame, names[0], names[1])
    contents = [chart_files(figure, name) for name, figure in figures.items()]
    return [path for files in contents for path in write_files(folder, files)]


def against(frame: pd.DataFrame, names: Sequence[str]) -> Figure:
    """λ against each number: of one as a line, of two as lines of the first, one a value of the second; of
    more as points."""
    shown = [names[0]] if len(names) <= 2 else list(names)
    figure = Figure(figsize=(7.0, 4.6) if len(shown) == 1 else (3.4 * len(shown), 4.2), layout="constrained")
    panels = figure.subplots(1, len(shown), sharey=True, squeeze=False)[0]
    for axes, name in zip(panels, shown, strict=True):
        axes.set_xlabel(label(name))
        axes.grid(color="0.9", linewidth=0.5)
        if len(names) == 2 and frame[names[1]].nunique() <= _MOST_LINES:
            _lines(axes, frame, *names)
        else:
            _points(axes, frame, name, joined=len(names) == 1)
        _failures(axes, frame, name)
        _off_axis(axes, frame, name)
        _least(axes, frame, name)
    panels[0].set_ylabel(LABEL)
    _set_height(panels[0], frame)
    handles, labels = _listed(panels)
    if labels:
        # As many beside each other as there is room for.
        columns = max(1, int(figure.get_figwidth() / (0.6 + 0.075 * max(map(len, labels)))))
        figure.legend(handles, labels, loc="outside lower center", ncols=columns, fontsize=8, frameon=False)
    return figure


def _points(axes: Axes, frame: pd.DataFrame, name: str, joined: bool) -> None:
    found = frame[frame["load_factor"].notna()].sort_values(name, kind="stable")
    x, y = found[name].to_numpy(float), found["load_factor"].to_numpy(float)
    if joined:
        axes.plot(x, y, color="0.6", linewidth=1, zorder=1)
    mechanisms = found["mechanism"].fillna(NONE).to_numpy()
    for mechanism, (colour, marker) in _LOOKS.items():
        own = mechanisms == mechanism
        if own.any():
            axes.plot(x[own], y[own], marker, color=colour, markersize=5, label=mechanism, zorder=2)
    if joined:
        _name_changes(axes, x, mechanisms)


def _name_changes(axes: Axes, x: np.ndarray, mechanisms: np.ndarray) -> None:
    """Lines where the mechanism changes, and what it is between them, above the chart."""
    stretches = list(_stretches(mechanisms))
    if not 1 < len(stretches) <= _MOST_NAMED:
        return
    above = axes.get_xaxis_transform()
    for first, last in stretches:
        begins = x[first] if first == 0 else (x[first - 1] + x[first]) / 2
        finishes = x[last] if last == len(x) - 1 else (x[last] + x[last + 1]) / 2
        if first:
            axes.axvline(begins, color="0.5", linewidth=0.8, linestyle=":")
        mechanism = str(mechanisms[first])
        axes.text(
            (begins + finishes) / 2,
            1.02,
            mechanism,
            transform=above,
            ha="center",
            va="bottom",
            fontsize=8,
            color=_LOOKS[mechanism][0],
            # Side by side, names of short stretches would run into each other.
            rotation=0 if (finishes - begins) > 0.12 * (x[-1] - x[0]) else 45,
        )


def _stretches(mechanisms: np.ndarray) -> Iterator[tuple[int, int]]:
    """First and last of each stretch of one mechanism."""
    if len(mechanisms) == 0:
        return
    starts = np.flatnonzero(np.r_[True, mechanisms[1:] != mechanisms[:-1]])
    yield from zip(starts.tolist(), np.r_[starts[1:] - 1, len(mechanisms) - 1].tolist(), strict=True)


def _lines(axes: Axes, frame: pd.DataFrame, name: str, other: str) -> None:
    for (value, group), colour in zip(frame.groupby(other), COLOURS, strict=False):
        found = group[group["load_factor"].notna()].sort_values(name, kind="stable")
        axes.plot(
            found[name], found["load_factor"], "o-", color=colour, markersize=4, label=f"{other} = {value:g}"
        )


def _failures(axes: Axes, frame: pd.DataFrame, name: str) -> None:
    """Crosses where there is no load factor, with the status, on a strip at the foot of the chart: they have
    no height."""
    failed = frame[frame["load_factor"].isna()]
    if failed.empty:
        return
    strip = Rectangle((0, 0), 1, _foot(frame), transform=axes.transAxes, color="0.92", zorder=0)
    axes.add_patch(strip)
    for number, (status, group) in enumerate(failed.groupby("status", sort=False)):
        axes.plot(
            group[name],
            np.full(len(group), _ROW * (number + 0.75)),
            "x",
            color="0.2",
            alpha=1 / (1 + 0.5 * number),
            transform=axes.get_xaxis_transform(),
            label=f"no load factor: {status}",
        )


def _off_axis(axes: Axes, frame: pd.DataFrame, name: str) -> None:
    """On a strip at the head of the chart, above the lines that lead there: values that are off the axis."""
    off = frame[off_axis(frame["load_factor"])]
    if off.empty:
        return
    above = axes.get_xaxis_transform()
    strip = Rectangle((0, 1 - _HEAD), 1, _HEAD, transform=axes.transAxes, color="0.92", zorder=3)
    axes.add_patch(strip)
    heights = np.full(len(off), 1 - 0.75 * _HEAD)
    axes.plot(off[name], heights, "^", color="0.2", markersize=5, transform=above, zorder=4, label=_OFF)
    # Values side by side run into each other where they are many: the greatest alone then.
    written = off if len(off) <= _MOST_NAMED else off.nlargest(1, "load_factor")
    for at in written[name].unique():
        told = ", ".join(f"{value:.4g}" for value in written.loc[written[name] == at, "load_factor"])
        text = axes.text(float(at), 1 - 0.1 * _HEAD, told, transform=above)
        text.set(ha="center", va="top", fontsize=8, zorder=4)


def _least(axes: Axes, frame: pd.DataFrame, name: str) -> None:
    """Rings round the least of values that differ."""
    low = frame[at_least(frame)]
    if len(low) < frame["load_factor"].count():
        x, y = low[name], low["load_factor"]
        axes.plot(x, y, "o", color="0.2", fillstyle="none", markersize=11, zorder=3, label=_RING)


def _foot(frame: pd.DataFrame) -> float:
    """Height of the strip of those without a load factor, as a share of the chart."""
    rows = frame.loc[frame["load_factor"].isna(), "status"].nunique()
    return _ROW * (rows + 0.5) if rows else 0.0


def _set_height(axes: Axes, frame: pd.DataFrame) -> None:
    """The axis of λ: all values above the strip at the foot, no zoom into rounding, no numbers for none."""
    off = off_axis(frame["load_factor"])
    least, greatest = ends(frame["load_factor"][~off])
    below, above = _foot(frame) + _PADDING, _PADDING + _HEAD * off.any()
    height = (greatest - least) / (1 - below - above)
    axes.set_ylim(least - below * height, greatest + above * height)
    ticks, known = axes.get_yticks(), frame["load_factor"].notna().any()
    beside = _PADDING * height
    axes.set_yticks(ticks[(ticks >= least - beside) & (ticks <= greatest + beside) & known])


def _listed(panels: Sequence[Axes]) -> tuple[list[Artist], list[str]]:
    """What the legend lists, each once."""
    by_label: dict[str, Artist] = {}
    for axes in panels:
        for handle, text in zip(*axes.get_legend_handles_labels(), strict=True):
            by_label.setdefault(str(text), handle)
    return list(by_label.values()), list(by_label)


def heat_map(frame: pd.DataFrame, across: str, up: str) -> Figure:
    """λ over two numbers; grey where there is no load factor, as is said beside the map."""
    values = frame.pivot(index=up, columns=across, values="load_factor").astype(float)
    off = off_axis(frame["load_factor"])
    least, greatest = ends(frame["load_factor"][~off])
    figure = Figure(figsize=(6.4, 4.8), layout="constrained")
    axes = figure.add_subplot()
    axes.set_facecolor(_GREY)
    x, y = _edges(values.columns.to_numpy(float)), _edges(values.index.to_numpy(float))
    known = np.ma.masked_invalid(values.to_numpy())
    colours = colormaps["viridis"].with_extremes(over="white")
    drawn = axes.pcolormesh(x, y, known, cmap=colours, vmin=least, vmax=greatest)
    figure.colorbar(drawn, ax=axes, label=LABEL, extend="max" if off.any() else "neither")
    axes.set(xlabel=label(across), ylabel=label(up))
    handles: list[Artist] = []
    if frame["load_factor"].nunique() > 1:
        found = frame[at_least(frame)]
        handles += axes.plot(found[across], found[up], "o", color="white", markeredgecolor="0.2", label=_RING)
    if off.any():
        for at, over, value in frame.loc[off, [across, up, "load_factor"]].to_numpy(float):
            axes.text(at, over, f"{value:.4g}", ha="center", va="center", fontsize=8)
        handles.append(Patch(facecolor="white", edgecolor="0.4", label="above the scale: λ as written"))
    if values.isna().any(axis=None):
        handles.append(Patch(facecolor=_GREY, edgecolor="0.4", label="no load factor"))
    if handles:
        figure.legend(handles=handles, loc="outside lower center", ncols=3, fontsize=8, frameon=False)
    return figure


def _edges(middles: np.ndarray) -> np.ndarray:
    """Edges of cells round middles."""
    if len(middles) == 1:
        half = abs(middles[0]) * 0.05 or 0.5
        return np.array([middles[0] - half, middles[0] + half])
    between = (middles[1:] + middles[:-1]) / 2
    first, last = 2 * middles[0] - between[0], 2 * middles[-1] - between[-1]
    return np.concatenate([[first], between, [last]])


def label(name: str) -> str:
    """What an axis says of a number."""
    return _SYMBOLS.get(name, name)

"""The charts as matplotlib figures, from the frames."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import NullFormatter, PercentFormatter

from masonry_opt.studies.compare import frames
from masonry_opt.studies.compare.judge import CERTIFIED, TARGET
from masonry_opt.studies.compare.known_answers import COULOMB
from masonry_opt.studies.compare.style import LETTERS, VERDICT_COLOURS, Look, letter, looks

_COLUMNS = 4

#: Panels of a picture; the interactive report has every scene.
_PANELS = 24

#: Share of a bar that has room for its count.
_LABELLED = 0.01


def time_error(summary: pd.DataFrame, asks: str, error: str = "error") -> Figure:
    """Time against error, a panel a scene; what is not certified stands in a band at the top."""
    asked = summary[summary["question"] == asks]
    every = list(dict.fromkeys(asked["scene"]))
    scenes = every[:_PANELS]
    asked = asked[asked["scene"].isin(scenes)]
    columns = min(_COLUMNS, len(scenes))
    rows = math.ceil(len(scenes) / columns)
    # Wide enough for two columns of legend even with one scene.
    figure = Figure(figsize=(max(3.4 * columns, 8.5), 3.1 * rows + 2.0), layout="constrained")
    shown = looks(summary)
    low, high = _decades(asked[asked["verdict"] == CERTIFIED][error])
    axes: Axes | None = None
    for number, scene in enumerate(scenes):
        axes = figure.add_subplot(rows, columns, number + 1, sharex=axes, sharey=axes)
        _time_error_panel(axes, asked[asked["scene"] == scene], error, shown, (low, high))
        axes.set_title(scene, fontsize=9, parse_math=False)
        axes.label_outer()
        if number >= len(scenes) - columns:
            axes.tick_params(labelbottom=True)
            axes.set_xlabel("time (s)", fontsize=9)
    figure.supylabel(_error_label(asks, error), fontsize=10)
    first = "" if len(scenes) == len(every) else f" (first {len(scenes)} of {len(every)} scenes)"
    title = f"{asks.capitalize()} load factor: time against {_error_word(asks, error)}{first}"
    figure.suptitle(title, fontsize=12)
    handles = [_handle(pair, shown[pair]) for pair in dict.fromkeys(asked["pair"])]
    handles.append(Line2D([], [], color="0.4", linewidth=1, label="Pareto front"))
    if (asked["below"] & (asked["verdict"] == CERTIFIED)).any() and error == "error":
        handles.append(
            Line2D([], [], color="0.4", marker="v", linestyle="", label="below the best exact state (|gap|)")
        )
    letters = dict.fromkeys(letter(line) for line in asked[asked["verdict"] != CERTIFIED].to_dict("records"))
    handles += [
        Line2D([], [], linestyle="", marker=f"${mark}$", color="0.2", label=LETTERS[mark]) for mark in letters
    ]
    figure.legend(
        handles=handles, loc="outside lower center", ncols=max(2, columns), fontsize=8, frameon=False
    )
    return figure


def _time_error_panel(
    axes: Axes, frame: pd.DataFrame, error: str, shown: dict[str, Look], decades: tuple[float, float]
) -> None:
    low, high = decades
    line, top = high * 10**0.3, high * 10 ** (0.3 + 0.22 * (math.log10(high / low) + 0.3))
    axes.set_xscale("log")
    axes.set_yscale("log")
    axes.xaxis.set_minor_formatter(NullFormatter())
    axes.set_ylim(low / 3, top)
    axes.axhspan(line, top, color="0.93", zorder=0)
    axes.text(0.02, 0.985, "not certified", transform=axes.transAxes, fontsize=7, color="0.35", va="top")
    certified = frame[(frame["verdict"] == CERTIFIED) & frame[error].notna()].sort_values("tolerance")
    for pair, group in certified.groupby("pair", sort=False):
        look = shown[str(pair)]
        face = look.colour if look.filled else "white"
        y = np.maximum(group[error], low)
        axes.plot(group["time"], y, color=look.colour, linewidth=0.6, alpha=0.5, zorder=2)
        axes.plot(
            group["time"],
            y,
            linestyle="",
            marker=look.marker,
            color=look.colour,
            markerfacecolor=face,
            markersize=6,
            zorder=3,
        )
        below = group[group["below"]] if error == "error" else group.iloc[:0]
        offset = np.maximum(below[error], low) * 0.55
        axes.plot(below["time"], offset, "v", color="0.4", markersize=3, zorder=3)
    front = frames.pareto(frame, error=error)
    axes.step(front["time"], np.maximum(front[error], low), where="post", color="0.4", linewidth=1, zorder=1)
    failures = frame[frame["verdict"] != CERTIFIED].to_dict("records")
    for number, failure in enumerate(failures):
        # Alternate heights keep letters at near times apart.
        height = 0.12 + 0.24 * (number % 3)
        axes.plot(
            failure["time"],
            line * (top / line) ** height,
            marker=f"${letter(failure)}$",
            linestyle="",
            color=shown[failure["pair"]].colour,
            markersize=5,
        )
    count = round(math.log10(high / low))
    axes.set_yticks([low * 10.0**power for power in range(0, count + 1, math.ceil(count / 6))])
    axes.tick_params(labelsize=8)
    axes.grid(which="major", color="0.9", linewidth=0.5)


def profile(summary: pd.DataFrame, asks: str) -> Figure:
    """Performance profiles over the scenes."""
    figure = Figure(figsize=(8.5, 5), layout="constrained")
    axes = figure.subplots()
    times, shown = frames.reached(summary, asks), looks(summary)
    curves = frames.profiles(times)
    last = 2.0 * float(curves["ratio"].max() if len(curves) else 1.0)
    for pair, curve in curves.groupby("pair", sort=False):
        look = shown[str(pair)]
        x, y = [*curve["ratio"], last], [*curve["share"], curve["share"].iloc[-1]]
        axes.step(
            x,
            y,
            where="post",
            color=look.colour,
            linestyle="-" if look.filled else "--",
            marker=look.marker,
            markerfacecolor=look.colour if look.filled else "white",
            markevery=(0, max(1, len(x) // 4)),
            markersize=5,
            label=pair,
        )
    axes.set_xscale("log", base=2)
    axes.set_xlim(1, last)
    axes.set_ylim(-0.02, 1.04)
    axes.yaxis.set_major_formatter(PercentFormatter(1.0))
    axes.set_xlabel("time over the fastest pair's")
    axes.set_ylabel("scenes reached within it")
    count = times["scene"].nunique()
    axes.set_title(f"Performance profile: {asks} λ to {TARGET[asks]:g}, {count} scenes", fontsize=11)
    axes.grid(color="0.9", linewidth=0.5)
    if axes.get_legend_handles_labels()[0]:
        figure.legend(loc="outside right upper", fontsize=8, frameon=False)
    return figure


def size(summary: pd.DataFrame, asks: str) -> Figure:
    """Time against the number of joints, with fitted exponents."""
    figure = Figure(figsize=(8.5, 5), layout="constrained")
    axes = figure.subplots()
    times, shown = frames.reached(summary, asks), looks(summary)
    fits = frames.growth(times).set_index("pair")
    for pair, group in times[np.isfinite(times["time"])].groupby("pair", sort=False):
        look, fit = shown[str(pair)], fits.loc[str(pair)]
        exponent = "" if np.isnan(fit["exponent"]) else f"  ∝ c^{fit['exponent']:.2f}"
        axes.plot(
            group["joints"],
            group["time"],
            linestyle="",
            marker=look.marker,
            color=look.colour,
            markerfacecolor=look.colour if look.filled else "white",
            label=f"{pair}{exponent}",
        )
        if exponent:
            fitted = group["joints"][group["joints"] >= frames.FITTED_FROM]
            x = np.array([fitted.min(), fitted.max()])
            line = fit["factor"] * x ** fit["exponent"]
            axes.plot(x, line, "-" if look.filled else "--", color=look.colour, linewidth=0.8)
    axes.set_xscale("log")
    axes.set_yscale("log")
    axes.set_xlabel("joints c")
    axes.set_ylabel("time (s)")
    axes.set_title(f"Time to reach {asks} λ to {TARGET[asks]:g}, against size", fontsize=11)
    axes.grid(color="0.9", linewidth=0.5)
    if axes.get_legend_handles_labels()[0]:
        figure.legend(loc="outside right upper", fontsize=8, frameon=False)
    return figure


def success(summary: pd.DataFrame) -> Figure:
    """How the scenes ended, a bar a pair and tolerance; beside it the time of its certified answers."""
    table = frames.success(summary)
    labels = [_rung(line) for line in table.to_dict("records")]
    figure = Figure(figsize=(11, 1.9 + 0.3 * len(table)), layout="constrained")
    bars, times = figure.subplots(1, 2, sharey=True, width_ratios=(3, 1.3))
    left = np.zeros(len(table))
    for verdict, colour in VERDICT_COLOURS.items():
        share = (table[verdict] / table["scenes"]).to_numpy(dtype=float)
        bars.barh(labels, share, left=left, color=colour, label=verdict, height=0.8)
        for number, count in enumerate(table[verdict]):
            if share[number] >= _LABELLED:
                bars.text(
                    left[number] + share[number] / 2, number, str(count), fontsize=7, ha="center", va="center"
                )
        left += share
    bars.invert_yaxis()
    bars.set_xlim(0, 1)
    bars.margins(y=0.01)
    bars.xaxis.set_major_formatter(PercentFormatter(1.0))
    bars.set_xlabel(f"scenes ({_range(table['scenes'])}; counts in the bars)")
    bars.set_title("How the scenes ended", fontsize=10)
    _times(times, table)
    for axes in (bars, times):
        axes.tick_params(labelsize=8)
    figure.legend(loc="outside upper center", ncols=len(VERDICT_COLOURS), fontsize=9, frameon=False)
    return figure


def _times(axes: Axes, table: pd.DataFrame) -> None:
    """Median time of the certified answers and its middle half, a row a pair and tolerance."""
    axes.set_xscale("log")
    rows, time = np.arange(len(table)), table["time"].to_numpy(dtype=float)
    axes.hlines(rows, table["time 25 %"], table["time 75 %"], color="0.6", linewidth=2)
    axes.plot(time, rows, "o", color="black", markersize=4)
    for row, value in enumerate(time):
        if np.isfinite(value):
            text = f"{value:.2g} s"
            axes.text(1.02, row, text, transform=axes.get_yaxis_transform(), fontsize=7, va="center")
    axes.tick_params(axis="y", length=0)
    axes.grid(axis="x", color="0.9", linewidth=0.5)
    axes.set_xlabel("time (s)")
    axes.set_title("Certified answers: median, middle half", fontsize=10)


def _range(counts: pd.Series) -> str:
    """ "12", or "9 to 12" where an interruption left some out."""
    least, most = int(counts.min()), int(counts.max())
    return str(most) if least == most else f"{least} to {most}"


def _rung(line: Mapping[Any, Any]) -> str:
    tolerance = line["tolerance"]
    known = isinstance(tolerance, float) and not math.isnan(tolerance)
    return f"{line['pair']}{f' · {tolerance:.0e}' if known else ''}"


def _handle(pair: str, look: Look) -> Line2D:
    face = look.colour if look.filled else "white"
    return Line2D(
        [], [], linestyle="", marker=look.marker, color=look.colour, markerfacecolor=face, label=pair
    )


def _decades(errors: pd.Series) -> tuple[float, float]:
    """Whole decades that hold the errors."""
    known = errors[errors > 0]
    if known.empty:
        return 1e-9, 1.0
    return 10.0 ** math.floor(math.log10(known.min())), 10.0 ** math.ceil(math.log10(known.max()) + 1e-9)


def _error_word(asks: str, error: str) -> str:
    if error == "violation":
        return "violation of yield"
    return "gap to the best exact state" if asks == COULOMB else "error"


def _error_label(asks: str, error: str) -> str:
    if error == "violation":
        return "largest violation of yield (median block weights)"
    if asks == COULOMB:
        return "relative gap to the best exact state known"
    return "relative error of λ (against certified bounds)"

"""Pictures of a sample: how its load factors are distributed, the fragility curve, and what matters."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from masonry_opt.errors import counted
from masonry_opt.report.pictures.letters import boxed
from masonry_opt.studies.load_factor_axis import LABEL, ends
from masonry_opt.studies.palette import COLOURS
from masonry_opt.studies.sampling.answer import CONFIDENCE, Sample
from masonry_opt.studies.sampling.estimates import LIMITS

#: So many of the numbers drawn are shown, those that matter most.
_SHOWN = 15

#: Ends of bars, of a load factor that does not change.
_BARS = 12

_RUNS, _MARKS = COLOURS[0], COLOURS[1]


def distribution(sample: Sample) -> Figure:
    """Histogram of the load factors, with quantiles and their intervals."""
    figure, found = _figure(), sample.load_factors
    axes, finite = figure.add_subplot(), found[np.isfinite(found)]
    middle = (finite.min() + finite.max()) / 2 if len(finite) else 0.0
    if len(finite):
        shown = ends(finite)
        # Of a load factor that hardly changes bars as wide as if it did.
        bins = "auto" if shown == (finite.min(), finite.max()) else np.linspace(*shown, _BARS).tolist()
        axes.hist(finite, bins=bins, color=_RUNS, alpha=0.55, edgecolor="white", linewidth=0.8)
    top = max(axes.get_ylim()[1], 1.0)
    for step, row in enumerate(sample.quantiles().to_dict("records")):
        if not np.isfinite(row["value"]):
            continue
        # Each on a line of its own above the bars: quantiles may lie close together.
        height = top * (1.06 + 0.09 * step)
        known = np.isfinite([row["lower"], row["upper"]])
        limits = [row[name] if there else row["value"] for name, there in zip(LIMITS, known, strict=True)]
        axes.plot(limits, [height, height], color=_MARKS, linewidth=5, alpha=0.45, solid_capstyle="butt")
        axes.plot([row["value"]] * 2, [0, height], color=_MARKS, linewidth=1.3)
        aside, at = (6, "left") if row["value"] <= middle else (-6, "right")
        text = f"{row['probability']:.0%}: {row['value']:.4f}"
        beyond = limits[1] if at == "left" else limits[0]
        axes.annotate(
            text, (beyond, height), (aside, 0), textcoords="offset points", ha=at, va="center", fontsize=9
        )
    axes.set_ylim(0, 1.36 * top)
    if len(finite):
        margin = 0.05 * (shown[1] - shown[0])
        axes.set_xlim(shown[0] - margin, shown[1] + margin)
    axes.yaxis.set_major_locator(MaxNLocator(integer=True))
    axes.set_xlabel(LABEL)
    axes.set_ylabel("runs")
    axes.set_title(f"{_title(sample)}\nquantiles, with {CONFIDENCE:.0%} confidence", fontsize=10)
    return figure


def fragility(sample: Sample) -> Figure:
    """Probability of collapse against load, with its interval."""
    figure, curve = _figure(), sample.fragility()
    axes = figure.add_subplot()
    axes.fill_between(
        curve["load"],
        curve["lower"],
        curve["upper"],
        color=_RUNS,
        alpha=0.25,
        linewidth=0,
        step="post",
        label=f"{CONFIDENCE:.0%} confidence",
    )
    axes.step(
        curve["load"], curve["probability"], where="post", color=_RUNS, linewidth=1.8, label="share of runs"
    )
    axes.set_ylim(0, 1.02)
    axes.set_xlim(float(curve["load"].min()), float(curve["load"].max()))
    axes.set_xlabel(LABEL)
    axes.set_ylabel("probability of collapse")
    axes.set_title(_title(sample), fontsize=10)
    axes.grid(color="#DDDDDD", linewidth=0.6)
    figure.legend(loc="outside lower center", ncols=2, frameon=False)
    return figure


def sensitivity(sample: Sample) -> Figure:
    """Rank correlations, strongest on top."""
    found = sample.sensitivity().dropna()
    shown = found.head(_SHOWN).iloc[::-1]
    figure = Figure(figsize=(7.0, 1.6 + 0.28 * max(len(shown), 2)), layout="constrained")
    axes = figure.add_subplot()
    at = np.arange(len(shown))
    value = shown["rank_correlation"].to_numpy()
    reach = np.abs(shown[["lower", "upper"]].to_numpy().T - value)
    # What may as well be chance is pale.
    certain = (shown["lower"] > 0) | (shown["upper"] < 0)
    axes.barh(at, value, color=[_RUNS if known else "#BBBBBB" for known in certain], alpha=0.7)
    axes.errorbar(value, at, xerr=reach, fmt="none", ecolor="black", elinewidth=1, capsize=2.5)
    axes.axvline(0, color="black", linewidth=0.8)
    axes.set_yticks(at, [*map(boxed, shown["parameter"])])
    axes.set_xlim(-1.05, 1.05)
    axes.set_ylim(-0.7, max(len(shown), 1) - 0.3)
    axes.set_xlabel(
        f"rank correlation with λ ({CONFIDENCE:.0%} confidence that all intervals hold; grey: may be none)"
    )
    left_out = f", the first {len(shown)} of {len(found)}" if len(found) > len(shown) else ""
    if found.empty:
        left_out = ": nothing drawn matters"
    axes.set_title(f"{_title(sample)}{left_out}", fontsize=10)
    return figure


#: What can be drawn.
KINDS = {"distribution": distribution, "fragility": fragility, "sensitivity": sensitivity}


def _figure() -> Figure:
    return Figure(figsize=(7.0, 4.2), layout="constrained")


def _title(sample: Sample) -> str:
    """The case, the runs, and those that no bar shows."""
    beside = [
        (sample.falling, "falls by itself" if sample.falling == 1 else "fall by themselves"),
        (sample.unlimited, f"never collapse{'s' if sample.unlimited == 1 else ''}"),
        (sample.undecided, "undecided"),
    ]
    told = "".join(f", {count} {what}" for count, what in beside if count)
    case = Path(sample.case)
    # A scene made in Python has a title in its place, which may have dots.
    name = case.stem if case.suffix in (".toml", ".json") else sample.case
    return f"{name}: {counted(sample.runs, 'run')}{told}"

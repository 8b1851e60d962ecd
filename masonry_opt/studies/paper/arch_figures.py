"""Pictures of the semicircular arch: its least thickness, and its modes of collapse."""

from __future__ import annotations

import pandas as pd
from matplotlib.figure import Figure

from masonry_opt.answer.result import Result
from masonry_opt.report.pictures.mechanism import draw_mechanism
from masonry_opt.scene.arch import Arch
from masonry_opt.studies.palette import COLOURS

#: Of the curve in each mode.
_COLOURS = dict(zip(("I", "II", "III"), COLOURS, strict=False))

#: Top of the thickness axis, over the radius: as in the paper's figure.
_TOP = 0.5


def draw_curve(arch: Arch, curve: pd.DataFrame, hinging: float, sliding: float) -> Figure:
    """Least thickness against friction, as in Fig. 9.

    Parameters
    ----------
    arch: for its radius and number of voussoirs.
    curve: columns "μ", "thickness (m)" (NaN where none stands).
    hinging, sliding: μ where modes I and II end.
    """
    figure = Figure(figsize=(7.0, 4.2))
    axes = figure.add_subplot()
    known = curve.dropna(subset=["thickness (m)"])
    mu, thickness = known["μ"], known["thickness (m)"]
    top, start = _TOP * arch.centreline, float(curve["μ"].min())
    parts = {
        "II": ([*mu[mu <= hinging + 1e-3]], [*thickness[mu <= hinging + 1e-3]]),
        "I": ([*mu[mu >= hinging]], [*thickness[mu >= hinging]]),
        "III": ([sliding, sliding], [float(thickness.iloc[0]), top]),
    }
    for mode, (x, y) in parts.items():
        axes.plot(
            x, y, color=_COLOURS[mode], linewidth=2, marker="" if mode == "III" else "o", markersize=3.5
        )
    axes.axvspan(start, sliding, color="#EEEEEE", zorder=0)
    axes.annotate("no thickness\nstands", ((start + sliding) / 2, top / 2), ha="center", va="center")
    for friction in (hinging, sliding):
        axes.axvline(friction, ymax=0.42, color="#777777", linewidth=0.8, linestyle=":", zorder=0)
        axes.annotate(f" {friction:.4f}", (friction, 0.03 * top), fontsize=9, color="#444444")
    last = float(thickness.iloc[-1])
    axes.annotate("mode I: hinging", (0.6, last + 0.03 * top), color=_COLOURS["I"])
    axes.annotate("mode II: mixed", (0.4, float(1.3 * last)), color=_COLOURS["II"])
    axes.annotate(" mode III: sliding", (sliding, 0.85 * top), color=_COLOURS["III"])
    axes.annotate(
        f"{last:.4f} m ", (float(mu.iloc[-1]), last - 0.02 * top), ha="right", va="top", color=_COLOURS["I"]
    )
    axes.set_xlim(start, float(mu.iloc[-1]))
    axes.set_ylim(0, top)
    axes.set_xlabel("friction μ = tan φ")
    axes.set_ylabel("least thickness (m)")
    percent = axes.twinx()
    percent.set_ylim(0, 100 * _TOP)
    percent.set_ylabel("% of the centreline radius")
    axes.set_title(f"Semicircular arch, {arch.voussoirs} voussoirs, centreline radius {arch.centreline:g} m")
    return figure


def draw_modes(results: dict[str, Result]) -> Figure:
    """One mechanism beside the other, each under its title."""
    figure = Figure(figsize=(4.2 * len(results), 3.6))
    for number, (title, result) in enumerate(results.items(), start=1):
        axes = figure.add_subplot(1, len(results), number)
        draw_mechanism(result, axes)
        axes.set_title(title)
        axes.set_xlabel("x (m)")
        axes.set_ylabel("y (m)" if number == 1 else "")
    return figure

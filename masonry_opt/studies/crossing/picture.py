"""Picture of a crossing: λ over the position, and below it the mechanism at the worst one."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import cycle
from typing import Any

import numpy as np
from matplotlib.axes import Axes

from masonry_opt.drawing.colours import HATCH, LIVE, MARKED, SERIES
from masonry_opt.drawing.elements import title_of
from masonry_opt.drawing.figure import Picture, style
from masonry_opt.drawing.pictures import draw_mechanism
from masonry_opt.errors import printable
from masonry_opt.result import Result
from masonry_opt.studies.crossing.passage import Passage
from masonry_opt.studies.crossing.search import CrossedPassage, PassageTrials
from masonry_opt.words.sentences import numeral

#: Inches: width of the axes, height of the chart, room beside, below, between and above them; most of the
#: bridge's height.
_WIDTH, _HIGH, _LEFT, _BELOW, _BETWEEN, _ABOVE, _TALLEST = 7.2, 3.0, 0.8, 0.85, 0.75, 0.7, 5.0

#: Load factors are shown up to so many times the least.
_SHOWN = 4.0

#: Length of the arrow of the greatest axle, as a share of the bridge's length.
_ARROW = 0.05


def picture(passages: Sequence[CrossedPassage], least: CrossedPassage, worst: Result) -> Picture:
    """Load factors by position, and below them, in the same scale, the mechanism at the worst."""
    passage = least.passage
    with style():
        made = Picture()
        chart, bridge = made.subplots(2)
        if worst.load_factor is not None:
            draw_mechanism(worst, bridge)
        low, high = bridge.get_xlim()
        positions = np.concatenate([one.found.positions for one in passages])
        low, high = min(low, positions.min()), max(high, positions.max())
        bottom, top = bridge.get_ylim()
        arrow = _ARROW * (high - low)
        top = max(top, _axles(bridge, passage, least.position, arrow) + 1.5 * arrow)
        tall = min((top - bottom) / (high - low) * _WIDTH, _TALLEST)
        size = np.array([_WIDTH + 1.4 * _LEFT, tall + _HIGH + _BELOW + _BETWEEN + _ABOVE])
        made.set_size_inches(*size)
        for axes, foot, height in ((bridge, _BELOW, tall), (chart, _BELOW + tall + _BETWEEN, _HIGH)):
            axes.set_position((_LEFT / size[0], foot / size[1], _WIDTH / size[0], height / size[1]))
            axes.set_xlim(low, high)
        bridge.set_ylim(bottom, top)
        bridge.set_xlabel("x, y in the length unit of the case")
        _load_factors(chart, passages, least, worst.load_factor)
        heading = str(worst.status)
        if worst.load_factor is not None:
            heading = printable(
                f"least λ = {numeral(worst.load_factor, '.5g')} with '{passage.axles.name}' at "
                f"{numeral(least.position, '.4g')}, travelling {passage.direction}"
            )
        chart.set_title(f"{title_of(worst.assembly.scene)}\n{heading}", parse_math=False, fontsize=10.5)
        handles, labels = chart.get_legend_handles_labels()
        made.legend(handles, labels, loc="lower center", ncols=3, frameon=False, fontsize=8.5)
    return made


def _load_factors(
    axes: Axes, passages: Sequence[CrossedPassage], least: CrossedPassage, load_factor: float | None
) -> None:
    """A line for each passage over the position of its first axle, and of Coulomb methods associative λ."""
    values: list[float] = []
    for one, colour in zip(passages, cycle(SERIES), strict=False):
        name = printable(f"'{one.passage.axles.name}', travelling {one.passage.direction}")
        proven = one.associative is one.found
        if not proven:
            axes.plot(
                one.associative.positions, _finite(one.associative), color=HATCH, linewidth=0.8, zorder=2
            )
        known = _finite(one.found)
        look: dict[str, Any] = (
            {"linewidth": 1.1} if proven else {"linestyle": "none", "marker": ".", "markersize": 7}
        )
        axes.plot(one.found.positions, known, color=colour, label=name, zorder=3, **look)
        values += known[np.isfinite(known)].tolist()
    if passages[0].associative is not passages[0].found:
        axes.plot([], [], color=HATCH, linewidth=0.8, label="associative")
    axes.set_ylabel("load factor λ")
    axes.set_xlabel("position of the first axle")
    axes.grid(color="#E4E4E4", linewidth=0.6)
    if load_factor is not None:
        ring: dict[str, Any] = {"marker": "o", "markersize": 11, "fillstyle": "none", "linestyle": "none"}
        axes.plot(least.position, load_factor, color=MARKED, label="worst", zorder=4, **ring)
        axes.set_ylim(0.0, min(_SHOWN * load_factor, 1.1 * max(values)) or 1.0)


def _finite(trials: PassageTrials) -> np.ndarray:
    """Load factors, NaN where any load is carried."""
    return np.where(np.isfinite(trials.load_factors), trials.load_factors, np.nan)


def _axles(axes: Axes, passage: Passage, position: float, arrow: float) -> float:
    """Draw the road and the axles on it; the highest point of the road."""
    line = passage.road.line
    axes.plot(*line.T, color=LIVE, linewidth=0.8, zorder=6)
    loads = np.array(passage.axles.group.loads)
    for x, share in zip(position + passage.offsets, loads / loads.max(), strict=True):
        if line[0, 0] <= x <= line[-1, 0]:
            y = float(np.interp(x, *line.T))
            look = {"arrowstyle": "-|>", "color": LIVE, "linewidth": 1.3, "shrinkA": 0, "shrinkB": 0}
            axes.annotate("", (x, y), (x, y + share * arrow), arrowprops=look, zorder=7)
    return float(line[:, 1].max())

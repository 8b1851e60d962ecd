"""Picture and page of a crossing: λ over the position, and below it the mechanism at the worst one."""

from __future__ import annotations

from base64 import b64encode

import numpy as np
import pandas as pd
from matplotlib.axes import Axes

from masonry_opt.drawing.colours import HATCH, LIVE, MARKED, SERIES
from masonry_opt.drawing.elements import title_of
from masonry_opt.drawing.figure import Picture, style
from masonry_opt.drawing.notebook import notebook_html
from masonry_opt.drawing.pictures import draw_mechanism
from masonry_opt.errors import OptionError, printable
from masonry_opt.studies.crossing.answer import Crossings
from masonry_opt.studies.crossing.passage import Passage
from masonry_opt.studies.writing import render
from masonry_opt.words.sentences import numeral

#: Inches: width of the axes, height of the chart, room beside, below, between and above them; most of the
#: bridge's height.
_WIDTH, _HIGH, _LEFT, _BELOW, _BETWEEN, _ABOVE, _TALLEST = 7.2, 3.0, 0.8, 0.85, 0.75, 0.7, 5.0

#: Load factors are shown up to so many times the least.
_SHOWN = 4.0

#: Length of the arrow of the greatest axle, as a share of the bridge's length.
_ARROW = 0.05


def picture(crossing: Crossings) -> Picture:
    """Load factors by position, and below them, in the same scale, the mechanism at the worst."""
    least, worst = crossing.least, crossing.worst
    if least is None:
        raise OptionError(f"{worst.case}: {worst.status}: no axle was moved, none can be drawn")
    passage = least.passage
    with style():
        made = Picture()
        chart, bridge = made.subplots(2)
        if worst.load_factor is not None:
            draw_mechanism(worst, bridge)
        low, high = bridge.get_xlim()
        positions = np.concatenate([one.found.positions for one in crossing.passages])
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
        _load_factors(chart, crossing)
        chart.set_title(
            f"{title_of(worst.assembly.scene)}\n{_heading(crossing)}", parse_math=False, fontsize=10.5
        )
        handles, labels = chart.get_legend_handles_labels()
        made.legend(handles, labels, loc="lower center", ncols=3, frameon=False, fontsize=8.5)
    return made


def _heading(crossing: Crossings) -> str:
    if crossing.load_factor is None or crossing.position is None:
        return str(crossing.worst.status)
    return printable(
        f"least λ = {numeral(crossing.load_factor, '.5g')} with '{crossing.axles}' at "
        f"{numeral(crossing.position, '.4g')}, travelling {crossing.direction}"
    )


def _load_factors(axes: Axes, crossing: Crossings) -> None:
    """A line for each passage over the position of its first axle, and of Coulomb methods associative λ."""
    values: list[float] = []
    for one, colour in zip(crossing.passages, SERIES * len(crossing.passages), strict=False):
        name = printable(f"'{one.passage.axles.name}', travelling {one.passage.direction}")
        proven = one.associative is one.found
        if not proven:
            known = np.where(np.isfinite(one.associative.load_factors), one.associative.load_factors, np.nan)
            axes.plot(one.associative.positions, known, color=HATCH, linewidth=0.8, zorder=2)
        known = np.where(np.isfinite(one.found.load_factors), one.found.load_factors, np.nan)
        look = {"linewidth": 1.1} if proven else {"linestyle": "none", "marker": ".", "markersize": 7}
        axes.plot(one.found.positions, known, color=colour, label=name, zorder=3, **look)
        values += known[np.isfinite(known)].tolist()
    if crossing.passages[0].associative is not crossing.passages[0].found:
        axes.plot([], [], color=HATCH, linewidth=0.8, label="associative")
    axes.set_ylabel("load factor λ")
    axes.set_xlabel("position of the first axle")
    axes.grid(color="#E4E4E4", linewidth=0.6)
    if crossing.load_factor is not None and crossing.position is not None:
        axes.plot(
            crossing.position,
            crossing.load_factor,
            marker="o",
            markersize=11,
            fillstyle="none",
            color=MARKED,
            linestyle="none",
            label="worst",
            zorder=4,
        )
        axes.set_ylim(0.0, min(_SHOWN * crossing.load_factor, 1.1 * max(values)) or 1.0)


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


def page(crossing: Crossings) -> str:
    """The picture, what was found, the worst position's result and the table, as HTML that stands by itself.

    Raises OptionError if Jinja2, of the extra "studies", is not installed.
    """
    drawn = b64encode(picture(crossing).image("svg")).decode()
    return render(
        "crossing.html",
        title=title_of(crossing.worst.assembly.scene),
        facts=crossing.facts(),
        picture=drawn,
        worst=notebook_html(crossing.worst),
        rows=_rows(crossing.table),
    )


def _rows(table: pd.DataFrame) -> list[tuple[str, ...]]:
    """Of the table what a page shows, as text."""
    return [
        (
            printable(row["axles"]),
            row["direction"],
            numeral(row["position"], ".6g"),
            "" if np.isnan(row["load_factor"]) else numeral(row["load_factor"], ".6g"),
            row["mechanism"] if isinstance(row["mechanism"], str) else "",
            row["status"],
        )
        for row in table.to_dict("records")
    ]

"""Picture of a crossing: λ by position above the mechanism at the worst position."""

from itertools import cycle
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.lines import Line2D
from matplotlib.patches import Patch, Rectangle

from masonry_opt.drawing.colours import HATCH, LIVE, MARKED, SERIES
from masonry_opt.drawing.elements import title_of
from masonry_opt.drawing.figure import Handle, Picture, entitle, finish, style
from masonry_opt.drawing.fill_areas import draw_fill
from masonry_opt.drawing.pictures import draw_mechanism
from masonry_opt.errors import OptionError, printable
from masonry_opt.reporting.load_factors import named_factor
from masonry_opt.reporting.sentences import numeral
from masonry_opt.studies.crossing.load_factors import CrossingLoadFactors
from masonry_opt.studies.crossing.search import Passage

_CHART_HEIGHT = 0.42  #: Height of the chart relative to the width of the picture.
_CHART_GAP = 0.1  #: Distance between the chart and the mechanism, relative to the width of the picture.
#: Largest λ that the chart shows, relative to the least λ; curves are cut off above this value.
_LARGEST_SHOWN = 4.0
_AXLE_ARROW_LENGTH = 0.05  #: Length of the arrow of the heaviest axle, relative to the length of the bridge.
_STRIP_HEIGHT_SHARE = 0.35  #: Height of a uniform load in the picture, relative to the longest arrow.


def crossing_picture(answer: CrossingLoadFactors) -> Picture:
    """Return the picture of a crossing; see :meth:`~.answer.Crossing.plot`."""
    least, worst = answer.least, answer.worst
    if least is None:
        raise OptionError(f"{worst.case} has no picture, because no axle was moved: {worst.status}")
    passage, heading = least.passage, str(worst.status)
    handles: list[Handle] = []
    with style():
        picture = Picture()
        bridge = picture.add_subplot()
        if worst.load_factor is not None:
            handles = draw_mechanism(worst, bridge)
            [position] = answer.printed_positions([least.position])
            where = f"'{answer.axles}' at {numeral(position, '.4g')}, travelling {answer.direction}"
            governing = "" if answer.interrupted else "governing "
            load_factor = named_factor(worst, answer.load_factor_name)
            heading = printable(f"{governing}{load_factor}\nwith {where}")
        positions = np.concatenate([trials.positions for trials in answer.passages])
        abscissae = [*bridge.get_xlim(), *positions]
        low, high = min(abscissae), max(abscissae)
        bottom, top = bridge.get_ylim()
        arrow = _AXLE_ARROW_LENGTH * (high - low)
        highest, of_axles = _draw_axles(bridge, passage, least.position, arrow)
        top = max(top, highest + 1.5 * arrow)
        handles += [*draw_fill(bridge, passage.assembly), *of_axles]
        bridge.set(xlim=(low, high), ylim=(bottom, top), xlabel="x, y in the length unit of the case")
        aspect = (high - low) / (top - bottom)
        box = (0.0, 1 + _CHART_GAP * aspect, 1.0, _CHART_HEIGHT * aspect)
        chart: Any = bridge.inset_axes(box, sharex=bridge)
        _draw_load_factors(answer, chart, least.position)
        entitle(chart, title_of(worst.assembly.scene), heading)
        finish(picture, bridge, [*chart.get_legend_handles_labels()[0], *handles])
    return picture


def _draw_load_factors(answer: CrossingLoadFactors, axes: Axes, position: float) -> None:
    """Draw the least λ of all load cases by position, for each group of axles and direction.

    Thin lines behind show each load case, if there are several, and the associative λ of other methods.
    """
    dots: dict[str, Any] = {"linestyle": "none", "marker": ".", "markersize": 7}
    coulomb = answer.passages[0].associative_trials is not None
    look = dots if coulomb else {"linewidth": 1.1}
    background = ["associative (upper bound)"] if coulomb else []
    background += ["each load case"] if len(answer.by_case) > 1 else []
    place = ["axles", "direction"]
    if background:
        cases = ["load_case"] if answer.cases else []
        for _, rows in answer.envelope.groupby([*cases, *place], sort=False):
            axes.plot(rows["position"], rows["associative"], color=HATCH, linewidth=0.8, zorder=2)
    groups = answer.governing.groupby(place, sort=False)
    for ((axles, direction), rows), colour in zip(groups, cycle(SERIES), strict=False):
        name = printable(f"'{axles}', travelling {direction}")
        axes.plot(rows["position"], rows["load_factor"], color=colour, label=name, zorder=3, **look)
    if background:
        axes.plot([], [], color=HATCH, linewidth=0.8, label=", ".join(background))
    axes.set(xlabel="position of the first axle", ylabel="load factor λ")
    axes.grid(color="#E4E4E4", linewidth=0.6)
    if answer.load_factor is None:
        return
    ring: dict[str, Any] = {"color": MARKED, "markersize": 11, "fillstyle": "none"}
    axes.plot(position, answer.load_factor, "o", label="worst", zorder=4, **ring)
    highest = 1.1 * float(answer.governing["load_factor"].max())
    top = min(_LARGEST_SHOWN * answer.load_factor, highest) or 1.0
    required = answer.required_factor
    axes.set_ylim(0.0, max(top, 1.1 * (required or 0.0)))
    if required is not None:
        axes.axhline(required, color=LIVE, linewidth=0.9, linestyle="--", label="required")


def _draw_axles(axes: Axes, passage: Passage, position: float, arrow: float) -> tuple[float, list[Handle]]:
    """Draw the road, the axles as arrows, and uniform loads as bands.

    Returns the height of the highest point of the road, and the legend entries.
    """
    line = passage.road.line
    axes.plot(*line.T, color=LIVE, linewidth=0.8, zorder=6)
    handles: list[Handle] = [Line2D([], [], color=LIVE, linewidth=0.8, label="road")]
    loads = np.array(passage.axles.group.loads)
    look = {"arrowstyle": "-|>", "color": LIVE, "linewidth": 1.3, "shrinkA": 0, "shrinkB": 0}
    for x, share in zip(position + passage.offsets, loads / max(loads, default=1.0), strict=True):
        if line[0, 0] <= x <= line[-1, 0]:
            y = float(np.interp(x, *line.T))
            axes.annotate("", (x, y), (x, y + share * arrow), arrowprops=look, zorder=7)
    if len(loads):
        marker: dict[str, Any] = {"marker": r"$\downarrow$", "markersize": 11, "linestyle": "none"}
        handles.append(Line2D([], [], color=LIVE, label="axle", **marker))
    band: dict[str, Any] = {"facecolor": "none", "edgecolor": LIVE, "hatch": "|||", "linewidth": 0.6}
    for start, end in position + passage.strips[:, 1:]:
        left, right = max(start, line[0, 0]), min(end, line[-1, 0])
        if left < right:
            height = float(np.interp([left, right], *line.T).max())
            corner = (left, height)
            axes.add_patch(Rectangle(corner, right - left, _STRIP_HEIGHT_SHARE * arrow, zorder=6, **band))
    if len(passage.strips):
        handles.append(Patch(label="uniform load", **band))
    return float(line[:, 1].max()), handles

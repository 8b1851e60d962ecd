"""Several mechanisms on one sheet."""

from __future__ import annotations

from collections.abc import Sequence

from matplotlib.axes import Axes
from matplotlib.figure import Figure

from masonry_opt.answer.result import Result
from masonry_opt.report.pictures.mechanism import draw_mechanism, legend_handles

#: Inches: width of a sheet, space between panels, room for a row's titles, and for the legend.
_WIDTH, _SPACE, _TITLE, _LEGEND = 8.0, 0.15, 0.35, 0.4


def draw_panel(result: Result, axes: Axes, title: str) -> None:
    """Draw a mechanism as one of several: a short title, no coordinates."""
    draw_mechanism(result, axes)
    axes.set_title(title, fontsize=10)
    axes.set_axis_off()


def mechanism_sheet(panels: Sequence[tuple[str, Result]], columns: int) -> Figure:
    """Mechanisms row by row, those of a row in the same scale, with one legend for all.

    Parameters
    ----------
    panels: title and result of each.
    columns: panels in a row.
    """
    figure = Figure(figsize=(_WIDTH, _WIDTH))
    drawn = []
    for title, result in panels:
        axes = figure.add_subplot()
        draw_panel(result, axes, title)
        (left, right), (bottom, top) = axes.get_xlim(), axes.get_ylim()
        drawn.append((axes, right - left, top - bottom))
    rows = [drawn[start : start + columns] for start in range(0, len(drawn), columns)]
    scales = [(_WIDTH - (len(row) - 1) * _SPACE) / sum(wide for _, wide, _ in row) for row in rows]
    heights = [scale * max(tall for *_, tall in row) for scale, row in zip(scales, rows, strict=True)]
    whole = sum(heights) + len(rows) * _TITLE + _LEGEND
    figure.set_size_inches(_WIDTH, whole)
    floor = whole
    for row, scale, height in zip(rows, scales, heights, strict=True):
        floor -= height + _TITLE
        left = 0.0
        for axes, wide, tall in row:
            axes.set_position((left / _WIDTH, floor / whole, scale * wide / _WIDTH, scale * tall / whole))
            left += scale * wide + _SPACE
    handles = {str(handle.get_label()): handle for _, result in panels for handle in legend_handles(result)}
    figure.legend(handles=[*handles.values()], loc="lower center", ncols=5, frameon=False)
    return figure

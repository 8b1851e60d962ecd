"""Marks as matplotlib draws them, and as a legend shows them."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from matplotlib.patheffects import withStroke

from masonry_opt.drawing.colours import BLOCK, FIXED, HATCH
from masonry_opt.drawing.elements import legend
from masonry_opt.drawing.figure import Handle
from masonry_opt.drawing.marks import Marks
from masonry_opt.errors import printable

#: Markers of the shapes that have no ends.
_MARKERS = {"dot": "o", "point": "o", "square": "s", "cross": "x"}

#: How blocks and supports look, beside the widths of their outlines.
BLOCK_LOOK: dict[str, Any] = {"facecolor": BLOCK, "edgecolor": "black"}
SUPPORT_LOOK: dict[str, Any] = {"facecolor": FIXED, "edgecolor": HATCH, "hatch": "////", "linewidth": 0}


def handles(marks: list[Marks]) -> list[Handle]:
    """What a legend shows: blocks, supports, and marks by their labels."""
    told = [_handle(label, alike) for label, alike in legend(marks).items()]
    return [Patch(label="block", **BLOCK_LOOK), Patch(label="support", **SUPPORT_LOOK), *told]


def draw_marks(axes: Axes, marks: Marks, at: np.ndarray) -> None:
    """Draw marks at points of the case, shape (marks, 1 or 2, 2)."""
    colour, width = marks.colour, marks.width
    match marks.shape:
        case "line":
            dashes = (0, marks.dashes) if marks.dashes else "solid"
            cap = "butt" if marks.dashes else "round"
            axes.add_collection(
                LineCollection(
                    list(at), color=colour, linewidth=width, linestyle=dashes, capstyle=cap, zorder=3
                )
            )
        case "arrow":
            axes.quiver(
                *at[:, 0].T,
                *(at[:, 1] - at[:, 0]).T,
                angles="xy",
                scale_units="xy",
                scale=1,
                units="inches",
                width=width / 72,
                headwidth=4.5,
                headlength=5,
                headaxislength=4.5,
                minlength=0.1,
                color=colour,
                zorder=5,
            )
        case "bar":
            axes.plot(*at[0].T, color=colour, linewidth=width, marker="|", markersize=6, zorder=8)
            axes.annotate(
                marks.text, at[0, 1], xytext=(6, 0), textcoords="offset points", va="center", zorder=8
            )
        case shape:
            look: dict[str, Any] = {"edgecolor": "white"} if shape == "dot" else {}
            look["linewidth"] = {"dot": 0.4, "cross": 1.5}.get(shape, 0.0)
            x, y = at[:, 0].T
            axes.scatter(x, y, s=width**2, marker=_MARKERS[shape], color=colour, zorder=4, **look)


def write_name(axes: Axes, name: str, at: np.ndarray, letters: float, rim: float, **look: Any) -> None:
    """Write a block's name at a point, in letters of a size in points, with a white rim of so many times
    that."""
    # To find in a layout what room thousands take is slow.
    look |= {"fontsize": letters, "ha": "center", "zorder": 7, "parse_math": False, "in_layout": False}
    written = axes.annotate(printable(name), (at[0], at[1]), **look)
    if rim:
        written.set_path_effects([withStroke(linewidth=rim * letters, foreground="white")])


def _handle(label: str, alike: list[Marks]) -> Line2D:
    """What a legend shows of marks that share a label."""
    handle = Line2D([], [], color=alike[0].colour, linestyle="none", label=label)
    for marks in alike:
        if marks.shape == "line":
            handle.set(linewidth=marks.width, linestyle=(0, marks.dashes) if marks.dashes else "solid")
        elif marks.shape == "arrow":
            handle.set(marker=r"$\rightarrow$", markersize=14)
        else:
            handle.set(marker=_MARKERS[marks.shape], markersize=marks.width)
    return handle

"""Pictures of several live loads on one scene: bars of load cases, load factors over directions in plan."""

from __future__ import annotations

import itertools
from collections.abc import Mapping
from itertools import cycle
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.lines import Line2D

from masonry_opt.drawing.colours import AT_REST, BLACK, SERIES, VERMILION
from masonry_opt.drawing.elements import title_of
from masonry_opt.drawing.figure import Handle, Picture, entitle, finish, style
from masonry_opt.errors import counted, printable
from masonry_opt.result import Result
from masonry_opt.words.summary import told_factor

#: Height of a bar over the width of the axes; most letters of a name beside one.
_BAR, _LETTERS = 0.09, 24

#: Load factors no farther from λ than this are not drawn beside it.
_SAME = 1e-4


def bars(results: Mapping[str, Result], governing: str | None, drawn: Result) -> Picture:
    """A bar for each result by its name, from the top down, the governing one in another colour; ``drawn`` is
    that, or stands for all."""
    names = [name if len(name) <= _LETTERS else f"{name[: _LETTERS - 1]}…" for name in results]
    with style():
        made = Picture()
        axes = made.add_subplot()
        axes.set_box_aspect(_BAR * (len(names) + 1))
        values = [result.load_factor or 0.0 for result in results.values()]
        colours = [VERMILION if name == governing else AT_REST for name in results]
        axes.barh(range(len(values)), values, color=colours, height=0.6)
        beside: dict[str, Any] = {"xytext": (4, 0), "textcoords": "offset points"}
        for number, result in enumerate(results.values()):
            at = (max(values[number], 0.0), number)
            axes.annotate(told_factor(result), at, va="center", fontsize=8, **beside)
        axes.set_yticks(range(len(names)), [*map(printable, names)], fontsize=8, parse_math=False)
        axes.invert_yaxis()
        axes.set_xlim(min(0.0, *values), 1.25 * max(*values, 1e-9))
        axes.set_xlabel("load factor λ")
        entitle(axes, title_of(drawn.assembly.scene.with_load_case(None)), _heading(governing, drawn))
        finish(made, axes, [])
    return made


def polar(table: pd.DataFrame, governing: str | None, drawn: Result) -> Picture:
    """Load factors over the direction in plan, of a table of :class:`~.directions.Directions`."""
    handles: list[Handle] = []
    with style():
        made = Picture()
        axes: Any = made.add_subplot(projection="polar")
        axes.set_thetagrids(range(0, 360, 30), [f"{angle}°" for angle in range(0, 360, 30)])
        entitle(axes, title_of(drawn.assembly.scene), f"{_heading(governing, drawn)}\n")
        shown = {"load_factor": f"λ ({drawn.method})"}
        ratios = table["vertical"].unique()
        if len(ratios) == 1:
            shown |= {"expected": "to expect", "associative": "associative"}
        looks = zip(cycle(SERIES), itertools.product(ratios, shown.items()), strict=False)
        for colour, (ratio, (column, words)) in looks:
            rows = table[table["vertical"] == ratio]
            first = column == "load_factor"
            if not first and not (rows[column] - rows["load_factor"]).abs().max() > _SAME:
                continue
            angle, value = (np.append(values, values[:1]) for values in (rows["direction"], rows[column]))
            look: dict[str, Any] = {
                "color": colour,
                "marker": "." if first else "",
                "linewidth": 1.4 if first else 0.9,
            }
            axes.plot(np.radians(angle.astype(float)), value, **look)
            sense = "against" if ratio < 0 else "with"
            beside = f", and {abs(ratio):g} of it {sense} gravity" if ratio else ""
            handles.append(Line2D([], [], label=f"{words}{beside}", **look))
        quake = drawn.assembly.scene.shaken_by
        if quake is not None and isinstance(worst := quake.direction, float) and governing:
            look = {"color": BLACK, "marker": "o", "fillstyle": "none", "linestyle": "none"}
            axes.plot(np.radians(worst), drawn.load_factor or 0.0, markersize=9, **look)
            handles.append(Line2D([], [], label="least", **look))
        axes.set_ylim(0)
        axes.tick_params(axis="y", labelsize=8)
        notes = ["The push is along the ray; x points to the right, y upwards."]
        if missing := int(table["load_factor"].isna().sum()):
            notes.append(f"No load factor in {counted(missing, 'direction')}.")
        finish(made, axes, handles, tuple(notes))
    return made


def _heading(governing: str | None, drawn: Result) -> str:
    return f"least {told_factor(drawn)}, {governing}" if governing else "no load factor"

"""Pictures of stability: a sheet of heat maps for each grid, and one of the atlas's scenes."""

from __future__ import annotations

import textwrap
from collections.abc import Sequence

import numpy as np
import pandas as pd
from matplotlib import colormaps
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.colors import Normalize
from matplotlib.figure import Figure
from matplotlib.patches import Patch, Rectangle

from masonry_opt.answer.status import Status
from masonry_opt.report.pictures.mechanism import draw_mechanism
from masonry_opt.studies.atlas.entry import Observation
from masonry_opt.studies.atlas.maps import TRACEBACK, Grid

#: A letter for each way to end without a load factor.
LETTERS: dict[str, str] = {
    Status.CYCLING: "C",
    Status.NO_STATE: "N",
    Status.ITERATION_LIMIT: "L",
    Status.SOLVER_FAILED: "F",
    Status.JAMMED: "J",
    TRACEBACK: "T",
}
OTHER = "X"

#: Colours saturate at this percentage; orange to purple is told apart by colour-blind readers.
_PERCENT = 2.0
_COLOURS = "PuOr_r"
_FAILED, _HATCH = "#DDDDDD", "////"
_COLUMNS = 3


def heat_maps(grid: Grid, frame: pd.DataFrame) -> Figure:
    """A sheet of a grid: a panel a wall, colour for λ, sub-problems as numbers, failures as letters.

    Parameters
    ----------
    frame: of ``run_grid``.
    """
    walls = list(dict.fromkeys(frame["wall"]))
    columns = min(_COLUMNS, len(walls))
    lines = -(-len(walls) // columns)
    names = max(map(len, grid.columns.values))
    width = 1.0 + columns * (0.9 + 0.62 * len(grid.columns.values))
    height = 1.7 + lines * (0.9 + 0.08 * names + 0.42 * len(grid.rows.values))
    figure = Figure(figsize=(max(width, 7.0), height), layout="constrained")
    panels = figure.subplots(lines, columns, squeeze=False)
    colours = ScalarMappable(Normalize(-_PERCENT, _PERCENT), colormaps[_COLOURS])
    for number, axes in enumerate(panels.flat):
        if number >= len(walls):
            axes.set_axis_off()
            continue
        _panel(axes, grid, frame[frame["wall"] == walls[number]], colours)
        axes.set_title(f"wall {walls[number]}", fontsize=10)
        if number % columns == 0:
            axes.set_ylabel(grid.rows.name)
        if number + columns >= len(walls):
            axes.set_xlabel(grid.columns.name)
    figure.colorbar(colours, ax=panels, extend="both", shrink=0.8, label="λ above the paper's (%)")
    figure.suptitle(f"The loop on the walls of Table 1: {grid.title}", fontsize=11)
    figure.legend(
        handles=_legend(frame),
        loc="outside lower center",
        ncols=3,
        frameon=False,
        fontsize=8,
        handlelength=1.6,
    )
    return figure


def _panel(axes: Axes, grid: Grid, cells: pd.DataFrame, colours: ScalarMappable) -> None:
    rows, columns = list(grid.rows.values), list(grid.columns.values)
    for cell in cells.to_dict("records"):
        x, y = columns.index(cell[grid.columns.name]), rows.index(cell[grid.rows.name])
        if np.isnan(cell["load_factor"]):
            patch = Rectangle((x - 0.5, y - 0.5), 1, 1, facecolor=_FAILED, edgecolor="#888888", hatch=_HATCH)
            text, ink = letter(cell["status"]), "black"
        else:
            colour = colours.to_rgba(100 * cell["off"])
            patch = Rectangle((x - 0.5, y - 0.5), 1, 1, facecolor=colour, edgecolor="white", linewidth=0.5)
            text = f"{cell['sub_problems']}{'' if cell['certified'] else '*'}"
            ink = "black" if np.dot(colour[:3], (0.299, 0.587, 0.114)) > 0.5 else "white"
        axes.add_patch(patch)
        backing = (
            {"facecolor": "white", "edgecolor": "none", "pad": 1.0} if ink and patch.get_hatch() else None
        )
        axes.text(x, y, text, ha="center", va="center", fontsize=8, color=ink, bbox=backing)
    default = (columns.index(grid.columns.default) - 0.5, rows.index(grid.rows.default) - 0.5)
    axes.add_patch(Rectangle(default, 1, 1, fill=False, edgecolor="black", linewidth=2.0, zorder=3))
    axes.set_xlim(-0.5, len(columns) - 0.5)
    axes.set_ylim(-0.5, len(rows) - 0.5)
    turn = 40 if max(map(len, columns)) > 7 else 0
    axes.set_xticks(range(len(columns)), columns, fontsize=8, rotation=turn, ha="right" if turn else "center")
    axes.set_yticks(range(len(rows)), rows, fontsize=8)
    axes.tick_params(length=0)


def letter(status: str) -> str:
    """The letter by which a sheet shows a status without a load factor."""
    return next((mark for start, mark in LETTERS.items() if status.startswith(start)), OTHER)


def _legend(frame: pd.DataFrame) -> list[Patch]:
    failed = frame.loc[frame["load_factor"].isna(), "status"]
    handles = [Patch(facecolor="white", edgecolor="black", linewidth=2.0, label="defaults")]
    handles.append(Patch(facecolor="none", edgecolor="none", label="number: sub-problems"))
    if (~frame["certified"] & frame["load_factor"].notna()).any():
        handles.append(Patch(facecolor="none", edgecolor="none", label="*: not certified to 0.1 %"))
    handles += [
        Patch(facecolor=_FAILED, edgecolor="#888888", hatch=_HATCH, label=f"{letter(status)}: {status}")
        for status in sorted(set(failed), key=letter)
    ]
    return handles


def scene_sheet(outcomes: Sequence[Observation]) -> Figure:
    """The atlas's scenes in small, each with the first answer that shows a mechanism, or else at rest."""
    first: dict[str, Observation] = {}
    for outcome in outcomes:
        name = outcome.entry.name
        if outcome.result is None:
            continue
        moves = bool(outcome.result.blocks["vx"].notna().all())
        before = first.get(name)
        if before is None or (moves and before.result and before.result.blocks["vx"].isna().any()):
            first[name] = outcome
    columns = 5
    lines = max(1, -(-len(first) // columns))
    figure = Figure(figsize=(2.7 * columns, 2.35 * lines), layout="constrained")
    panels = figure.subplots(lines, columns, squeeze=False).flat
    for axes, outcome in zip(panels, first.values(), strict=False):
        if outcome.result is None:
            continue
        draw_mechanism(outcome.result, axes)
        found = outcome.result.load_factor
        answer = f"λ = {found:.4g}" if found is not None else "no λ"
        axes.set_title(f"{textwrap.fill(outcome.entry.name, 34)}\n{outcome.run.method}: {answer}", fontsize=8)
        axes.set_xlabel("")
        axes.set_ylabel("")
        axes.set_xticks([])
        axes.set_yticks([])
    for axes in list(figure.axes)[len(first) :]:
        axes.set_axis_off()
    return figure

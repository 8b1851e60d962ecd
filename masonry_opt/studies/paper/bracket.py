"""The least load factor of the walls of Table 1 between states found and lower bounds, against time."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from masonry_opt.analysis import solve
from masonry_opt.answer.result import Result
from masonry_opt.studies.cases import open_case
from masonry_opt.studies.palette import COLOURS
from masonry_opt.studies.paper.example import ProgressLine, Report, or_nan
from masonry_opt.studies.paper.table1 import SEED, WALLS, wall_file
from masonry_opt.studies.parts import in_processes

#: Seconds for both ends of one wall.
_SECONDS = 300.0

#: Of states, which are found within 10 s or not for long.
_SEARCH: dict[str, Any] = {"search": 10.0, "seed": SEED}

#: Where the axis of time begins, for states and bounds that are there sooner.
_SOONEST = 0.05


@dataclass(frozen=True)
class _Wall:
    number: int
    search: Result
    bracket: Result

    @property
    def lowest(self) -> float:
        """λ of the lowest state that either method found."""
        return min(or_nan(result.load_factor) for result in (self.search, self.bracket))

    @property
    def assumed(self) -> str:
        """What the bound assumes."""
        if self.bracket.solution.bound_derived:
            return "nothing"
        return f"Σ rates ≤ {self.bracket.reasons[0].values.get('rates', np.nan):.0f}"

    def steps(self) -> pd.DataFrame:
        """λ and bound whenever either came nearer: seconds, end, value."""
        states = self.search.history.assign(end="λ", value=self.search.history["load_factor"])
        bounds = self.bracket.history.assign(end="bound", value=self.bracket.history["bound"].cummax())
        both = pd.concat([states, bounds])[["seconds", "end", "value"]]
        return both.sort_values("seconds").assign(wall=self.number)


def bracket(cases: Path, progress: ProgressLine = lambda _: None) -> Report:
    """States that the search finds and lower bounds by ``global``, for each wall, against time."""
    for number in WALLS:
        open_case(cases, wall_file(number))
    progress(f"six walls, {_SECONDS:g} s each, on all cores")
    found = in_processes(_both_ends, [(cases, number) for number in WALLS])
    walls = [both for _, both in sorted(found)]
    return Report(
        captions={
            "bracket": "Least load factor of the six walls: from above the lowest exact state that "
            f"`refined` has found, from below what `global` certifies within {_SECONDS:g} s of all states "
            "whose slips and edge openings sum to no more than the table says",
            "bracket_walls": "Both ends, and what the bound assumes (rates: slips and edge openings, in "
            "units of the live load's mean velocity)",
            "bracket_steps": "Every state and every bound that came nearer",
        },
        tables={
            "bracket_walls": pd.DataFrame([_row(wall) for wall in walls]),
            "bracket_steps": pd.concat([wall.steps() for wall in walls]),
        },
        figures={"bracket": _draw(walls)},
    )


def _both_ends(cases: Path, number: int) -> _Wall:
    scene = open_case(cases, wall_file(number))
    search = solve(scene, "refined", **_SEARCH)
    return _Wall(number, search, solve(scene, "global", time_limit=_SECONDS))


def _row(wall: _Wall) -> dict[str, object]:
    lowest, bound = wall.lowest, or_nan(wall.bracket.bound)
    return {
        "wall": wall.number,
        "joints": wall.bracket.size.joints,
        "lowest λ found": lowest,
        "bound": bound,
        "bound / λ": bound / lowest,
        "assumes": wall.assumed,
        "associative λ": or_nan(wall.bracket.associative),
    }


def _draw(walls: list[_Wall]) -> Figure:
    figure = Figure(figsize=(9.0, 6.0), layout="constrained")
    for axes, wall in zip(figure.subplots(2, 3, sharex=True).flat, walls, strict=True):
        _draw_wall(axes, wall)
    figure.supxlabel("time (s)")
    figure.supylabel("load factor λ")
    handles, labels = figure.axes[0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside upper center", ncols=len(handles), fontsize=9)
    return figure


def _draw_wall(axes: Axes, wall: _Wall) -> None:
    steps = wall.steps()
    for end, label, colour, start in (
        ("λ", "lowest exact state found", COLOURS[1], np.nan),
        ("bound", "lower bound (assuming a largest sum of rates)", COLOURS[0], 0.0),
    ):
        of = steps[steps["end"] == end]
        seconds = np.concatenate([[_SOONEST], np.maximum(of["seconds"], _SOONEST), [1.2 * _SECONDS]])
        values = np.concatenate([[start], of["value"], of["value"].tail(1) if len(of) else [start]])
        axes.step(seconds, values, where="post", color=colour, linewidth=1.8, label=label)
    associative = wall.bracket.associative
    if associative is not None:
        axes.axhline(associative, color=COLOURS[-1], linewidth=1, linestyle=":", label="associative λ")
    axes.set_title(f"wall {wall.number}", loc="left", fontsize=10)
    axes.set_xscale("log")
    axes.set_xlim(_SOONEST, 1.2 * _SECONDS)
    axes.set_ylim(0.0, 1.1 * max(or_nan(associative), wall.lowest))
    axes.grid(color="#EEEEEE")

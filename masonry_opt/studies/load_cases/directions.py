"""Earthquakes from all sides: the load factor over the direction of the push."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from masonry_opt.drawing.colours import BLACK, SERIES
from masonry_opt.drawing.elements import title_of
from masonry_opt.drawing.figure import Picture, entitle, finish, style
from masonry_opt.effort import Phases
from masonry_opt.errors import OptionError, counted
from masonry_opt.methods.registry import DEFAULT
from masonry_opt.methods.task import Progress
from masonry_opt.result import Result
from masonry_opt.scene.case_file import as_scene
from masonry_opt.scene.load_cases import Earthquake
from masonry_opt.scene.scene import Scene
from masonry_opt.studies.load_cases.cases import COLUMNS, Cases, solve_all

#: Load factors no farther from λ than this are not drawn beside it.
_SAME = 1e-4

#: Degrees between directions in plan, and the most directions.
EVERY, _MOST = 15.0, 3600


class Directions(Cases):
    """The seismic coefficient of a scene by the direction of the earthquake.

    Attributes
    ----------
    results: :class:`Result` of each earthquake, by its words: "at 15° in plan", ...
    table: one row an earthquake: ``direction``, ``vertical``, ``load_factor`` (NaN without one), ``status``,
        ``expected``, ``associative``, ``exact``.
    governing, usable, summary, details: as of :class:`~.cases.Cases`.
    """

    what = "earthquake"

    def _apart(self, result: Result) -> dict[str, Any]:
        quake = quake_of(result)
        return {"direction": quake.direction, "vertical": quake.vertical}

    def as_dict(self) -> dict[str, Any]:
        """The table as plain numbers and strings (NaN as None)."""
        told, of = super().as_dict(), self.to_draw
        rows = zip(told.pop("load_cases"), self.results.values(), strict=True)
        return {
            **told,
            "load_case": of.load_case,
            "method": of.method,
            "directions": [
                self._apart(result) | {key: row[key] for key in (*COLUMNS, "message")} for row, result in rows
            ],
        }

    def plot(self) -> Picture:
        """Draw the load factor over the direction: in space in plan, as a polar chart, x to the right; in the
        plane as bars."""
        drawn, table = self.to_draw, self.table
        if drawn.assembly.scene.dimension == 2:
            return super().plot()
        with style():
            made = Picture()
            axes: Any = made.add_subplot(projection="polar")
            axes.set_thetagrids(range(0, 360, 30), [f"{angle}°" for angle in range(0, 360, 30)])
            entitle(axes, title_of(drawn.assembly.scene), f"{self._heading}\n")
            shown = {"load_factor": f"λ ({drawn.method})"}
            ratios = table["vertical"].unique()
            if len(ratios) == 1:
                shown |= {"expected": "to expect", "associative": "associative"}
            looks = zip(itertools.cycle(SERIES), itertools.product(ratios, shown.items()), strict=False)
            for colour, (ratio, (column, words)) in looks:
                rows = table[table["vertical"] == ratio]
                first = column == "load_factor"
                if not first and not (rows[column] - rows["load_factor"]).abs().max() > _SAME:
                    continue
                angle, value = (np.append(values, values[:1]) for values in (rows["direction"], rows[column]))
                look = {"marker": ".", "linewidth": 1.4} if first else {"linewidth": 0.9}
                sense = "against" if ratio < 0 else "with"
                beside = f", and {abs(ratio):g} of it {sense} gravity" if ratio else ""
                angle = np.radians(angle.astype(float))
                axes.plot(angle, value, color=colour, label=f"{words}{beside}", **look)
            if self.governing and isinstance(worst := quake_of(drawn).direction, float):
                ring = {"marker": "o", "markersize": 9, "fillstyle": "none", "linestyle": "none"}
                axes.plot(np.radians(worst), drawn.load_factor or 0.0, color=BLACK, label="least", **ring)
            axes.set_ylim(0)
            axes.tick_params(axis="y", labelsize=8)
            notes = ["The push is along the ray; x points to the right, y upwards."]
            if missing := int(table["load_factor"].isna().sum()):
                notes.append(f"No load factor in {counted(missing, 'direction')}.")
            finish(made, axes, axes.get_legend_handles_labels()[0], tuple(notes))
        return made


def quake_of(result: Result) -> Earthquake:
    """The earthquake of a result."""
    quake = result.assembly.scene.shaken_by
    assert quake is not None
    return quake


def directions(
    scene: Scene | str | Path,
    method: str = DEFAULT,
    *,
    every: float = EVERY,
    vertical: float | Sequence[float] | None = None,
    load_case: str | None = None,
    progress: Progress = lambda _: None,
    phases: Phases = lambda _: None,
    **options: Any,
) -> Directions:
    """Solve a scene for earthquakes from all sides, in place of its live loads.

    Raises OptionError if an argument is wrong, or as of :func:`~masonry_opt.analysis.solve`; CaseError if the
    scene is wrong.

    Parameters
    ----------
    scene: A scene, or the path of a case file.
    every: Degrees between directions in plan, which go once round from x towards y. In the plane there are
        two, "left" and "right".
    vertical: Vertical part over the horizontal one, or several, such as ``(0.3, -0.3)``; see
        :class:`Earthquake` (default: that of the scene's own earthquake, else 0). Masses are as of that
        earthquake.
    load_case: Name of the load case whose dead loads act.
    method, progress, phases, options: As of :func:`~masonry_opt.analysis.solve`, its model, solver, ... too.
    """
    of = as_scene(scene, load_case)
    of.refuse_without_case()
    if of.tilt:
        raise OptionError(f"{of.origin}: 'tilt' is the scene's live load: take it away")
    own = of.shaken_by or Earthquake(direction=0.0)
    ratios = [own.vertical] if vertical is None else list(np.atleast_1d(vertical).tolist())
    if not ratios:
        raise OptionError("'vertical' is one number or several (found none)")
    angles = _angles(every)
    pushes: list[Any] = ["left", "right"] if of.dimension == 2 else list(angles)
    quakes = [
        Earthquake(direction=push, vertical=ratio, dead_as_mass=own.dead_as_mass)
        for ratio, push in itertools.product(ratios, pushes)
    ]
    scenes = {str(quake): of.shaken(quake) for quake in quakes}
    return Directions(solve_all(scenes, method, progress, phases, **options))


def _angles(every: float) -> list[float]:
    if isinstance(every, bool) or not isinstance(every, int | float) or not 360 / _MOST <= every <= 360:
        raise OptionError(f"'every' is an angle from {360 / _MOST:g} to 360 degrees (found {every!r})")
    return [float(f"{place * every:.12g}") for place in range(int(np.ceil(360 / every - 1e-9)))]

"""All load cases of a scene, and which of them governs; earthquakes from all sides in place of them."""

import itertools
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any, ClassVar

import numpy as np
import pandas as pd

from masonry_opt.analysis import prepare
from masonry_opt.answer.reasons import Status
from masonry_opt.drawing.colours import AT_REST, BLACK, SERIES, VERMILION
from masonry_opt.drawing.elements import title_of
from masonry_opt.drawing.figure import Picture, entitle, finish, style
from masonry_opt.effort import Effort, Phases
from masonry_opt.errors import OptionError, counted, printable
from masonry_opt.methods.registry import DEFAULT
from masonry_opt.methods.task import Progress
from masonry_opt.result import Result, distinct_warnings
from masonry_opt.scene.case_file import as_scene
from masonry_opt.scene.loads import Earthquake
from masonry_opt.scene.scene import Scene
from masonry_opt.studies.many.runs import at_least
from masonry_opt.studies.writing import StudyAnswer, records
from masonry_opt.words.load_factors import INCREMENTAL, factor_text, named_factor
from masonry_opt.words.names import warning_lines
from masonry_opt.words.terminal import frame_text

_BAR, _LETTERS = 0.09, 24  #: Height of a bar over the width of the axes; most letters of a name beside one.
COLUMNS = ("load_factor", "status", "incremental", "associative", "exact")  #: What a table says of results.
_APART = 1e-4  #: Load factors no farther from λ than this are not drawn beside it.
EVERY, _MOST = 15.0, 3600  #: Degrees between directions in plan, and the most directions.


def _bar_label(result: Result) -> str:
    """Return the text beside a bar: the load factor, or the status if there is none."""
    return str(result.status) if result.load_factor is None else f"λ = {factor_text(result.load_factor)}"


@dataclass(frozen=True, eq=False)
class Cases(StudyAnswer):
    """The load cases of a scene, solved.

    Attributes
    ----------
    results: :class:`Result` of each, by its name.
    table: one row a case: ``load_case``, ``live`` (what λ scales), ``load_factor`` (NaN without one),
        ``status``, ``incremental``, ``associative``, ``exact``.
    governing: name of the first case that falls under its dead loads, else of that with the least load
        factor; None where there is neither.
    usable: whether all have a load factor.
    left_out: names of cases in which axles alone are live, which only :func:`~masonry_opt.crossing` answers.
    summary: what ``print`` shows: the table, and the summary of the governing case.
    details: the table, and the details of every case.
    """

    results: Mapping[str, Result]
    left_out: tuple[str, ...] = ()
    what: ClassVar[str] = "load case"

    def __str__(self) -> str:
        return self.summary

    def _apart(self, result: Result) -> dict[str, Any]:
        """What tells a result from the others, by column."""
        return {"load_case": result.load_case, "live": str(result.assembly.scene.load_case)}

    @property
    def table(self) -> pd.DataFrame:
        results = self.results.values()
        rows = [self._apart(of) | {name: getattr(of, name) for name in COLUMNS} for of in results]
        numbers = dict.fromkeys(("load_factor", "incremental", "associative"), "float64")
        return pd.DataFrame(rows).astype(numbers | {"status": "str"})

    told = table

    @cached_property
    def governing(self) -> str | None:
        # No load factor is below zero: what falls comes first; of those alike but for rounding the first.
        falls = self.table["status"] == str(Status.UNSTABLE)
        least = at_least(self.table[["load_factor"]].mask(falls, -1.0))
        return next(itertools.compress(self.results, least), None)

    @property
    def usable(self) -> bool:
        return all(result.usable for result in self.results.values())

    @property
    def to_draw(self) -> Result:
        """The governing result; where none governs, the first."""
        return self.results[self.governing or next(iter(self.results))]

    @property
    def warning_records(self) -> list[dict[str, Any]]:
        return distinct_warnings(list(self.results.values()))

    @property
    def summary(self) -> str:
        shown = [self.to_draw] if self.governing else []
        # The summary of the governing result has printed its own warnings already.
        printed = {sentence for result in shown for sentence in result.warning_sentences}
        others = [sentence for sentence in self.warning_sentences if sentence not in printed]
        told = self._told([result.summary for result in shown])
        return printable("\n".join([told, *warning_lines(others)]))

    @property
    def details(self) -> str:
        return self._told([result.details for result in self.results.values()])

    def _said(self) -> str:
        of = self.to_draw
        governs = f"'{self.governing}' governs: {named_factor(of)}" if self.governing else "none governs"
        if self.left_out:
            governs += f"\nleft out: {', '.join(map(repr, self.left_out))}, for axles move: see 'crossing'"
        return printable(f"{of.case}: {counted(len(self.results), self.what)}\n{governs}")

    def _told(self, results: Iterable[str]) -> str:
        table = frame_text(self.table.rename(columns={"incremental": INCREMENTAL}), "").strip("\n")
        return printable("\n\n".join([self._said(), table, *results]))

    def as_dict(self) -> dict[str, Any]:
        of = self.to_draw
        load_factor = of.load_factor if self.governing else None
        told: dict[str, Any] = {"case": of.case, "governing": self.governing, "load_factor": load_factor}
        if self.left_out:
            told["left_out"] = list(self.left_out)
        told["warnings"] = self.warning_records
        return told | {"load_cases": [result.as_dict() for result in self.results.values()]}

    @property
    def _heading(self) -> str:
        if not self.governing:
            return "no load factor"
        return f"governing {named_factor(self.to_draw)}, {self.governing}"

    def plot(self) -> Picture:
        """Draw load factors as bars, from the top down, the governing one marked."""
        names = [name if len(name) <= _LETTERS else f"{name[: _LETTERS - 1]}…" for name in self.results]
        values = [result.load_factor or 0.0 for result in self.results.values()]
        colours = [VERMILION if name == self.governing else AT_REST for name in self.results]
        with style():
            made = Picture()
            axes = made.add_subplot()
            axes.set_box_aspect(_BAR * (len(names) + 1))
            bars = axes.barh(range(len(values)), values, color=colours, height=0.6)
            axes.bar_label(bars, [*map(_bar_label, self.results.values())], padding=4, fontsize=8)
            axes.set_yticks(range(len(names)), [*map(printable, names)], fontsize=8, parse_math=False)
            axes.invert_yaxis()
            axes.set_xlim(min(0.0, *values), 1.25 * max(*values, 1e-9))
            axes.set_xlabel("load factor λ")
            entitle(axes, title_of(self.to_draw.assembly.scene.with_load_case(None)), self._heading)
            finish(made, axes, [])
        return made

    def save(self, path: str | Path, force: bool = False) -> None:
        """Write that picture (.png, .svg, .pdf); raises as :meth:`Result.save`."""
        self.plot().save(path, force)


class Directions(Cases):
    """The seismic coefficient of a scene by the direction of the earthquake.

    Attributes
    ----------
    results: :class:`Result` of each earthquake, by its words: "at 15° in plan", ...
    table: one row an earthquake: ``direction``, ``vertical``, ``load_factor`` (NaN without one), ``status``,
        ``incremental``, ``associative``, ``exact``.
    governing, usable, summary, details: as of :class:`Cases`.
    """

    what = "earthquake"

    def _apart(self, result: Result) -> dict[str, Any]:
        return {name: getattr(result.assembly.scene.shaken_by, name) for name in ("direction", "vertical")}

    def as_dict(self) -> dict[str, Any]:
        """The table as plain numbers and strings (NaN as None)."""
        told, of = super().as_dict(), self.to_draw
        messages = [one["message"] for one in told.pop("load_cases")]
        rows = records(self.table.assign(message=messages))
        return told | {"load_case": of.load_case, "method": of.method, "directions": rows}

    def plot(self) -> Picture:
        """Draw λ over the direction: in space as a polar chart, x to the right; in the plane as bars."""
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
                shown |= {"incremental": "incremental", "associative": "associative"}
            looks = zip(itertools.cycle(SERIES), itertools.product(ratios, shown.items()), strict=False)
            for colour, (ratio, (column, words)) in looks:
                rows = table[table["vertical"] == ratio]
                first = column == "load_factor"
                if not first and not (rows[column] - rows["load_factor"]).abs().max() > _APART:
                    continue
                look = {"marker": ".", "linewidth": 1.4} if first else {"linewidth": 0.9}
                sense = "against" if ratio < 0 else "with"
                beside = f", and {abs(ratio):g} of it {sense} gravity" if ratio else ""
                around = pd.concat([rows, rows.head(1)])
                angle = np.radians(around["direction"].astype(float))
                axes.plot(angle, around[column], color=colour, label=f"{words}{beside}", **look)
            if self.governing:
                worst = self._apart(drawn)["direction"]
                ring = {"marker": "o", "markersize": 9, "fillstyle": "none", "linestyle": "none"}
                axes.plot(np.radians(worst), drawn.load_factor or 0.0, color=BLACK, label="least", **ring)
            axes.set_ylim(0)
            axes.tick_params(axis="y", labelsize=8)
            notes = ["The push is along the ray; x points to the right, y upwards."]
            if missing := int(table["load_factor"].isna().sum()):
                notes.append(f"No load factor in {counted(missing, 'direction')}.")
            finish(made, axes, axes.get_legend_handles_labels()[0], tuple(notes))
        return made


def solve_cases(
    scene: Scene | str | Path,
    method: str = DEFAULT,
    *,
    progress: Progress = lambda _: None,
    phases: Phases = lambda _: None,
    **options: Any,
) -> Cases:
    """Solve all load cases of a scene. Geometry, joints and matrices are found once.

    Raises OptionError if the scene has no load case, or as of :func:`~masonry_opt.analysis.solve`; CaseError
    if the scene is wrong, or nothing carries a live load in one of the cases, which is named.

    Parameters
    ----------
    scene, method, progress, phases, options: As of :func:`~masonry_opt.analysis.solve`, its model, solver,
        ... too. What ``phases`` is called with begins with the name of the case.
    """
    of = as_scene(scene)
    if not of.load_cases:
        raise OptionError(f"{of.origin}: has no [[load_case]]: solve it as it is, or give it some")
    moving = [case.name for case in of.load_cases if case.moves]
    # Where all are, the first says what to use.
    asked = [case.name for case in of.load_cases if case.name not in moving] or moving
    results = solve_all({name: of.in_case(name) for name in asked}, method, progress, phases, **options)
    return Cases(results, tuple(moving))


def solve_all(
    scenes: Mapping[str, Scene], method: str, progress: Progress, phases: Phases, **options: Any
) -> dict[str, Result]:
    """Results of scenes of the same blocks, by name, by one session."""
    session = prepare(method, keeps=True, **options)

    def named(name: str) -> Phases:
        return lambda phase: phases(f"{name}: {phase}")

    return {name: session.solve(scene, progress, Effort(named(name))) for name, scene in scenes.items()}


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
    if isinstance(every, bool) or not isinstance(every, int | float) or not 360 / _MOST <= every <= 360:
        raise OptionError(f"'every' is an angle from {360 / _MOST:g} to 360 degrees (found {every!r})")
    pushes: list[Any] = ["left", "right"]
    if of.dimension == 3:
        pushes = [float(f"{place * every:.12g}") for place in range(int(np.ceil(360 / every - 1e-9)))]
    scenes: dict[str, Scene] = {}
    for ratio, push in itertools.product(ratios, pushes):
        quake = Earthquake(direction=push, vertical=ratio, dead_as_mass=own.dead_as_mass)
        scenes[str(quake)] = of.shaken(quake)
    return Directions(solve_all(scenes, method, progress, phases, **options))

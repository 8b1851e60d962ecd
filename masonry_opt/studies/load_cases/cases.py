"""Functions ``solve_cases`` and ``directions``: all load cases of a scene, or earthquakes from all sides."""

import itertools
import textwrap
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any, ClassVar

import numpy as np
import pandas as pd

from masonry_opt.analysis import prepare
from masonry_opt.brief import brief
from masonry_opt.drawing.colours import AT_REST, BLACK, SERIES, VERMILION
from masonry_opt.drawing.elements import title_of
from masonry_opt.drawing.figure import Picture, entitle, finish, style
from masonry_opt.effort import Effort, Phases, ignore_progress, phases_from
from masonry_opt.errors import OptionError, counted, printable
from masonry_opt.finite_motion.kinematic_check import activation
from masonry_opt.finite_motion.settled_state import settled_scene
from masonry_opt.methods.registry import DEFAULT
from masonry_opt.methods.task import Progress
from masonry_opt.problem.settled import Movements
from masonry_opt.reporting.load_factors import factor_text, named_factor
from masonry_opt.reporting.names import warning_lines
from masonry_opt.reporting.terminal import frame_text
from masonry_opt.result import Result, distinct_warnings
from masonry_opt.scene.case_file import as_scene
from masonry_opt.scene.loads import Earthquake
from masonry_opt.scene.scene import Scene
from masonry_opt.solution.reasons import Status
from masonry_opt.studies.many.runs import at_least
from masonry_opt.studies.writing import StudyAnswer, records

_BAR_HEIGHT = 0.09  #: Height of a bar, relative to the width of the axes.
#: Printed headings of the table, by column.
_HEADINGS = {
    "vertical": "vertical / horizontal",
    "a_0": "a_0 (g)",
    "a_star_0": "a_star_0 (g)",
}
#: Each bar is labelled with the name of its load case, in lines of at most this number of letters.
_MOST_LETTERS = 24
_MOST_NAME_LINES = 2  #: Largest number of lines in the label of a bar; longer names are shortened.
#: Columns of the table of load cases. Each name is an attribute of a result.
LOAD_CASE_COLUMNS = ("load_factor", "status", "incremental", "associative", "exact")
#: Additional columns of the table for earthquakes from all sides: acceleration that activates the mechanism,
#: participating mass fraction, and spectral acceleration. See :class:`Directions`.
_ACTIVATION_COLUMNS = ("a_0", "mass_fraction", "a_star_0")
#: The incremental and the associative load factor are drawn only if their absolute difference from λ is
#: larger than this value in at least one direction.
_VISIBLE_DIFFERENCE = 1e-4
#: Default angle in plan between successive directions of the earthquake, in degrees.
DEFAULT_ANGLE_STEP = 15.0
_MOST_DIRECTIONS = 3600  #: Largest number of directions of an earthquake; more directions raise an error.


def _bar_label(result: Result) -> str:
    """Return the text next to a bar: the load factor, or the status if there is no load factor."""
    return (
        str(result.status) if result.load_factor is None else f"λ = {factor_text(result, result.load_factor)}"
    )


@dataclass(frozen=True, eq=False)
class Cases(StudyAnswer):
    """Results of a scene under all its load cases.

    Attributes
    ----------
    results: :class:`~masonry_opt.Result` of each load case, by its name.
    left_out: Names of the load cases whose only live loads are axles; solve them with
        :func:`~masonry_opt.crossing`.
    """

    results: Mapping[str, Result]
    left_out: tuple[str, ...] = ()
    what: ClassVar[str] = "load case"

    __repr__ = brief

    def __str__(self) -> str:
        return self.summary

    def _identity(self, result: Result) -> dict[str, Any]:
        """Return the table columns that identify a result: load case and live load."""
        return {"load_case": result.load_case, "live": str(result.assembly.scene.load_case)}

    def _further(self, result: Result) -> dict[str, Any]:
        """Return additional table columns for a result. Only a subclass may return columns."""
        return {}

    @property
    def table(self) -> pd.DataFrame:
        """Table with one row for each load case.

        The columns are ``load_case``, ``live`` (the loads that λ multiplies), ``load_factor`` (NaN without
        one), ``status``, ``incremental``, ``associative`` and ``exact``.
        """
        rows = [
            self._identity(result)
            | {name: getattr(result, name) for name in LOAD_CASE_COLUMNS}
            | self._further(result)
            for result in self.results.values()
        ]
        numbers = dict.fromkeys(("load_factor", "incremental", "associative"), "float64")
        frame = pd.DataFrame(rows)
        numbers |= {name: "float64" for name in _ACTIVATION_COLUMNS if name in frame}
        return frame.astype(numbers | {"status": "str"})

    notebook_table = table

    @cached_property
    def governing(self) -> str | None:
        """Name of the governing load case: the first unstable case, or else the case with the least λ.

        It is None if no load case is unstable and none has a load factor. If load factors differ only by
        rounding errors, the first of them governs.
        """
        unstable = self.table["status"] == str(Status.UNSTABLE)
        # Load factors are not negative, so the value −1 ranks unstable load cases before all others.
        least = at_least(self.table[["load_factor"]].mask(unstable, -1.0))
        return next(itertools.compress(self.results, least), None)

    @property
    def time_limit_reached(self) -> bool:
        """True if the time limit ended the analysis of a load case."""
        return any(result.time_limit_reached for result in self.results.values())

    @property
    def usable(self) -> bool:
        """True if all load cases have a usable load factor."""
        return all(result.usable for result in self.results.values())

    @property
    def to_draw(self) -> Result:
        """Result that pictures show: the result of the governing load case, or else the first result."""
        return self.results[self.governing or next(iter(self.results))]

    @property
    def warning_records(self) -> list[dict[str, Any]]:
        """Warnings of all results, without repetitions."""
        return distinct_warnings(list(self.results.values()))

    @property
    def summary(self) -> str:
        """Printed text: the table of load cases, and the summary of the governing load case."""
        shown = [self.to_draw] if self.governing else []
        # Omit the warnings that the summary of the governing result contains already.
        printed = {sentence for result in shown for sentence in result.warning_sentences}
        unprinted = [sentence for sentence in self.warning_sentences if sentence not in printed]
        text = self._with_table([result.summary for result in shown])
        return printable("\n".join([text, *warning_lines(unprinted)]))

    @property
    def details(self) -> str:
        """Printed text: the table of load cases, and the details of every load case."""
        return self._with_table([result.details for result in self.results.values()])

    def _text(self) -> str:
        """Return the heading of the printed text: the scene, its load cases, and the governing load case."""
        drawn = self.to_draw
        governs = f"'{self.governing}' governs: {named_factor(drawn)}" if self.governing else "none governs"
        if self.left_out:
            names = ", ".join(map(repr, self.left_out))
            governs += f"\nleft out: {names} (axles move in these load cases: use 'crossing')"
        return printable(f"{drawn.case}: {counted(len(self.results), self.what)}\n{governs}")

    def _with_table(self, results: Iterable[str]) -> str:
        """Return the printed text: the heading, the table of load cases, and ``results``.

        ``results`` are texts on single results. Blank lines separate heading, table and texts.
        """
        headings = dict(_HEADINGS)
        if self.to_draw.assembly.scene.dimension == 3:
            headings["direction"] = "direction (°)"  # in the plane, the directions are "left" and "right"
        table = frame_text(self.table.rename(columns=headings), "").strip("\n")
        return printable("\n\n".join([self._text(), table, *results]))

    def as_dict(self) -> dict[str, Any]:
        """Return all results as plain numbers, strings, lists and dictionaries."""
        load_factor = self.to_draw.load_factor if self.governing else None
        result: dict[str, Any] = {"case": self.to_draw.case, "governing": self.governing}
        result["load_factor"] = load_factor
        if self.left_out:
            result["left_out"] = list(self.left_out)
        result["warnings"] = self.warning_records
        return result | {"load_cases": [result.as_dict() for result in self.results.values()]}

    @property
    def _heading(self) -> str:
        """Heading of a picture."""
        if not self.governing:
            return "no load factor"
        return f"governing {named_factor(self.to_draw)}, {self.governing}"

    def plot(self) -> Picture:
        """Return a bar chart of the load factors, in which the governing bar is coloured."""
        limits: dict[str, Any] = {"max_lines": _MOST_NAME_LINES, "placeholder": "…"}
        names = [textwrap.fill(printable(name), _MOST_LETTERS, **limits) for name in self.results]
        values = [result.load_factor or 0.0 for result in self.results.values()]
        colours = [VERMILION if name == self.governing else AT_REST for name in self.results]
        with style():
            picture = Picture()
            axes = picture.add_subplot()
            axes.set_box_aspect(_BAR_HEIGHT * (len(names) + 1))
            bars = axes.barh(range(len(values)), values, color=colours, height=0.6)
            axes.bar_label(bars, [*map(_bar_label, self.results.values())], padding=4, fontsize=8)
            axes.set_yticks(range(len(names)), names, fontsize=8, parse_math=False)
            axes.invert_yaxis()
            axes.set_xlim(min(0.0, *values), 1.25 * max(*values, 1e-9))
            axes.set_xlabel("load factor λ")
            entitle(axes, title_of(self.to_draw.assembly.scene.with_load_case(None)), self._heading)
            finish(picture, axes, [])
        return picture

    def save(self, path: str | Path, force: bool = False) -> None:
        """Write the picture that ``plot`` returns to a .png, .svg or .pdf file.

        Parameters
        ----------
        path: File to write.
        force: True to replace a file that another program wrote.

        Raises
        ------
        OptionError
            If the name has another ending, or if the file cannot be written or replaced.
        OSError
            If the file cannot be written.
        """
        self.plot().save(path, force)


class Directions(Cases):
    """Results of a scene for earthquakes from all sides. The load factors are seismic coefficients.

    The table has the columns ``direction`` and ``vertical`` instead of ``load_case`` and ``live``. It also
    has the acceleration ``a_0`` of the masses that activates the mechanism, in g, the participating
    ``mass_fraction`` e*, and the spectral acceleration ``a_star_0`` = a_0 / (e* FC), in g, with FC = 1.35.
    The additional columns are NaN with a vertical push. See :class:`Cases` for the other attributes.

    Attributes
    ----------
    results: :class:`~masonry_opt.Result` of each earthquake, by its text: "at 15° in plan", ...
    left_out: Empty.
    """

    what = "earthquake"

    def _identity(self, result: Result) -> dict[str, Any]:
        """Return the table columns that identify a result: ``direction`` and ``vertical``."""
        return {name: getattr(result.assembly.scene.shaken_by, name) for name in ("direction", "vertical")}

    def _further(self, result: Result) -> dict[str, Any]:
        """Return the additional table columns ``a_0``, ``mass_fraction`` and ``a_star_0`` of a result.

        See :class:`Directions` for their meaning. The values are None if :func:`activation` returns None.
        """
        activated = activation(result)
        if activated is None:
            return dict.fromkeys(_ACTIVATION_COLUMNS)
        values = (activated.acceleration, activated.mass_fraction, activated.spectral)
        return dict(zip(_ACTIVATION_COLUMNS, values, strict=True))

    def as_dict(self) -> dict[str, Any]:
        """Return the table and the messages as plain numbers and strings, with None instead of NaN."""
        result, drawn = super().as_dict(), self.to_draw
        messages = [load_case["message"] for load_case in result.pop("load_cases")]
        rows = records(self.table.assign(message=messages))
        return result | {"load_case": drawn.load_case, "method": drawn.method, "directions": rows}

    def plot(self) -> Picture:
        """Return a picture of λ by direction: a polar chart in space, a bar chart in the plane."""
        drawn, table = self.to_draw, self.table
        if drawn.assembly.scene.dimension == 2:
            return super().plot()
        with style():
            picture = Picture()
            axes: Any = picture.add_subplot(projection="polar")
            axes.set_thetagrids(range(0, 360, 30), [f"{angle}°" for angle in range(0, 360, 30)])
            entitle(axes, title_of(drawn.assembly.scene), f"{self._heading}\n")
            self._draw_lines(axes)
            if self.governing:
                worst = self._identity(drawn)["direction"]
                ring = {"marker": "o", "markersize": 9, "fillstyle": "none", "linestyle": "none"}
                axes.plot(np.radians(worst), drawn.load_factor or 0.0, color=BLACK, label="least", **ring)
            axes.set_ylim(0)
            axes.tick_params(axis="y", labelsize=8)
            notes = [
                "The angle is the direction of the push (x points to the right, y upwards); the distance "
                "from the centre is λ."
            ]
            missing = int(table["load_factor"].isna().sum())
            if missing:
                notes.append(f"No load factor in {counted(missing, 'direction')}.")
            finish(picture, axes, axes.get_legend_handles_labels()[0], tuple(notes))
        return picture

    def _draw_lines(self, axes: Any) -> None:
        """Draw λ by direction as closed lines, one for each ratio of the vertical to the horizontal push.

        With one ratio only, the incremental and the associative load factor are drawn too if they differ.
        """
        table = self.table
        labels = {"load_factor": f"λ (method {self.to_draw.method})"}
        ratios = table["vertical"].unique()
        if len(ratios) == 1:
            labels |= {
                "incremental": "incremental load factor",
                "associative": "associative load factor",
            }
        lines = itertools.product(ratios, labels.items())
        for colour, (ratio, (column, label)) in zip(itertools.cycle(SERIES), lines, strict=False):
            rows = table[table["vertical"] == ratio]
            is_own = column == "load_factor"
            difference = (rows[column] - rows["load_factor"]).abs().max()
            if not is_own and not difference > _VISIBLE_DIFFERENCE:
                continue
            look = {"marker": ".", "linewidth": 1.4} if is_own else {"linewidth": 0.9}
            sense = "against" if ratio < 0 else "along"
            vertical = (
                f"; the vertical force is {abs(ratio):g} times the horizontal force and acts {sense} gravity"
                if ratio
                else ""
            )
            closed = pd.concat([rows, rows.head(1)])
            angle = np.radians(closed["direction"].astype(float))
            axes.plot(angle, closed[column], color=colour, label=f"{label}{vertical}", **look)


def solve_cases(
    scene: Scene | str | Path,
    method: str = DEFAULT,
    *,
    settled: Movements | None = None,
    progress: Progress = ignore_progress,
    phases: Phases = ignore_progress,
    **options: Any,
) -> Cases:
    """Solve all load cases of a scene. Geometry, joints and matrices are computed once.

    Parameters
    ----------
    scene, method, settled, progress, phases, options: As for :func:`~masonry_opt.solve`, including
        ``model``, ``solver``, ... The supports settle under the dead loads of each load case. The text with
        which ``phases`` is called begins with the name of the load case.

    Returns
    -------
    Cases
        Results by load case. Load cases whose only live loads are axles are left out.

    Raises
    ------
    OptionError
        If the scene has no load case, or for the reasons of :func:`~masonry_opt.solve`.
    CaseError
        If the scene is wrong, or no block that can move has a live load in one of the load cases.
    """
    base = as_scene(scene)
    if not base.load_cases:
        raise OptionError(
            f"{base.origin}: the scene has no load cases: use 'solve', or add a table [[load_case]]"
        )
    moving = [case.name for case in base.load_cases if case.moves]
    # Load cases whose only live loads are moving axles need ``crossing``, and are omitted. If there are no
    # other load cases, the first solve raises an error that advises to use ``crossing``.
    solved = [case.name for case in base.load_cases if case.name not in moving] or moving
    scenes = {name: settled_scene(base.in_case(name), settled) for name in solved}
    results = solve_all(scenes, method, progress, phases, function=solve_cases, **options)
    return Cases(results, tuple(moving))


def solve_all(
    scenes: Mapping[str, Scene], method: str, progress: Progress, phases: Phases, **options: Any
) -> dict[str, Result]:
    """Solve scenes that share the same blocks, and return the results by scene name.

    One session solves all scenes, so data that depend only on the blocks are computed once.

    See :func:`~masonry_opt.analysis.prepare` for the options.
    """
    session = prepare(method, keeps=True, **options)

    def with_name(name: str) -> Phases:
        return lambda phase: phases(f"{name}: {phase}")

    return {name: session.solve(scene, progress, Effort(with_name(name))) for name, scene in scenes.items()}


def directions(
    scene: Scene | str | Path,
    method: str = DEFAULT,
    *,
    every: float = DEFAULT_ANGLE_STEP,
    vertical: float | Sequence[float] | None = None,
    load_case: str | None = None,
    settled: Movements | None = None,
    progress: Progress = ignore_progress,
    **options: Any,
) -> Directions:
    """Solve a scene for earthquakes from all sides. They replace the live loads of the scene.

    Parameters
    ----------
    scene: A scene, or the path of a case file.
    every: Angle in plan between successive directions of the earthquake, in degrees. The first direction is
        x, and further directions turn towards y. In the plane there are two directions, "left" and "right".
    vertical: Ratio of the vertical to the horizontal push, or several ratios such as ``(0.3, -0.3)``; see
        :class:`Earthquake`. Default: the ratio of the scene's own earthquake, else 0. The masses are those
        of the scene's own earthquake.
    load_case: Name of the load case whose dead loads are applied.
    settled: Movement of supports before the earthquake, by name: (x, y) or (x, y, rotation). The scene must
        be in the plane.
    method, progress, options: As for :func:`~masonry_opt.solve`, including ``model``, ``solver``,
        ``phases``, ...

    Returns
    -------
    Directions
        Results by earthquake.

    Raises
    ------
    OptionError
        If an argument is wrong, or for the reasons of :func:`~masonry_opt.solve`.
    CaseError
        If the scene is wrong.
    """
    phases = phases_from(options)
    base = as_scene(scene, load_case)
    base.refuse_without_case()
    if base.tilt:
        raise OptionError(f"{base.origin}: earthquakes need level ground: remove 'tilt'")
    own = base.shaken_by or Earthquake(direction=0.0)
    ratios = [own.vertical] if vertical is None else list(np.atleast_1d(vertical).tolist())
    if not ratios:
        raise OptionError("'vertical' must be a number or a list of numbers (found an empty list)")
    least = 360 / _MOST_DIRECTIONS
    if isinstance(every, bool) or not isinstance(every, int | float) or not least <= every <= 360:
        raise OptionError(f"'every' must be an angle from {least:g} to 360 degrees (found {every!r})")
    pushes: list[Any] = ["left", "right"]
    if base.dimension == 3:
        count = int(np.ceil(360 / every - 1e-9))
        pushes = [float(f"{number * every:.12g}") for number in range(count)]
    scenes: dict[str, Scene] = {}
    for ratio, push in itertools.product(ratios, pushes):
        quake = Earthquake(direction=push, vertical=ratio, dead_as_mass=own.dead_as_mass)
        scenes[str(quake)] = base.shaken(quake)
    # One settled state is enough, because the supports settle under the dead load, which is equal for all
    # earthquakes.
    state = settled_scene(next(iter(scenes.values())), settled).settled
    scenes = {name: shaken.settled_as(state) for name, shaken in scenes.items()}
    return Directions(solve_all(scenes, method, progress, phases, function=directions, **options))

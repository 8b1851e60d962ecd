"""All load cases of a scene, and which of them governs."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any, ClassVar

import numpy as np
import pandas as pd

from masonry_opt.analysis import prepare
from masonry_opt.answer.acceptance import SMALLEST
from masonry_opt.answer.reasons import Status
from masonry_opt.answer.thresholds import SAME
from masonry_opt.drawing.colours import AT_REST, VERMILION
from masonry_opt.drawing.elements import title_of
from masonry_opt.drawing.figure import Picture, entitle, finish, style
from masonry_opt.effort import Effort, Phases
from masonry_opt.errors import OptionError, counted, printable
from masonry_opt.methods.registry import DEFAULT
from masonry_opt.methods.task import Progress
from masonry_opt.result import Result
from masonry_opt.scene.case_file import as_scene
from masonry_opt.scene.scene import Scene
from masonry_opt.studies.writing import StudyAnswer
from masonry_opt.words.summary import told_factor
from masonry_opt.words.terminal import frame_text

#: Height of a bar over the width of the axes; most letters of a name beside one.
_BAR, _LETTERS = 0.09, 24

#: Columns of a table of results, beside what tells them apart.
COLUMNS = ("load_factor", "status", "expected", "associative", "exact")


@dataclass(frozen=True, eq=False)
class Cases(StudyAnswer):
    """The load cases of a scene, solved.

    Attributes
    ----------
    results: :class:`Result` of each, by its name.
    table: one row a case: ``load_case``, ``live`` (what λ scales), ``load_factor`` (NaN without one),
        ``status``, ``expected``, ``associative``, ``exact``.
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

    @cached_property
    def table(self) -> pd.DataFrame:
        results = self.results.values()
        rows = [self._apart(of) | {name: getattr(of, name) for name in COLUMNS} for of in results]
        numbers = dict.fromkeys(("load_factor", "expected", "associative"), "float64")
        return pd.DataFrame(rows).astype(numbers | {"status": "str"})

    @cached_property
    def governing(self) -> str | None:
        found = {
            name: -np.inf if result.status is Status.UNSTABLE else result.required()
            for name, result in self.results.items()
            if result.load_factor is not None or result.status is Status.UNSTABLE
        }
        least = min(found.values(), default=0.0)
        # Of those that rounding alone tells apart the first.
        most = least if np.isinf(least) else least + SAME * max(abs(least), SMALLEST)
        return next((name for name, value in found.items() if value <= most), None)

    @property
    def usable(self) -> bool:
        return all(result.usable for result in self.results.values())

    @property
    def to_draw(self) -> Result:
        """The governing result; where none governs, the first."""
        return self.results[self.governing or next(iter(self.results))]

    @property
    def summary(self) -> str:
        return self._told([] if self.governing is None else [self.to_draw.summary])

    @property
    def details(self) -> str:
        return self._told([result.details for result in self.results.values()])

    def _told(self, results: Iterable[str]) -> str:
        of = self.to_draw
        head = f"{of.case}: {counted(len(self.results), self.what)}"
        governs = f"'{self.governing}' governs: {told_factor(of)}" if self.governing else "none governs"
        if self.left_out:
            governs += f"\nleft out: {', '.join(map(repr, self.left_out))}, for axles move: see 'crossing'"
        table = frame_text(self.table, "").strip("\n")
        return printable("\n\n".join([f"{head}\n{governs}", table, *results]))

    def as_dict(self) -> dict[str, Any]:
        """Everything as plain numbers, strings, lists and dictionaries (NaN as None)."""
        told: dict[str, Any] = {"case": self.to_draw.case, "governing": self.governing, "load_factor": None}
        if self.governing is not None:
            told["load_factor"] = self.to_draw.load_factor
        if self.left_out:
            told["left_out"] = list(self.left_out)
        return told | {"load_cases": [result.as_dict() for result in self.results.values()]}

    @property
    def _heading(self) -> str:
        return f"least {told_factor(self.to_draw)}, {self.governing}" if self.governing else "no load factor"

    def plot(self) -> Picture:
        """Draw load factors as bars, from the top down, the governing one marked."""
        names = [name if len(name) <= _LETTERS else f"{name[: _LETTERS - 1]}…" for name in self.results]
        with style():
            made = Picture()
            axes = made.add_subplot()
            axes.set_box_aspect(_BAR * (len(names) + 1))
            values = [result.load_factor or 0.0 for result in self.results.values()]
            colours = [VERMILION if name == self.governing else AT_REST for name in self.results]
            axes.barh(range(len(values)), values, color=colours, height=0.6)
            beside: dict[str, Any] = {"xytext": (4, 0), "textcoords": "offset points"}
            for number, result in enumerate(self.results.values()):
                at = (max(values[number], 0.0), number)
                axes.annotate(told_factor(result), at, va="center", fontsize=8, **beside)
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

    def named(name: str) -> Callable[[str], None]:
        return lambda phase: phases(f"{name}: {phase}")

    return {name: session.solve(scene, progress, Effort(named(name))) for name, scene in scenes.items()}

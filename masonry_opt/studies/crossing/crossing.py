"""``crossing``: the load factor of a scene as axles move over it, and their worst position."""

from __future__ import annotations

import math
from base64 import b64encode
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from masonry_opt.analysis import prepare
from masonry_opt.answer.frames import unsigned
from masonry_opt.answer.reasons import Code
from masonry_opt.answer.status import Status
from masonry_opt.drawing.elements import title_of
from masonry_opt.drawing.figure import Picture, save_as
from masonry_opt.drawing.notebook import notebook_html
from masonry_opt.effort import Effort
from masonry_opt.errors import CaseError, OptionError, counted
from masonry_opt.methods.registry import DEFAULT
from masonry_opt.problem.assembly import assemble
from masonry_opt.problem.road import Road
from masonry_opt.result import Result
from masonry_opt.scene.axles import Axles
from masonry_opt.scene.blocks import Point
from masonry_opt.scene.case_file import as_scene
from masonry_opt.scene.scene import Scene
from masonry_opt.session import Session
from masonry_opt.studies.answer import StudyAnswer, records
from masonry_opt.studies.crossing import search
from masonry_opt.studies.crossing.moving_load import MovingLoad
from masonry_opt.studies.crossing.passage import Passage
from masonry_opt.studies.crossing.picture import picture
from masonry_opt.studies.many.runs import COLUMNS, columns
from masonry_opt.studies.writing import frame_table, render
from masonry_opt.words.sentences import numeral

#: Columns of the table on a page with their headings, and how their numbers are written.
_SHOWN = {"axles": "axles", "direction": "direction", "position": "first axle at", "load_factor": "λ"}
_SHOWN |= {"mechanism": "mechanism", "status": "status"}
_FORMATS = dict.fromkeys(("position", "load_factor"), "{:.6g}")

#: Distance of the least load factor from what is proven, relative, where anything is.
WITHIN = 1e-3

#: Longest range between two positions, as a share of the road.
_LONGEST = 0.01

#: Positions without an answer that are named in words; the table has all.
_NAMED = 5


@dataclass(frozen=True, kw_only=True)
class Crossing(StudyAnswer):
    """Load factors of a scene by the position of axles.

    Attributes
    ----------
    worst: result at the worst position, as of :func:`~masonry_opt.analysis.solve` of a scene with the axles
        there as loads of its blocks; of a scene that does not stand, that. It has the mechanism.
    passages: each group of axles in each direction in which it travelled.
    interrupted: whether the user ended it: λ may be less at other positions than those solved by then.
    """

    worst: Result
    passages: tuple[search.CrossedPassage, ...] = field(repr=False)
    interrupted: bool = False

    @property
    def load_factor(self) -> float | None:
        """The least load factor; None without one."""
        return self.worst.load_factor

    def required(self) -> float:
        """The least load factor; NoLoadFactorError if there is none."""
        return self.worst.required()

    @property
    def least(self) -> search.CrossedPassage | None:
        """The passage with the worst position; None of a scene that does not stand."""
        return min(self.passages, key=lambda one: one.least, default=None)

    @property
    def axles(self) -> str | None:
        """Name of the worst group."""
        return self.least.passage.axles.name if self.least else None

    @property
    def direction(self) -> str | None:
        """In which it travels, "right" or "left"."""
        return self.least.passage.direction if self.least else None

    @property
    def position(self) -> float | None:
        """Abscissa of its first axle at the worst position."""
        return self.least.position if self.least else None

    @property
    def at(self) -> list[float]:
        """Abscissae of all its axles there, the first axle first."""
        return (self.least.position + self.least.passage.offsets).tolist() if self.least else []

    @property
    def resolution(self) -> float | None:
        """How finely the worst position was sought: the larger distance from it to the next positions solved
        on either side."""
        return self.least.found.resolution(self.least.position) if self.least else None

    @property
    def bound(self) -> float | None:
        """What the load factor at no position is below, proven, with associative flow; else None."""
        bounds = [None if self.interrupted else one.found.bound for one in self.passages]
        return min((one for one in bounds if one is not None), default=None) if None not in bounds else None

    @property
    def undecided(self) -> int:
        """Number of positions at which the method found no load factor and proved none."""
        return len(self.undecided_at)

    @property
    def undecided_at(self) -> list[dict[str, Any]]:
        """These: ``axles``, ``direction`` and ``position`` of each, as in the table."""
        return [
            _place(one.passage, position)
            for one in self.passages
            for position, answer in one.found.answers.items()
            if math.isnan(search.load_factor(answer))
        ]

    @cached_property
    def table(self) -> pd.DataFrame:
        """One row a position solved by the method: ``axles``, ``direction``, ``position`` (abscissa of the
        first axle), then the columns of ``mo.sweep`` but for the seconds. Where loads jump
        there is a row on either side."""
        rows = [
            _place(one.passage, position) | columns(one.passage.loaded(one.passage.live(position)), answer)
            for one in self.passages
            for position, answer in one.found.answers.items()
        ]
        types = {"axles": "object", "direction": "object", "position": "float64"} | COLUMNS
        del types["seconds"]
        return unsigned(pd.DataFrame(rows, columns=[*types]).astype(types))

    @cached_property
    def envelope(self) -> pd.DataFrame:
        """One row a position: ``axles``, ``direction``, ``position`` and ``associative``, the load factor
        with associative flow (NaN where it carries any load), which no Coulomb answer exceeds."""
        rows = [
            _place(one.passage, x) | {"associative": value if math.isfinite(value) else math.nan}
            for one in self.passages
            for x, value in zip(one.associative.positions, one.associative.load_factors, strict=True)
        ]
        return pd.DataFrame(rows, columns=["axles", "direction", "position", "associative"])

    def facts(self) -> dict[str, str]:
        worst, least = self.worst, self.least
        told = {"case": worst.case, "method": worst.method}
        if worst.load_case is not None:
            told["load case"] = f"'{worst.load_case}': {worst.assembly.scene.load_case}"
        if least is None:
            return told | {"status": f"{worst.status}: {worst.message}"}
        found = "none: any load is carried" if worst.solution.carries_any_load else str(worst.status)
        if worst.load_factor is not None:
            found = numeral(worst.load_factor, ".6f")
        at = ", ".join(numeral(x, ".6g") for x in self.at)
        source = least.passage.axles.group.source
        positions, away = counted(len(self.table), "position"), numeral(self.resolution or 0.0, ".3g")
        told |= {
            "least λ": found,
            "at": f"{at} (abscissae of the axles, the first first)",
            "axles": f"'{self.axles}', travelling {self.direction}{f' ({source})' if source else ''}",
            "solved": f"{positions}, the next ones to the worst at most {away} away",
        }
        if least.passage.assembly.problem.live.any():
            told["beside them"] = "the scene's other live loads, which λ multiplies too"
        if self.bound is not None:
            told["bound"] = f"λ is nowhere on the road less than {numeral(self.bound, '.6f')}"
        if self.undecided:
            named = _named(self.undecided_at)
            told["undecided"] = f"{counted(self.undecided, 'position')}, at which λ may be less: {named}"
        if self.interrupted:
            told["interrupted"] = "λ may be less at positions that were not solved"
        return told

    def as_dict(self) -> dict[str, Any]:
        worst = self.worst.as_dict()
        keys = ("case", "load_case", "method", "model", "solver", "status", "load_factor")
        own = ("axles", "direction", "position", "at", "resolution", "bound", "undecided", "undecided_at")
        return (
            {key: worst[key] for key in keys}
            | {key: getattr(self, key) for key in (*own, "interrupted")}
            | {"positions": records(self.table), "worst": worst}
        )

    def plot(self) -> Picture:
        """Draw the load factor over the position of the first axle, and below it, in the same scale, the
        mechanism at the worst, as a matplotlib figure; a notebook shows it.

        Raises OptionError of a scene that does not stand.
        """
        if self.least is None:
            worst = self.worst
            raise OptionError(f"{worst.case}: {worst.status}: no axle was moved, none can be drawn")
        return picture(self.passages, self.least, self.worst)

    def save(self, path: str | Path, force: bool = False) -> None:
        """Write the picture (.png, .svg, .pdf), or a page with it, the worst position's result and the table
        (.html), whole or not at all.

        Raises OptionError if the file's name has another ending, it cannot be written or replaced (``force``
        replaces what was not written here), or the scene does not stand.
        """
        save_as(path, force, self._page, self.plot)

    def _page(self) -> str:
        """The picture, what was found, the worst position's result and the table, as HTML that stands by
        itself.

        Raises OptionError if Jinja2, of the extra "studies", is not installed.
        """
        return render(
            "crossing.html",
            title=title_of(self.worst.assembly.scene),
            facts=self.facts(),
            picture=b64encode(self.plot().image("svg")).decode(),
            worst=notebook_html(self.worst),
            rows=frame_table(self.table, _FORMATS, _SHOWN),
        )


def _named(places: list[dict[str, Any]]) -> str:
    """The first few positions, in words."""
    first = [f"{one['position']:.6g} ('{one['axles']}', {one['direction']})" for one in places[:_NAMED]]
    return ", ".join(first) + (f" and {len(places) - _NAMED} more" if len(places) > _NAMED else "")


def _place(passage: Passage, position: float) -> dict[str, Any]:
    return {"axles": passage.axles.name, "direction": passage.direction, "position": position}


def crossing(
    scene: Scene | str | Path,
    axles: str | Axles | Sequence[Axles] | None = None,
    *,
    method: str = DEFAULT,
    load_case: str | None = None,
    progress: Callable[[float, float], None] = lambda position, load_factor: None,
    **options: Any,
) -> Crossing:
    """Move axles over a scene in the plane and find where the load factor is least.

    The axles press straight down; the load factor multiplies their loads, and whatever other live loads the
    scene has. Those on the road count: a group may be partly beyond its ends. Over supports, and where the
    road runs over nothing, an axle does nothing. A group that is not the same from behind crosses in both
    directions, unless it says in which it ``travels``.

    With associative flow (methods "static" and "kinematic") the least is proven: λ of all positions between
    two is known not to be less than at some that are solved (see
    :func:`~.crossing.search.least_associative`). Other methods are asked where the associative load factor,
    which none of their answers exceeds, says that λ may be least, which proves nothing (see
    :func:`~.crossing.search.least_coulomb`). Interrupted (Ctrl-C), it returns the worst of the
    positions solved by then.

    Parameters
    ----------
    scene:
        A scene, or the path of a case file.
    axles:
        A group, several, or the name of one of the scene's. Default: all of the scene's.
    method, options:
        As of :func:`~masonry_opt.analysis.solve`, its model, solver, ... too; the load to expect is that of
        the worst position alone.
    load_case:
        Name of the load case in which they cross, where the scene has any: its ``live`` names "axles", whose
        factor multiplies them, and what else is live beside them.
    progress:
        Called with each position solved and its load factor (NaN without one).

    Raises
    ------
    CaseError
        If the case file or scene is wrong, or has no axles, or no road; if the road runs through a block, or
        over none that can move; if the load case leaves axles out.
    OptionError
        If a method, an option or the name of a group is wrong, or the scene's blocks are solids.
    KeyboardInterrupt
        If it was interrupted before any position was solved.
    """
    session = prepare(method, **options)
    many = session.without_expected()
    scene = as_scene(scene, load_case)
    scene.in_plane()  # which refuses solids
    passages = list(_passages(scene, axles))
    effort = Effort()
    first = passages[0]
    ends = np.array(first.pieces(_longest(first)))
    start = next(x for x in (*ends.mean(axis=1), *ends.ravel()) if first.carried(x))
    result = session.solve(first.scene(start))
    undecided = any(reason.code is Code.DEAD_LOAD_UNDECIDED for reason in result.reasons)
    if undecided or result.status is Status.UNSTABLE:
        return Crossing(worst=result, passages=())
    associative = MovingLoad(replace(first.assembly.problem, live=first.live(start)), effort)
    crossed, interrupted, proves = [], False, session.method.associative
    own = session.how.model is None and session.how.solver is None
    for passage in passages:
        solve = _solve(many, passage, effort)
        plain = own and proves and not len(passage.assembly.problem.crushing)
        solving = search.PassageSolver(passage, associative if plain else solve, progress)
        envelope = solving if proves else search.PassageSolver(passage, associative)
        try:
            beside = search.least_associative(envelope, _longest(passage), WITHIN)
            found = beside if proves else search.least_coulomb(solving, beside, WITHIN)
        except KeyboardInterrupt:
            interrupted, found = True, solving.found()
            beside = found if proves else envelope.found()
        if found.answers:
            crossed.append(search.CrossedPassage(passage, found, beside))
        if interrupted:
            break
    if not crossed:
        raise KeyboardInterrupt
    worst = min(crossed, key=lambda one: one.least)
    result = session.solve(worst.passage.scene(worst.position))
    return Crossing(worst=result, passages=tuple(crossed), interrupted=interrupted)


def _longest(passage: Passage) -> float:
    return _LONGEST * float(passage.road.breaks[-1] - passage.road.breaks[0])


def _solve(session: Session, passage: Passage, effort: Effort) -> search.SolveLive:
    """The method itself, on the scene's own matrices, of a scene that stands."""
    return lambda live: session.pushed(passage.loaded(live), lambda _: None, effort)


def _passages(scene: Scene, axles: str | Axles | Sequence[Axles] | None) -> Iterator[Passage]:
    """The groups asked for, in the directions in which they travel."""
    if scene.tilt:
        raise CaseError(f"{scene.origin}: axles do not tilt: take 'tilt' away")
    scene.refuse_without_case()
    if scene.earthquake:
        raise CaseError(f"{scene.origin}: axles do not cross in an earthquake: take 'earthquake' away")
    if not scene.factor_of_axles:
        assert scene.load_case is not None
        raise CaseError(
            f"{scene.origin}: load case '{scene.load_case.name}' leaves axles out ({scene.load_case}): name "
            "another, or give it 'live = { axles = 1 }'"
        )
    groups = _groups(scene, axles)
    assembly = assemble(scene.replace(axles=[]))
    for group in groups:
        road = Road(scene, assembly.geometry, _line(scene, group), f"the road of axles '{group.name}'")
        for direction in group.directions:
            yield Passage(group, direction, assembly, road)


def _groups(scene: Scene, axles: str | Axles | Sequence[Axles] | None) -> list[Axles]:
    if isinstance(axles, Axles):
        return [axles]
    if isinstance(axles, str):
        named = [group for group in scene.axles if group.name == axles]
        if not named:
            known = ", ".join(repr(group.name) for group in scene.axles) or "none"
            raise OptionError(f"{scene.origin}: no axles '{axles}'; known: {known}")
        return named
    groups = list(scene.axles if axles is None else axles)
    if not groups:
        raise CaseError(f"{scene.origin}: has no axles: give [[axles]], or in Python axles=mo.Axles(...)")
    if not all(isinstance(group, Axles) for group in groups):
        raise OptionError("axles must be an Axles, a list of them, or the name of one of the scene's")
    return groups


def _line(scene: Scene, group: Axles) -> list[Point]:
    """The group's own road, else that of the scene's fills."""
    if group.road is not None:
        return group.road
    points = [point for fill in sorted(scene.fills, key=lambda fill: fill.road[0]) for point in fill.road]
    if not points:
        raise CaseError(
            f"{scene.origin}: axles '{group.name}': on which road? Give 'road', the points of a line above "
            "the blocks from left to right"
        )
    return [point for point, after in zip(points, [*points[1:], None], strict=True) if point != after]

"""``settle``: the least and the greatest reaction of supports with which a scene stands."""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from masonry_opt.analysis import prepare
from masonry_opt.answer.reasons import Status
from masonry_opt.answer.thresholds import ZERO
from masonry_opt.drawing.elements import result_elements, title_of
from masonry_opt.drawing.figure import Picture, save_as
from masonry_opt.drawing.pictures import elements_picture
from masonry_opt.drawing.view import ViewAngles, refuse_view
from masonry_opt.effort import Effort, Phases
from masonry_opt.errors import OptionError, printable
from masonry_opt.methods.associative import associative
from masonry_opt.methods.push.compliant import PUSHED_UP_TO
from masonry_opt.methods.push.push import Elastic
from masonry_opt.methods.registry import DEFAULT
from masonry_opt.methods.task import Task
from masonry_opt.problem.assembly import Assembly, assemble
from masonry_opt.problem.problem import Problem
from masonry_opt.result import Result
from masonry_opt.scene.case_file import as_scene
from masonry_opt.scene.scene import Scene
from masonry_opt.standing.diagnosis import carries
from masonry_opt.studies.settle.bound import COLUMNS, NOTE, Bound, moving, opening_marks
from masonry_opt.studies.settle.freed import freed, refuse_idle, supports_of, unit_of
from masonry_opt.studies.writing import StudyAnswer, frame_table, records, render
from masonry_opt.words.names import some
from masonry_opt.words.sentences import numeral

_WAY = "way in which the support moves"  #: What a legend says of the arrows on supports.


@dataclass(frozen=True, kw_only=True)
class Settlement(StudyAnswer):
    """The reactions with which a scene stands on supports that can move in one direction.

    Attributes
    ----------
    case: case file or title of the scene.
    supports, direction, turns: names of the supports, unit vector in which they settle, and whether each can
        turn.
    method: as asked for.
    at_rest: reaction while the supports are held (and turn, if they can), of contacts that give; None where
        it was not found.
    least, greatest: the reactions; None where none holds the scene.
    fallen: of a scene that no reaction holds, the result that says why, and how it falls; else None.
    assembly: of the scene as it was given, its supports fixed, in its load case.
    """

    case: str
    supports: tuple[str, ...]
    direction: tuple[float, ...]
    turns: bool
    method: str
    at_rest: float | None = None
    least: Bound | None = None
    greatest: Bound | None = None
    fallen: Result | None = field(default=None, repr=False)
    assembly: Assembly = field(repr=False, compare=False)

    @property
    def ends(self) -> dict[str, Bound]:
        """Least and greatest by name; empty where no reaction holds the scene."""
        return {name: end for name in ("least", "greatest") if (end := getattr(self, name))}

    @property
    def status(self) -> Status:
        """Whether some reaction holds the scene."""
        return self.fallen.status if self.fallen else Status.STANDS

    @property
    def usable(self) -> bool:
        """Whether some reaction holds the scene, and the method found both ends, or that there is none."""
        found = (end.reaction is not None or end.unlimited for end in self.ends.values())
        return not self.fallen and all(found)

    @property
    def table(self) -> pd.DataFrame:
        """A row for each end and kind of flow: ``end`` ("least", "greatest"), ``kind`` ("coulomb",
        "expected", "associative"), ``reaction`` (NaN where there is none), ``status``, ``moves`` (names of
        blocks, fastest first)."""
        rows = [{"end": name} | row for name, end in self.ends.items() for row in end.rows()]
        return pd.DataFrame(rows, columns=["end", *COLUMNS]).astype({"reaction": float})

    told = table

    @property
    def openings(self) -> pd.DataFrame:
        """A row a joint that opens or slides at the least reaction, the widest first: ``joint`` (its row in
        the result's ``joints``), ``first``, ``second``, ``x``, ``y`` (``z``) where it opens most, ``opening``
        there and ``sliding``, both for each unit that the support moves: mm per mm, in a small motion."""
        return self.least.openings if self.least else pd.DataFrame()

    def facts(self) -> dict[str, str]:
        along = ", ".join(numeral(part, ".6g") for part in self.direction)
        rate = ", at a common rate" if len(self.supports) > 1 else ""
        turning = "and each can turn" if self.turns else "without turning"
        settles = f"{some([*map(repr, self.supports)])} along ({along}){rate}, {turning}"
        told = {"case": self.case, "method": self.method, "settles": settles}
        if self.fallen:
            return told | {"reaction": f"none holds the scene ({self.status}): {self.fallen.message}"}
        if self.at_rest is not None:
            told["at rest"] = numeral(self.at_rest, ".6g")
        told |= {name: _words(end) for name, end in self.ends.items()}
        if len(found := self.openings):
            wide = found[["opening", "sliding"]].max(axis=1)
            joints = zip(found["first"], found["second"], wide, strict=True)
            listed = some([f"'{one}'–'{other}' {numeral(width, '.3g')}" for one, other, width in joints])
            told["openings"] = f"per unit of movement, at the least: {listed}"
        return told

    def as_dict(self) -> dict[str, Any]:
        """Everything as plain numbers, strings, lists and dictionaries (not finite: None)."""
        own = ("case", "supports", "direction", "turns", "method", "at_rest")
        told: dict[str, Any] = {name: getattr(self, name) for name in own}
        told |= {"status": str(self.status), "usable": self.usable}
        numbers = ("reaction", "expected", "associative", "across_rest", "unlimited")
        for name in ("least", "greatest"):
            end = self.ends.get(name)
            told[name] = end and {key: getattr(end, key) for key in numbers} | {
                "openings": records(end.openings),
                "results": {
                    row["kind"]: {"reaction": row["reaction"], "moves": row["moves"]} | of.as_dict()
                    for row, of in zip(end.rows(), end.results.values(), strict=True)
                },
            }
        return told | {"fallen": self.fallen and self.fallen.as_dict()}

    def plot(
        self, end: str = "least", kind: str | None = None, names: bool = False, view: ViewAngles | None = None
    ) -> Picture:
        """Draw what moves at the "least" or the "greatest" reaction, with an arrow on each support in the
        direction in which it moves, as a matplotlib figure; how the scene falls, where no reaction holds it.
        Raises OptionError if there is no such end or kind, or the view is none.

        Parameters
        ----------
        kind: one of ``Bound.results``; by default the first.
        names: whether to write each block's name into it.
        view: of solids, as of :meth:`Result.plot`.
        """
        if end not in ("least", "greatest"):
            raise OptionError(f"there is no end '{end}': choose from least, greatest")
        if self.fallen:
            return _drawn(self.fallen, "no reaction holds it: how it falls", names, view, settles=False)
        rows = {row["kind"]: row for row in self.ends[end].rows()}
        kind = kind or next(iter(rows))
        if kind not in rows:
            raise OptionError(f"there is no answer of kind '{kind}': choose from {', '.join(rows)}")
        reaction, of = rows[kind]["reaction"], printable(some([*map(repr, self.supports)]))
        said = f"none ({rows[kind]['status']})" if reaction is None else numeral(reaction, ".6g")
        return _drawn(self.ends[end].results[kind], f"{end} reaction of {of}: {said} ({kind})", names, view)

    def save(
        self,
        path: str | Path,
        end: str = "least",
        kind: str | None = None,
        force: bool = False,
        view: ViewAngles | None = None,
    ) -> None:
        """Write one picture (.png, .svg, .pdf; ``end``, ``kind`` and ``view`` as in ``plot``), or a page with
        both ends (.html), whole or not at all. Raises OptionError if the file's name has another ending, it
        cannot be written or replaced (``force`` replaces what was not written here), or as ``plot``."""
        save_as(path, force, partial(self._page, view), partial(self.plot, end, kind, view=view))

    def _page(self, view: ViewAngles | None) -> str:
        title, pictures = title_of(self.assembly.scene), self.pictures(view)
        return render("study.html", title=title, answer=self, pictures=pictures, parts={})

    def pictures(self, view: ViewAngles | None = None) -> dict[str, Picture]:
        if self.fallen:
            return {"How it falls": self.plot(view=view)}
        return {f"What moves at the {end} reaction": self.plot(end, view=view) for end in self.ends}

    def page_tables(self) -> dict[str, dict[str, Any]]:
        told = {"Reactions": frame_table(self.table, kind="flow", moves="moves, fastest first")}
        for name, end in self.ends.items():
            if len(end.openings):
                rows = frame_table(end.openings.drop(columns="joint"))
                told[f"Openings per unit of movement, at the {name} reaction"] = rows
        return told if self.ends else {}


def _drawn(
    result: Result, heading: str, names: bool, view: ViewAngles | None, settles: bool = True
) -> Picture:
    refuse_view(result.assembly.scene, view)
    elements = result_elements(result)
    loads = [replace(each, label=_WAY) if each.name == "live" else each for each in elements.loads]
    numbers = opening_marks(result, elements) if settles else []
    elements = replace(elements, heading=heading, loads=[*loads, *numbers])
    return elements_picture(elements, "mechanism", names, view, (NOTE,) if numbers else ())


def _words(end: Bound) -> str:
    """An end in one line."""
    if end.reaction is None:
        said = "unlimited" if end.unlimited else f"not found ({end.result.status})"
    else:
        said = f"{numeral(end.reaction, '.6g')}; moves {some(moving(end.result))}"
    others = {"with other forces at rest": end.across_rest}
    if end.result is not end.with_associative:
        others |= {"to expect": end.expected, "associative": end.associative}
    told = [f"{label} {numeral(value, '.6g')}" for label, value in others.items() if value is not None]
    return " · ".join([said, *told])


def settle(
    scene: Scene | str | Path,
    support: str | Sequence[str],
    direction: Sequence[float],
    *,
    turns: bool = False,
    load_case: str | None = None,
    method: str = DEFAULT,
    phases: Phases = lambda _: None,
    **options: Any,
) -> Settlement:
    """Find the reactions of a support, or of several, with which a scene stands under its dead load.

    The support gives way in one direction, or is pushed back, and neither moves otherwise nor turns. Its
    reaction is the force of the ground on it against that direction: > 0 presses the support against the
    scene. As it settles its reaction falls, to the least at which the scene stands; below, the scene follows.
    As it is pushed against the direction its reaction grows, to the greatest. Either may be below zero (the
    ground must pull), or unlimited.

    Live loads of the scene are left out. Weights and loads of the supports themselves are left to the ground.

    Raises CaseError if the case file or scene is wrong; OptionError if there is no such support, it can move
    already, or touches nothing that can, if the direction is none of the scene's, or as
    :func:`~masonry_opt.solve`.

    Parameters
    ----------
    scene: a scene, or the path of a case file.
    support: name of a fixed block; of several, these move at a common rate, and the reaction is their sum.
    direction: in which it settles, ``(x, y)``, in space ``(x, y, z)``; only the direction counts.
    turns: whether each support may turn too, also at rest; its reaction passes its centroid.
    load_case: name of one of the scene's, whose dead loads act.
    method, phases, options: as of :func:`~masonry_opt.solve`, its model, solver, ... too.
    """
    session = prepare(method, **options)
    scene, effort = as_scene(scene, load_case), Effort(phases)
    scene.refuse_without_case()
    supports = supports_of(scene, support)
    along = unit_of(scene, direction)
    effort.begins("finding joints")
    assembly = assemble(scene)
    problem = assembly.problem
    unit = problem.force_unit * (float(problem.force_sizes(problem.dead).sum()) or 1.0)
    settling, pushed_back = (freed(assembly, supports, along, push, turns) for push in (unit, -unit))
    refuse_idle(assembly, settling, supports)
    told = partial(Settlement, case=scene.called, turns=turns, method=method, assembly=assembly)
    told = partial(told, supports=tuple(assembly.names(supports)), direction=tuple(along.tolist()))
    held = freed(assembly, supports, along, None, turns) if turns else assembly
    if fallen := session.falls(held, effort):
        return told(fallen=fallen)
    effort.begins("reaction at rest")
    rest = _at_rest(held.problem, settling.problem, problem.B.shape[1])
    if rest is None:
        session = session.without_expected()
        begins = _ends_by_statics(settling.problem, pushed_back.problem)[::-1]
    else:
        begins = [(_reaction(settling.problem, rest), rest)] * 2
    sessions = [session] if session.method.associative else [session, prepare("static")]

    def bound(moved: Assembly, sign: float, start: float, settled: np.ndarray | None) -> Bound:
        """The end that a push leads to, from a reaction and the forces there, if known."""
        dead = moved.problem.dead - sign * start * moved.problem.live
        begun = replace(moved, problem=replace(moved.problem, dead=dead, settled=settled))
        results = [each.push(begun, lambda _: None, Effort(phases)) for each in sessions]
        return Bound(results[0], results[-1], start=unit * start, per_load_factor=-sign * unit)

    at_rest = None if rest is None else unit * begins[0][0]
    least, greatest = bound(settling, 1.0, *begins[0]), bound(pushed_back, -1.0, *begins[1])
    return told(at_rest=at_rest, least=least, greatest=greatest)


def _at_rest(held: Problem, settling: Problem, own: int) -> np.ndarray | None:
    """Forces under the dead load of contacts that give while the supports are held, as those of supports that
    settle, shape (3c + t,); None if these do not come to carry it. The first, so many, are the scene's own;
    the others hold supports."""
    if held.joints > PUSHED_UP_TO or held.dilatancy_depends_on_stress:
        return None
    q = Elastic(held).settled
    if q is None or not carries(held, q, ZERO):
        return None
    return np.append(q[:own], np.zeros(settling.B.shape[1] - own))


def _reaction(settling: Problem, q: np.ndarray) -> float:
    """What forces press on the supports, over the live load."""
    reaction = float(settling.B @ q @ settling.live / (settling.live @ settling.live))
    # What is rounding counts as zero: solvers would measure loads by it.
    return reaction if abs(reaction) > ZERO else 0.0


def _ends_by_statics(settling: Problem, pushed_back: Problem) -> list[tuple[float, np.ndarray | None]]:
    """Least and greatest reaction with associative flow, over the live load, and the forces there; for one
    without limit a reaction beyond the other."""
    least, greatest = (associative(Task(problem)) for problem in (settling, pushed_back))
    low = None if least.load_factor is None else -least.load_factor
    high = greatest.load_factor
    if low is None:
        low = 0.0 if high is None else high - 1.0
    return [(low, least.q), (low + 1.0 if high is None else high, greatest.q)]

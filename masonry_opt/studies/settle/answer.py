"""The answer of ``settle``: the least and the greatest reaction, and what moves, opens and slides there."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property, partial
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from masonry_opt.answer.frames import unsigned
from masonry_opt.answer.motion import fastest, joint_motion, moving_names
from masonry_opt.answer.reasons import Status
from masonry_opt.answer.thresholds import ZERO
from masonry_opt.drawing.colours import BLACK
from masonry_opt.drawing.elements import result_elements, title_of
from masonry_opt.drawing.figure import Picture, save_as
from masonry_opt.drawing.marks import Marks
from masonry_opt.drawing.pictures import elements_picture
from masonry_opt.drawing.solids import ViewAngles, refuse_view
from masonry_opt.errors import OptionError, printable
from masonry_opt.problem.assembly import Assembly
from masonry_opt.result import Result, distinct_warnings
from masonry_opt.studies.warning_codes import StudyCode, study_warning
from masonry_opt.studies.writing import StudyAnswer, frame_table, records, render
from masonry_opt.words.load_factors import (
    ASSOCIATIVE,
    INCREMENTAL,
    known_least,
    load_history_ends_lower,
    search_remark,
    state_found,
)
from masonry_opt.words.names import some
from masonry_opt.words.sentences import numeral

#: Columns of a table of reactions, beside the end.
_COLUMNS = ("kind", "reaction", "status", "certainty", "moves")
#: Printed names of the kinds of results.
KIND_NAMES = {"coulomb": "Coulomb", "incremental": INCREMENTAL, "associative": ASSOCIATIVE}
_WRITTEN = 12  #: Joints at which a picture has numbers, and what it says of them.
_NOTE = "Numbers at joints: how wide they open, or slide (s), per unit of the support's movement"
_WAY = "way in which the support moves"  #: What a legend says of the arrows on supports.


@dataclass(frozen=True)
class Bound:
    """The least or the greatest reaction, in the case's unit of force; None where there is none.

    Attributes
    ----------
    result: of the method asked, with its mechanism, tables and pictures. Its live load pushes the supports,
        from the reaction ``start`` on: the reaction is ``start`` and its load factor times
        ``per_load_factor``.
    with_associative: the same with associative flow; ``result`` itself where that is what was asked.
    """

    result: Result
    with_associative: Result = field(repr=False)
    start: float = field(repr=False)
    per_load_factor: float = field(repr=False)

    @property
    def answered_by(self) -> str | None:
        """Kind of the result that ``reaction`` belongs to, a key of ``results``; None without a reaction.

        The method asked comes first. Where it finds no exact state on this side of rest, the incremental
        analysis ("incremental") answers, as where all exact states lie across rest.
        """
        if self.result.load_factor is not None:
            return next(iter(self.results))
        return None if self.incremental is None else "incremental"

    @property
    def reaction(self) -> float | None:
        """Reaction by the method asked, or by the incremental analysis (see ``answered_by``)."""
        own = self.result.load_factor
        return self.incremental if own is None else self._reaction(own)

    @property
    def incremental(self) -> float | None:
        """Incremental reaction of a scene at rest whose supports then move.

        It is None of an associative answer, or if no preload was found.
        """
        return self._reaction(self.result.incremental)

    @property
    def associative(self) -> float | None:
        """That with associative flow, which no other lies beyond."""
        return self._reaction(self.with_associative.load_factor)

    @property
    def across_rest(self) -> float | None:
        """That of a state met on the other side of rest, of other forces than those at rest, if any."""
        return self._reaction(below if (below := self.result.solution.below_zero) < -ZERO else None)

    @property
    def reaction_at_end(self) -> float | None:
        """Reaction at the end of the load history, or the incremental one if it was not followed so far."""
        return self.incremental if self.result.end is None else self._reaction(self.result.end)

    @property
    def unlimited(self) -> bool:
        """Whether the scene is proven to stand with any reaction on this side."""
        return self.result.solution.carries_any_load

    @property
    def results(self) -> dict[str, Result]:
        """Results by kind: "coulomb" and "incremental", where asked for, and "associative"."""
        if self.result is self.with_associative:
            return {"associative": self.result}
        found = {"coulomb": self.result, "incremental": self.result.at_incremental}
        return {kind: of for kind, of in found.items() if of} | {"associative": self.with_associative}

    @cached_property
    def openings(self) -> pd.DataFrame:
        """As :attr:`Settlement.openings`, of the mechanism of the first of ``results`` that has one."""
        return _joint_openings(next((of for of in self.results.values() if of.solution.answer), self.result))

    def rows(self) -> list[dict[str, Any]]:
        """Return reaction, status, certainty and moving blocks of each of the results."""
        results = self.results.items()
        # The incremental reaction may be a peak of the load history, above that of the final state.
        by_kind = {kind: self._reaction(of.load_factor) for kind, of in results}
        by_kind |= {"incremental": self.incremental}
        rows = (
            (kind, by_kind[kind], str(of.status), self._certainty(kind, of), _moving(of))
            for kind, of in results
        )
        return [dict(zip(_COLUMNS, row, strict=True)) for row in rows]

    @property
    def is_proven(self) -> bool:
        """True if no exact state is known to lie, or can lie, nearer to the reaction at rest."""
        return bool(known_least(self.result))

    @property
    def history_ends_nearer(self) -> bool:
        """True if the load history ends at a reaction nearer to the one at rest than ``reaction``."""
        return self.answered_by == "coulomb" and load_history_ends_lower(self.result)

    def _certainty(self, kind: str, result: Result) -> str:
        """Return what is known of a reaction of a kind; "" if there is none.

        The load factor pushes the support away from its reaction at rest: a lower one is nearer to that.
        """
        if kind == "incremental":
            return "" if self.incremental is None else "equilibrium is lost as the support moves on from rest"
        if result.load_factor is None:
            return ""
        if kind == "associative":
            return "no state lies further from the reaction at rest"
        if self.is_proven:
            return f"{state_found(result)}; proven: no exact state lies nearer to the reaction at rest"
        nearer = "exact states may lie nearer to the reaction at rest"
        return f"{state_found(result)}; found, not proven: {nearer}{search_remark(result, 'them')}"

    def _reaction(self, load_factor: float | None) -> float | None:
        if load_factor is None:
            return None
        reaction = self.start + self.per_load_factor * load_factor
        return reaction if abs(reaction) > ZERO * abs(self.per_load_factor) else 0.0


@dataclass(frozen=True, kw_only=True)
class Settlement(StudyAnswer):
    """The reactions with which a scene stands on supports that can move in one direction.

    Attributes
    ----------
    case: case file or title of the scene.
    supports, direction, turns: their names, unit vector in which they settle, and whether each can turn.
    method: as asked for.
    at_rest: reaction while supports are held (and turn, if they can), of contacts that give; or None.
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
        """Whether some reaction holds the scene, and each end has a reaction or provably no limit."""
        found = (end.reaction is not None or end.unlimited for end in self.ends.values())
        return not self.fallen and all(found)

    @property
    def table(self) -> pd.DataFrame:
        """A row for each end and kind of flow: ``end`` ("least", "greatest"), ``kind`` ("coulomb",
        "incremental", "associative"), ``reaction`` (NaN where there is none), ``status``, ``certainty`` (what is
        known of the reaction), ``moves`` (names of blocks, fastest first)."""
        rows = [{"end": name} | row for name, end in self.ends.items() for row in end.rows()]
        return pd.DataFrame(rows, columns=["end", *_COLUMNS]).astype({"reaction": float})

    told = table

    @property
    def openings(self) -> pd.DataFrame:
        """A row a joint that opens or slides at the least reaction, the widest first: ``joint`` (its row in
        the result's ``joints``), ``first``, ``second``, ``x``, ``y`` (``z``) where it opens most, ``opening``
        there and ``sliding``, both for each unit that the support moves: mm per mm, in a small motion."""
        return self.least.openings if self.least else pd.DataFrame()

    @property
    def warning_records(self) -> list[dict[str, Any]]:
        if self.fallen:
            return distinct_warnings([self.fallen])
        results = [result for end in self.ends.values() for result in end.results.values()]
        own = [warning for name, end in self.ends.items() for warning in self._doubts(name, end)]
        return [*distinct_warnings(results), *own]

    def _doubts(self, name: str, end: Bound) -> Iterator[dict[str, Any]]:
        """Yield the warnings that an end may lie nearer to the reaction at rest, or across it."""
        found, incremental = end.reaction, end.reaction_at_end
        if end.history_ends_nearer and found is not None and incremental is not None:
            answer, at_end = numeral(found, ".6g"), numeral(incremental, ".6g")
            nearer = f"the load history ends at {at_end}, nearer to the reaction at rest than {answer}"
            sentence = f"{name} reaction: {nearer}: the scene may collapse there"
            values = {"end": name, "reaction": found, "incremental": incremental}
            yield study_warning(StudyCode.HISTORY_ENDS_NEARER, sentence, **values)
        if end.across_rest is not None:
            state = f"an exact collapse state has the reaction {numeral(end.across_rest, '.6g')}"
            across = f"{state}, on the other side of the reaction at rest"
            sentence = f"{name} reaction: {across}: with its forces the scene would fall by itself"
            values = {"end": name, "reaction": end.across_rest, "at_rest": self.at_rest}
            yield study_warning(StudyCode.STATE_ACROSS_REST, sentence, **values)

    def facts(self) -> dict[str, str]:
        along = ", ".join(numeral(part, ".6g") for part in self.direction)
        rate = ", at a common rate" if len(self.supports) > 1 else ""
        turning = "and each can turn" if self.turns else "without turning"
        settles = f"{some([*map(repr, self.supports)])} along ({along}){rate}, {turning}"
        told = {"case": self.case, "method": self.method, "settles": settles}
        if self.fallen:
            return told | {"reaction": f"none holds the scene ({self.status}): {self.fallen.message}"}
        if self.at_rest is not None:
            told["at rest"] = f"{numeral(self.at_rest, '.6g')}, with elastic contacts"
        told |= {name: _words(end) for name, end in self.ends.items()}
        if len(found := self.openings):
            wide = found[["opening", "sliding"]].max(axis=1)
            joints = zip(found["first"], found["second"], wide, strict=True)
            listed = some([f"'{one}'–'{other}' {numeral(width, '.3g')}" for one, other, width in joints])
            told["openings"] = f"per unit of movement, at the least: {listed}"
        return told

    def as_dict(self) -> dict[str, Any]:
        own = ("case", "supports", "direction", "turns", "method", "at_rest")
        told: dict[str, Any] = {name: getattr(self, name) for name in own}
        told |= {"status": str(self.status), "usable": self.usable}
        numbers = ("reaction", "answered_by", "incremental", "associative", "across_rest", "unlimited")
        for name in ("least", "greatest"):
            end = self.ends.get(name)
            told[name] = end and {key: getattr(end, key) for key in numbers} | {
                "openings": records(end.openings),
                "results": {
                    row["kind"]: {"reaction": row["reaction"], "moves": row["moves"]} | of.as_dict()
                    for row, of in zip(end.rows(), end.results.values(), strict=True)
                },
            }
        told["warnings"] = self.warning_records
        return told | {"fallen": self.fallen and self.fallen.as_dict()}

    def plot(
        self, end: str = "least", kind: str | None = None, names: bool = False, view: ViewAngles | None = None
    ) -> Picture:
        """Draw what moves at the "least" or the "greatest" reaction, with an arrow on each support in the
        direction in which it moves, as a matplotlib figure; how the scene falls, where no reaction holds it.
        Raises OptionError if there is no such end or kind, or the view is none.

        Parameters
        ----------
        kind: one of ``Bound.results``; by default the one that the reaction belongs to.
        names: whether to write each block's name into it.
        view: of solids, as of :meth:`Result.plot`.
        """
        if end not in ("least", "greatest"):
            raise OptionError(f"there is no end '{end}': choose from least, greatest")
        if self.fallen:
            return _drawn(self.fallen, "no reaction holds it: how it falls", names, view)
        rows = {row["kind"]: row for row in self.ends[end].rows()}
        kind = kind or self.ends[end].answered_by or next(iter(rows))
        if kind not in rows:
            raise OptionError(f"there is no answer of kind '{kind}': choose from {', '.join(rows)}")
        reaction, of = rows[kind]["reaction"], printable(some([*map(repr, self.supports)]))
        said = f"none ({rows[kind]['status']})" if reaction is None else numeral(reaction, ".6g")
        heading = f"{end} reaction of {of}: {said} ({KIND_NAMES[kind]})"
        return _drawn(self.ends[end].results[kind], heading, names, view)

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
        reactions = self.table.replace({"kind": KIND_NAMES})
        told = {"Reactions": frame_table(reactions, kind="flow", moves="moves, fastest first")}
        for name, end in self.ends.items():
            if len(end.openings):
                rows = frame_table(end.openings.drop(columns="joint"))
                told[f"Openings per unit of movement, at the {name} reaction"] = rows
        return told if self.ends else {}


def _moving(result: Result) -> list[str]:
    """Names of the blocks that move, fastest first."""
    found = result.solution.answer
    return moving_names(result.assembly, found.d) if found else []


def _joint_openings(result: Result) -> pd.DataFrame:
    """:attr:`Settlement.openings` of the mechanism of a result."""
    assembly, solution = result.assembly, result.solution
    problem, joints = assembly.problem, assembly.joints
    columns = ["joint", "first", "second", *"xyz"[: assembly.scene.dimension], "opening", "sliding"]
    if solution.d is None or solution.load_factor is None:
        return pd.DataFrame(columns=columns)
    # The push, along the movement, is the one live load.
    movement = float(problem.live @ solution.d) / float(problem.force_sizes(problem.live).sum())
    rates, rounding = problem.motion(solution.d), ZERO * fastest(assembly, solution.d)
    apart, slip = np.empty(len(joints.joint)), np.hypot.reduce(np.abs(problem.shears(rates)), axis=0)
    apart[assembly.pressed] = problem.at_points(rates)
    widest = pd.Series(apart).groupby(joints.joint).idxmax().to_numpy()
    motion = joint_motion(assembly, solution)
    moves = np.flatnonzero(motion.slides | motion.hinges | motion.separates)
    opens, slides = apart[widest], joints.most(slip[assembly.of_point])
    opens, slides = (np.where(rate > rounding, rate, 0.0)[moves] / movement for rate in (opens, slides))
    first, second = np.array(assembly.pairs_of(moves), dtype=object).reshape(-1, 2).T
    at = (joints.point[widest] + assembly.geometry.origin)[moves]
    frame = pd.DataFrame(dict(zip(columns, (moves, first, second, *at.T, opens, slides), strict=True)))
    widths = frame[["opening", "sliding"]].max(axis=1).sort_values(ascending=False, kind="stable")
    return unsigned(frame.loc[widths.index]).reset_index(drop=True)


def _drawn(result: Result, heading: str, names: bool, view: ViewAngles | None) -> Picture:
    """The mechanism, with numbers at the joints that open or slide most."""
    refuse_view(result.assembly.scene, view)
    elements, joints = result_elements(result), result.assembly.joints
    marks = [replace(each, label=_WAY) if each.name == "live" else each for each in elements.loads]
    widest = _joint_openings(result).head(_WRITTEN)
    for number, opening, sliding in zip(widest["joint"], widest["opening"], widest["sliding"], strict=True):
        motion = elements.motion[[joints.first[number], joints.second[number]]].mean(axis=0)[None]
        text = f"{opening:.3g}" if opening >= sliding else f"{sliding:.3g} s"
        point = joints.middle[number][None, None]
        marks.append(Marks("openings", "", "point", BLACK, 0.0, point, motion, text=text))
    elements = replace(elements, heading=heading, loads=marks)
    return elements_picture(elements, "mechanism", names, view, (_NOTE,) if len(widest) else ())


def _words(end: Bound) -> str:
    """Return an end in words: its reaction, what is known of it, and the reactions of other kinds."""
    by_kind = {row["kind"]: row for row in end.rows()}
    others = [kind for kind in ("incremental", "associative") if kind != end.answered_by and kind in by_kind]
    told = [
        f"{KIND_NAMES[kind]} {numeral(by_kind[kind]['reaction'], '.6g')}: {by_kind[kind]['certainty']}"
        for kind in others
        if by_kind[kind]["reaction"] is not None
    ]
    return "\n".join(filter(None, [_reaction(end), _remark(end, by_kind), *told]))


def _reaction(end: Bound) -> str:
    """Return the reaction of an end with what moves, or why there is none."""
    if end.reaction is None:
        return "unlimited" if end.unlimited else f"not found ({end.result.status})"
    value = numeral(end.reaction, ".6g")
    if end.answered_by == "incremental":
        by = "by the incremental analysis: no exact collapse state was found on this side of rest"
        return f"{value} {by}"
    name = ASSOCIATIVE
    if end.answered_by == "coulomb":
        name = "proven" if end.is_proven else "found, not proven"
    return f"{value} ({name}); moves {some(_moving(end.result))}"


def _remark(end: Bound, by_kind: Mapping[str, Mapping[str, Any]]) -> str:
    """Return what is known of the reaction of an end; "" if it has none."""
    return "" if end.answered_by is None else str(by_kind[end.answered_by]["certainty"])

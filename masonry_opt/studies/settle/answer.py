"""Answer of ``settle``: the least and the greatest reaction of supports, with their mechanisms."""

from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from functools import cached_property, partial
from pathlib import Path
from typing import Any

import pandas as pd

from masonry_opt.brief import brief
from masonry_opt.drawing.colours import BLACK
from masonry_opt.drawing.elements import result_elements, title_of
from masonry_opt.drawing.figure import Picture, save_as
from masonry_opt.drawing.marks import Marks
from masonry_opt.drawing.pictures import elements_picture
from masonry_opt.drawing.solids import ViewAngles, refuse_view
from masonry_opt.errors import OptionError, printable
from masonry_opt.problem.assembly import Assembly
from masonry_opt.reporting.linear_laws import BY_CHORDS
from masonry_opt.reporting.load_factors import (
    ASSOCIATIVE,
    INCREMENTAL,
    known_least,
    load_history_ends_lower,
    search_remark,
    state_found,
)
from masonry_opt.reporting.names import some
from masonry_opt.reporting.sentences import numeral
from masonry_opt.result import Result, distinct_warnings
from masonry_opt.solution.motion import moving_names
from masonry_opt.solution.reasons import Status
from masonry_opt.solution.thresholds import ZERO
from masonry_opt.studies.settle.openings import after_movement, in_words, joint_openings, largest_movement
from masonry_opt.studies.warning_codes import StudyCode, study_warning
from masonry_opt.studies.writing import StudyAnswer, frame_table, records, render

#: Columns of the table of reactions that follow its first column, "end".
_REACTION_COLUMNS = ("kind", "reaction", "status", "certainty", "moves")
#: Printed names of the kinds of results.
KIND_NAMES = {"coulomb": "Coulomb", "incremental": INCREMENTAL, "associative": ASSOCIATIVE}
#: Headings of two columns of the table of openings on a page, by column name.
_OPENING_HEADINGS = {f"{kind}_at_movement": f"{kind} after the movement" for kind in ("opening", "sliding")}
_WRITTEN_JOINTS = 12  #: A picture states the opening or slip of at most this number of joints, largest first.
#: Note on the numbers in a picture.
_NOTE = "Numbers at joints: opening, or sliding if marked s, {}"
_ARROWS = "direction in which the support moves"  #: Legend entry for the arrows on supports.


@dataclass(frozen=True)
class Bound:
    """Least or greatest reaction of supports, and the results of the analyses that compute this reaction.

    Reactions are in the case's unit of force.

    Attributes
    ----------
    result: Result of the chosen method, with its mechanism, tables and pictures. The live load pushes the
        supports, beginning at the reaction ``start``. The reaction at a load factor λ is
        ``start + per_load_factor * λ``.
    with_associative: Result with associative flow; ``result`` itself if the chosen method is associative.
    start: Reaction at λ = 0.
    per_load_factor: Change of the reaction per unit of λ.
    movement: Size of a support movement, in the unit of length, for which openings are reported too; or None.
    """

    result: Result
    with_associative: Result = field(repr=False)
    start: float = field(repr=False)
    per_load_factor: float = field(repr=False)
    movement: float | None = None

    __repr__ = brief

    @property
    def answered_by(self) -> str | None:
        """Key in ``results`` of the result that determines ``reaction``; None if there is no reaction.

        It is the kind of the chosen method if this method found a load factor in the direction of movement.
        Otherwise it is "incremental", for the incremental analysis.
        """
        if self.result.load_factor is not None:
            return next(iter(self.results))
        return None if self.incremental is None else "incremental"

    @property
    def reaction(self) -> float | None:
        """Reaction by the chosen method, or by the incremental analysis if the method found no load factor.

        The property ``answered_by`` names the method.
        """
        load_factor = self.result.load_factor
        return self.incremental if load_factor is None else self._reaction(load_factor)

    @property
    def incremental(self) -> float | None:
        """Reaction at which equilibrium is lost as the supports move from their initial position.

        The value is None for an associative method, or if no preload was found.
        """
        return self._reaction(self.result.incremental)

    @property
    def associative(self) -> float | None:
        """Reaction of the supports at collapse with associative flow.

        In this direction of movement, no state has a reaction farther from the reaction at rest.
        """
        return self._reaction(self.with_associative.load_factor)

    @property
    def across_rest(self) -> float | None:
        """Reaction of an exact state on the wrong side of the reaction at rest; None if none was found.

        The wrong side is above the reaction at rest for the least reaction, and below for the greatest.
        """
        load_factor = self.result.solution.below_zero
        return self._reaction(load_factor) if load_factor < -ZERO else None

    @property
    def reaction_at_end(self) -> float | None:
        """Reaction at the end of the load history; equal to ``incremental`` if the end is not known."""
        return self.incremental if self.result.end is None else self._reaction(self.result.end)

    @property
    def unlimited(self) -> bool:
        """True if a proof shows that the reaction is unlimited."""
        return self.result.solution.carries_any_load

    @property
    def results(self) -> dict[str, Result]:
        """Results by kind: "associative", and "coulomb" and "incremental" if the method computes them."""
        if self.result is self.with_associative:
            return {"associative": self.result}
        results = {"coulomb": self.result}
        if self.result.at_incremental:
            results["incremental"] = self.result.at_incremental
        return results | {"associative": self.with_associative}

    @cached_property
    def openings(self) -> pd.DataFrame:
        """Table of the joints that open or slide, in the first mechanism that ``results`` contains.

        If ``movement`` is set, two columns have the opening and the sliding at this movement of the supports.
        """
        table = joint_openings(self._with_mechanism)
        if self.movement is not None:
            for name in ("opening", "sliding"):
                table[f"{name}_at_movement"] = self.movement * table[name]
        return table

    @property
    def _with_mechanism(self) -> Result:
        """First result that has a mechanism; if no result has one, the result of the chosen method."""
        with_mechanism = (result for result in self.results.values() if result.solution.answer)
        return next(with_mechanism, self.result)

    @property
    def largest_movement(self) -> float:
        """Largest support movement for which the openings, computed for small rotations, are accurate."""
        return largest_movement(self._with_mechanism)

    def rows(self) -> list[dict[str, Any]]:
        """Return a table row for each result: reaction, status, certainty and moving blocks."""
        rows = []
        for kind, result in self.results.items():
            # The load factor of an incremental result is the one at the end of the load history. The reaction
            # may be from an earlier peak, so it is taken from ``incremental``.
            reaction = self.incremental if kind == "incremental" else self._reaction(result.load_factor)
            values = (kind, reaction, str(result.status), self._certainty(kind, result), _moving(result))
            rows.append(dict(zip(_REACTION_COLUMNS, values, strict=True)))
        return rows

    @property
    def is_proven(self) -> bool:
        """True if it is proven that no exact state has a reaction between this reaction and that at rest."""
        return bool(known_least(self.result))

    @property
    def history_ends_nearer(self) -> bool:
        """True if the load history ends at a reaction between ``reaction`` and the reaction at rest."""
        return self.answered_by == "coulomb" and load_history_ends_lower(self.result)

    def _certainty(self, kind: str, result: Result) -> str:
        """Return a text that says how far the reaction of a result is proven; "" without a reaction.

        The live load pushes the support away from its reaction at rest. A state with a lower load factor is
        therefore closer to the reaction at rest.
        """
        if kind == "incremental":
            return (
                ""
                if self.incremental is None
                else "equilibrium is lost at this reaction as the support moves from its initial position"
            )
        if result.load_factor is None:
            return ""
        if kind == "associative":
            return "no state in this direction has a reaction farther from the reaction at rest than this one"
        if self.is_proven:
            return (
                f"{state_found(result)}; proven: no other exact state has a reaction closer to the reaction "
                "at rest"
            )
        return (
            f"{state_found(result)}; this reaction is not proven to be the limit: other exact states may "
            f"have a reaction closer to the reaction at rest{search_remark(result, 'them')}"
        )

    def _reaction(self, load_factor: float | None) -> float | None:
        """Return the reaction at a load factor; a value of the size of rounding errors becomes zero."""
        if load_factor is None:
            return None
        reaction = self.start + self.per_load_factor * load_factor
        return reaction if abs(reaction) > ZERO * abs(self.per_load_factor) else 0.0


@dataclass(frozen=True, kw_only=True)
class Settlement(StudyAnswer):
    """Answer of ``settle``: the least and the greatest reaction of supports with which a scene is stable.

    Attributes
    ----------
    case: Case file or title of the scene.
    supports: Names of the supports.
    direction: Unit vector in which the supports settle.
    turns: True if each support can turn.
    method: Name of the chosen method.
    at_rest: Reaction with elastic contacts while the supports do not move; None if it was not found.
    least, greatest: Least and greatest reaction; None if the scene is unstable with every reaction.
    fallen: If the scene is unstable with every reaction, the result with the mechanism; otherwise None.
    assembly: Assembly of the scene with fixed supports, in its load case.
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

    __repr__ = brief

    @property
    def ends(self) -> dict[str, Bound]:
        """Both reactions, by the keys "least" and "greatest"; empty if no reaction makes the scene stable."""
        ends = {"least": self.least, "greatest": self.greatest}
        return {name: end for name, end in ends.items() if end is not None}

    @property
    def movement(self) -> float | None:
        """Size of the support movement for which openings are reported, in the unit of length, or None."""
        return self.least.movement if self.least else None

    @property
    def status(self) -> Status:
        """STABLE if at least one reaction makes the scene stable; otherwise the status of the collapse."""
        return self.fallen.status if self.fallen else Status.STABLE

    @property
    def time_limit_reached(self) -> bool:
        """True if the time limit ended the analysis of a reaction."""
        results = (result for end in self.ends.values() for result in (end.result, end.with_associative))
        return any(result.time_limit_reached for result in results)

    @property
    def usable(self) -> bool:
        """True if the least and the greatest reaction exist, and each is known or proven to be unlimited."""
        known = (end.reaction is not None or end.unlimited for end in self.ends.values())
        return not self.fallen and all(known)

    @property
    def table(self) -> pd.DataFrame:
        """Table of reactions, with one row for each limit (least, greatest) and kind of result.

        The columns are ``end`` ("least", "greatest"), ``kind`` ("coulomb", "incremental", "associative"),
        ``reaction`` (NaN if there is none), ``status``, ``certainty`` (how far the reaction is proven)
        and ``moves`` (names of blocks, fastest first).
        """
        rows = [{"end": name} | row for name, end in self.ends.items() for row in end.rows()]
        return pd.DataFrame(rows, columns=["end", *_REACTION_COLUMNS]).astype({"reaction": float})

    notebook_table = table

    @property
    def openings(self) -> pd.DataFrame:
        """Table of the joints that open or slide at the least reaction, with the widest opening first.

        The columns are ``joint`` (its row in the result's ``joints``), ``first``, ``second``, the point
        ``x``, ``y`` (``z``) that opens most, ``opening`` at this point, and ``sliding``. Both are per unit
        that the support moves, in a small motion: mm per mm. If ``settle`` was called with a movement, the
        columns ``opening_at_movement`` and ``sliding_at_movement`` are at this movement, in units of length.
        """
        return self.least.openings if self.least else pd.DataFrame()

    @property
    def warning_records(self) -> list[dict[str, Any]]:
        """Warnings of all results without repetitions, and warnings about doubtful reactions."""
        if self.fallen:
            return distinct_warnings([self.fallen])
        results = [result for end in self.ends.values() for result in end.results.values()]
        records = distinct_warnings(results)
        for name, end in self.ends.items():
            records += self._doubts(name, end)
        return records

    def _doubts(self, name: str, end: Bound) -> Iterator[dict[str, Any]]:
        """Generate warnings about states that put the least or the greatest reaction in doubt.

        The reaction of such a state is closer to the reaction at rest than the reaction of the answer, or on
        the wrong side of the reaction at rest: see ``Bound.across_rest``.
        """
        reaction, incremental = end.reaction, end.reaction_at_end
        if end.history_ends_nearer and reaction is not None and incremental is not None:
            sentence = (
                f"{name} reaction: the computed value is {numeral(reaction, '.6g')}, but the load history "
                f"ends at {numeral(incremental, '.6g')}, closer to the reaction at rest; the scene may "
                "collapse before the computed value is reached"
            )
            values = {"end": name, "reaction": reaction, "incremental": incremental}
            yield study_warning(StudyCode.HISTORY_ENDS_NEARER, sentence, **values)
        if end.across_rest is not None:
            sentence = (
                f"{name} reaction: an exact collapse state has the reaction "
                f"{numeral(end.across_rest, '.6g')}, on the wrong side of the reaction at rest (above it for "
                "the least reaction, below it for the greatest); with the joint forces of this state, the "
                "scene would fall by itself"
            )
            values = {"end": name, "reaction": end.across_rest, "at_rest": self.at_rest}
            yield study_warning(StudyCode.STATE_ACROSS_REST, sentence, **values)

    def facts(self) -> dict[str, str]:
        """Return the printed lines of the answer as a dictionary: the text of each line by its label."""
        along = ", ".join(numeral(part, ".6g") for part in self.direction)
        rate = ", at a common rate" if len(self.supports) > 1 else ""
        turning = "and each can turn" if self.turns else "without turning"
        settles = f"{some([*map(repr, self.supports)])} along ({along}){rate}, {turning}"
        facts = {"case": self.case, "method": self.method, "settles": settles}
        if self.fallen:
            return facts | {
                "reaction": f"no reaction makes the blocks stable ({self.status}): {self.fallen.message}"
            }
        if self.at_rest is not None:
            facts["at rest"] = f"{numeral(self.at_rest, '.6g')}, with elastic contacts"
        facts |= {name: _words(end) for name, end in self.ends.items()}
        if len(self.openings):
            facts["openings"] = in_words(self.openings, self.movement)
        if any(end.result.crushing == "chords" for end in self.ends.values()):
            wider = "the range of associative reactions would be wider with the parabola than with chords"
            facts["crushing"] = f"limited by {BY_CHORDS}; {wider}"
        return facts

    def as_dict(self) -> dict[str, Any]:
        """Return the answer as plain numbers, strings, lists and dictionaries."""
        names = ("case", "supports", "direction", "turns", "method", "movement", "at_rest")
        result: dict[str, Any] = {name: getattr(self, name) for name in names}
        result |= {"status": str(self.status), "usable": self.usable}
        for name, end in (("least", self.least), ("greatest", self.greatest)):
            result[name] = None if end is None else _bound_as_dict(end)
        result["warnings"] = self.warning_records
        result["fallen"] = self.fallen and self.fallen.as_dict()
        return result

    def plot(
        self, end: str = "least", kind: str | None = None, names: bool = False, view: ViewAngles | None = None
    ) -> Picture:
        """Return a matplotlib figure of the mechanism at the "least" or the "greatest" reaction.

        Arrows show how the supports move. Without a stable reaction, the figure shows the collapse mechanism.
        Raises OptionError if the end or the kind does not exist, or the view is wrong.

        Parameters
        ----------
        end: "least" or "greatest".
        kind: Key of ``Bound.results``; by default the kind of the reaction.
        names: True to write the names of the blocks into the picture.
        view: Angles from which solids are seen, as in :meth:`Result.plot`.
        """
        if end not in ("least", "greatest"):
            raise OptionError(f"'end' must be 'least' or 'greatest' (found '{end}')")
        if self.fallen:
            return _drawn(self.fallen, "collapse mechanism that no reaction prevents", names, view, None)
        rows = {row["kind"]: row for row in self.ends[end].rows()}
        kind = kind or self.ends[end].answered_by or next(iter(rows))
        if kind not in rows:
            raise OptionError(f"no answer of kind '{kind}': choose from {', '.join(rows)}")
        reaction, supports = rows[kind]["reaction"], printable(some([*map(repr, self.supports)]))
        value = f"none ({rows[kind]['status']})" if reaction is None else numeral(reaction, ".6g")
        heading = f"{end} reaction of {supports}: {value} ({KIND_NAMES[kind]})"
        return _drawn(self.ends[end].results[kind], heading, names, view, self.movement)

    def save(
        self,
        path: str | Path,
        end: str = "least",
        kind: str | None = None,
        force: bool = False,
        view: ViewAngles | None = None,
    ) -> None:
        """Write one picture to a .png, .svg or .pdf file, or a page with all pictures to an .html file.

        See ``plot`` for the parameters ``end``, ``kind`` and ``view``. The file is written completely or not
        at all. Raises OptionError if the name has another ending, if the file cannot be written or replaced
        (``force`` replaces files of other programs), or for the reasons of ``plot``.
        """
        save_as(path, force, partial(self._page, view), partial(self.plot, end, kind, view=view))

    def _page(self, view: ViewAngles | None) -> str:
        """Return the page as HTML."""
        title, pictures = title_of(self.assembly.scene), self.pictures(view)
        return render("study.html", title=title, answer=self, pictures=pictures, parts={})

    def pictures(self, view: ViewAngles | None = None) -> dict[str, Picture]:
        """Return the pictures of the HTML page, by caption."""
        if self.fallen:
            return {"How it falls": self.plot(view=view)}
        return {f"What moves at the {end} reaction": self.plot(end, view=view) for end in self.ends}

    def page_tables(self) -> dict[str, dict[str, Any]]:
        """Return the tables of the HTML page, by heading; empty if the scene is unstable."""
        if not self.ends:
            return {}
        reactions = self.table.replace({"kind": KIND_NAMES})
        tables = {"Reactions": frame_table(reactions, kind="flow", moves="moves, fastest first")}
        for name, end in self.ends.items():
            if len(end.openings):
                rows = frame_table(end.openings.drop(columns="joint").rename(columns=_OPENING_HEADINGS))
                tables[f"Openings per unit of movement, at the {name} reaction"] = rows
        return tables


def _bound_as_dict(end: Bound) -> dict[str, Any]:
    """Return a dictionary of one reaction, with the joint openings and the results of all analyses."""
    names = ("reaction", "answered_by", "incremental", "associative", "across_rest", "unlimited")
    values: dict[str, Any] = {name: getattr(end, name) for name in names}
    values["openings"] = records(end.openings)
    values["results"] = {
        row["kind"]: {"reaction": row["reaction"], "moves": row["moves"]} | result.as_dict()
        for row, result in zip(end.rows(), end.results.values(), strict=True)
    }
    return values


def _moving(result: Result) -> list[str]:
    """Return the names of the blocks that move, in order of decreasing velocity."""
    answer = result.solution.answer
    return moving_names(result.assembly, answer.d) if answer else []


def _drawn(
    result: Result, heading: str, names: bool, view: ViewAngles | None, movement: float | None
) -> Picture:
    """Return a picture of a mechanism, with numbers at the joints that open or slide most.

    The numbers are lengths after a movement of the supports, or per unit of their movement if it is None.
    """
    refuse_view(result.assembly.scene, view)
    elements, joints = result_elements(result), result.assembly.joints
    marks = [replace(mark, label=_ARROWS) if mark.name == "live" else mark for mark in elements.loads]
    widest, scale = joint_openings(result).head(_WRITTEN_JOINTS), 1.0 if movement is None else movement
    for number, opening, sliding in zip(widest["joint"], widest["opening"], widest["sliding"], strict=True):
        motion = elements.motion[[joints.first[number], joints.second[number]]].mean(axis=0)[None]
        text = f"{scale * opening:.3g}" if opening >= sliding else f"{scale * sliding:.3g} s"
        point = joints.middle[number][None, None]
        marks.append(Marks("openings", "", "point", BLACK, 0.0, point, motion, text=text))
    elements = replace(elements, heading=heading, loads=marks)
    notes = (_NOTE.format(after_movement(movement)),) if len(widest) else ()
    return elements_picture(elements, "mechanism", names, view, notes)


def _words(end: Bound) -> str:
    """Return a text on the least or greatest reaction: value, certainty, and results of other analyses."""
    by_kind = {row["kind"]: row for row in end.rows()}
    lines = [_reaction_text(end)]
    if end.answered_by is not None:
        lines.append(by_kind[end.answered_by]["certainty"])
    for kind in ("incremental", "associative"):
        row = by_kind.get(kind)
        if row is None or kind == end.answered_by or row["reaction"] is None:
            continue
        lines.append(f"{KIND_NAMES[kind]} {numeral(row['reaction'], '.6g')}: {row['certainty']}")
    return "\n".join(filter(None, lines))


def _reaction_text(end: Bound) -> str:
    """Return a text with the reaction and the moving blocks, or with the status if no reaction was found."""
    if end.reaction is None:
        return "unlimited" if end.unlimited else f"not found ({end.result.status})"
    value = numeral(end.reaction, ".6g")
    if end.answered_by == "incremental":
        return f"{value} by the incremental analysis (no exact collapse state was found in this direction)"
    name = ASSOCIATIVE
    if end.answered_by == "coulomb":
        name = "proven" if end.is_proven else "found, not proven"
    return f"{value} ({name}); moves {some(_moving(end.result))}"

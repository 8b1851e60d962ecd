"""Answer of ``settle``: the least and the greatest reaction of supports, with their mechanisms."""

from collections.abc import Iterator
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from typing import Any

import pandas as pd

from masonry_opt.brief import brief
from masonry_opt.drawing.elements import title_of
from masonry_opt.drawing.figure import Picture, save_as
from masonry_opt.drawing.solids import ViewAngles
from masonry_opt.errors import OptionError, printable
from masonry_opt.methods.incremental.settings import IncrementalSettings
from masonry_opt.problem.assembly import Assembly
from masonry_opt.reporting.linear_laws import BY_CHORDS
from masonry_opt.reporting.names import FORCE_UNIT, some
from masonry_opt.reporting.sentences import numeral
from masonry_opt.result import Result, distinct_warnings
from masonry_opt.solution.reasons import Status
from masonry_opt.studies.settle.bound import (
    KIND_NAMES,
    REACTION_COLUMNS,
    Bound,
    bound_as_dict,
    bound_text,
    mechanism_picture,
)
from masonry_opt.studies.settle.openings import in_words
from masonry_opt.studies.warning_codes import StudyCode, study_warning
from masonry_opt.studies.writing import StudyAnswer, frame_table, render

#: Headings of two columns of the table of openings on a page, by column name.
_OPENING_HEADINGS = {f"{kind}_at_movement": f"{kind} after the movement" for kind in ("opening", "sliding")}


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
        """STABLE if the scene is stable for some support reaction; otherwise the status of the collapse."""
        return self.fallen.status if self.fallen else Status.STABLE

    @property
    def time_limit_reached(self) -> bool:
        """True if the time limit ended the analysis of a reaction."""
        results = (result for end in self.ends.values() for result in (end.result, end.with_associative))
        return any(result.time_limit_reached for result in results)

    @property
    def usable(self) -> bool:
        """True if the least and the greatest reaction that keep the scene stable are known or infinite."""
        known = (end.reaction is not None or end.unlimited for end in self.ends.values())
        return not self.fallen and all(known)

    @property
    def table(self) -> pd.DataFrame:
        """Table of reactions, with one row for each limit (least, greatest) and kind of result.

        The columns are ``end`` ("least", "greatest"), ``kind`` ("coulomb", "incremental", "associative"),
        ``reaction`` (NaN if there is none), ``status``, ``certainty`` (text on what is
        proven about the reaction) and ``moves`` (names of blocks, fastest first).
        """
        rows = [{"end": name} | row for name, end in self.ends.items() for row in end.rows()]
        return pd.DataFrame(rows, columns=["end", *REACTION_COLUMNS]).astype({"reaction": float})

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
        """Generate warnings about states that make the least or the greatest reaction doubtful.

        The reaction of such a state is closer to the reaction at rest than the reaction of the answer, or on
        the wrong side of the reaction at rest: see ``Bound.across_rest``.
        """
        reaction, incremental = end.reaction, end.reaction_at_end
        if end.history_ends_nearer and reaction is not None and incremental is not None:
            sentence = (
                f"{name} reaction: the computed value is {numeral(reaction, '.6g')}, but the load history "
                f"ends at {numeral(incremental, '.6g')}, which is closer to the reaction at rest; the scene "
                "may collapse before the computed value is reached"
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
        facts["reactions"] = FORCE_UNIT
        facts["at rest"] = self._at_rest_text()
        facts |= {name: bound_text(end) for name, end in self.ends.items()}
        if self.least and self.least.moves_no_support:
            facts["openings"] = "none, because no support moves in the mechanism of the least reaction"
        elif len(self.openings):
            facts["openings"] = in_words(self.openings, self.movement)
        if any(end.result.crushing == "chords" for end in self.ends.values()):
            wider = "with the parabola, the range of associative reactions would be wider"
            facts["crushing"] = f"limited by {BY_CHORDS}; {wider}"
        return facts

    def _at_rest_text(self) -> str:
        """Return a text with the reaction at rest, or with the reason why there is none."""
        problem = self.assembly.problem
        if self.at_rest is not None:
            return f"{numeral(self.at_rest, '.6g')}, with elastic contacts"
        if problem.dilatancy_depends_on_stress:
            return "not computed, because dilatancy falls with stress"
        if problem.joints > IncrementalSettings().most_joints:
            return "not computed, because the scene has too many joints"
        return "not found: blocks at rest, with elastic contacts, reach no equilibrium under the dead load"

    def as_dict(self) -> dict[str, Any]:
        """Return the answer as plain numbers, strings, lists and dictionaries.

        Returns
        -------
        dict
            The data by name. The values ``least`` and ``greatest`` are dictionaries of a reaction, or None if
            the scene is unstable with every reaction.
        """
        names = ("case", "supports", "direction", "turns", "method", "movement", "at_rest")
        result: dict[str, Any] = {name: getattr(self, name) for name in names}
        result |= {"status": str(self.status), "usable": self.usable}
        for name, end in (("least", self.least), ("greatest", self.greatest)):
            result[name] = None if end is None else bound_as_dict(end)
        result["warnings"] = self.warning_records
        result["fallen"] = self.fallen and self.fallen.as_dict()
        return result

    def plot(
        self, end: str = "least", kind: str | None = None, names: bool = False, view: ViewAngles | None = None
    ) -> Picture:
        """Return a matplotlib figure of the mechanism at the "least" or the "greatest" reaction.

        Arrows show how the supports move. Without a stable reaction, the figure shows the collapse mechanism.

        Parameters
        ----------
        end: "least" or "greatest".
        kind: Key of ``Bound.results``; by default the kind of the reaction.
        names: True to write the names of the blocks into the picture.
        view: Angles from which solids are seen, as in :meth:`Result.plot`.

        Returns
        -------
        Picture
            The figure, a subclass of matplotlib's ``Figure``.

        Raises
        ------
        OptionError
            If the end or the kind does not exist, or if the view is wrong.
        """
        if end not in ("least", "greatest"):
            raise OptionError(f"'end' must be 'least' or 'greatest' (found '{end}')")
        if self.fallen:
            return mechanism_picture(
                self.fallen, "collapse mechanism that no reaction prevents", names, view, None
            )
        rows = {row["kind"]: row for row in self.ends[end].rows()}
        kind = kind or self.ends[end].answered_by or next(iter(rows))
        if kind not in rows:
            raise OptionError(f"no answer of kind '{kind}': choose from {', '.join(rows)}")
        reaction, supports = rows[kind]["reaction"], printable(some([*map(repr, self.supports)]))
        value = f"none ({rows[kind]['status']})" if reaction is None else numeral(reaction, ".6g")
        heading = f"{end} reaction of {supports}: {value} ({KIND_NAMES[kind]})"
        return mechanism_picture(self.ends[end].results[kind], heading, names, view, self.movement)

    def save(
        self,
        path: str | Path,
        end: str = "least",
        kind: str | None = None,
        force: bool = False,
        view: ViewAngles | None = None,
    ) -> None:
        """Write one picture to a .png, .svg or .pdf file, or a page with all pictures to an .html file.

        The file is written completely or not at all.

        Parameters
        ----------
        path: File to write.
        end, kind, view: See ``plot``. A page shows both ends, and uses only ``view``.
        force: True to replace a file that another program wrote.

        Raises
        ------
        OptionError
            If the name has another ending, if the file cannot be written or replaced (``force`` replaces
            files of other programs), or for the reasons of ``plot``.
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
                tables[f"Openings per unit of support movement, at the {name} reaction"] = rows
        return tables

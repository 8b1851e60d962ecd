"""The answer of ``settle``: the reactions with which a scene stands, and what moves at either end."""

from __future__ import annotations

from base64 import b64encode
from dataclasses import dataclass, field, replace
from functools import partial
from pathlib import Path
from typing import Any

import pandas as pd

from masonry_opt.answer.motion import moving_names
from masonry_opt.answer.status import Status
from masonry_opt.answer.thresholds import ZERO
from masonry_opt.drawing.elements import result_elements, title_of
from masonry_opt.drawing.figure import Picture, save_as
from masonry_opt.drawing.pictures import elements_picture
from masonry_opt.drawing.view import ViewAngles, refuse_view
from masonry_opt.errors import OptionError, printable
from masonry_opt.result import Result
from masonry_opt.studies.answer import StudyAnswer
from masonry_opt.studies.writing import render
from masonry_opt.words.names import some
from masonry_opt.words.sentences import numeral

#: What a legend says of the arrows on supports.
_WAY = "way in which the support moves"


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
    def reaction(self) -> float | None:
        """That of the method asked."""
        return self._reaction(self.result.load_factor)

    @property
    def expected(self) -> float | None:
        """That to expect of a scene at rest whose supports then move; None of an associative answer, or where
        the forces at rest were not found."""
        return self._reaction(self.result.expected)

    @property
    def associative(self) -> float | None:
        """That with associative flow, which no other lies beyond."""
        return self._reaction(self.with_associative.load_factor)

    @property
    def across_rest(self) -> float | None:
        """That of a state met on the other side of rest, of other forces there than those at rest, if any."""
        return self._reaction(below if (below := self.result.solution.below_zero) < 0 else None)

    @property
    def unlimited(self) -> bool:
        """Whether the scene is proven to stand with any reaction on this side."""
        return self.result.solution.carries_any_load

    @property
    def results(self) -> dict[str, Result]:
        """Results by kind: "coulomb" and "expected", where asked for, and "associative"."""
        if self.result is self.with_associative:
            return {"associative": self.result}
        found = {"coulomb": self.result, "expected": self.result.at_expected}
        return {kind: of for kind, of in found.items() if of} | {"associative": self.with_associative}

    def rows(self) -> list[dict[str, Any]]:
        """Reaction, status and moving blocks of each of the results."""
        return [
            {
                "kind": kind,
                "reaction": self._reaction(of.load_factor),
                "status": str(of.status),
                "moves": _moving(of),
            }
            for kind, of in self.results.items()
        ]

    def _reaction(self, load_factor: float | None) -> float | None:
        if load_factor is None:
            return None
        reaction = self.start + self.per_load_factor * load_factor
        return reaction if abs(reaction) > ZERO * abs(self.per_load_factor) else 0.0


def _moving(result: Result) -> list[str]:
    """Names of the blocks that move at a load factor, fastest first."""
    found = result.solution.answer
    return moving_names(result.assembly, found.d) if found else []


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
        return not self.fallen and all(
            end.reaction is not None or end.unlimited for end in self.ends.values()
        )

    @property
    def table(self) -> pd.DataFrame:
        """A row for each end and kind of flow: ``end`` ("least", "greatest"), ``kind`` ("coulomb",
        "expected", "associative"), ``reaction`` (NaN where there is none), ``status``, ``moves`` (names of
        blocks, fastest first)."""
        rows = [{"end": name} | row for name, end in self.ends.items() for row in end.rows()]
        frame = pd.DataFrame(rows, columns=["end", "kind", "reaction", "status", "moves"])
        return frame.astype({"reaction": float})

    def facts(self) -> dict[str, str]:
        along = ", ".join(numeral(part, ".6g") for part in self.direction)
        rate = ", at a common rate" if len(self.supports) > 1 else ""
        turning = "and each can turn" if self.turns else "without turning"
        settles = f"{some([repr(name) for name in self.supports])} along ({along}){rate}, {turning}"
        told = {"case": self.case, "method": self.method, "settles": settles}
        if self.fallen:
            return told | {"reaction": f"none holds the scene ({self.status}): {self.fallen.message}"}
        if self.at_rest is not None:
            told["at rest"] = numeral(self.at_rest, ".6g")
        return told | {name: _words(end) for name, end in self.ends.items()}

    def as_dict(self) -> dict[str, Any]:
        """Everything as plain numbers, strings, lists and dictionaries (not finite: None)."""
        own = ("case", "supports", "direction", "turns", "method", "at_rest")
        told: dict[str, Any] = {name: getattr(self, name) for name in own}
        told |= {"status": str(self.status), "usable": self.usable}
        numbers = ("reaction", "expected", "associative", "across_rest", "unlimited")
        for name in ("least", "greatest"):
            end = self.ends.get(name)
            told[name] = end and {key: getattr(end, key) for key in numbers} | {
                "results": {
                    row["kind"]: {"reaction": row["reaction"], "moves": row["moves"]} | of.as_dict()
                    for row, of in zip(end.rows(), end.results.values(), strict=True)
                },
            }
        return told | {"fallen": self.fallen and self.fallen.as_dict()}

    def plot(
        self,
        end: str = "least",
        kind: str | None = None,
        names: bool = False,
        view: ViewAngles | None = None,
    ) -> Picture:
        """Draw what moves at the "least" or the "greatest" reaction, with an arrow on each support in the
        direction in which it moves, as a matplotlib figure; how the scene falls, where no reaction holds it.

        Parameters
        ----------
        kind: one of ``Bound.results``; by default the first.
        names: whether to write each block's name into it.
        view: of solids, as of :meth:`Result.plot`.

        Raises OptionError if there is no such end or kind, or the view is none.
        """
        if end not in ("least", "greatest"):
            raise OptionError(f"there is no end '{end}': choose from least, greatest")
        if self.fallen:
            return _drawn(self.fallen, "no reaction holds it: how it falls", names, view)
        bound = self.ends[end]
        kind = kind or next(iter(bound.results))
        if kind not in bound.results:
            raise OptionError(f"there is no answer of kind '{kind}': choose from {', '.join(bound.results)}")
        row = next(row for row in bound.rows() if row["kind"] == kind)
        said = f"none ({row['status']})" if row["reaction"] is None else numeral(row["reaction"], ".6g")
        of = printable(some([repr(name) for name in self.supports]))
        return _drawn(bound.results[kind], f"{end} reaction of {of}: {said} ({kind})", names, view)

    def save(
        self,
        path: str | Path,
        end: str = "least",
        kind: str | None = None,
        force: bool = False,
        view: ViewAngles | None = None,
    ) -> None:
        """Write one picture (.png, .svg, .pdf; ``end``, ``kind`` and ``view`` as in ``plot``), or a page with
        both ends (.html), whole or not at all.

        Raises OptionError if the file's name has another ending, it cannot be written or replaced (``force``
        replaces what was not written here), or as ``plot``.
        """
        save_as(path, force, partial(self._page, view), partial(self.plot, end, kind, view=view))

    def _page(self, view: ViewAngles | None) -> str:
        """Both ends with their pictures, and the table, as HTML that stands by itself.

        Raises OptionError if Jinja2, of the extra "studies", is not installed.
        """
        ends = list(self.ends) or ["least"]
        drawn = {end: b64encode(self.plot(end, view=view).image("svg")).decode() for end in ends}
        rows = [
            (
                row["end"],
                row["kind"],
                "" if row["reaction"] != row["reaction"] else numeral(row["reaction"], ".6g"),
                row["status"],
                printable(some(row["moves"])),
            )
            for row in self.table.to_dict("records")
        ]
        title = title_of((self.fallen or next(iter(self.ends.values())).result).assembly.scene)
        return render("settlement.html", title=title, facts=self.facts(), pictures=drawn, rows=rows)


def _drawn(result: Result, heading: str, names: bool, view: ViewAngles | None) -> Picture:
    refuse_view(result.assembly.scene, view)
    elements = result_elements(result)
    loads = [replace(each, label=_WAY) if each.name == "live" else each for each in elements.loads]
    return elements_picture(replace(elements, heading=heading, loads=loads), "mechanism", names, view)


def _words(end: Bound) -> str:
    """An end in one line."""
    if end.reaction is None:
        said = "unlimited" if end.unlimited else f"not found ({end.result.status})"
    else:
        said = f"{numeral(end.reaction, '.6g')}; moves {some(_moving(end.result))}"
    others = {"with other forces at rest": end.across_rest}
    if end.result is not end.with_associative:
        others |= {"to expect": end.expected, "associative": end.associative}
    told = [f"{label} {numeral(value, '.6g')}" for label, value in others.items() if value is not None]
    return " · ".join([said, *told])

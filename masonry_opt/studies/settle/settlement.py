"""The answer of ``settle``: the reactions with which a scene stands, and what moves at either end."""

from __future__ import annotations

import json
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

from masonry_opt.answer.motion import moving_names
from masonry_opt.answer.status import Status
from masonry_opt.answer.thresholds import ZERO
from masonry_opt.errors import printable
from masonry_opt.result import Result
from masonry_opt.words.names import some
from masonry_opt.words.sentences import numeral

if TYPE_CHECKING:
    import pandas as pd


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
class Reactions:
    """Reactions of supports that can move in one direction, in numbers; see :class:`~.settle.Settlement`."""

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
        import pandas as pd

        rows = [{"end": name} | row for name, end in self.ends.items() for row in end.rows()]
        frame = pd.DataFrame(rows, columns=["end", "kind", "reaction", "status", "moves"])
        return frame.astype({"reaction": float})

    def __str__(self) -> str:
        return printable("\n".join(f"{label:<16} {words}" for label, words in self.facts().items()))

    def facts(self) -> dict[str, str]:
        """What it found, in words by name."""
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

    def to_json(self) -> str:
        """``as_dict`` as one JSON object."""
        return json.dumps(self.as_dict(), allow_nan=False, ensure_ascii=False)


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

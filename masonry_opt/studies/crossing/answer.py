"""The answer of ``crossing``: the worst position, and the load factor by position."""

from __future__ import annotations

import json
import math
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np
import pandas as pd

from masonry_opt.answer.frames import unsigned
from masonry_opt.errors import counted, printable
from masonry_opt.result import Result
from masonry_opt.studies.crossing.passage import Passage
from masonry_opt.studies.crossing.search import PassageTrials, PositionTrial
from masonry_opt.studies.many.runs import COLUMNS, columns
from masonry_opt.words.sentences import numeral

#: Positions without an answer that are named in words; the table has all.
_NAMED = 5


@dataclass(frozen=True)
class CrossedPassage:
    """A passage with its answers, and those of associative flow at all positions looked at."""

    passage: Passage
    found: PassageTrials
    associative: PassageTrials = field(repr=False)

    @property
    def least(self) -> float:
        """The least load factor; infinite without one."""
        known = self.found.load_factors
        return float(np.nanmin(known)) if not np.isnan(known).all() else math.inf

    @property
    def position(self) -> float:
        """Where it is least, the first of several with an axle on a block that can move."""
        return min(self.found.trials, key=self._least_first).position

    def _least_first(self, trial: PositionTrial) -> tuple[float, bool]:
        if math.isfinite(trial.load_factor):
            return trial.load_factor, False
        return math.inf, not self.passage.carried(trial.position)


@dataclass(frozen=True, kw_only=True)
class Crossings:
    """Load factors of a scene by the position of axles, in numbers; see :class:`~.crossing.Crossing`."""

    worst: Result
    passages: tuple[CrossedPassage, ...] = field(repr=False)
    interrupted: bool = False

    @property
    def load_factor(self) -> float | None:
        """The least load factor; None without one."""
        return self.worst.load_factor

    def required(self) -> float:
        """The least load factor; NoLoadFactorError if there is none."""
        return self.worst.required()

    @property
    def least(self) -> CrossedPassage | None:
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
            _place(one.passage, trial.position)
            for one in self.passages
            for trial in one.found.trials
            if math.isnan(trial.load_factor)
        ]

    @cached_property
    def table(self) -> pd.DataFrame:
        """One row a position solved by the method: ``axles``, ``direction``, ``position`` (abscissa of the
        first axle), then the columns of ``mo.sweep`` but for the seconds. Where loads jump
        there is a row on either side."""
        rows = [
            _place(one.passage, trial.position) | columns(one.passage.loaded(trial.position), trial.solution)
            for one in self.passages
            for trial in one.found.trials
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

    def __str__(self) -> str:
        return printable("\n".join(f"{name:<16} {value}" for name, value in self.facts().items()))

    def facts(self) -> dict[str, str]:
        """What it found, in words by name."""
        worst, least = self.worst, self.least
        told = {"case": worst.case, "method": worst.method}
        if worst.load_case is not None:
            told["load case"] = f"'{worst.load_case}': {worst.assembly.scene.load_case}"
        if least is None:
            return told | {"status": f"{worst.status}: {worst.message}"}
        found = (
            "none: any load is carried" if worst.load_factor is None else numeral(worst.load_factor, ".6f")
        )
        group = least.passage.axles.group
        told |= {
            "least λ": found
            if worst.load_factor is not None or worst.solution.carries_any_load
            else str(worst.status),
            "at": ", ".join(numeral(x, ".6g") for x in self.at)
            + " (abscissae of the axles, the first first)",
            "axles": f"'{self.axles}', travelling {self.direction}"
            + (f" ({group.source})" if group.source else ""),
            "solved": f"{counted(len(self.table), 'position')}, the next ones to the worst at most "
            f"{numeral(self.resolution or 0.0, '.3g')} away",
        }
        if least.passage.assembly.problem.live.any():
            told["beside them"] = "the scene's other live loads, which λ multiplies too"
        if self.bound is not None:
            told["bound"] = f"λ is nowhere on the road less than {numeral(self.bound, '.6f')}"
        if self.undecided:
            told["undecided"] = f"{counted(self.undecided, 'position')}, at which λ may be less: " + _named(
                self.undecided_at
            )
        if self.interrupted:
            told["interrupted"] = "λ may be less at positions that were not solved"
        return told

    def as_dict(self) -> dict[str, Any]:
        """Everything as plain numbers, strings, lists and dictionaries (not finite: None)."""
        worst = self.worst.as_dict()
        keys = ("case", "load_case", "method", "model", "solver", "status", "load_factor")
        own = (
            "axles",
            "direction",
            "position",
            "at",
            "resolution",
            "bound",
            "undecided",
            "undecided_at",
            "interrupted",
        )
        table = self.table.astype(object).where(self.table.notna(), None)
        return (
            {key: worst[key] for key in keys}
            | {key: getattr(self, key) for key in own}
            | {"positions": table.to_dict("records"), "worst": worst}
        )

    def to_json(self) -> str:
        """``as_dict`` as one JSON object."""
        return json.dumps(self.as_dict(), allow_nan=False, ensure_ascii=False)


def _named(places: list[dict[str, Any]]) -> str:
    """The first few positions, in words."""
    first = [f"{one['position']:.6g} ('{one['axles']}', {one['direction']})" for one in places[:_NAMED]]
    return ", ".join(first) + (f" and {len(places) - _NAMED} more" if len(places) > _NAMED else "")


def _place(passage: Passage, position: float) -> dict[str, Any]:
    return {"axles": passage.axles.name, "direction": passage.direction, "position": position}

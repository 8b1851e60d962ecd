"""The answer of ``least`` and ``most``."""

from __future__ import annotations

import json
import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

import pandas as pd

from masonry_opt.answer.certificate import Certificate
from masonry_opt.errors import printable
from masonry_opt.result import Result
from masonry_opt.studies.many.runs import columns
from masonry_opt.studies.many.table import framed
from masonry_opt.words.sentences import numeral

#: ``Trial.number`` of a scene without a load factor: it falls by itself, or no load makes it collapse.
FALLS, UNLIMITED = -math.inf, math.inf


@dataclass(frozen=True)
class Trial:
    """One value tried.

    Attributes
    ----------
    holds: whether the scene stands, or carries the load.
    number: load factor, or margin under dead load; -inf where the scene falls, inf where it carries any load.
    result: state and mechanism; under dead load see :class:`~.standing.DeadLoadMargin`.
    certificate: residuals of ``number``; None where it is not finite.
    """

    value: float
    holds: bool
    number: float
    result: Result = field(repr=False)
    certificate: Certificate | None = field(repr=False)


@dataclass(frozen=True)
class Threshold:
    """The least (or the greatest) value of a number at which a scene holds.

    Attributes
    ----------
    least: whether the scene holds from ``value`` upwards; else it holds up to it.
    load: load factor to be carried; None if the scene is to stand under its dead load alone.
    value: the threshold, interpolated between the ends; at a jump the end at which the scene holds.
    holds, fails: the ends, both solved: ``result`` has state and mechanism, ``certificate`` the residuals.
    jump: load factors (margins) at the failing and the holding end, if they differ although the ends do not
        (the mechanism changes, joints lock, or the scene itself changes); else None.
    contradictions: values tried below a least (above a greatest) at which the scene holds too.
    trials: every value tried, in order.
    """

    least: bool
    load: float | None
    value: float
    holds: Trial
    fails: Trial
    jump: tuple[float, float] | None
    contradictions: tuple[float, ...]
    trials: tuple[Trial, ...] = field(repr=False)

    @property
    def interval(self) -> tuple[float, float]:
        """Lower and upper end."""
        lower, upper = sorted((self.holds.value, self.fails.value))
        return lower, upper

    @property
    def evaluations(self) -> int:
        """Number of scenes solved."""
        return len(self.trials)

    @property
    def history(self) -> pd.DataFrame:
        """One row a trial: ``value``, ``holds``, ``number``, then the columns of ``mo.sweep``."""
        rows = [
            {"value": trial.value, "holds": trial.holds, "number": trial.number}
            | columns(trial.result.assembly, trial.result.solution)
            | {"seconds": sum(trial.result.seconds.values())}
            for trial in self.trials
        ]
        return framed(rows, ["value", "holds", "number"]).astype({"holds": bool})

    @property
    def _measure(self) -> str:
        return "margin" if self.load is None else "load factor"

    def __str__(self) -> str:
        does = "stands under its dead load" if self.load is None else f"carries λ = {numeral(self.load, 'g')}"
        kind = "least" if self.least else "greatest"
        lines = {
            f"{kind} value": f"{numeral(self.value, '.9g')}, at which the scene {does}",
            "holds": self._end(self.holds),
            "fails": self._end(self.fails),
            "scenes solved": str(self.evaluations),
        }
        if self.jump:
            before, after = map(_worded, self.jump)
            lines["jump"] = f"the {self._measure} goes from {before} to {after} at once"
        if self.contradictions:
            values = ", ".join(f"{value:.6g}" for value in self.contradictions)
            side = "below" if self.least else "above"
            lines["warning"] = f"the scene holds {side} this value too, at {values}: search there by itself"
        return printable("\n".join(f"{name:<16} {value}" for name, value in lines.items()))

    def _end(self, end: Trial) -> str:
        known = math.isfinite(end.number)
        worst = end.certificate.worst if known and end.certificate else None
        residual = "" if worst is None else f" (largest residual {worst:.0e})"
        # As many digits as make the ends differ, and the failing end differ from the load.
        near = [number for number in (self.holds.number, self.load) if number is not None]
        said = numeral(end.number, _telling(self.fails.number, near, 6)) if known else str(end.result.status)
        value = numeral(end.value, _telling(self.fails.value, [self.holds.value], 9))
        return f"at {value}: {self._measure + ' ' if known else ''}{said}{residual}"

    def as_dict(self) -> dict[str, Any]:
        """All but the results, as plain numbers, strings and lists (not finite: None)."""
        return {
            "kind": "least" if self.least else "greatest",
            "load": self.load,
            "value": self.value,
            "interval": list(self.interval),
            "jump": [_finite(number) for number in self.jump] if self.jump else None,
            "contradictions": list(self.contradictions),
            "evaluations": self.evaluations,
            "holds": _end_as_dict(self.holds),
            "fails": _end_as_dict(self.fails),
            "trials": [
                {"value": trial.value, "holds": trial.holds, "number": _finite(trial.number)}
                for trial in self.trials
            ],
        }

    def to_json(self) -> str:
        """``as_dict`` as one JSON object."""
        return json.dumps(self.as_dict(), allow_nan=False, ensure_ascii=False)


def _telling(number: float, others: Sequence[float], least: int) -> str:
    """The format with fewest significant digits, at least ``least``, that tells a number from others."""
    formats = [f".{digits}g" for digits in range(least, 18)]
    told = (form for form in formats if all(f"{number:{form}}" != f"{other:{form}}" for other in others))
    return next(told, formats[-1])


def _worded(number: float) -> str:
    if number == FALLS:
        return "none (it falls by itself)"
    return "any" if number == UNLIMITED else numeral(number, ".6g")


def _end_as_dict(end: Trial) -> dict[str, Any]:
    return {
        "value": end.value,
        "number": _finite(end.number),
        "status": str(end.result.status),
        "certificate": end.certificate.as_dict() if end.certificate else None,
    }


def _finite(number: float) -> float | None:
    return number + 0.0 if math.isfinite(number) else None

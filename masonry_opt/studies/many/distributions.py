"""Distributions of the numbers of a scene, as a user writes them."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy import stats

from masonry_opt.errors import OptionError

_HOW = (
    "write it as ('lognormal', 0.6, 0.1): the mean and the standard deviation of the number itself, or '15%' "
    "of the mean, both positive; ('normal', mean, positive deviation); ('uniform', least, greatest); or any "
    "frozen distribution of scipy.stats"
)


@dataclass(frozen=True)
class Distribution:
    """A frozen distribution of scipy.stats, and its text for readers."""

    text: str
    frozen: Any


def distribution(name: str, given: Any) -> Distribution:
    """The distribution of a number.

    Parameters
    ----------
    name: of the number, for errors.
    given: ("normal", mean, standard deviation), ("lognormal", mean, standard deviation), both of the number
        itself and not of its logarithm; ("uniform", least, greatest); or a frozen distribution of
        scipy.stats. The standard deviation may be a text such as "15%", of the mean; above a mean other than
        zero it must be one.

    Raises OptionError if it is none of these, or a value is out of range; the message names the number.
    """
    of = f"distribution of '{name}'"
    if callable(getattr(given, "ppf", None)) and callable(getattr(given, "cdf", None)):
        return Distribution(_text(given), given)
    try:
        kind, first, second = given
        frozen = _FROZEN[kind]
        first = _number(first)
        second = _number(second) if kind == "uniform" else _deviation(second, first, of)
        least = {"uniform": second - first, "normal": second, "lognormal": min(first, second)}[kind]
        if least <= 0:
            raise ValueError
    except (TypeError, ValueError, KeyError):
        raise OptionError(f"{of}: {_HOW} (found {given!r})") from None
    return Distribution(f"{kind}({first:g}, {second:g})", frozen(first, second))


def lognormal(mean: float, deviation: float) -> Any:
    """The lognormal distribution with this mean and standard deviation.

    Its logarithm has the variance v = ln(1 + (deviation / mean)²) and the mean ln(mean) − v / 2.
    """
    variance = math.log1p((deviation / mean) ** 2)
    return stats.lognorm(math.sqrt(variance), scale=mean * math.exp(-variance / 2))


#: What makes a distribution of two numbers, by kind.
_FROZEN = {
    "normal": stats.norm,
    "lognormal": lognormal,
    "uniform": lambda least, greatest: stats.uniform(least, greatest - least),
}


def parse(text: str) -> tuple[str, tuple[str, Any, Any]]:
    """Name and distribution of a text such as ``joints.friction=lognormal:0.65:15%``.

    Raises OptionError if it has not these parts.
    """
    name, equals, words = text.partition("=")
    parts = [_read(part.strip()) for part in words.split(":")]
    if not equals or not name.strip() or len(parts) != 3:
        raise OptionError(
            f"'{text}': write it as NAME=lognormal:MEAN:DEVIATION (a number, or 15% of the mean), "
            "NAME=normal:MEAN:DEVIATION or NAME=uniform:LEAST:GREATEST"
        )
    return name.strip(), tuple(parts)  # type: ignore[return-value]


def _read(text: str) -> float | str:
    try:
        return float(text)
    except ValueError:
        return text


def _number(value: Any) -> float:
    """Raises TypeError if it is not a finite number."""
    if isinstance(value, bool) or not isinstance(value, int | float | np.number) or not math.isfinite(value):
        raise TypeError
    return float(value)


def _deviation(value: Any, mean: float, of: str) -> float:
    if isinstance(value, str) and value.strip().endswith("%"):
        return abs(mean) / 100 * _number(_read(value.strip()[:-1]))
    number = _number(value)
    if mean and number > abs(mean):
        raise OptionError(
            f"{of}: a standard deviation of {number:g} is more than the mean, {mean:g}: if per cent of the "
            f"mean are meant, write '{number:g}%'; if it is meant as it stands, "
            f"'{100 * number / abs(mean):.6g}%'"
        )
    return number


def _text(frozen: Any) -> str:
    of = getattr(getattr(frozen, "dist", None), "name", type(frozen).__name__)
    values = [*getattr(frozen, "args", ()), *getattr(frozen, "kwds", {}).values()]
    return f"{of}({', '.join(f'{value:g}' for value in values)})"

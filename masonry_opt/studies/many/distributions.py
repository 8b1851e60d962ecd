"""Distributions of the numbers of a scene, as a user writes them."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy import stats

from masonry_opt.errors import OptionError

#: What a distribution by name is given.
_ARGUMENTS = {
    "normal": "mean and standard deviation",
    "lognormal": "mean and standard deviation of the number itself",
    "uniform": "least and greatest value",
}

_HOW = (
    "write it as ('lognormal', 0.6, 0.1): the mean and the standard deviation of the number itself, or "
    "'15%' of the mean; ('normal', mean, standard deviation); ('uniform', least, greatest); or any frozen "
    "distribution of scipy.stats"
)


@dataclass(frozen=True)
class Distribution:
    """A distribution of one number.

    Attributes
    ----------
    text: as a user would write it.
    quantile: values at probabilities, shape (n,) to (n,).
    below: probability of a lower value.
    """

    text: str
    quantile: Callable[[np.ndarray], np.ndarray]
    below: Callable[[float], float]


def distribution(name: str, given: Any) -> Distribution:
    """The distribution of a number.

    Parameters
    ----------
    name: of the number, for errors.
    given: ("normal", mean, standard deviation), ("lognormal", mean, standard deviation), both of the number
        itself and not of its logarithm, the standard deviation also as a text such as "15%", of the mean;
        ("uniform", least, greatest); or a frozen distribution of scipy.stats. A standard deviation above
        the mean, which is likely to be meant in per cent, must be given in per cent; with a mean of zero
        (of a normal distribution) any is taken.

    Raises
    ------
    OptionError
        If it is none of these, its values are out of range, or a standard deviation is above the mean; the
        message names the number.
    """
    if callable(getattr(given, "ppf", None)) and callable(getattr(given, "cdf", None)):
        return Distribution(_frozen_text(given), given.ppf, lambda value: float(given.cdf(value)))
    if isinstance(given, str) or not isinstance(given, (tuple, list)) or len(given) != 3:
        raise OptionError(f"distribution of '{name}': {_HOW} (found {given!r})")
    kind, *values = given
    if kind not in _ARGUMENTS:
        raise OptionError(f"distribution of '{name}': {_HOW} (found {kind!r})")
    first = _number(name, kind, values[0])
    second = _spread(name, kind, values[1], first)
    if kind == "uniform":
        if not first < second:
            raise OptionError(f"distribution of '{name}': the least value must be below the greatest")
        frozen = stats.uniform(first, second - first)
    else:
        if not second > 0:
            raise OptionError(f"distribution of '{name}': the standard deviation must be positive")
        if kind == "lognormal" and not first > 0:
            raise OptionError(f"distribution of '{name}': the mean of a lognormal must be positive")
        frozen = stats.norm(first, second) if kind == "normal" else lognormal(first, second)
    text = f"{kind}({first:g}, {second:g})"
    return Distribution(text, frozen.ppf, lambda value: float(frozen.cdf(value)))


def lognormal(mean: float, deviation: float) -> Any:
    """The lognormal distribution whose own mean and standard deviation are given.

    Its logarithm has variance ln(1 + (deviation / mean)²) and mean ln(mean) less half of that.
    """
    variance = math.log1p((deviation / mean) ** 2)
    return stats.lognorm(math.sqrt(variance), scale=mean * math.exp(-variance / 2))


def parse(text: str) -> tuple[str, tuple[str, Any, Any]]:
    """Name and distribution of a text such as ``joints.friction=lognormal:0.65:15%``.

    Raises OptionError if it has not these parts.
    """
    name, equals, words = text.partition("=")
    parts = words.split(":")
    if not equals or not name.strip() or len(parts) != 3:
        raise OptionError(
            f"'{text}': write it as NAME=lognormal:MEAN:DEVIATION (a number, or 15% of the mean), "
            "NAME=normal:MEAN:DEVIATION or NAME=uniform:LEAST:GREATEST"
        )
    kind, *values = (part.strip() for part in parts)
    return name.strip(), (kind, *map(_read, values))  # type: ignore[return-value]


def _read(text: str) -> float | str:
    try:
        return float(text)
    except ValueError:
        return text


def _number(name: str, kind: str, value: object) -> float:
    good = isinstance(value, int | float | np.number) and not isinstance(value, bool)
    if not good or not math.isfinite(value):  # type: ignore[arg-type]
        raise OptionError(f"distribution of '{name}': {kind} takes {_ARGUMENTS[kind]} (found {value!r})")
    return float(value)  # type: ignore[arg-type]


def _spread(name: str, kind: str, value: object, mean: float) -> float:
    """The second number, of which a standard deviation may be a share of the mean."""
    if isinstance(value, str) and value.strip().endswith("%") and kind != "uniform":
        return abs(mean) / 100 * _number(name, kind, _read(value.strip()[:-1]))
    number = _number(name, kind, value)
    if kind != "uniform" and mean and number > abs(mean):
        raise OptionError(
            f"distribution of '{name}': a standard deviation of {number:g} is more than the mean, {mean:g}: "
            f"if per cent of the mean are meant, write '{number:g}%'; if it is meant as it stands, "
            f"'{100 * number / abs(mean):.6g}%'"
        )
    return number


def _frozen_text(given: Any) -> str:
    of = getattr(getattr(given, "dist", None), "name", type(given).__name__)
    values = [*getattr(given, "args", ()), *getattr(given, "kwds", {}).values()]
    return f"{of}({', '.join(f'{value:g}' for value in values)})"

"""The axis of load factors in charts of sweeps and samples."""

from __future__ import annotations

import numpy as np
from matplotlib.ticker import MaxNLocator
from numpy.typing import ArrayLike

from masonry_opt.answer.thresholds import ZERO

LABEL = "load factor λ"

#: Least length of an axis, as a share of the largest load factor: a shorter one would magnify rounding.
_LEAST = 0.02

#: A load factor so many times the greatest of the others is left off the axis: at most this share of all, or
#: one of three or more.
_FAR, _FEW = 10.0, 0.25


def ends(load_factors: ArrayLike) -> tuple[float, float]:
    """Ends of an axis that holds all finite load factors; 0 and 1 without any."""
    values = np.asarray(load_factors, dtype=float)
    finite = values[np.isfinite(values)]
    if not len(finite):
        return 0.0, 1.0
    least, greatest = float(finite.min()), float(finite.max())
    missing = (_LEAST * max(abs(least), abs(greatest)) or 0.1) - (greatest - least)
    aside = max(0.0, missing) / 2
    return least - aside, greatest + aside


def off_axis(load_factors: ArrayLike) -> np.ndarray:
    """Whether each load factor is far above the others and so left off the axis; shape (n,)."""
    values = np.asarray(load_factors, dtype=float)
    rising = np.sort(values[np.isfinite(values)])
    greatest = np.maximum.accumulate(np.abs(rising))
    few = max(int(_FEW * len(rising)), len(rising) >= 3)
    for first in range(len(rising) - few, len(rising)):
        if first and greatest[first - 1] > ZERO and rising[first] >= _FAR * greatest[first - 1]:
            return values >= rising[first]
    return np.zeros(len(values), dtype=bool)


def ticks(least: float, greatest: float, whole: bool = False) -> list[float]:
    """A few round numbers between two ends; ``whole``: only integers."""
    values = np.asarray(MaxNLocator(6, integer=whole).tick_values(least, greatest))
    return values[(values >= least) & (values <= greatest)].tolist()

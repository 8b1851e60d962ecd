"""The axis of load factors in charts of many scenes."""

from __future__ import annotations

import numpy as np
from matplotlib.ticker import MaxNLocator
from numpy.typing import ArrayLike

from masonry_opt.answer.thresholds import ZERO

#: What it is called.
LABEL = "load factor λ"

#: Least length of an axis, as a share of the largest load factor: a shorter one would show rounding, or a
#: change that matters to nobody, as a great one.
_LEAST = 0.02

#: From so many times the greatest of the others on, a load factor would press them into the foot of an axis;
#: at most this share of all is left off it, one of three at least.
_FAR, _FEW = 10.0, 0.25


def ends(load_factors: ArrayLike) -> tuple[float, float]:
    """Least and greatest of the finite ones, apart by more than rounding; of none, 0 and 1."""
    values = np.asarray(load_factors, dtype=float)
    finite = values[np.isfinite(values)]
    if not len(finite):
        return 0.0, 1.0
    least, greatest = float(finite.min()), float(finite.max())
    missing = (_LEAST * max(abs(least), abs(greatest)) or 0.1) - (greatest - least)
    aside = max(0.0, missing) / 2
    return least - aside, greatest + aside


def off_axis(load_factors: ArrayLike) -> np.ndarray:
    """Which of them would make an axis on which the others cannot be told apart, shape (n,)."""
    values = np.asarray(load_factors, dtype=float)
    rising = np.sort(values[np.isfinite(values)])
    greatest = np.maximum.accumulate(np.abs(rising))
    few = max(int(_FEW * len(rising)), len(rising) >= 3)
    for first in range(len(rising) - few, len(rising)):
        if first and greatest[first - 1] > ZERO and rising[first] >= _FAR * greatest[first - 1]:
            return values >= rising[first]
    return np.zeros(len(values), dtype=bool)


def ticks(least: float, greatest: float, whole: bool = False) -> list[float]:
    """Round numbers between two ends, a few; ``whole`` ones alone."""
    values = np.asarray(MaxNLocator(6, integer=whole).tick_values(least, greatest))
    found: list[float] = values[(values >= least) & (values <= greatest)].tolist()
    return found

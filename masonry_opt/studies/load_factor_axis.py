"""The axis of load factors in charts of many scenes."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

#: What it is called.
LABEL = "load factor λ"

#: Least length of an axis, as a share of the largest load factor: a shorter one would show rounding, or a
#: change that matters to nobody, as a great one.
_LEAST = 0.02


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

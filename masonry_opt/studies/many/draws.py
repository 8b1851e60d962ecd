"""Points drawn from many distributions at once, some of them alike."""

from __future__ import annotations

import warnings
from collections.abc import Sequence

import numpy as np
from scipy import stats
from scipy.stats import qmc

from masonry_opt.errors import OptionError

#: How points are spread over the unit cube: a scrambled sequence, and plain random numbers.
SEQUENCES = ("sobol", "random")

#: Dimensions up to which Sobol's points are taken unless others are named. Of 83 dimensions 128 of them have
#: pairs correlated by 0.8, where independent points have 0.3 at most.
_FEW = 10

#: Probabilities are kept this far from 0 and 1, where distributions have no value: below what the sequence
#: resolves.
_EDGE = 2.0**-32


def scores(
    count: int, groups: Sequence[Sequence[int]], correlation: float, sequence: str | None, seed: int
) -> np.ndarray:
    """Standard normal scores, shape (count, columns), of columns that are correlated in groups.

    Score j of a group is √ρ g + √(1 − ρ) e_j, with g common to the group: every two have the correlation ρ,
    and columns of different groups none. The first points of a longer sequence are those of a shorter one.

    Parameters
    ----------
    groups: columns of each group, which together are 0, 1, ...; a group of one column takes one dimension.
    correlation: ρ within groups, from 0 to 1.
    sequence: one of SEQUENCES; None for "sobol" or, of many dimensions, "random".

    Raises
    ------
    OptionError
        If there are more dimensions than the sequence has.
    """
    columns = sum(map(len, groups))
    shared = 0.0 < correlation < 1.0
    own = [group for group in groups if len(group) == 1 or correlation < 1.0]
    common = [group for group in groups if len(group) > 1 and correlation > 0.0]
    dimensions = sum(map(len, own)) + len(common)
    points = stats.norm.ppf(np.clip(_points(count, dimensions, sequence, seed), _EDGE, 1 - _EDGE))
    found = np.zeros((count, columns))
    taken = len(common)
    for group in own:
        found[:, list(group)] = points[:, taken : taken + len(group)]
        taken += len(group)
    for number, group in enumerate(common):
        part = found[:, list(group)]
        of_own = np.sqrt(1 - correlation) if shared else 0.0
        found[:, list(group)] = np.sqrt(correlation) * points[:, [number]] + of_own * part
    return found


def _points(count: int, dimensions: int, sequence: str | None, seed: int) -> np.ndarray:
    rng = np.random.default_rng(seed)
    sequence = sequence or ("sobol" if dimensions <= _FEW else "random")
    if sequence == "random":
        return rng.random((count, dimensions))
    try:
        made = qmc.Sobol(dimensions, seed=rng)
    except ValueError as error:
        raise OptionError(f"{dimensions} numbers are drawn: {error}; take sequence='random'") from None
    with warnings.catch_warnings():
        # That a power of two is spread most evenly is for the user to choose.
        warnings.simplefilter("ignore", UserWarning)
        return made.random(count)

"""What a sample says of the load factor: quantiles, probability of collapse, and what matters.

All intervals are those of independent draws, and hold whatever the distribution: a quantile's lies between
two of the ordered values, whose ranks are quantiles of the binomial distribution; a probability's is Clopper
& Pearson's. Points of a scrambled sequence scatter less than independent ones where the load factor changes
steadily, so that the intervals are then wide.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
import pandas as pd
from scipy import stats

from masonry_opt.answer.thresholds import SAME

#: Names of the confidence limits in tables.
LIMITS = ["lower", "upper"]


def quantiles(values: np.ndarray, probabilities: Sequence[float], confidence: float) -> pd.DataFrame:
    """Quantiles of a distribution from a sample, shape (n,), which may hold -inf and inf.

    With X₍₁₎ ≤ ... ≤ X₍ₙ₎ and K binomial (n, p), X₍ₗ₎ ≤ quantile ≤ X₍ᵤ₎ holds with probability
    P(l ≤ K < u) at least; l and u leave half of what the confidence leaves on either side.

    Returns
    -------
    DataFrame
        ``probability``, ``value``, ``lower``, ``upper``. A limit is NaN where the sample is too small to have
        one.
    """
    ordered, beside = np.sort(values), (1 - confidence) / 2
    n, rows = len(ordered), []
    padded = np.concatenate([[math.nan], ordered, [math.nan]])
    for p in probabilities:
        first = int(stats.binom.ppf(beside, n, p))  # P(K < first) ≤ beside
        last = int(stats.binom.ppf(1 - beside, n, p)) + 1  # P(K ≥ last) ≤ beside
        value = ordered[min(max(math.ceil(n * p), 1), n) - 1]
        rows.append((p, value, padded[first], padded[min(last, n + 1)]))
    return pd.DataFrame(rows, columns=["probability", "value", *LIMITS])


def fragility(values: np.ndarray, loads: Sequence[float], confidence: float) -> pd.DataFrame:
    """Probability of collapse at loads: the share of a sample whose load factor does not exceed them.

    Returns
    -------
    DataFrame
        ``load``, ``probability``, ``lower``, ``upper``.
    """
    ordered = np.sort(values)
    n, collapsed = len(ordered), np.searchsorted(ordered, loads, side="right")
    beside = (1 - confidence) / 2
    with np.errstate(invalid="ignore"):
        lower = np.where(collapsed == 0, 0.0, stats.beta.ppf(beside, collapsed, n - collapsed + 1))
        upper = np.where(collapsed == n, 1.0, stats.beta.ppf(1 - beside, collapsed + 1, n - collapsed))
    shares = collapsed / n
    return pd.DataFrame({"load": loads, "probability": shares, "lower": lower, "upper": upper})


def sensitivity(drawn: pd.DataFrame, values: np.ndarray, confidence: float) -> pd.DataFrame:
    """Spearman's rank correlation of the load factor with each number drawn, strongest first.

    The interval is Fisher's, with Bonett & Wright's (2000) variance (1 + r²/2) / (n − 3). All of them hold
    at once with the confidence (Bonferroni): of many numbers that do not matter some would else seem to.
    Load factors that differ by rounding have one rank: it would else seem to follow what it does not.

    Returns
    -------
    DataFrame
        ``parameter``, ``rank_correlation``, ``lower``, ``upper``; NaN where the load factor, or the number,
        is the same in all runs.
    """
    n, rows = len(values), []
    each = 1 - (1 - confidence) / max(drawn.shape[1], 1)
    known = np.abs(values[np.isfinite(values)])
    step = (SAME * float(np.median(known)) if len(known) else 0.0) or 1.0
    ranks = stats.rankdata(np.round(values / step))
    for name in drawn:
        own = stats.rankdata(drawn[name].to_numpy())
        if n < 2 or np.ptp(ranks) == 0 or np.ptp(own) == 0:
            rows.append((name, math.nan, math.nan, math.nan))
            continue
        r = float(np.clip(np.corrcoef(own, ranks)[0, 1], -1.0, 1.0))
        rows.append((name, r, *_fisher(r, n, each)))
    found = pd.DataFrame(rows, columns=["parameter", "rank_correlation", *LIMITS])
    order = found["rank_correlation"].abs().sort_values(ascending=False, kind="stable", na_position="last")
    return found.loc[order.index].reset_index(drop=True)


def _fisher(r: float, n: int, confidence: float) -> tuple[float, float]:
    if n <= 3 or abs(r) >= 1 - 1e-12:
        return (r, r) if n > 3 else (-1.0, 1.0)
    half = float(stats.norm.ppf((1 + confidence) / 2)) * math.sqrt((1 + r**2 / 2) / (n - 3))
    return math.tanh(math.atanh(r) - half), math.tanh(math.atanh(r) + half)

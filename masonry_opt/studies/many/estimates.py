"""Estimates from a sample of load factors: quantiles, probability of collapse, rank correlations.

All intervals hold for independent draws from any distribution.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pandas as pd
from scipy import stats

from masonry_opt.answer.thresholds import SAME

#: Names of the confidence limits in tables.
LIMITS = ["lower", "upper"]

#: Confidence of intervals, unless another is asked for.
CONFIDENCE = 0.95


def quantiles(values: np.ndarray, probabilities: Sequence[float], confidence: float) -> pd.DataFrame:
    """Quantiles of a distribution from a sample, shape (n,), which may hold -inf and inf.

    The limits are two of the ordered values, whose ranks are quantiles of the binomial distribution (n, p):
    on either side half of what the confidence leaves.

    Returns
    -------
    DataFrame
        ``probability``, ``value``, ``lower``, ``upper``. A limit is NaN where the sample is too small to have
        one.
    """
    rows = []
    for p in probabilities:
        limits = stats.quantile_test(values, p=p).confidence_interval(confidence)
        rows.append((p, np.quantile(values, p, method="inverted_cdf"), *limits))
    return pd.DataFrame(rows, columns=["probability", "value", *LIMITS])


def fragility(values: np.ndarray, loads: Sequence[float], confidence: float) -> pd.DataFrame:
    """Probability of collapse at loads: the share of a sample whose load factor does not exceed them.

    The limits are Clopper & Pearson's.

    Returns
    -------
    DataFrame
        ``load``, ``probability``, ``lower``, ``upper``.
    """
    n, collapsed = len(values), np.searchsorted(np.sort(values), loads, side="right")
    beside = (1 - confidence) / 2
    with np.errstate(invalid="ignore"):
        lower = np.where(collapsed == 0, 0.0, stats.beta.ppf(beside, collapsed, n - collapsed + 1))
        upper = np.where(collapsed == n, 1.0, stats.beta.ppf(1 - beside, collapsed + 1, n - collapsed))
    return pd.DataFrame({"load": loads, "probability": collapsed / n, "lower": lower, "upper": upper})


def sensitivity(drawn: pd.DataFrame, values: np.ndarray, confidence: float) -> pd.DataFrame:
    """Spearman's rank correlation of the load factor with each number drawn, strongest first.

    The interval is Fisher's, with Bonett & Wright's (2000) variance (1 + r²/2) / (n − 3). All intervals hold
    at once with the confidence (Bonferroni).
    Load factors that differ by rounding have one rank.

    Returns
    -------
    DataFrame
        ``parameter``, ``rank_correlation``, ``lower``, ``upper``; NaN where the load factor, or the number,
        is the same in all runs.
    """
    known = np.abs(values[np.isfinite(values)])
    step = (SAME * float(np.median(known)) if len(known) else 0.0) or 1.0
    ranks = pd.Series(stats.rankdata(np.round(values / step)), drawn.index)
    r = drawn.rank().corrwith(ranks).clip(-1, 1)
    each = 1 - (1 - confidence) / max(drawn.shape[1], 1)
    degrees = len(values) - 3
    half = stats.norm.ppf((1 + each) / 2) * np.sqrt((1 + r**2 / 2) / degrees) if degrees > 0 else np.inf
    # Of a perfect correlation Fisher's transform is infinite.
    middle = np.arctanh(r.clip(-1 + 1e-15, 1 - 1e-15))
    columns = {"rank_correlation": r, "lower": np.tanh(middle - half), "upper": np.tanh(middle + half)}
    found = pd.DataFrame(columns).rename_axis("parameter").reset_index()
    # Rounded, and sorted stably: equal ones stay in the order in which they were named.
    order = found["rank_correlation"].abs().round(12).sort_values(ascending=False, kind="stable").index
    return found.loc[order].reset_index(drop=True)

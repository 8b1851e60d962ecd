"""Write the statistics of a sample as lines of text."""

import math
from collections.abc import Mapping
from typing import Any

import pandas as pd

from masonry_opt.reporting.sentences import numeral
from masonry_opt.studies.many.runs import INCREMENTAL_COLUMN


def quantile_text(row: Mapping[Any, Any], confidence: float) -> str:
    """Return a line of text that states a quantile of λ and its confidence limits.

    ``row`` is a row of :meth:`~.sample.Sample.quantiles`. An infinite quantile shows which fraction of the
    runs is unstable or carries any load, so the line states this fraction.
    """
    probability, value = row["probability"], row["value"]
    remark = f"({confidence:.0%} confidence)"
    if not math.isinf(value):
        return (
            f"{probability:<6.0%} of the load factors are below "
            f"{_statistic_text(row, 'value', '.5f')} {remark}"
        )
    share = probability if value < 0 else 1 - probability
    does = "are unstable under their dead load" if value < 0 else "carry any load"
    line = f"at least {share:.0%} of the runs {does}"
    if not math.isfinite(row[INCREMENTAL_COLUMN + "value"]):
        return line
    incremental = _with_limits(row, INCREMENTAL_COLUMN, "value", ".5f")
    return f"{line}; {probability:.0%} of the incremental load factors are below {incremental} {remark}"


def correlation_text(row: Mapping[Any, Any]) -> str:
    """Return a line of text that states a rank correlation.

    ``row`` is a row of :meth:`~.sample.Sample.sensitivity`.
    """
    return f"rank correlation with {row['parameter']} {_statistic_text(row, 'rank_correlation', '+.3f')}"


def spread_text(table: pd.DataFrame) -> str:
    """Return a text that states the spread of the incremental load factor.

    ``table`` has one row for each run.
    """
    lower, upper = table["spread_lower"], table["spread_upper"]
    share = ((upper - lower) / table["incremental"]).median()
    within = f"{numeral(lower.min(), '.5f')} to {numeral(upper.max(), '.5f')}"
    return (
        "with random contact stiffness or self-stress, the incremental λ of a run varies by "
        f"{share:.1%} (median of the runs); over all runs, it ranges from {within}"
    )


def _statistic_text(row: Mapping[Any, Any], name: str, spec: str) -> str:
    """Return a text that states a statistic of λ and of the incremental load factor, with confidence limits.

    ``row`` is a row of a table of ``Sample``, ``name`` is the column of the statistic, and ``spec`` is the
    format of numbers.
    """
    statistic = _with_limits(row, "", name, spec)
    if math.isnan(row[INCREMENTAL_COLUMN + name]):
        return statistic
    incremental = _with_limits(row, INCREMENTAL_COLUMN, name, spec)
    return f"{statistic}; incremental {'the same' if incremental == statistic else incremental}"


def _with_limits(row: Mapping[Any, Any], prefix: str, name: str, spec: str) -> str:
    """Return a statistic and its confidence limits as text, from the columns with a given prefix."""
    value, lower, upper = (_value_text(row[prefix + end], spec) for end in (name, "lower", "upper"))
    return f"{value} ({lower} to {upper})"


def _value_text(value: float, spec: str) -> str:
    """Return a load factor or a statistic as text: a number, "unstable", "unknown" or "any load"."""
    if math.isfinite(value):
        return numeral(value, spec)
    if math.isnan(value):
        return "unknown"
    return "unstable" if value < 0 else "any load"

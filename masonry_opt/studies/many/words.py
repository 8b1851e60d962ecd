"""What a sweep found, in words: between what λ lies, and where it is least."""

from __future__ import annotations

from collections.abc import Sequence

import pandas as pd

from masonry_opt.answer.acceptance import SMALLEST
from masonry_opt.answer.thresholds import SAME
from masonry_opt.errors import counted
from masonry_opt.words.sentences import numeral


def at_least(frame: pd.DataFrame) -> pd.Series:
    """Which runs have the least load factor, shape (runs,): of a plateau all that are on it."""
    values = frame["load_factor"]
    least = values.min()
    return values <= least + SAME * max(abs(least), SMALLEST)


def where(rows: pd.DataFrame, names: Sequence[str]) -> str:
    """The values of the first of some runs, and how many more there are."""
    first = ", ".join(f"{name} = {rows.iloc[0][name]:g}" for name in names)
    more = len(rows) - 1
    return f"{first}, and in {more} more run{'' if more == 1 else 's'}" if more else first


def said(frame: pd.DataFrame, names: Sequence[str]) -> str:
    """What a sweep over these names found, in a few lines."""
    found = frame["load_factor"].dropna()
    lines = [f"{counted(len(frame), 'run')}, {len(found)} with a load factor"]
    if len(found):
        lines.append(f"λ from {numeral(found.min(), '.6f')} to {numeral(found.max(), '.6f')}")
        lines.append(f"least at {where(frame[at_least(frame)], names)}")
    failed = frame[frame["load_factor"].isna()]
    for status, count in failed["status"].value_counts().items():
        lines.append(f"{count} {status}, at {where(failed[failed['status'] == status], names)}")
    return "\n".join(lines)

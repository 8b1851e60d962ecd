"""Settings of the loop as the paper describes it, without the exact end and the remedies added here."""

from __future__ import annotations

from typing import Any

import pandas as pd

from masonry_opt.answer.result import Result

#: Section 5: "unless stated otherwise". A sub-problem without a state, which the paper does not mention,
#: makes the loop begin again with less slope.
PAPER: dict[str, Any] = {
    "pace": "paper",
    "alpha": 0.3,
    "alpha_min": 0.001,
    "beta": 0.6,
    "tol": 1e-5,
    "c0": 1e-5,
    "finish": False,
    "remedies": "slope",
}


def last_run(result: Result) -> pd.DataFrame:
    """The history of a loop's last run: what came before it failed and was begun again."""
    history = result.history
    return history[history["attempt"] == history["attempt"].max()]

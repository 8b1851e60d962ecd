"""One look for both reports: a colour a solver, a marker a method, a word a failure."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import pandas as pd

from masonry_opt.studies.compare.judge import CERTIFIED, FAILED, NAMED, WRONG
from masonry_opt.studies.compare.measure import MEMORY_LIMIT, TIME_LIMIT

#: Okabe & Ito (2008), in the order in which solvers appear; black last.
_COLOURS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9", "#000000")

#: By method: marker in matplotlib and in plotly.
_MARKERS = {
    "static": ("o", "circle"),
    "kinematic": ("s", "square"),
    "nonassociative": ("^", "triangle-up"),
    "mpec": ("D", "diamond"),
    "refined": ("*", "star"),
    "global": ("P", "cross"),
}

#: Letters of failures in pictures, and what they stand for.
LETTERS = {
    "T": "time limit",
    "M": "memory limit",
    "W": "wrong",
    "N": "no load factor, and the right reason why",
    "F": "failed but said so",
}

#: Colours of the verdicts (Okabe & Ito), and grey for no answer.
VERDICT_COLOURS = {CERTIFIED: "#009E73", NAMED: "#56B4E9", FAILED: "#BBBBBB", WRONG: "#D55E00"}


@dataclass(frozen=True)
class Look:
    """How a pair is drawn: ``filled`` for CVXPY, open for Pyomo."""

    colour: str
    marker: str
    symbol: str
    filled: bool
    dash: str


def looks(summary: pd.DataFrame) -> dict[str, Look]:
    """The look of every pair of a summary, by its label."""
    solvers: Sequence[str] = list(dict.fromkeys(summary["solver"]))
    found = {}
    for line in summary.drop_duplicates("pair").to_dict("records"):
        marker, symbol = _MARKERS[line["method"]]
        filled = line["model"] == "cvxpy"
        found[line["pair"]] = Look(
            _COLOURS[solvers.index(line["solver"]) % len(_COLOURS)],
            marker,
            symbol if filled else f"{symbol}-open",
            filled,
            "solid" if filled else "dash",
        )
    return found


def letter(line: Mapping[Any, Any]) -> str:
    """The letter of a row that is not certified."""
    if line["verdict"] == WRONG:
        return "W"
    if line["verdict"] == NAMED:
        return "N"
    if str(line["reason"]).startswith(TIME_LIMIT):
        return "T"
    return "M" if str(line["reason"]).startswith(MEMORY_LIMIT) else "F"

"""The answer of ``compare``: what was run, within which limits, and how it was judged."""

from __future__ import annotations

from dataclasses import dataclass, field

import pandas as pd

from masonry_opt.studies.compare.accuracy import CertifiedBounds
from masonry_opt.studies.compare.best_known import BestKnown
from masonry_opt.studies.compare.plan import CaseScene, RunPlan

#: Runs that take longer (seconds) are not repeated: their scatter is relatively small.
REPEATED_BELOW = 5.0


@dataclass(frozen=True)
class RunLimits:
    """Seconds and MB that a run may take, and how often it is repeated."""

    time: float = 60.0
    memory: float = 4000.0
    repeats: int = 3


@dataclass(frozen=True)
class Comparison:
    """Results of a comparison.

    Attributes
    ----------
    bounds: certified bounds of the associative load factor, by scene name.
    best: lowest exact Coulomb state known, by scene name.
    to_expect: load factor to expect, by scene name, where Coulomb methods are compared; None: there is none.
    results: one row a run (see :data:`~.runs.COLUMNS`).
    summary: one row a scene and pair (see :func:`~.frames.summary`), with the load factor to expect.
    notes: further remarks, a line each.
    interrupted: whether runs are missing.
    text: the report that ``print`` shows.
    """

    scenes: tuple[CaseScene, ...]
    plan: RunPlan
    limits: RunLimits
    bounds: dict[str, CertifiedBounds]
    best: dict[str, BestKnown]
    to_expect: dict[str, float | None]
    results: pd.DataFrame
    summary: pd.DataFrame
    notes: tuple[str, ...] = ()
    interrupted: bool = False
    text: str = field(default="", repr=False)

    def __str__(self) -> str:
        return self.text

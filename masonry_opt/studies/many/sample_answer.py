"""The answer of ``sample``: quantiles, probability of collapse and sensitivity."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import pandas as pd

from masonry_opt.answer.status import Status
from masonry_opt.errors import OptionError, counted, printable
from masonry_opt.studies.load_factor_axis import ends
from masonry_opt.studies.many.estimates import CONFIDENCE, fragility, quantiles, sensitivity
from masonry_opt.words.sentences import numeral

if TYPE_CHECKING:
    import altair

    from masonry_opt.studies.charts import NamedChart

#: Probabilities of the quantiles, unless others are asked for.
PROBABILITIES = (0.05, 0.5, 0.95)

#: Kinds of chart.
KINDS = ("distribution", "fragility", "sensitivity")

#: Most rank correlations that are printed.
_PRINTED = 5


@dataclass(frozen=True)
class Sample:
    """The load factors of a scene whose numbers were drawn.

    A scene that is proven to carry any load counts as collapsed at none. Any other run without a load factor
    (the scene falls by itself, or the run is ``undecided``: not converged, refused, unlimited without a
    proof, ...) counts as collapsed at any load, so that no probability of collapse is too low.

    Intervals are those of independent runs (``sequence="random"``), for any distribution. Sobol's points of
    few numbers are closer to the truth than the intervals show.

    Attributes
    ----------
    case: case file or title of the scene.
    table: one row a run: the numbers drawn, then the columns of ``mo.sweep``.
    drawn: names of the columns that were drawn.
    distributions: of each number, in words.
    """

    case: str
    table: pd.DataFrame = field(repr=False)
    drawn: tuple[str, ...] = field(repr=False)
    distributions: Mapping[str, str]

    @property
    def runs(self) -> int:
        """Number of scenes solved."""
        return len(self.table)

    @property
    def load_factors(self) -> np.ndarray:
        """Load factor of each run, shape (n,); -inf: collapsed at any load, inf: at none."""
        found = self.table["load_factor"].to_numpy(dtype=float)
        any_load = self.table["any_load"].fillna(False).to_numpy(dtype=bool)
        return np.where(np.isfinite(found), found, np.where(any_load, math.inf, -math.inf))

    @property
    def falling(self) -> int:
        """Runs whose scene falls by itself."""
        return int((self.table["status"] == str(Status.UNSTABLE)).sum())

    @property
    def unlimited(self) -> int:
        """Runs whose scene is proven to carry any load."""
        return int(np.isposinf(self.load_factors).sum())

    @property
    def undecided(self) -> int:
        """Runs that decide nothing, counted as collapsed at any load."""
        return int(np.isneginf(self.load_factors).sum()) - self.falling

    @property
    def counted(self) -> str:
        """How many runs there are, and how many of them have no load factor, in words."""
        without = {
            "fell under dead load alone": self.falling,
            "carried any load": self.unlimited,
            "undecided, counted as fallen": self.undecided,
        }
        told = [f"{count} ({count / self.runs:.1%}) {what}" for what, count in without.items() if count]
        return "; ".join([counted(self.runs, "run"), *told])

    def quantiles(
        self, probabilities: Sequence[float] = PROBABILITIES, confidence: float = CONFIDENCE
    ) -> pd.DataFrame:
        """Quantiles of the load factor (see :func:`~.estimates.quantiles`).

        Raises OptionError if a probability is not between 0 and 1.
        """
        shares = [_share("probabilities", value) for value in probabilities]
        return quantiles(self.load_factors, shares, _share("confidence", confidence))

    def fragility(self, loads: Sequence[float] | None = None, confidence: float = CONFIDENCE) -> pd.DataFrame:
        """Probability of collapse at load factors (see :func:`~.estimates.fragility`); by default at those
        found, and 5 % of their range to either side.

        Raises OptionError if the confidence is not between 0 and 1.
        """
        if loads is None:
            found = np.unique(self.load_factors[np.isfinite(self.load_factors)])
            least, greatest = ends(found)
            aside = 0.05 * (greatest - least) if len(found) else 0.0
            loads = [max(least - aside, 0.0), *found.tolist(), greatest + aside]
        return fragility(self.load_factors, loads, _share("confidence", confidence))

    def sensitivity(self, confidence: float = CONFIDENCE) -> pd.DataFrame:
        """Rank correlations with the numbers drawn (see :func:`~.estimates.sensitivity`).

        Raises OptionError if the confidence is not between 0 and 1.
        """
        return sensitivity(self.table[list(self.drawn)], self.load_factors, _share("confidence", confidence))

    def tables(self) -> dict[str, pd.DataFrame]:
        """Quantiles, fragility and sensitivity, by these names."""
        return {name: getattr(self, name)() for name in ("quantiles", "fragility", "sensitivity")}

    def plot(self, kind: str = "distribution") -> altair.TopLevelMixin:
        """Draw the "distribution" of the load factor, its "fragility" curve or the "sensitivity" to what was
        drawn, as a chart of Altair.

        Raises OptionError if there is no such kind, or Altair, of the extra "studies", is not installed.
        """
        if kind not in KINDS:
            raise OptionError(f"kind '{kind}' is unknown; choose from: {', '.join(KINDS)}")
        return self.drawing(kind).on_paper()

    def drawing(self, kind: str) -> NamedChart:
        """The chart of a kind. Raises OptionError if Altair is not installed."""
        # Charts are slow to import: only when they are needed.
        from masonry_opt.studies.many import sample_charts

        case = Path(self.case)
        # A scene made in Python has a title instead, which may have dots.
        name = case.stem if case.suffix in (".toml", ".json") else self.case
        title = f"{name}: {self.counted}"
        if kind == "distribution":
            return sample_charts.distribution(title, self.load_factors, self.quantiles())
        if kind == "fragility":
            return sample_charts.fragility(title, self.fragility())
        return sample_charts.sensitivity(title, self.sensitivity())

    def __str__(self) -> str:
        drawn = "; ".join(f"{name} = {text}" for name, text in self.distributions.items())
        lines = {"case": self.case, "drawn": drawn, "solved": self.counted}
        text = [f"{name:<16} {value}" for name, value in lines.items()]
        for row in self.quantiles().to_dict("records"):
            limits = f"({_worded(row['lower'])} to {_worded(row['upper'])} with {CONFIDENCE:.0%} confidence)"
            text.append(f"{row['probability']:<6.0%} of λ below {_worded(row['value'])} {limits}")
        for row in self.sensitivity().dropna().head(_PRINTED).to_dict("records"):
            r, low, high = (numeral(row[name], "+.3f") for name in ("rank_correlation", "lower", "upper"))
            text.append(f"rank correlation {r} with {row['parameter']} ({low} to {high})")
        return printable("\n".join(text))

    def as_dict(self) -> dict[str, Any]:
        """All but the single runs, as plain numbers, strings, lists and dictionaries (not finite: None)."""
        counts = {name: getattr(self, name) for name in ("runs", "falling", "unlimited", "undecided")}
        return (
            {"case": self.case, "distributions": dict(self.distributions)}
            | counts
            | {"confidence": CONFIDENCE}
            | {name: _records(frame) for name, frame in self.tables().items()}
        )

    def to_json(self) -> str:
        """``as_dict`` as one JSON object."""
        return json.dumps(self.as_dict(), allow_nan=False, ensure_ascii=False)


def _records(frame: pd.DataFrame) -> list[dict[Any, Any]]:
    finite = frame.replace([math.inf, -math.inf], math.nan).astype(object)
    return finite.where(finite.notna(), None).to_dict("records")


def _worded(value: float) -> str:
    if math.isfinite(value):
        return numeral(value, ".5f")
    return "unknown" if math.isnan(value) else "none" if value < 0 else "any load"


def _share(name: str, value: float) -> float:
    if not 0 < value < 1:
        raise OptionError(f"{name} must lie between 0 and 1 (found {value})")
    return value

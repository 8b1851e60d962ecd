"""The report of an example of the paper: published values beside ours, tables, figures, remarks."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from enum import StrEnum

import pandas as pd
from matplotlib.figure import Figure

from masonry_opt.answer.result import Result
from masonry_opt.scene.scene import Scene

ProgressLine = Callable[[str], None]

#: What the column of differences holds.
DIFFERENCE_NOTE = (
    "diff %: relative to the value before ours, or the nearer end of its interval; – where that is 0"
)


class Basis(StrEnum):
    """Where a value comes from that ours is held against; the heading of its column."""

    PUBLISHED = "published"
    BY_HAND = "derived by hand"
    COMPUTED = "computed apart"
    DEMANDED = "demanded"


#: How the sources of case files begin whose values were published nowhere.
_NOT_PUBLISHED = {"by hand": Basis.BY_HAND, "by an independent": Basis.COMPUTED}


@dataclass(frozen=True)
class PublishedValue:
    """A published value, or one known otherwise, beside ours.

    Attributes
    ----------
    what: what is compared, such as "wall 1, associative".
    published: the value, or the interval it lies in.
    computed: ours; None if there is none.
    source: where the value was published, or the closed form it comes from.
    basis: whether it was published at all.
    tolerance: relative difference that is no miss (absolute if the published value is 0); None if nothing is
        demanded.
    cause: why ours is likely to differ, where it does.
    may_be_lower: whether a lower value of ours is no miss (a lower Coulomb state than was known).
    """

    what: str
    published: float | tuple[float, float]
    computed: float | None
    source: str
    tolerance: float | None = None
    cause: str = ""
    may_be_lower: bool = False
    basis: Basis = Basis.PUBLISHED

    @property
    def difference(self) -> float:
        """Ours less the published value or the nearer end of its interval; NaN if there is none."""
        return or_nan(self.computed) - self._nearest

    @property
    def relative_difference(self) -> float:
        """The difference over the published value; NaN also where that is 0."""
        return self.difference / abs(self._nearest) if self._nearest else float("nan")

    @property
    def missed(self) -> bool:
        """Whether a tolerance is demanded and not met."""
        if self.tolerance is None or (self.may_be_lower and self.difference < 0):
            return False
        return not abs(self.difference) <= self.tolerance * (abs(self._nearest) or 1.0)

    @property
    def line(self) -> str:
        """The published value and ours in words."""
        scale, unit = (100.0, " %") if self._nearest else (1.0, "")
        ours, off = "no value", ""
        if self.computed is not None:
            ours = f"{self.computed:.7g}"
            off = f", off by {scale * self.difference / (abs(self._nearest) or 1.0):+.3g}{unit}"
        allowed = f" (tolerance {scale * self.tolerance:.2g}{unit})" if self.missed and self.tolerance else ""
        cause = f": {self.cause}" if self.cause else ""
        return f"{self.what}: {ours}, {self.basis} {self._published_text}{off}{allowed}{cause}"

    def as_row(self) -> dict[str, object]:
        """The row of a table of such values beside ours: a column a basis, a dash in all but its own."""
        return {
            "what": self.what,
            **{basis: self._published_text if basis is self.basis else "–" for basis in Basis},
            "ours": "–" if self.computed is None else f"{self.computed:.7g}",
            "diff %": 100 * self.relative_difference,
            "source": self.source,
        }

    @property
    def _ends(self) -> tuple[float, float]:
        return self.published if isinstance(self.published, tuple) else (self.published, self.published)

    @property
    def _nearest(self) -> float:
        """The published value, or what of its interval is nearest to ours."""
        low, high = self._ends
        return low if self.computed is None else min(max(self.computed, low), high)

    @property
    def _published_text(self) -> str:
        return " to ".join(f"{value:g}" for value in dict.fromkeys(self._ends))


@dataclass
class Report:
    """What an example yields.

    Attributes
    ----------
    published_values: published values, and others known, beside ours.
    tables: frames by file stem.
    figures: pictures by file stem.
    captions: what a table or figure shows, by file stem.
    remarks: plain sentences: what was found.
    differences: plain sentences: what does not come out, by how much, and why it may be so (beside
        the published values that miss or name a cause, which are listed by themselves).
    """

    published_values: list[PublishedValue] = field(default_factory=list)
    tables: dict[str, pd.DataFrame] = field(default_factory=dict)
    figures: dict[str, Figure] = field(default_factory=dict)
    captions: dict[str, str] = field(default_factory=dict)
    remarks: list[str] = field(default_factory=list)
    differences: list[str] = field(default_factory=list)

    @property
    def published_table(self) -> pd.DataFrame:
        """One row for each published value; no column for a basis that none has."""
        table = pd.DataFrame([value.as_row() for value in self.published_values])
        known = {value.basis for value in self.published_values}
        return table.drop(columns=[basis for basis in Basis if basis not in known], errors="ignore")

    @property
    def missed(self) -> list[str]:
        """One line for each value outside its tolerance."""
        return [value.line for value in self.published_values if value.missed]

    @property
    def all_differences(self) -> list[str]:
        """What does not come out: values that miss or name a cause, and the example's own differences."""
        named = [value.line for value in self.published_values if value.missed or value.cause]
        return [*named, *self.differences]


def published_value(
    scene: Scene, reference: str, computed: float | None, what: str, cause: str = ""
) -> PublishedValue:
    """The case file's reference of that name, beside ours."""
    known = scene.reference[reference]
    # One state of many, or the lowest that is known: a lower one is no miss.
    lower = reference in ("mcp", "refined")
    basis = next(
        (b for start, b in _NOT_PUBLISHED.items() if known.source.startswith(start)), Basis.PUBLISHED
    )
    return PublishedValue(what, known.value, computed, known.source, known.tolerance, cause, lower, basis)


def against_reference(
    scene: Scene, reference: str, result: Result, what: str, cause: str = ""
) -> PublishedValue:
    """The case file's reference of that name, beside the load factor of a result."""
    if result.load_factor is None:
        cause = f"{result.status}: {result.message}"
    return published_value(scene, reference, result.load_factor, f"{what}: {reference}", cause)


def reference_number(scene: Scene, reference: str) -> float:
    """The case file's reference of that name, as tables take it: NaN if there is none."""
    return scene.reference[reference].value if reference in scene.reference else float("nan")


def or_nan(value: float | None) -> float:
    """A number as tables and charts take it: NaN if there is none."""
    return float("nan") if value is None else value


def load_factor_text(result: Result) -> str:
    """The load factor as titles show it, or the status if there is none."""
    return str(result.status) if result.load_factor is None else f"λ = {result.load_factor:.5f}"

"""The legends of the page's charts: in its text, below each chart, where they cover nothing at any width."""

from __future__ import annotations

from dataclasses import dataclass

from masonry_opt.studies.compare.charts import MARKERS, Bars, Chart, Series

#: Outlines of the marks, some 10 across, about the origin.
_OUTLINES = dict(
    zip(
        MARKERS,
        (
            "M5 0A5 5 0 1 1-5 0A5 5 0 1 1 5 0Z",
            "M-4.5-4.5H4.5V4.5H-4.5Z",
            "M0-5L5.2 4H-5.2Z",
            "M0-6L6 0 0 6-6 0Z",
            "M0-6L1.5-2 5.7-1.9 2.4.8 3.5 4.9 0 2.5-3.5 4.9-2.4.8-5.7-1.9-1.5-2Z",
            "M-5-1.7H-1.7V-5H1.7V-1.7H5V1.7H1.7V5H-1.7V1.7H-5Z",
            "M0-5.5L4.8-2.7V2.7L0 5.5-4.8 2.7V-2.7Z",
            "M0 5L5.2-4H-5.2Z",
        ),
        strict=True,
    )
)


@dataclass(frozen=True)
class Entry:
    """A name and its look: the outline of its mark ("" for none), full or open, a line through it, broken."""

    name: str
    colour: str
    outline: str = ""
    filled: bool = True
    line: bool = False
    broken: bool = False


def legend(chart: Chart | Bars) -> list[Entry]:
    """One entry a name, in the order in which the names first come."""
    if isinstance(chart, Bars):
        return [Entry(name, colour, _OUTLINES["square"]) for name, colour, _ in chart.parts]
    named: dict[str, list[Series]] = {}
    for panel in chart.panels.values():
        for series in panel:
            if not series.letters:  # of a name whose marks come before them
                named.setdefault(series.name, []).append(series)
    return [_entry(name, of_one) for name, of_one in named.items()]


def _entry(name: str, series: list[Series]) -> Entry:
    first = series[0]
    line = any(one.line for one in series)
    outline = _OUTLINES[first.marker] if first.marker else ""
    return Entry(name, first.colour, outline, first.filled, line, line and not first.filled)

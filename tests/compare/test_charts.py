"""What charts hold, on made-up runs, and that both ways of drawing draw it."""

from __future__ import annotations

import pytest
from lines import line

from masonry_opt.studies.compare import draw_matplotlib, draw_plotly, frames
from masonry_opt.studies.compare.accuracy import CertifiedBounds
from masonry_opt.studies.compare.best_known import BestKnown
from masonry_opt.studies.compare.charts import Bars, Chart, charts
from masonry_opt.studies.palette import COLOURS

#: One scene: Clarabel at two tolerances in 1 s and 2 s; Pyomo with HiGHS certified, and killed after 60 s.
#: Then Coulomb states, above and below the best exact one of 0.8.
ROWS = [
    line(scene="a", tolerance=1e-4, wall=1.0, load_factor=1.00005),
    line(scene="a", tolerance=1e-8, wall=2.0, load_factor=1.0000001),
    line(scene="a", model="pyomo", solver="highs", wall=4.0, load_factor=1.0000002),
    line(scene="a", model="pyomo", solver="highs", wall=60.0, tolerance=1e-4, ended="time limit")
    | {"load_factor": None},
    line(scene="a", method="nonassociative", wall=3.0, load_factor=0.88),
    line(scene="a", method="refined", wall=5.0, load_factor=0.76),
]


@pytest.fixture(scope="module")
def drawn() -> dict[str, Chart | Bars]:
    bounds = {"a": CertifiedBounds(1 - 1e-12, 1 + 1e-12)}
    summary = frames.summary(ROWS, bounds, {"a": BestKnown(0.8, "refined")}, {})
    return {chart.name: chart for chart in charts(summary)}


def test_time_against_error(drawn):
    chart = drawn["time_error_associative"]
    clarabel, highs, killed, front = chart.panels["a"]
    assert [*clarabel.x] == [2.0, 1.0]  # from tight to loose
    assert [*clarabel.y] == pytest.approx([1e-7, 5e-5])
    assert (clarabel.colour, clarabel.marker, clarabel.filled) == (COLOURS[0], "circle", True)
    assert (highs.colour, highs.marker, highs.filled) == (COLOURS[1], "circle", False)
    assert ([*killed.x], [*killed.letters], killed.name) == ([60.0], ["T"], highs.name)
    assert all(chart.band < y < chart.y.limits[1] for y in killed.y)
    assert [*front.x] == [1.0, 2.0]
    assert chart.x.limits[0] < 1.0
    assert chart.x.limits[1] > 60.0


def test_a_state_below_the_best_is_marked(drawn):
    *_, below = drawn["time_error_coulomb"].panels["a"]
    assert ([*below.x], below.marker) == ([5.0], "triangle-down")


def test_what_is_drawn_at_a_floor_is_told(drawn):
    """The gap of 5 % of one scene is above it, and needs no word; the violation is zero."""
    gap, violation = drawn["time_error_coulomb"], drawn["time_violation_coulomb"]
    assert gap.notes == ""
    assert not any("≤" in text for text in gap.y.ticks.values())
    assert "1e-10" in violation.notes
    assert violation.y.ticks[1e-10] == "≤ 10⁻¹⁰"


def test_a_state_at_the_best_one_is_drawn_at_the_floor_of_gaps():
    rows = [
        line(scene="a", method="mcp", load_factor=0.8),
        line(scene="a", method="refined", load_factor=0.8008),
    ]
    summary = frames.summary(rows, {}, {"a": BestKnown(0.8, "refined")}, {})
    chart = next(chart for chart in charts(summary) if chart.name == "time_error_coulomb")
    heights = sorted(y for series in chart.panels["a"] if series.marker for y in series.y)
    assert heights == pytest.approx([1e-6, 1e-3])
    assert min(chart.y.ticks) == pytest.approx(1e-6)
    assert chart.y.ticks[min(chart.y.ticks)].startswith("≤")
    assert "1e-06" in chart.notes


def test_short_axes_have_few_ticks():
    rows = [line(scene="a", wall=10.0**power, tolerance=10.0**power) for power in range(-3, 4)]
    bars = charts(frames.summary(rows, {}, {}, {}))[0]
    assert 2 <= len(bars.time.ticks) <= 3


def test_counts_and_times_of_the_bars(drawn):
    bars = drawn["success"]
    counts = {name: counts for name, _, counts in bars.parts}
    assert counts["certified"] == [1, 1, 1, 0, 1, 1]
    assert counts["failed but said so"] == [0, 0, 0, 1, 0, 0]
    assert bars.times[1] == (2.0, 2.0, 2.0)


def test_both_drawings_hold_every_point(drawn):
    for chart in drawn.values():
        figure, picture = draw_plotly.draw(chart), draw_matplotlib.draw(chart)
        if isinstance(chart, Bars):
            assert [[*trace.x] for trace in figure.data[:-1]] == [counts for _, _, counts in chart.parts]
            continue
        series = chart.panels[next(iter(chart.panels))]
        for one, trace in zip(series, figure.data, strict=True):
            assert [*trace.y] == [*one.y]
        lines = picture.axes[0].lines
        assert sum(len(line.get_xdata()) for line in lines) == sum(len([*one.x]) for one in series)

"""What the charts of a sweep show."""

from __future__ import annotations

import numpy as np
import pandas as pd
import pytest
from drawn import legend

from masonry_opt.studies.chart_files import chart_files
from masonry_opt.studies.load_factor_axis import off_axis
from masonry_opt.studies.many.charts import against, heat_map, write_charts


def frame(mechanisms, load_factors):
    """A sweep over a friction, with these mechanisms and load factors."""
    friction = [0.1 * number for number in range(1, len(mechanisms) + 1)]
    status = ["optimal" if value == value else "unstable under dead load" for value in load_factors]
    return pd.DataFrame(
        {"joints.friction": friction, "load_factor": load_factors, "mechanism": mechanisms, "status": status}
    )


def test_mechanisms_are_named_where_they_change():
    swept = frame(["sliding"] * 3 + ["mixed"] + ["hinging"] * 3, [0.1, 0.2, 0.3, 0.35, 0.4, 0.4, 0.4])
    (axes,) = against(swept, ["joints.friction"]).axes
    assert [(text.get_text(), pytest.approx(text.get_position()[0])) for text in axes.texts] == [
        ("sliding", 0.225),
        ("mixed", 0.4),
        ("hinging", 0.575),
    ]
    drawn = {line.get_label(): line.get_xydata() for line in axes.lines}
    assert drawn["hinging"].tolist() == swept[["joints.friction", "load_factor"]][4:].to_numpy().tolist()


def test_runs_without_a_load_factor_are_marked():
    swept = frame(["sliding", "sliding", "sliding"], [np.nan, 0.2, 0.3])
    figure = against(swept, ["joints.friction"])
    (axes,) = figure.axes
    (failed,) = (line for line in axes.lines if "unstable" in str(line.get_label()))
    assert failed.get_xdata().tolist() == [0.1]
    assert len(figure.legends) == 1
    # All of them: there is still a chart.
    assert against(swept[:1], ["joints.friction"]).axes


def test_a_load_factor_that_does_not_change_is_not_drawn_as_if_it_did():
    swept = frame(["hinging"] * 4, [0.25, 0.25 + 1e-10, 0.25 - 1e-10, np.nan])
    (axes,) = against(swept, ["joints.friction"]).axes
    low, high = axes.get_ylim()
    assert 0.005 <= high - low <= 0.01
    assert low < 0.25 - 1e-10
    assert high > 0.25 + 1e-10
    falls = frame([None], [np.nan])
    (axes,) = against(falls, ["joints.friction"]).axes
    assert len(axes.get_yticks()) == 0
    swept = swept.assign(b=[1.0, 1.0, 2.0, 2.0], a=[1.0, 2.0] * 2)
    (cells,) = heat_map(swept, "a", "b").axes[0].collections
    assert cells.norm.vmax - cells.norm.vmin == pytest.approx(0.005, abs=1e-8)


@pytest.mark.parametrize("statuses", [1, 2, 4])
def test_crosses_lie_below_all_values_on_a_strip_without_numbers(statuses):
    swept = frame(["sliding"] * 6, [0.1, 0.4] + [np.nan] * 4)
    swept.loc[2:, "status"] = [f"status {number % statuses}" for number in range(4)]
    figure = against(swept, ["joints.friction"])
    (axes,) = figure.axes
    top = axes.patches[0].get_height()
    crosses = [line.get_ydata()[0] for line in axes.lines if "no load factor" in str(line.get_label())]
    assert len(crosses) == statuses
    assert max(crosses) < top
    low, high = axes.get_ylim()
    assert (0.1 - low) / (high - low) > top
    assert (axes.get_yticks() > low + top * (high - low)).all()


def test_a_heat_map_has_a_cell_for_each_run():
    load_factors = [1.0, 2.0, 3.0, np.nan]
    swept = pd.DataFrame({"a": [1.0, 1.0, 2.0, 2.0], "b": [1.0, 3.0] * 2, "load_factor": load_factors})
    figure = heat_map(swept, "a", "b")
    axes = figure.axes[0]
    (cells,) = axes.collections
    assert cells.get_array().filled(-1).tolist() == [[1, 3], [2, -1]]
    assert (cells.norm.vmin, cells.norm.vmax) == (1, 3)
    assert len(legend(figure)) == 2  # the least, and what grey means
    assert len(legend(heat_map(swept.fillna(4), "a", "b"))) == 1
    # A ring in the cell of the least.
    assert [line.get_xydata().tolist() for line in axes.lines] == [[[1.0, 1.0]]]
    assert axes.get_xlim() == (0.5, 2.5)
    assert axes.get_ylim() == (0, 4)


#: Load factors of a sweep, and which of them its axis leaves out.
OFF = {
    "one a hundred times the others": ([0.2, 0.3, 25.0, 0.25, 0.4], [2]),
    "two of eight": ([0.2, 0.3, 25.0, 0.25, 0.4, 0.3, 80.0, 0.3], [2, 6]),
    "of three": ([0.25, 0.25, 30.0], [2]),
    "growing steadily": ([0.1, 0.4, 1.0, 2.5, 6.0, 15.0], []),
    "most of them large": ([0.2, 30.0, 25.0, 28.0, 0.3], []),
    "below": ([-25.0, 0.2, 0.3, 0.2], []),
    "zero but for rounding": ([1e-13, 2e-13, 0.0, 0.5], []),
    "two values": ([0.2, 30.0], []),
    "among runs without any": ([0.2, np.nan, 0.3, 30.0], [3]),
    "none": ([np.nan, np.nan, np.nan], []),
}


@pytest.mark.parametrize("kind", OFF)
def test_what_would_press_the_others_together_is_left_off_the_axis(kind):
    values, off = OFF[kind]
    assert np.flatnonzero(off_axis(values)).tolist() == off


def test_a_value_off_the_axis_stands_at_its_head():
    swept = frame(["sliding"] * 6, [0.2, 0.3, 25.0, 0.25, np.nan, 0.4])
    figure = against(swept, ["joints.friction"])
    (axes,) = figure.axes
    low, high = axes.get_ylim()
    # The others take most of the height, below the strip and above that of the crosses.
    assert (0.4 - 0.2) / (high - low) > 0.7
    (foot, head) = sorted(axes.patches, key=lambda strip: strip.get_y())
    assert low + foot.get_height() * (high - low) < 0.2
    assert low + head.get_y() * (high - low) > 0.4
    assert axes.get_yticks().max() < low + head.get_y() * (high - low)
    (mark,) = (line for line in axes.lines if "axis" in str(line.get_label()))
    assert mark.get_xdata().tolist() == [pytest.approx(0.3)]
    assert head.get_y() < mark.get_ydata()[0] < 1
    assert [(text.get_text(), text.get_position()[0]) for text in axes.texts] == [("25", pytest.approx(0.3))]
    assert len([text for text in legend(figure) if "axis" in text]) == 1


def test_a_value_above_the_scale_of_a_map_stands_in_its_cell():
    values = [0.2, 0.3, 25.0, 0.25, 0.3, 0.4]
    swept = pd.DataFrame(
        {"a": [1.0, 1.0, 1.0, 2.0, 2.0, 2.0], "b": [1.0, 2.0, 3.0] * 2, "load_factor": values}
    )
    figure = heat_map(swept, "a", "b")
    (cells,) = figure.axes[0].collections
    assert (cells.norm.vmin, cells.norm.vmax) == (0.2, 0.4)
    assert [(text.get_text(), text.get_position()) for text in figure.axes[0].texts] == [("25", (1, 3))]
    assert len(legend(figure)) == 2


def test_the_least_is_ringed_and_all_of_a_plateau():
    for values, least in (
        ([0.3, 0.2, 0.25], [[0.2]]),
        ([0.2, 0.3, 0.2 + 1e-12], [[0.1, 0.3]]),
        ([0.2] * 3, []),
    ):
        (axes,) = against(frame(["sliding"] * 3, values), ["joints.friction"]).axes
        rings = [line.get_xdata().tolist() for line in axes.lines if line.get_label() == "least"]
        assert rings == [pytest.approx(at) for at in least]


@pytest.mark.parametrize("friction", [0.5, np.inf])
def test_a_map_is_drawn_of_finite_values_alone(friction, tmp_path):
    names = ["joints.friction", "arch.thickness"]
    swept = pd.DataFrame([(0.3, 1.0), (0.3, 2.0), (friction, 1.0), (friction, 2.0)], columns=names)
    swept = swept.assign(load_factor=1.0, status="optimal", mechanism="sliding")
    drawn = {path.stem for path in write_charts(swept, names, tmp_path)}
    assert drawn == {"load_factor"} | ({"heat_map"} if friction < np.inf else set())


def test_files_are_the_same_from_run_to_run():
    swept = frame(["sliding", "hinging"], [0.1, 0.2])
    one, other = (chart_files(against(swept, ["joints.friction"]), "chart") for _ in range(2))
    assert list(one) == ["chart.png", "chart.svg"]
    assert one == other
    assert b"<dc:date>" not in one["chart.svg"]

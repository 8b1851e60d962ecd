"""What the charts of a sweep show."""

from __future__ import annotations

import numpy as np
import pandas as pd
import pytest

from masonry_opt.studies.chart_files import chart_files
from masonry_opt.studies.many.charts import against, heat_map


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


def test_a_heat_map_has_a_cell_for_each_run():
    load_factors = [1.0, 2.0, 3.0, np.nan]
    swept = pd.DataFrame({"a": [1.0, 1.0, 2.0, 2.0], "b": [1.0, 3.0] * 2, "load_factor": load_factors})
    axes = heat_map(swept, "a", "b").axes[0]
    (cells,) = axes.collections
    assert cells.get_array().filled(-1).tolist() == [[1, 3], [2, -1]]
    assert axes.get_xlim() == (0.5, 2.5)
    assert axes.get_ylim() == (0, 4)


def test_files_are_the_same_from_run_to_run():
    swept = frame(["sliding", "hinging"], [0.1, 0.2])
    one, other = (chart_files(against(swept, ["joints.friction"]), "chart") for _ in range(2))
    assert list(one) == ["chart.png", "chart.svg"]
    assert one == other
    assert b"<dc:date>" not in one["chart.svg"]

"""What the charts of a comparison hold, on made-up runs, and that pictures show every point of it."""

import pytest
from lines import line

from masonry_opt.drawing.colours import SERIES
from masonry_opt.studies.charts import NamedChart, pictures
from masonry_opt.studies.compare import frames
from masonry_opt.studies.compare.accuracy import CertifiedBounds
from masonry_opt.studies.compare.charts import charts
from masonry_opt.studies.compare.judge import BestKnown

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
def drawn() -> dict[str, NamedChart]:
    bounds = {"a": CertifiedBounds(1 - 1e-12, 1 + 1e-12)}
    summary = frames.summary(ROWS, bounds, {"a": BestKnown(0.8, "refined")}, {})
    return {drawing.name: drawing for drawing in charts(summary)}


def encodings(drawing, channel):
    """What each layer of a drawing says of a channel by which it places or codes a column."""
    found = (layer["encoding"].get(channel, {}) for layer in drawing.on_page()["layer"])
    return [encoding for encoding in found if "scale" in encoding]


def looks(drawing, channel):
    """What is told apart by a channel, and how."""
    (scale,) = (of["scale"] for of in encodings(drawing, channel) if of["scale"])
    return dict(zip(scale["domain"], scale["range"], strict=True))


def ticks(drawing, channel):
    return encodings(drawing, channel)[0]["axis"]["values"]


def test_time_against_error(drawn):
    drawing = drawn["time_error_associative"]
    marks = drawing.chart.data
    assert marks["time"].tolist() == [1.0, 2.0, 4.0, 60.0]
    assert marks["height"].tolist()[:3] == pytest.approx([5e-5, 1e-7, 2e-7])
    assert marks["letter"].tolist() == ["", "", "", "T"]
    assert marks["front"].tolist() == [True, True, False, False]
    least, top = encodings(drawing, "y")[0]["scale"]["domain"]
    assert least < 1e-7
    assert 5e-5 < marks["height"].iloc[3] < top
    low, high = encodings(drawing, "x")[0]["scale"]["domain"]
    assert low < 1.0
    assert high > 60.0
    assert looks(drawing, "color") == {"cvxpy · clarabel": SERIES[0], "pyomo · highs": SERIES[1]}
    assert marks["colour"].tolist() == [SERIES[0], SERIES[0], SERIES[1], SERIES[1]]


def test_a_state_below_the_best_is_marked(drawn):
    marks = drawn["time_error_coulomb"].chart.data
    assert marks["time"][marks["below"]].tolist() == [5.0]
    assert marks["method"].nunique() == 2


def test_what_is_drawn_at_a_floor_is_told(drawn):
    """The gap of 5 % of one scene is above it, and needs no word."""
    gap = drawn["time_error_coulomb"]
    assert "drawn there" not in gap.notes


def test_without_a_yardstick_there_is_no_chart_of_accuracy():
    """None of a question of which no scene has one, and no panel of a scene that has none."""
    rows = [line(scene=scene, method="mcp", load_factor=0.8) for scene in "ab"]
    assert charts(frames.summary(rows, {}, {}, {})) == []
    (drawing,) = charts(frames.summary(rows, {}, {"a": BestKnown(0.8, "refined")}, {}))
    assert {*drawing.chart.data["scene"]} == {"a"}


def test_a_state_at_the_best_one_is_drawn_at_the_floor_of_gaps():
    rows = [
        line(scene="a", method="mcp", load_factor=0.8),
        line(scene="a", method="refined", load_factor=0.8008),
    ]
    summary = frames.summary(rows, {}, {"a": BestKnown(0.8, "refined")}, {})
    drawing = next(drawing for drawing in charts(summary) if drawing.name == "time_error_coulomb")
    assert sorted(drawing.chart.data["height"]) == pytest.approx([1e-6, 1e-3])
    assert min(ticks(drawing, "y")) == pytest.approx(1e-6)
    assert "1e-06" in drawing.notes


def test_pictures_hold_every_point_and_are_the_same_from_run_to_run(drawn):
    names = ("time_error_associative", "time_error_coulomb")
    files = pictures(drawn[name] for name in names)
    assert set(files) == {f"{name}.{kind}" for name in names for kind in ("png", "svg")}
    for name in names:
        marks = drawn[name].chart.data
        points = int((marks["letter"] == "").sum() + marks["below"].sum())
        assert files[f"{name}.svg"].count('aria-roledescription="point"') == points
    assert pictures([drawn[names[0]]]).items() <= files.items()

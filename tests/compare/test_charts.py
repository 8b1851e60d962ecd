"""Charts and the page of a comparison: their points, load factors, reasons and order."""

from dataclasses import replace

import pytest
from comparisons import BLOCKS, WALL, made_up
from lines import line
from scenes_in_space import pushed_box

import masonry_opt as mo
from masonry_opt.drawing.colours import SERIES
from masonry_opt.studies.charts import NamedChart, pictures
from masonry_opt.studies.compare.accuracy import CertifiedBounds
from masonry_opt.studies.compare.judge import BestKnown, Comparison, answers
from masonry_opt.studies.compare.judge import summary as summary_of
from masonry_opt.studies.compare.page import charts, load_factors, page

#: Runs of one scene: Clarabel at two tolerances in 1 s and 2 s, and Pyomo with HiGHS, certified or stopped
#: after 60 s. Two Coulomb states follow, above and below the best exact state at 0.8.
ROWS = [
    line(scene="a", tolerance=1e-4, wall=1.0, load_factor=1.00005),
    line(scene="a", tolerance=1e-8, wall=2.0, load_factor=1.0000001),
    line(scene="a", model="pyomo", solver="highs", wall=4.0, load_factor=1.0000002),
    line(scene="a", model="pyomo", solver="highs", wall=60.0, tolerance=1e-4, ended="time limit")
    | {"load_factor": None},
    line(scene="a", method="nonassociative", wall=3.0, load_factor=0.88),
    line(scene="a", method="coulomb", model="matrices", solver="newton", wall=5.0, load_factor=0.76),
]


@pytest.fixture(scope="module")
def drawn() -> dict[str, NamedChart]:
    bounds = {"a": CertifiedBounds(1 - 1e-12, 1 + 1e-12)}
    summary = summary_of(ROWS, bounds, {"a": BestKnown(0.8, "coulomb")})
    return {drawing.name: drawing for drawing in charts(summary)}


def encodings(drawing, channel):
    """Return the encodings of a channel, in all layers of a drawing, that have a scale."""
    found = (layer["encoding"].get(channel, {}) for layer in drawing.on_page()["layer"])
    return [encoding for encoding in found if "scale" in encoding]


@pytest.mark.slow
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
    (scale,) = (of["scale"] for of in encodings(drawing, "color") if of["scale"])
    assert dict(zip(scale["domain"], scale["range"], strict=True)) == {
        "cvxpy · clarabel": SERIES[0],
        "pyomo · highs": SERIES[1],
    }
    assert marks["colour"].tolist() == [SERIES[0], SERIES[0], SERIES[1], SERIES[1]]


def test_a_state_below_the_best_is_marked(drawn):
    """A Coulomb state below the best exact state is marked as below.

    Its gap of 5 % is above the smallest drawn gap, so that no note on this gap appears.
    """
    marks = drawn["time_error_coulomb"].chart.data
    assert marks["time"][marks["below"]].tolist() == [5.0]
    assert marks["method"].nunique() == 2
    assert "count as zero" not in drawn["time_error_coulomb"].notes


def test_without_a_yardstick_there_is_no_chart_of_accuracy():
    """Without a reference value there is no chart, and a scene without one has no panel."""
    rows = [line(scene=scene, method="coulomb", load_factor=0.8) for scene in "ab"]
    assert charts(summary_of(rows, {}, {})) == []
    (drawing,) = charts(summary_of(rows, {}, {"a": BestKnown(0.8, "coulomb")}))
    assert {*drawing.chart.data["scene"]} == {"a"}


def test_a_state_at_the_best_one_is_drawn_at_the_floor_of_gaps():
    rows = [
        line(scene="a", method="mpec", load_factor=0.8),
        line(scene="a", method="coulomb", load_factor=0.8008),
    ]
    summary = summary_of(rows, {}, {"a": BestKnown(0.8, "mpec")})
    drawing = next(drawing for drawing in charts(summary) if drawing.name == "time_error_coulomb")
    assert sorted(drawing.chart.data["height"]) == pytest.approx([1e-6, 1e-3])
    assert min(encodings(drawing, "y")[0]["axis"]["values"]) == pytest.approx(1e-6)
    assert "relative gaps below 1e-06 count as zero" in drawing.notes


@pytest.mark.slow
def test_pictures_hold_every_point_and_are_the_same_from_run_to_run(drawn):
    names = ("time_error_associative", "time_error_coulomb")
    files = pictures(drawn[name] for name in names)
    assert set(files) == {f"{name}.{kind}" for name in names for kind in ("png", "svg")}
    for name in names:
        marks = drawn[name].chart.data
        points = int((marks["letter"] == "").sum() + marks["below"].sum())
        assert files[f"{name}.svg"].count('aria-roledescription="point"') == points
    assert pictures([drawn[names[0]]]).items() <= files.items()


@pytest.fixture(scope="module")
def comparison() -> Comparison:
    return made_up()


def cells(comparison: Comparison) -> dict[tuple[str, str], str]:
    """Return the cells of the table of load factors, by scene and column."""
    shown = load_factors(comparison)
    return {
        (row[0], column): cell
        for row in shown["rows"]
        for column, cell in zip(shown["columns"], row, strict=True)
    }


def test_load_factors_are_those_of_the_frames(comparison):
    shown = cells(comparison)
    known = comparison.summary[comparison.summary["verdict"] == "certified"]
    lowest = known.groupby(["scene", "method"])["load_factor"].min()
    assert {method for _, method in lowest.index} == {"static", "nonassociative", "coulomb"}
    for (scene, method), load_factor in lowest.items():
        question = "associative" if method == "static" else "Coulomb"
        said, _, _ = shown[scene, f"{question} λ, {method}"].partition(";")
        assert float(said) == pytest.approx(load_factor, rel=5e-5)
    assert shown[BLOCKS, "lowest exact Coulomb λ"] == "0.15000, by hand"
    # The load factor 0.153 is 2 % above 0.15; Clarabel took 2.5 s.
    assert shown[BLOCKS, "Coulomb λ, nonassociative"] == "0.15300; gap +2 %; 2.5 s"
    assert shown[BLOCKS, "Coulomb λ, coulomb"] == "0.15000; gap 0 %; 0.5 s"


def test_what_is_no_answer_says_why(comparison):
    shown = cells(comparison)
    verdicts = {
        (BLOCKS, "mpec"): ("wrong", "flow"),
        (WALL, "nonassociative"): ("reported failure", "time limit"),
        (WALL, "coulomb"): ("named correctly", "unstable under dead load"),
        (WALL, "mpec"): ("wrong", "0.63898"),
    }
    for (scene, method), (verdict, word) in verdicts.items():
        cell = shown[scene, f"Coulomb λ, {method}"]
        assert cell.startswith(f"{verdict}: ")
        assert word in cell
        assert len(cell) < 120  # the message that explains the status is not repeated here


def test_without_an_associative_method_the_bounds_tell(comparison):
    plan = comparison.plan
    coulomb = tuple(pair for pair in plan.pairs if pair.method == "coulomb")
    part = comparison.summary[comparison.summary["method"] == "coulomb"]
    fewer = replace(comparison, plan=replace(plan, pairs=coulomb), summary=part)
    assert cells(fewer)[WALL, "associative λ, certified"] == "0.64286"


def test_answers_of_repeated_solvers():
    """The page shows one run of each method: certified if possible, then the lowest λ, then the fastest."""
    kept = answers(made_up().summary).set_index(["scene", "method"])
    assert kept.loc[(BLOCKS, "nonassociative"), "solver"] == "clarabel"
    assert kept.loc[(BLOCKS, "static"), "time"] == 1.5
    summary = made_up().summary
    first = (summary["scene"] == BLOCKS) & (summary["method"] == "nonassociative")
    summary.loc[summary.index[first][0], "verdict"] = "wrong"
    kept = answers(summary).set_index(["scene", "method"])
    assert kept.loc[(BLOCKS, "nonassociative"), "solver"] == "highs"
    assert kept.loc[(BLOCKS, "nonassociative"), "error"] == pytest.approx(0.0404)


def test_the_page_opens_with_the_table_and_ends_with_definitions(comparison):
    html = page(comparison, [])
    first = html.index("<table")
    assert html[first:].startswith('<table id="answers"')
    assert first < html.index("<dl>")
    assert html.index("<h2") < first < html.index("<h2", html.index("<h2") + 1)
    assert html.index('id="about"') < html.index('id="words"')
    assert "0.63898" in html[first : html.index("</table>", first)]
    assert 'href="#words"' in html


@pytest.mark.slow
def test_a_scene_in_space_has_numbers(tmp_path):
    """Certified bounds of a box that slides in space are closer than 1e-8, at λ = μ = 0.5."""
    case = tmp_path / "slides.toml"
    mo.save(pushed_box((2.0, 2.0, 1.0), 0.5, 7.5), case)
    found = mo.compare([case], methods=["static"], solvers=["clarabel"], repeats=1, out=tmp_path)
    (bounds,) = found.bounds.values()
    assert bounds.middle == pytest.approx(0.5, rel=1e-8)
    assert bounds.width < 1e-8
    (row,) = load_factors(found)["rows"]
    assert "nan" not in " ".join(row)
    assert row[0] in page(found, [])

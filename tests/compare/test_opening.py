"""What the comparison's page opens with: the frames' numbers and reasons; the order of its parts."""

from dataclasses import replace

import pytest
from comparisons import BLOCKS, WALL, made_up
from scenes_in_space import pushed_box

import masonry_opt as mo
from masonry_opt.studies.compare import frames
from masonry_opt.studies.compare.frames import Comparison
from masonry_opt.studies.compare.page import load_factors, page


@pytest.fixture(scope="module")
def comparison() -> Comparison:
    return made_up()


def cells(comparison: Comparison) -> dict[tuple[str, str], str]:
    """By scene and column."""
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
    assert {method for _, method in lowest.index} == {"static", "nonassociative", "mcp"}
    for (scene, method), load_factor in lowest.items():
        question = "associative" if method == "static" else "Coulomb"
        said, _, _ = shown[scene, f"{question} λ, {method}"].partition(";")
        assert float(said) == pytest.approx(load_factor, rel=5e-5)
    assert shown[BLOCKS, "lowest exact Coulomb λ"] == "0.15000, by hand"


def test_gap_and_time_stand_beside(comparison):
    """0.153 is 2 % above 0.15, in Clarabel's 2.5 s."""
    shown = cells(comparison)
    assert shown[BLOCKS, "Coulomb λ, nonassociative"] == "0.15300; gap +2 %; 2.5 s"
    assert shown[BLOCKS, "Coulomb λ, mcp"] == "0.15000; gap 0 %; 0.5 s"


def test_what_is_no_answer_says_why(comparison):
    shown = cells(comparison)
    verdicts = {
        (BLOCKS, "refined"): ("wrong", "flow"),
        (WALL, "nonassociative"): ("failed but said so", "time limit"),
        (WALL, "mcp"): ("named correctly", "unstable under dead load"),
        (WALL, "refined"): ("wrong", "0.63898"),
    }
    for (scene, method), (verdict, word) in verdicts.items():
        cell = shown[scene, f"Coulomb λ, {method}"]
        assert cell.startswith(f"{verdict}: ")
        assert word in cell
        assert len(cell) < 120  # the message that explains the status is not repeated here


def test_without_an_associative_method_the_bounds_tell(comparison):
    plan = comparison.plan
    coulomb = tuple(pair for pair in plan.pairs if pair.method == "mcp")
    part = comparison.summary[comparison.summary["method"] == "mcp"]
    fewer = replace(comparison, plan=replace(plan, pairs=coulomb), summary=part)
    assert cells(fewer)[WALL, "associative λ, certified"] == "0.64286"


def test_answers_of_repeated_solvers():
    """Of two certified Coulomb runs the lower; of two alike the quicker; any certified before any other."""
    kept = frames.answers(made_up().summary).set_index(["scene", "method"])
    assert kept.loc[(BLOCKS, "nonassociative"), "solver"] == "clarabel"
    assert kept.loc[(BLOCKS, "static"), "time"] == 1.5
    summary = made_up().summary
    first = (summary["scene"] == BLOCKS) & (summary["method"] == "nonassociative")
    summary.loc[summary.index[first][0], "verdict"] = "wrong"
    kept = frames.answers(summary).set_index(["scene", "method"])
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


def test_a_scene_in_space_has_numbers(tmp_path):
    """A box slides at friction, which feasible points of the cone say from both sides."""
    case = tmp_path / "slides.toml"
    mo.save(pushed_box((2.0, 2.0, 1.0), 0.5, 7.5), case)
    found = mo.compare([case], methods=["static"], solvers=["clarabel"], repeats=1, out=tmp_path)
    (bounds,) = found.bounds.values()
    assert bounds.middle == pytest.approx(0.5, rel=1e-8)
    assert bounds.width < 1e-8
    (row,) = load_factors(found)["rows"]
    assert "nan" not in " ".join(row)
    assert row[0] in page(found, [])

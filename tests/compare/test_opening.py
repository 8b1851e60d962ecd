"""What the comparison's page opens with: the frames' numbers, reasons, pictures; the order of its parts."""

from __future__ import annotations

import re
from dataclasses import replace

import pytest
from comparisons import BLOCKS, NAMES, WALL, made_up
from scenes import CASES
from scenes_in_space import pushed_box

import masonry_opt as mo
from masonry_opt.studies.compare import frames
from masonry_opt.studies.compare.frames import Comparison
from masonry_opt.studies.compare.page import TableCell, opening, page


@pytest.fixture(scope="module")
def comparison() -> Comparison:
    return made_up()


def cells(comparison: Comparison) -> dict[tuple[str, str], TableCell]:
    """By scene and column."""
    columns, rows = opening(comparison)
    return {
        (row.scene, column): cell for row in rows for column, cell in zip(columns, row.cells, strict=True)
    }


def test_load_factors_are_those_of_the_frames(comparison):
    shown = cells(comparison)
    known = comparison.summary[comparison.summary["verdict"] == "certified"]
    lowest = known.groupby(["scene", "method"])["load_factor"].min()
    assert {method for _, method in lowest.index} == {"static", "nonassociative", "mcp"}
    for (scene, method), load_factor in lowest.items():
        question = "associative" if method == "static" else "Coulomb"
        assert float(shown[scene, f"{question} λ, {method}"].value) == pytest.approx(load_factor, rel=5e-5)
    assert shown[BLOCKS, "lowest Coulomb λ known"] == TableCell("0.15000", ("by hand",))
    assert shown[BLOCKS, "b × c"].value == "50 × 100"
    assert [shown[scene, "λ to expect"].value for scene in (BLOCKS, WALL)] == ["–", "0.64154"]


def test_gap_and_time_stand_below(comparison):
    """0.153 is 2 % above 0.15, in Clarabel's 2.5 s."""
    shown = cells(comparison)
    assert shown[BLOCKS, "Coulomb λ, nonassociative"].notes == ("gap +2 %", "2.5 s")
    assert shown[BLOCKS, "Coulomb λ, mcp"].notes == ("gap 0 %", "0.5 s")


def test_what_is_no_answer_says_why(comparison):
    shown = cells(comparison)
    looks = {
        (BLOCKS, "refined"): ("wrong", "flow"),
        (WALL, "nonassociative"): ("failed", "time limit"),
        (WALL, "mcp"): ("named", "unstable under dead load"),
        (WALL, "refined"): ("wrong", "0.63898"),
    }
    for (scene, method), (look, word) in looks.items():
        cell = shown[scene, f"Coulomb λ, {method}"]
        assert cell.look == look
        assert word in cell.notes[0]
        assert len(cell.notes[0]) < 100  # the message that explains the status is not repeated here
        assert not re.fullmatch(r"[\d.]+", cell.value)


def test_without_an_associative_method_the_bounds_tell(comparison):
    plan = comparison.plan
    coulomb = tuple(pair for pair in plan.pairs if pair.method == "mcp")
    part = comparison.summary[comparison.summary["method"] == "mcp"]
    fewer = replace(comparison, plan=replace(plan, pairs=coulomb), summary=part)
    assert cells(fewer)[WALL, "associative λ, certified"].value == "0.64286"


def test_answers_of_repeated_solvers():
    """Of two certified Coulomb runs the lower; of two alike the quicker; any certified before any other."""
    kept = frames.answers(made_up().summary).set_index(["scene", "method"])
    assert kept.loc[(BLOCKS, "nonassociative"), "solver"] == "clarabel"
    assert kept.loc[(BLOCKS, "static"), "time"] == 1.5
    assert kept.loc[(BLOCKS, "static"), ["runs", "alike"]].tolist() == [2, 2]
    summary = made_up().summary
    first = (summary["scene"] == BLOCKS) & (summary["method"] == "nonassociative")
    summary.loc[summary.index[first][0], "verdict"] = "wrong"
    kept = frames.answers(summary).set_index(["scene", "method"])
    assert kept.loc[(BLOCKS, "nonassociative"), "solver"] == "highs"
    assert kept.loc[(BLOCKS, "nonassociative"), ["runs", "alike"]].tolist() == [2, 1]
    assert kept.loc[(BLOCKS, "nonassociative"), "gap"] == pytest.approx(0.0404)


def test_the_page_opens_with_the_table_and_ends_with_definitions(comparison):
    html = page(comparison, [])
    first = html.index("<table")
    assert html[first:].startswith('<table id="answers"')
    assert first < html.index("<dl>")
    assert html.index("<h2") < first < html.index("<h2", html.index("<h2") + 1)
    assert html.index('id="about"') < html.index('id="words"')
    opening_rows = html[first : html.index("</table>", first)]
    assert opening_rows.count("<svg") == len(NAMES)
    assert ">0.63898</b>" in opening_rows
    assert 'href="#words"' in html


def test_a_row_has_a_picture_of_its_scene(comparison):
    """Two blocks and their two supports; of a façade of thousands there is none."""
    first, _ = opening(comparison)[1]
    blocks, fixed = first.picture.split('class="fixed"')
    assert (blocks.count("<path"), fixed.split("</g>")[0].count("<path")) == (2, 2)
    facade = replace(comparison.scenes[0], path=CASES / "gilbert" / "facade_4x12.toml")
    assert opening(replace(comparison, scenes=(facade,)))[1][0].picture == ""


def test_a_scene_whose_file_is_gone_has_no_picture(tmp_path, comparison):
    scene, other = comparison.scenes
    lost = replace(comparison, scenes=(replace(scene, path=tmp_path / "gone.toml"), other))
    first, second = opening(lost)[1]
    assert first.picture == ""
    assert page(lost, []).count('class="blocks"') == second.picture.count('class="blocks"') == 1


def test_a_scene_in_space_has_numbers_and_no_picture(tmp_path):
    """A box slides at friction, which feasible points of the cone say from both sides."""
    mo.save(pushed_box((2.0, 2.0, 1.0), 0.5, 7.5), tmp_path / "slides.toml")
    found = mo.compare([tmp_path / "slides.toml"], methods=["static"], solvers=["clarabel"], repeats=1)
    (bounds,) = found.bounds.values()
    assert bounds.middle == pytest.approx(0.5, rel=1e-8)
    assert bounds.width < 1e-8
    (row,) = opening(found)[1]
    assert row.picture == ""
    assert "nan" not in {cell.value for cell in row.cells}
    assert row.scene in page(found, [])

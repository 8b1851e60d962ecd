"""Tests of what notebooks show of scenes and of studies: words, tables, and pictures without files."""

import re
from base64 import b64decode

import numpy as np
import pandas as pd
import pytest
from loads.overhang import OVERHANG, axles, slab, support
from scenes import CASES, small_wall, two_blocks

import masonry_opt as mo
from masonry_opt.studies.writing import notebook_html


def pictures(html):
    """Return the content of the images in HTML, by media type."""
    found = re.findall(r'src="data:image/([^;]+);base64,([^"]*)"', html)
    return {kind: b64decode(content) for kind, content in found}


@pytest.mark.slow
@pytest.mark.parametrize("scene", [two_blocks(), mo.extrude(two_blocks(), 1.0)], ids=["plane", "space"])
def test_a_scene_shows_its_lines_and_its_drawing(scene):
    shown = scene._repr_html_()
    assert "2 of the blocks fixed" in shown
    assert pictures(shown) == {"png": mo.draw(scene).image("png")}


@pytest.mark.slow
def test_a_scene_of_800_blocks_is_drawn_and_a_huge_one_says_why_not():
    """A scene of more than 2000 blocks is not drawn.

    A drawing would be refused because two of its blocks coincide, but this is not examined.
    """
    large = small_wall(40, 20)
    assert len(large.blocks) > 800
    assert len(large._repr_html_()) < 200_000
    huge = small_wall(51, 40)
    twice = huge.blocks[0].model_copy(update={"name": "twice"})
    shown = huge.model_copy(update={"blocks": [*huge.blocks, twice]})._repr_html_()
    assert "not drawn: the scene has more than 2000 blocks: call mo.draw(scene) to draw it" in shown
    assert "&lt;Scene" in shown
    assert "<img" not in shown


def test_a_scene_that_cannot_be_drawn_says_why():
    """A scene whose blocks overlap shows the reason. A block that touches nothing is drawn, with a
    warning."""
    on = {"joints": {"friction": 0.5}}
    overlapping = mo.Scene(**on, blocks=[slab("<b>"), slab("c", left=0.0), support(-0.5, 0.5)])
    shown = overlapping._repr_html_()
    assert "not drawn: " in shown
    assert "&lt;b&gt;" in shown
    assert "<img" not in shown
    floating = mo.Scene(**on, blocks=[slab(), slab("far", left=9.0), support(-0.5, 0.5)])
    assert pictures(floating._repr_html_())


def shows(answer, *words):
    """Assert that the HTML of an answer has the given words and its table; return its pictures."""
    html = answer._repr_html_()
    assert not re.findall(r"<script|<style", html)
    cells = re.findall(r"<td>(.*?)</td>", html)
    assert len(cells) >= answer.notebook_table.size
    for word in words:
        assert word in html
    assert f"{answer.notebook_table.select_dtypes('number').iloc[0, 0]:.6g}" in cells
    return pictures(html)


@pytest.mark.slow
def test_studies_show_facts_a_table_and_a_picture():
    crossed = mo.crossing(OVERHANG, axles(3.0), method="static")
    assert shows(crossed, "governing λ", "associative", "4.000000") == {"png": crossed.plot().image("png")}
    settled = mo.settle(OVERHANG, "support -0.5", (0, -1))
    assert shows(settled, "settles", "12") == {"png": settled.plot().image("png")}
    pushed = two_blocks().replace(load_cases=[{"name": name, "live": {"live": 1}} for name in ("a", "b")])
    cases = mo.solve_cases(pushed, "static")
    assert shows(cases, "'a' governs", "2 load cases") == {"png": cases.plot().image("png")}


def test_samples_show_quantiles_and_fragility_and_searches_what_was_tried():
    friction = {"joints.friction": ("uniform", 0.1, 0.2)}
    drawn = mo.sample(two_blocks(), friction, n=4, workers=1, method="static")
    (chart,) = shows(drawn, "4 runs", "probability").values()
    assert b"confidence" in chart
    found = mo.least(two_blocks, 0.01, 0.4, load=0.15, tolerance=0.1, method="static", samples=0)
    assert shows(found, "least value", "holds") == {}


@pytest.mark.slow
def test_a_comparison_shows_how_scenes_ended_and_its_first_chart(tmp_path):
    of = {"methods": ["static"], "solvers": ["clarabel"], "repeats": 1, "out": tmp_path}
    of |= {"models": ["cvxpy"], "tolerances": [1e-8]}
    found = mo.compare([CASES / "gilbert" / "two_blocks.toml"], **of)
    html = found._repr_html_()
    assert "<td>100%</td>" in html
    assert [*pictures(html).values()] == [(tmp_path / "time_error_associative.svg").read_bytes()]
    assert {tmp_path / "summary.csv", tmp_path / "report.html"} <= {*found.files}


def test_long_tables_are_cut():
    html = notebook_html("words & signs", pd.DataFrame({"x": np.arange(100) / 3}))
    assert html.count("<tr") == 31
    assert "and 70 more rows" in html
    assert "words &amp; signs" in html

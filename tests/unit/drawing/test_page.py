"""What the page of a result holds: numbers in the right places, and words that do no harm."""

import json
import re
from html import unescape

import numpy as np
import pytest
from drawn import solved
from scenes import CASES, WALLS, block_on_floor, on_a_corner, overhanging, pressed_down

import masonry_opt as mo
from masonry_opt.drawing.elements import FULL, KINDS, START, legend, result_elements
from masonry_opt.drawing.page import page
from masonry_opt.drawing.svg import Canvas

ARCH = CASES / "casapulla_lauro" / "arch.toml"


def data_of(text):
    """What the page's script knows."""
    return json.loads(re.search(r'id="data">(.*?)</script>', text, re.DOTALL)[1])


def canvas_of(result):
    """The canvas of a result's page."""
    elements = result_elements(result)
    return Canvas(elements, elements.all_marks)


@pytest.mark.parametrize("case", [WALLS[0], ARCH], ids=["wall", "arch"])
def test_a_page_has_the_elements_and_their_legends(case):
    """All that pictures have, in the same colours and at the same places, beside a slider that moves it."""
    result = solved(case)
    elements, canvas, text = result_elements(result), canvas_of(result), page(result)
    groups = re.findall(r'<g class="(\w+)" fill="[^"]*" stroke="([^"]*)"[^>]*>(.*?)</g>', text)
    groups = [group for group in groups if group[0] not in ("rest", "blocks", "supports", "rims")]
    marks = [*elements.loads, *(each for layer in elements.layers.values() for each in layer)]
    assert [group[:2] for group in groups] == [(each.name, each.colour) for each in marks]
    for each, (_, _, drawn) in zip(marks, groups, strict=True):
        begun = {(int(x), int(y)) for x, y in re.findall(r"M(-?\d+) ?(-?\d+)", drawn)}
        assert {tuple(point) for point in canvas.at(each.points[:, 0]).tolist()} <= begun
        moves = each.motion is not None and np.abs(canvas.motions(each.motion)).max() > 10
        assert ("data-motion" in drawn) == moves
    for kind in KINDS:
        told = re.search(rf'<ul class="{kind}">(.*?)</ul>', text)[1]
        for label in legend([*elements.layers[kind], *elements.loads]):
            assert label in told


@pytest.mark.parametrize("scene", [WALLS[0], on_a_corner()], ids=["wall", "corner on an edge"])
def test_forces_of_every_joint_are_those_of_the_result(scene):
    result = mo.solve(scene)
    told = data_of(page(result))
    names = np.array(told["blocks"])
    for name in ("first", "second"):
        assert names[told["joints"][name]].tolist() == result.joints[name].tolist()
    for name in ("n", "s", "m", "slip", "opening", "utilisation"):
        expected = result.joints[name].to_numpy()
        got = np.array([np.nan if value is None else value for value in told["joints"][name]])
        nothing = 1e-6 * np.nanmax(np.abs(expected))
        assert got == pytest.approx(expected, rel=6e-5, abs=nothing, nan_ok=True)


def blocks_of(text):
    """First corner and attribute of motion of every block drawn."""
    drawn = text[text.index('<g class="blocks"') : text.index('<g class="supports"')]
    groups = re.findall(r"<g([^>]*)>(<path.*?)</g>", drawn)
    found = [
        (np.array(corner, dtype=float), "data-motion" in attributes)
        for attributes, inside in groups
        for corner in re.findall(r'd="M(-?\d+) ?(-?\d+)', inside)
    ]
    return [corner for corner, _ in found], [moves for _, moves in found]


def test_blocks_that_move_are_those_of_the_mechanism():
    result = solved(WALLS[0])
    _, moves = blocks_of(page(result))
    speed = np.zeros(len(result.assembly.scene.blocks))
    speed[result.assembly.movable] = np.hypot(result.blocks["vx"], result.blocks["vy"])
    assert moves == (speed > 1e-6 * speed.max()).tolist()
    assert 0 < sum(moves) < len(moves) - 1


NASTY = '<script>alert("$x")</script>&\'</svg>${title}'


def test_words_of_the_case_are_words_and_nothing_else():
    scene = block_on_floor().model_copy(update={"title": f"{NASTY} {'very ' * 300}\n long"})
    named = scene.blocks[0].model_copy(update={"name": NASTY})
    result = mo.solve(scene.model_copy(update={"blocks": [named, scene.blocks[1]]}))
    text = page(result)
    assert "<script>alert" not in text
    assert data_of(text)["blocks"][0] == NASTY
    assert unescape(re.search("<title>(.*?)</title>", text)[1]).startswith(NASTY)
    assert "<script" not in result._repr_html_()


def test_the_page_asks_for_nothing():
    text = page(solved(WALLS[0]))
    assert not re.findall(r"(?:src|href|url|@import)\s*[=(]", text)
    assert set(re.findall(r"https?://[^\"' ]*", text)) == {"http://www.w3.org/2000/svg"}


@pytest.mark.parametrize(
    ("scene", "moves"), [(overhanging, True), (pressed_down, False)], ids=["falls", "unlimited"]
)
def test_without_a_load_factor_the_page_shows_what_there_is(scene, moves, tmp_path):
    result = mo.solve(scene())
    result.save(tmp_path / "page.html")
    text = (tmp_path / "page.html").read_text(encoding="utf-8")
    assert result.load_factor is None
    assert str(result.status) in text
    assert ('data-motion="' in text) is moves
    for kind in ("thrust", "utilisation"):
        assert re.search(rf'value="{kind}" disabled', text)
        assert f'<g class="layer {kind}"' not in text
    assert set(data_of(text)["joints"]["n"]) == {None}
    assert str(result.status) in result._repr_html_()


def test_a_notebook_shows_a_picture_that_clashes_with_no_other():
    result = mo.solve(block_on_floor(4, 2, 0.5))
    text = result._repr_html_()
    assert not re.findall(r"\bid=|<style|<script|url\(", text)
    assert "λ = 0.5" in text
    # The block slides to the right: its motion is part of the picture.
    elements = result_elements(result)
    canvas = Canvas(elements, elements.shown("mechanism"), START)
    share = re.search(r'<g transform="matrix\(1 0\.00000 -?0\.00000 1 (\d+) -?0\)"', text)
    assert float(share[1]) == pytest.approx(START * FULL * 4 * canvas.scale, abs=1)

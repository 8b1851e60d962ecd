"""The page of a result in the plane, in a browser: layout, motion of blocks, and the panel of a joint."""

import re

import numpy as np
import pytest
from pages import cell, found, move_to, quiet, show, sticking_out, written
from scenes import WALLS, block_on_floor, overhanging
from selenium.webdriver.common.action_chains import ActionChains
from selenium.webdriver.common.actions.pointer_input import PointerInput
from selenium.webdriver.common.keys import Keys

import masonry_opt as mo
from masonry_opt.drawing.elements import result_elements
from masonry_opt.drawing.keyframes import keyframes_of
from masonry_opt.drawing.marks import moved
from masonry_opt.drawing.page import HISTORY, motions_of
from masonry_opt.drawing.svg import LONGER_SIDE, Canvas
from masonry_opt.solution.motion import fastest

pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def wall(tmp_path_factory):
    """Return the result of wall 1 and the file of its page."""
    return written(mo.solve(WALLS[0]), tmp_path_factory)


def transform(page, block):
    """Return the matrix with which a block is drawn, as 2 × 3 numbers.

    The browser inverts a matrix to compute it, with rounding errors.
    """
    a, b, c, d, e, f = page.execute_script(
        "const block = document.querySelectorAll('.blocks path')[arguments[0]];"
        "const svg = block.ownerSVGElement;"
        "const m = svg.getScreenCTM().inverse().multiply(block.getScreenCTM());"
        "return [m.a, m.b, m.c, m.d, m.e, m.f]",
        int(block),
    )
    return np.array([[a, c, e], [b, d, f]])


def test_everything_fits_and_the_answer_comes_first(page, result):
    assert sticking_out(page) == []
    factor = found(page, ".load-factor")
    assert f"{result.load_factor:.5g}" in factor.text
    assert factor.rect["y"] + factor.rect["height"] < 400
    # A part of the picture is visible without scrolling.
    assert found(page, "svg.picture").rect["y"] < 700


def fastest_block(result):
    """Return the index in the scene of the block whose centroid is fastest."""
    speed = np.hypot(result.blocks["vx"], result.blocks["vy"])
    return result.assembly.movable[speed.idxmax()]


def test_the_slider_moves_blocks_as_the_mechanism_does(page, result):
    elements, frame = result_elements(result), result.blocks
    canvas = Canvas(elements, elements.all_marks)
    speed = np.hypot(frame["vx"], frame["vy"])
    # At 1, the fastest corner moves by a tenth of the size of the scene, which is 20 long and 10.5 high.
    full = 2.0 / fastest(result.assembly, result.solution.d)
    middle = canvas.at(frame[["x", "y"]].to_numpy() - result.assembly.geometry.origin)
    for share in (1.0, 0.35, 0.0):
        move_to(page, share)
        for block in (speed.idxmax(), speed.idxmin(), 12):
            matrix = transform(page, result.assembly.movable[block])
            moved = matrix @ [*middle[block], 1.0] - middle[block]
            expected = share * full * canvas.scale * frame.loc[block, ["vx", "vy"]].to_numpy(float)
            assert moved == pytest.approx(expected * [1, -1], abs=2.0)


def test_keys_move_along_the_load_history_and_the_mechanism_comes_back(page, result):
    """Keys move the blocks to the keyframes of the load history, and a click returns to the mechanism.

    The page marks joints that have slid or are open, and the point on the load–displacement curve.
    """
    tall = page.execute_script("return document.documentElement.scrollHeight")
    elements, frames = result_elements(result), keyframes_of(result)
    canvas = Canvas(elements, elements.all_marks)
    motions = canvas.motions(motions_of(result, frames))
    moves = np.stack([frames.has_slid, frames.is_open], axis=1)
    slider, moving = found(page, "#loaded"), fastest_block(result)
    assert all(control.accessible_name for control in page.find_elements("css selector", "input"))
    before = transform(page, moving)
    events, last = set(), len(frames.d) - 1
    for key, at in (
        (Keys.ARROW_RIGHT, 1),
        (Keys.END, last),
        (Keys.ARROW_LEFT, last - 1),
        (Keys.PAGE_DOWN, None),
    ):
        slider.send_keys(key)
        at = int(slider.get_property("value")) if at is None else at
        assert int(slider.get_property("value")) == at
        assert found(page, "main").get_attribute("data-show") == HISTORY
        for row, block in enumerate(result.assembly.movable):
            vx, vy, omega = motions[at, row]
            expected = [[1, -omega, vx], [omega, 1, vy]]
            assert np.abs((transform(page, block) - expected) / [1, 1, LONGER_SIDE]).max() <= 1e-4
        lines = [len(page.find_elements("css selector", f".yielded g:nth-child({k}) path")) for k in (1, 2)]
        assert lines == moves[at].sum(axis=1).tolist()
        numbers = re.findall(r"\d+\.?\d*(?:e-?\d+)?", found(page, "#now").text)
        assert float(numbers[0]) == pytest.approx(frames.load_factor[at], rel=1e-3)
        assert [int(number) for number in numbers[2:]] == lines
        events.add(found(page, "#event").text)
        curve = page.execute_script("return document.querySelector('.chart polyline').getAttribute('points')")
        marker = found(page, ".chart .at")
        place = [float(marker.get_attribute(of)) for of in ("cx", "cy")]
        assert place == pytest.approx([float(of) for of in curve.split()[at].split(",")])
        assert sticking_out(page) == []
    assert len(events) >= 3
    assert page.execute_script("return document.documentElement.scrollHeight") == tall
    found(page, 'input[value="mechanism"]').click()
    assert transform(page, moving) == pytest.approx(before)
    assert page.find_elements("css selector", ".yielded path") == []
    assert quiet(page)


def test_focus_on_a_joint_tells_its_forces_and_moves_nothing_else(page, result):
    height = "return document.documentElement.scrollHeight"
    tall = page.execute_script(height)
    number = found(page, "#joint")
    number.send_keys("20")
    for joint in (20, 21):
        row = result.joints.iloc[joint]
        for name in ("n", "s", "m", "slip", "opening"):
            assert cell(page, name) == pytest.approx(row[name], rel=1e-4, abs=1e-5)
        assert (found(page, "#first").text, found(page, "#second").text) == (row["first"], row["second"])
        assert len(page.find_elements("css selector", ".blocks .first, .blocks .second")) == 2
        number.send_keys(Keys.ARROW_UP)
    assert page.execute_script(height) == tall
    panel, picture = found(page, ".joint").rect, found(page, "svg.picture").rect
    right = picture["x"] + picture["width"]
    assert panel["y"] > picture["y"] + picture["height"] or panel["x"] > right


@pytest.mark.parametrize("kind", ["mouse", "touch"])
def test_pointing_at_a_joint_picks_it(page, result, kind):
    move_to(page, 1.0)
    elements, joints = result_elements(result), result.assembly.joints
    canvas = Canvas(elements, elements.all_marks)
    page.execute_script("document.querySelector('svg.picture').scrollIntoView()")
    # The joint that moves most is drawn at its displaced position, midway between its blocks.
    motion = canvas.motions(elements.motion[joints.first] + elements.motion[joints.second]) / 2
    middle = canvas.at(joints.middle)
    moves = moved(middle, motion) - middle
    joint = int(np.hypot(*moves.T).argmax())
    x, y = page.execute_script(
        "const at = new DOMPoint(...arguments[0]).matrixTransform("
        "document.querySelector('svg.picture').getScreenCTM()); return [at.x, at.y]",
        (middle[joint] + moves[joint]).tolist(),
    )
    pointer = PointerInput(kind, kind)
    actions = ActionChains(page, devices=[pointer]).w3c_actions
    actions.pointer_action.move_to_location(round(x), round(y))
    if kind == "touch":
        actions.pointer_action.pointer_down().pointer_up()
    actions.perform()
    assert found(page, "#joint").get_property("value") == str(joint)
    assert cell(page, "n") == pytest.approx(result.joints["n"][joint], rel=1e-4, abs=1e-5)


def test_forces_are_shown_at_rest_and_the_mechanism_comes_back(page, result):
    shown = "return getComputedStyle(document.querySelector(arguments[0])).display !== 'none'"
    tall = page.execute_script("return document.documentElement.scrollHeight")
    moving = fastest_block(result)
    before = transform(page, moving)
    for kind in ("thrust", "utilisation", "mechanism"):
        found(page, f'input[value="{kind}"]').click()
        for layer in ("thrust", "utilisation", "mechanism"):
            assert page.execute_script(shown, f".layer.{layer}") is (layer == kind)
        assert found(page, "#moved").is_enabled() is (kind == "mechanism")
        assert page.execute_script("return document.documentElement.scrollHeight") == tall
        if kind != "mechanism":
            # The matrix is the identity up to rounding. Translations are divided by the side of the picture.
            assert np.abs((transform(page, moving) - np.eye(2, 3)) / [1, 1, LONGER_SIDE]).max() <= 1e-13
    assert transform(page, moving) == pytest.approx(before)


NASTY = '"><script>document.title = "harmed"</script><img src="http://localhost/x">$title'


def test_pages_without_a_load_factor_and_with_odd_names_work(browser, tmp_path_factory, width):
    scene = overhanging()
    blocks = [scene.blocks[0].model_copy(update={"name": NASTY}), scene.blocks[1]]
    odd = scene.model_copy(update={"title": f"{NASTY} {'M' * 1000}", "blocks": blocks})
    for result in (mo.solve(odd), mo.solve(block_on_floor(live=(0.0, -1.0)))):
        _, path = written(result, tmp_path_factory)
        page = show(browser, path, width)
        assert page.title != "harmed"
        assert sticking_out(page) == []
        assert str(result.status) in found(page, "body").text
        factor = found(page, ".load-factor").rect
        assert factor["y"] + factor["height"] < 400
        found(page, "#joint").send_keys("0")
        assert found(page, "#first").text == result.joints["first"][0]
        assert found(page, '[data-of="n"]').text == "–"
        assert quiet(page)

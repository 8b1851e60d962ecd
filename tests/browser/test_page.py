"""The page of a result in a browser: what fits, what moves, and what a joint tells."""

from __future__ import annotations

import json
import re
import shutil

import numpy as np
import pytest
from scenes import WALLS, block_on_floor, overhanging

import masonry_opt as mo
from masonry_opt.report.motion import fastest
from masonry_opt.report.page.page import write_page
from masonry_opt.report.page.view import START, view_of

webdriver = pytest.importorskip("selenium.webdriver")

BROWSER, DRIVER = shutil.which("chromium"), shutil.which("chromedriver")

pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(not (BROWSER and DRIVER), reason="no chromium and chromedriver here"),
]

ARGUMENTS = (
    "headless=new",
    "no-sandbox",
    "disable-gpu",
    "disable-quic",
    "no-first-run",
    "disable-background-networking",
    "disable-component-update",
    "disable-sync",
)

WIDTHS = (1280, 400)


@pytest.fixture(scope="module")
def browser(tmp_path_factory):
    from selenium.webdriver.chrome.service import Service

    options = webdriver.ChromeOptions()
    options.binary_location = BROWSER
    for argument in ARGUMENTS:
        options.add_argument(f"--{argument}")
    options.add_argument(f"--user-data-dir={tmp_path_factory.mktemp('chromium')}")
    options.set_capability("goog:loggingPrefs", {"browser": "ALL", "performance": "ALL"})
    driver = webdriver.Chrome(options=options, service=Service(executable_path=DRIVER))
    yield driver
    driver.quit()


@pytest.fixture(scope="module")
def wall(tmp_path_factory):
    """A wall's result and the file of its page."""
    return written(mo.solve(WALLS[0]), tmp_path_factory)


def written(result, tmp_path_factory):
    path = tmp_path_factory.mktemp("page") / "page.html"
    write_page(result, path)
    return result, path


def show(browser, path, width):
    """Open a page in a window of that width and a phone's height."""
    size = {"width": width, "height": 800, "deviceScaleFactor": 1, "mobile": False}
    browser.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", size)
    for log in ("browser", "performance"):
        browser.get_log(log)
    browser.get(path.as_uri())


def found(browser, selector):
    return browser.find_element("css selector", selector)


def sticking_out(browser):
    """What does not fit into the window's width, with less of its own than it needs, or beside it."""
    return browser.execute_script(
        "const width = document.documentElement.clientWidth;"
        "return [...document.querySelectorAll('html, body, body *:not(svg *)')].filter((element) => {"
        "  const {left, right} = element.getBoundingClientRect();"
        "  const needs = element.scrollWidth > Math.max(width, element.clientWidth);"
        "  return left < 0 || right > width + 0.5 || needs;"
        "}).map((element) => element.outerHTML.slice(0, 80))"
    )


def cell(browser, name):
    """A number that the panel tells of the joint."""
    return float(found(browser, f'[data-of="{name}"]').text.replace("−", "-"))


def move_to(browser, value):
    """Move the slider, as keys and pointer do."""
    browser.execute_script(
        "const slider = document.getElementById('moved'); slider.value = arguments[0];"
        "slider.dispatchEvent(new Event('input', {bubbles: true}))",
        value,
    )


def transform(browser, block):
    """The matrix by which a block is drawn, as 2 × 3 numbers."""
    a, b, c, d, e, f = browser.execute_script(
        "const block = document.querySelectorAll('.blocks path')[arguments[0]];"
        "const svg = block.ownerSVGElement;"
        "const m = svg.getScreenCTM().inverse().multiply(block.getScreenCTM());"
        "return [m.a, m.b, m.c, m.d, m.e, m.f]",
        int(block),
    )
    return np.array([[a, c, e], [b, d, f]])


@pytest.mark.parametrize("width", WIDTHS)
def test_everything_fits_and_the_answer_comes_first(browser, wall, width):
    result, path = wall
    show(browser, path, width)
    assert sticking_out(browser) == []
    factor = found(browser, ".load-factor")
    assert f"{result.load_factor:.5g}" in factor.text
    assert factor.rect["y"] + factor.rect["height"] < 400
    # Without a step of scrolling some of the picture is there.
    assert found(browser, "svg.picture").rect["y"] < 700


def fastest_block(result):
    """Which of the scene's blocks has the fastest centroid."""
    speed = np.hypot(result.blocks["vx"], result.blocks["vy"])
    return result.assembly.movable[speed.idxmax()]


@pytest.mark.parametrize("width", WIDTHS)
def test_the_slider_moves_blocks_as_the_mechanism_does(browser, wall, width):
    result, path = wall
    show(browser, path, width)
    view, frame = view_of(result), result.blocks
    speed = np.hypot(frame["vx"], frame["vy"])
    # At 1 the fastest corner moves by a tenth of the scene's size: 20 long, 10.5 high.
    assert view.full * fastest(result) == pytest.approx(2.0)
    middle = view.at(frame[["x", "y"]].to_numpy() - result.assembly.geometry.origin)
    for share in (1.0, 0.35, 0.0):
        move_to(browser, share)
        for block in (speed.idxmax(), speed.idxmin(), 12):
            matrix = transform(browser, result.assembly.movable[block])
            moved = matrix @ [*middle[block], 1.0] - middle[block]
            expected = share * view.full * view.scale * frame.loc[block, ["vx", "vy"]].to_numpy(float)
            assert moved == pytest.approx(expected * [1, -1], abs=2.0)


def test_keys_move_the_slider_and_labels_tell_what_it_does(browser, wall):
    from selenium.webdriver.common.keys import Keys

    _, path = wall
    show(browser, path, 1280)
    slider = found(browser, "#moved")
    assert float(slider.get_property("value")) == START
    assert slider.accessible_name
    moving = fastest_block(wall[0])
    before = transform(browser, moving)
    slider.send_keys(Keys.HOME)
    assert transform(browser, moving) == pytest.approx(np.eye(2, 3))
    slider.send_keys(Keys.ARROW_RIGHT)
    assert not np.allclose(transform(browser, moving), before)
    for control in browser.find_elements("css selector", "input"):
        assert control.accessible_name


@pytest.mark.parametrize("width", WIDTHS)
def test_focus_on_a_joint_tells_its_forces_and_moves_nothing_else(browser, wall, width):
    from selenium.webdriver.common.keys import Keys

    result, path = wall
    show(browser, path, width)
    height = "return document.documentElement.scrollHeight"
    tall = browser.execute_script(height)
    number = found(browser, "#joint")
    number.send_keys("20")
    for joint in (20, 21):
        row = result.joints.iloc[joint]
        for name in ("n", "s", "m", "slip", "opening"):
            assert cell(browser, name) == pytest.approx(row[name], rel=1e-4, abs=1e-5)
        assert (found(browser, "#first").text, found(browser, "#second").text) == (
            row["first"],
            row["second"],
        )
        assert len(browser.find_elements("css selector", ".blocks .first, .blocks .second")) == 2
        number.send_keys(Keys.ARROW_UP)
    assert browser.execute_script(height) == tall
    panel, picture = found(browser, ".joint").rect, found(browser, "svg.picture").rect
    right = picture["x"] + picture["width"]
    assert panel["y"] > picture["y"] + picture["height"] or panel["x"] > right


@pytest.mark.parametrize("kind", ["mouse", "touch"])
@pytest.mark.parametrize("width", WIDTHS)
def test_pointing_at_a_joint_picks_it(browser, wall, width, kind):
    from selenium.webdriver.common.action_chains import ActionChains
    from selenium.webdriver.common.actions.pointer_input import PointerInput

    result, path = wall
    show(browser, path, width)
    move_to(browser, 1.0)
    view, joints = view_of(result), result.assembly.joints
    browser.execute_script("document.querySelector('svg.picture').scrollIntoView()")
    # The joint that moves most, where it then is: midway between its blocks.
    motion = (view.motions[joints.first] + view.motions[joints.second]) / 2
    middle = view.at(joints.middle)
    turning = motion[:, 2:] * np.column_stack([-middle[:, 1], middle[:, 0]])
    moves = motion[:, :2] + turning
    joint = int(np.hypot(*moves.T).argmax())
    x, y = browser.execute_script(
        "const at = new DOMPoint(...arguments[0]).matrixTransform("
        "document.querySelector('svg.picture').getScreenCTM()); return [at.x, at.y]",
        (middle[joint] + moves[joint]).tolist(),
    )
    pointer = PointerInput(kind, kind)
    actions = ActionChains(browser, devices=[pointer]).w3c_actions
    actions.pointer_action.move_to_location(round(x), round(y))
    if kind == "touch":
        actions.pointer_action.pointer_down().pointer_up()
    actions.perform()
    assert found(browser, "#joint").get_property("value") == str(joint)
    assert cell(browser, "n") == pytest.approx(result.joints["n"][joint], rel=1e-4, abs=1e-5)


@pytest.mark.parametrize("width", WIDTHS)
def test_forces_are_shown_at_rest_and_the_mechanism_comes_back(browser, wall, width):
    _, path = wall
    show(browser, path, width)
    shown = "return getComputedStyle(document.querySelector(arguments[0])).display !== 'none'"
    tall = browser.execute_script("return document.documentElement.scrollHeight")
    moving = fastest_block(wall[0])
    before = transform(browser, moving)
    for kind in ("thrust", "utilisation", "mechanism"):
        found(browser, f'input[value="{kind}"]').click()
        for layer in ("thrust", "utilisation", "mechanism"):
            assert browser.execute_script(shown, f".layer.{layer}") is (layer == kind)
        assert found(browser, "#moved").is_enabled() is (kind == "mechanism")
        assert browser.execute_script("return document.documentElement.scrollHeight") == tall
        if kind != "mechanism":
            assert transform(browser, moving) == pytest.approx(np.eye(2, 3))
    assert transform(browser, moving) == pytest.approx(before)


NASTY = '"><script>document.title = "harmed"</script><img src="http://localhost/x">$title'


@pytest.mark.parametrize("width", WIDTHS)
def test_pages_without_a_load_factor_and_with_odd_names_work(browser, tmp_path_factory, width):
    scene = overhanging()
    blocks = [scene.blocks[0].model_copy(update={"name": NASTY}), scene.blocks[1]]
    odd = scene.model_copy(update={"title": f"{NASTY} {'M' * 1000}", "blocks": blocks})
    for result in (mo.solve(odd), mo.solve(block_on_floor(live=(0.0, -1.0)))):
        _, path = written(result, tmp_path_factory)
        show(browser, path, width)
        assert browser.title != "harmed"
        assert sticking_out(browser) == []
        assert str(result.status) in found(browser, "body").text
        factor = found(browser, ".load-factor").rect
        assert factor["y"] + factor["height"] < 400
        found(browser, "#joint").send_keys("0")
        assert found(browser, "#first").text == result.joints["first"][0]
        assert found(browser, '[data-of="n"]').text == "–"
        assert quiet(browser)


def test_no_error_and_no_request(browser, wall):
    _, path = wall
    show(browser, path, 1280)
    found(browser, 'input[value="thrust"]').click()
    found(browser, "#joint").send_keys("5")
    assert quiet(browser)


def quiet(browser):
    """Whether nothing was logged, and nothing asked for but the file."""
    events = [json.loads(entry["message"])["message"] for entry in browser.get_log("performance")]
    sent = [event["params"] for event in events if event["method"] == "Network.requestWillBeSent"]
    asked = [event["request"]["url"] for event in sent]
    assert asked
    return browser.get_log("browser") == [] and all(re.match("file:", url) for url in asked)

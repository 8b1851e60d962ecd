"""What the page of a result holds: numbers in the right places, and words that do no harm."""

from __future__ import annotations

import functools
import json
import re
from html import unescape

import numpy as np
import pytest
import shapely
from scenes import CASES, WALLS, block_on_floor, on_a_corner, overhanging, pressed_down, small_wall

import masonry_opt as mo
from masonry_opt.report.page.carried import UTILISATION, resultants
from masonry_opt.report.page.drawing import joints_by_kind
from masonry_opt.report.page.page import page, write_page
from masonry_opt.report.page.view import FULL, SIDE, START, view_of
from masonry_opt.report.thrust import thrust

ARCH = CASES / "casapulla_lauro" / "arch.toml"

#: Of case files, once for all tests.
solved = functools.cache(mo.solve)


def data_of(text):
    """What the page's script knows."""
    return json.loads(re.search(r'id="data">(.*?)</script>', text, re.DOTALL)[1])


def lines_of(text, name):
    """Both ends of all lines in the group of that class, in the picture's units."""
    start = text.index(f'<g class="{name}"')
    found = re.findall(r"M(-?\d+) ?(-?\d+)l(-?\d+) ?(-?\d+)", text[start : text.index("</g>", start)])
    numbers = np.array(found, dtype=float)
    return numbers[:, :2], numbers[:, :2] + numbers[:, 2:]


@pytest.mark.parametrize("case", [WALLS[0], ARCH], ids=["wall", "arch"])
def test_joints_open_and_slip_as_the_motions_of_their_blocks_say(case):
    """The motion of the first block's picture against the second's, resolved along the joint by hand."""
    result = solved(case)
    view, joints, frame = view_of(result), result.assembly.joints, result.joints
    middle = view.at(joints.middle)

    def moved(blocks):
        vx, vy, omega = view.motions[blocks].T
        return np.column_stack([vx - omega * middle[:, 1], vy + omega * middle[:, 0]])

    apart = (moved(joints.first) - moved(joints.second)) * [1, -1] / view.scale / view.full
    along = np.column_stack([joints.normal[:, 1], -joints.normal[:, 0]])
    # The middle is known to half a unit of the picture.
    near = 1.0 / view.scale * np.abs(result.blocks["omega"]).max()
    assert (apart * joints.normal).sum(axis=1) == pytest.approx(frame["opening"].to_numpy(), abs=near)
    assert (apart * along).sum(axis=1) == pytest.approx(frame["slip"].to_numpy(), abs=near)


def test_the_fastest_corner_moves_by_a_tenth_and_stays_in_the_picture():
    # A block of 1 × 2 overturns about its toe (1, 0): fastest is the corner furthest from it, (0, 2).
    view = view_of(mo.solve(block_on_floor(1, 2, 0.8)))
    (vx, vy, omega), corner = view.motions[0], view.at(np.array([-0.5, 1.0]))
    assert omega == pytest.approx(0.1 * 2 / np.sqrt(5))  # clockwise is positive where y runs down
    move = [vx - omega * corner[1], vy + omega * corner[0]]
    assert np.hypot(*move) == pytest.approx(FULL * 2 * view.scale, rel=1e-3)
    assert max(view.width, view.height) == SIDE
    for x, y in ([-0.5, -1.0], [0.5, -1.0], [0.5, 1.0], [-0.5, 1.0]):
        here = view.at(np.array([x, y]))
        after = here + np.array([vx - omega * here[1], vy + omega * here[0]])
        assert (after > 0).all()
        assert (after < [view.width, view.height]).all()


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


def test_blocks_are_drawn_in_the_order_of_the_scene_and_at_their_places():
    result = solved(WALLS[0])
    view, text = view_of(result), page(result)
    corners, _ = blocks_of(text)
    for outline, polygon in zip(corners, result.assembly.geometry.polygons, strict=True):
        assert outline == pytest.approx(view.at(shapely.get_coordinates(polygon)[:1])[0])


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


def test_thrust_acts_where_the_resultant_meets_the_floor():
    # A block of 4 × 2 slides at the push 0.5: the floor's answer (−0.5, 1) acts at x = 2.5.
    result = mo.solve(block_on_floor(4, 2, 0.5))
    view = view_of(result)
    start, end = (ends[0] for ends in lines_of(page(result), "resultants"))
    assert (start + end) / 2 == pytest.approx(view.at(np.array([0.5, -1.0])), abs=2)
    assert resultants(result).longest == pytest.approx(np.sqrt(1.25))
    along = (end - start) / np.hypot(*(end - start))
    assert along == pytest.approx(np.array([-1, -2]) / np.sqrt(5), abs=0.01)


def test_the_line_of_thrust_joins_the_points_of_action_of_every_voussoir():
    result = solved(ARCH)
    view = view_of(result)
    start, end = lines_of(page(result), "line")
    assert len(start) == result.size.blocks
    points = view.at(thrust(result).point - result.assembly.geometry.origin)
    for ends in (start, end):
        assert np.abs(ends[:, None] - points).max(axis=2).min(axis=1).max() == 0


def test_colours_of_utilisation_are_those_of_the_joints():
    result = solved(WALLS[0])
    text = page(result)
    drawn = text[text.index('<g class="layer utilisation"') : text.index('<g class="layer thrust"')]
    used = result.joints["utilisation"].to_numpy()
    for number, colour in enumerate(UTILISATION):
        inside = re.search(rf'stroke="{colour}"[^>]*><path d="([^"]*)"', drawn)
        low, high = number / len(UTILISATION), (number + 1) / len(UTILISATION)
        last = number == len(UTILISATION) - 1
        expected = int(((used >= low) & ((used < high) | last)).sum())
        assert (inside[1].count("M") if inside else 0) == expected


def test_marks_of_joints_are_only_of_what_occurs():
    slides, hinges = (page(mo.solve(block_on_floor(*shape))) for shape in ((4, 2, 0.5), (1, 2, 0.8)))
    assert '<g class="slides"' in slides
    assert '<g class="hinges"' not in slides
    assert '<g class="hinges"' in hinges
    assert '<g class="slides"' not in hinges


def test_a_joint_that_slides_and_crushes_is_marked_once():
    result = mo.solve(small_wall(strength=3.0), "static")
    marked, slip = joints_by_kind(result), result.joints["slip"].abs().to_numpy()
    both = marked["crushes"][slip[marked["crushes"]] > 0.01 * slip.max()]
    assert len(both)
    assert not np.isin(both, marked.get("slides", [])).any()
    assert '<g class="crushes"' in page(result)


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
    write_page(result, tmp_path / "page.html")
    text = (tmp_path / "page.html").read_text(encoding="utf-8")
    assert result.load_factor is None
    assert str(result.status) in text
    assert ('data-motion="' in text) is moves
    for kind in ("thrust", "utilisation"):
        assert re.search(rf'value="{kind}" disabled', text)
        assert f'<g class="layer {kind}"' not in text
    assert set(data_of(text)["joints"]["n"]) == {None}
    assert str(result.status) in result._repr_html_()


@pytest.mark.parametrize("name", ["page.png", "page", "missing/page.html"])
def test_a_page_is_refused_where_it_cannot_be(name, tmp_path):
    with pytest.raises(mo.OptionError, match=re.escape(name)):
        write_page(mo.solve(overhanging()), tmp_path / name)
    assert not list(tmp_path.iterdir())


def test_warnings_are_on_the_page_and_in_the_notebook():
    result = mo.solve(block_on_floor(friction=35.0))
    assert len(result.warnings) == 1
    for text in (page(result), result._repr_html_()):
        assert text.count("Warning: ") == 1


def test_a_notebook_shows_a_picture_that_clashes_with_no_other():
    result = mo.solve(block_on_floor(4, 2, 0.5))
    text = result._repr_html_()
    assert not re.findall(r"\bid=|<style|<script|url\(", text)
    assert "λ = 0.5" in text
    # The block slides to the right: its motion is part of the picture.
    view = view_of(result)
    share = re.search(r'<g transform="matrix\(1 0\.00000 -?0\.00000 1 (\d+) -?0\)"', text)
    assert float(share[1]) == pytest.approx(START * FULL * 4 * view.scale, abs=1)


def test_an_edge_load_of_nothing_is_not_drawn(tmp_path):
    """Such as a sweep from zero on has."""
    scene = block_on_floor(4, 2, 0.5)
    none = mo.EdgeLoad(**{"from": (0, 0), "to": (0, 2)}, pressure=0.0)
    loaded = mo.solve(scene.model_copy(update={"edge_loads": [none]}))
    assert loaded.load_factor == mo.solve(scene).load_factor
    assert not loaded.assembly.loaded_pieces
    loaded.save(tmp_path / "a.svg")
    assert "-9223372036854775808" not in page(loaded)

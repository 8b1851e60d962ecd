"""Pictures and pages have all their elements and no others, with the right numbers, and wrong requests are
refused."""

import json
import re
from html import unescape
from itertools import combinations, pairwise
from pathlib import Path

import matplotlib as mpl
import numpy as np
import pytest
from atlas.small_scenes import rectangle
from drawn import solved
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.collections import LineCollection
from matplotlib.quiver import Quiver
from scenes import (
    CASES,
    WALLS,
    block_on_floor,
    on_a_corner,
    overhanging,
    pressed_down,
    small_wall,
    two_blocks,
)

import masonry_opt
import masonry_opt as mo
from masonry_opt.drawing import colours
from masonry_opt.drawing.colours import SERIES
from masonry_opt.drawing.elements import (
    PICTURE_KINDS,
    SHOWN_MOTION_SHARE,
    legend,
    result_elements,
    scene_elements,
)
from masonry_opt.drawing.figure import (
    Picture,
    _grouped_numbers,
    _legend_columns,
    draw_marks,
    finish,
    remove_overlapping_texts,
    write_name,
)
from masonry_opt.drawing.marks import Marks
from masonry_opt.drawing.page import page
from masonry_opt.drawing.svg import Canvas
from masonry_opt.problem.assembly import assemble

BEGINS = {"png": b"\x89PNG\r\n\x1a\n", "svg": b"<?xml", "pdf": b"%PDF-", "HTML": b"<!doctype html"}


@pytest.fixture(scope="module")
def result():
    return mo.solve(two_blocks())


def points_of(artist):
    """Return the points of the marks of an artist."""
    if isinstance(artist, LineCollection):
        return np.array(artist.get_segments())
    if isinstance(artist, Quiver):
        return np.stack([artist.XY, artist.XY + np.column_stack([artist.U, artist.V])], axis=1)
    return np.ma.getdata(artist.get_offsets())[:, None]


@pytest.mark.parametrize("kind", PICTURE_KINDS)
@pytest.mark.parametrize("case", [WALLS[0], CASES / "pippard_ashby" / "rib.toml"], ids=["wall", "arch"])
def test_a_picture_has_the_elements_and_their_legend(case, kind):
    result = solved(case)
    elements, figure = result_elements(result), result.plot(kind)
    title = figure.axes[0].get_title()
    assert result.assembly.scene.title in title.replace("\n", " ")
    assert float(re.search(r"λ = (\S+)", title)[1]) == pytest.approx(result.load_factor, rel=1e-5)
    marks = [each for each in elements.shown(kind) if each.shape != "bar"]
    # The first artists are supports, blocks and, for a mechanism, outlines at rest.
    artists = figure.axes[0].collections[3 if kind == "mechanism" else 2 :]
    share = SHOWN_MOTION_SHARE if kind == "mechanism" else 0.0
    for each, artist in zip(marks, artists, strict=True):
        expected = each.moved(share) + elements.assembly.geometry.origin
        assert points_of(artist) == pytest.approx(expected)
    labels = [text.get_text() for text in figure.legends[0].get_texts()]
    assert labels == ["block", "support", *legend(elements.shown(kind))]
    bars = [axes.get_xlabel() for axes in figure.axes[1:]]
    assert ["utilisation" in label for label in bars] == ([True] if kind == "utilisation" else [])


@pytest.mark.parametrize(
    ("kind", "ending"), list(zip([*PICTURE_KINDS, PICTURE_KINDS[0]], BEGINS, strict=True))
)
def test_every_kind_is_written_in_every_format(result, kind, ending, tmp_path):
    """The ending of the file determines its format. A page first shows the requested kind."""
    result.save(tmp_path / f"picture.{ending}", kind)
    written = (tmp_path / f"picture.{ending}").read_bytes()
    assert written.startswith(BEGINS[ending])
    assert len(written) > 5000
    assert [path.name for path in tmp_path.iterdir()] == [f"picture.{ending}"]
    if ending == "HTML":
        (chosen,) = [line for line in written.decode().splitlines() if " checked" in line]
        assert f'value="{kind}"' in chosen


@pytest.mark.parametrize(
    ("name", "how"),
    [
        *((name, {}) for name in ("a.gif", "a", "none/a.html", "none/a.png")),
        *(("a.html", how) for how in ({"names": True}, {"kind": "stress"})),
    ],
)
def test_what_cannot_be_written_is_refused_and_leaves_nothing(result, tmp_path, name, how):
    with pytest.raises(mo.OptionError):
        result.save(tmp_path / name, **how)
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("kind", PICTURE_KINDS)
def test_names_are_written_where_asked_for(result, kind):
    for names in (False, True):
        axes = result.plot(kind, names=names).axes[0]
        written = {text.get_text() for text in axes.texts}
        assert ({"A", "B", "floor", "support"} <= written) == names


@pytest.mark.parametrize("kind", ["thrust", "utilisation"])
def test_without_forces_the_picture_says_so(kind):
    axes = mo.solve(overhanging()).plot(kind).axes[0]
    assert [text.get_text() for text in axes.texts] == ["no forces were found to draw"]


@pytest.mark.parametrize("height", [1, 20, 100])
def test_the_scale_keeps_its_label_beside_slender_scenes(height):
    """The scale bar is up to 12 % of the height long, which is more than the free width beside a slender
    column."""
    blocks = [rectangle(str(y), 0, y, 0.5, y + 1, weight=1, live=(1, 0)) for y in range(height)]
    scene = mo.Scene(joints={"friction": 0.6}, blocks=[*blocks, rectangle("floor", -1, -1, 2, 0)])
    figure = mo.solve(scene, "static").plot("thrust")
    canvas = FigureCanvasAgg(figure)
    canvas.draw()
    (label,) = figure.axes[0].texts
    box, axes = label.get_window_extent(), figure.axes[0].bbox
    assert axes.x0 <= box.x0 < box.x1 <= axes.x1
    assert axes.y0 <= box.y0 < box.y1 <= axes.y1


@pytest.fixture(scope="module")
def curved():
    return mo.solve(two_blocks(), "incremental", curve=True)


def test_a_curve_is_drawn_with_its_load_factor_and_the_first_joints_that_move(curved):
    figure, curve = curved.plot("curve"), curved.curve
    axes = figure.axes[0]
    drawn = {line.get_label(): line.get_xydata() for line in axes.lines}
    states = curve[["displacement", "load_factor"]].to_numpy()
    assert any(np.array_equal(points, states) for points in drawn.values())
    assert any((points[:, 1] == curved.load_factor).all() for points in drawn.values())
    (first,) = np.flatnonzero(curve["starts_sliding"])
    assert any(np.array_equal(points, states[first : first + 1]) for points in drawn.values())
    assert {text.get_text() for text in axes.texts} == {"1", "start to slide"}
    labels = [text.get_text() for text in figure.legends[0].get_texts()]
    assert labels == ["load factor λ = 0.18844", "associative λ = 0.25", "the first joints slide"]


def test_the_label_below_a_curve_is_narrower_than_the_axis_and_above_the_legend(curved):
    figure = curved.plot("curve")
    FigureCanvasAgg(figure).draw()
    (axes,), (below,) = figure.axes, figure.legends
    label = axes.xaxis.label.get_window_extent()
    assert label.width < 0.9 * axes.get_window_extent().width
    assert label.y0 > below.get_window_extent().y1


def test_entries_of_two_lines_in_a_legend_are_above_the_notes():
    made = Picture()
    axes = made.add_subplot()
    handles = [*axes.plot([0, 1], label="a long entry " * 8), *axes.plot([1, 2], label="a short entry")]
    finish(made, axes, handles, ("a note",))
    FigureCanvasAgg(made).draw()
    (note,) = made.texts
    assert "\n" in made.legends[0].get_texts()[0].get_text()
    assert made.legends[0].get_window_extent().y0 > note.get_window_extent().y1


def test_numbers_that_would_overlap_below_a_curve_are_added():
    grouped = _grouped_numbers([0.0, 0.9, 1.0, 1.5, 4.0], [1, 2, 4, 8, 16], 1.0)
    assert grouped == [(0.0, 3), (1.0, 12), (4.0, 16)]


def test_the_text_of_a_mark_does_not_overlap_the_text_of_an_earlier_mark():
    """The text at x = 0.01 overlaps the text at x = 0 and is removed; the text at x = 0.5 remains.

    The name of a block at x = 0 remains too, although it overlaps the text of a mark.
    """
    made = Picture()
    axes = made.add_subplot(xlim=(0, 1), ylim=(0, 1))
    for x in (0.0, 0.01, 0.5):
        motion, point = np.zeros((1, 3)), np.full((1, 1, 2), (x, 0.5))
        mark = Marks("openings", "", "point", "#000000", 0.0, point, motion, text=f"{x:g}")
        draw_marks(axes, mark, mark.points)
    write_name(axes, "A", np.array([0.0, 0.5]), 8.0, 0.0)
    remove_overlapping_texts(made, axes)
    assert [text.get_text() for text in axes.texts] == ["0", "0.5", "A"]


def test_numbers_of_joints_below_a_curve_do_not_overlap():
    """Each row below the curve contains the number of all joints that start to slide or to open."""
    result = mo.solve(small_wall(), "incremental", curve=True)
    figure = result.plot("curve")
    canvas = FigureCanvasAgg(figure)
    canvas.draw()
    for column, word in (("starts_sliding", "slide"), ("starts_opening", "open")):
        texts = figure.axes[0].texts
        (row,) = {text.get_position()[1] for text in texts if text.get_text() == f"start to {word}"}
        numbers = [text for text in texts if text.get_position()[1] == row and text.get_text().isdigit()]
        assert sum(int(text.get_text()) for text in numbers) == result.curve[column].map(len).sum()
        boxes = [text.get_window_extent() for text in numbers]
        assert all(left.x1 < right.x0 for left, right in pairwise(boxes))


@pytest.mark.parametrize("ending", ["png", "HTML"])
def test_a_curve_is_written_in_every_format(curved, ending, tmp_path):
    curved.save(tmp_path / f"curve.{ending}", "curve")
    written = (tmp_path / f"curve.{ending}").read_bytes()
    assert written.startswith(BEGINS[ending])
    assert (b'src="data:image/svg+xml;base64,' in written) == (ending == "HTML")


PACKAGE = Path(masonry_opt.__file__).parent


def test_no_other_module_has_colours_of_its_own():
    named = {colours.BLUE, colours.VERMILION, colours.BLUISH_GREEN, colours.REDDISH_PURPLE, colours.ORANGE}
    named |= {colours.SKY_BLUE, colours.BLACK}
    assert set(SERIES) == named
    assert len(SERIES) == len(named) == 7
    home = PACKAGE / "drawing" / "colours.py"
    others = [path for path in PACKAGE.rglob("*.py") if path != home]
    written = [path.read_text("utf-8").upper() for path in others]
    assert not [text for text in written if any(colour in text for colour in named - {colours.BLACK})]


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize("ending", ["png", "pdf", "svg"])
def test_letters_that_the_font_lacks_are_boxes_without_a_warning(tmp_path, ending):
    scene = block_on_floor().replace(title="石塔", blocks={"A": {"name": "石塔 क"}})
    with mpl.rc_context({"font.family": ["DejaVu Sans"]}):
        mo.draw(scene, tmp_path / f"a.{ending}", names=True)


def test_names_of_inclined_stones_do_not_overlap():
    """The stones of a ring are as wide as high in their bounding boxes, but much narrower."""
    ring = mo.Arch(radius=4, angles=(180, 0), thickness=1.2, voussoirs=35, unit_weight=20)
    scene = mo.Scene(title="ring", joints=mo.JointDefaults(friction=0.9), blocks=ring.blocks())
    figure = mo.draw(scene, names=True)
    FigureCanvasAgg(figure).draw()
    boxes = [text.get_window_extent() for text in figure.axes[0].texts if text.get_text().startswith("v")]
    assert len(boxes) == 35
    assert not any(one.overlaps(other) for one, other in combinations(boxes, 2))


ARCH = CASES / "casapulla_lauro" / "arch.toml"


def data_of(text):
    """Return the data that the script of a page uses."""
    return json.loads(re.search(r'id="data">(.*?)</script>', text, re.DOTALL)[1])


@pytest.mark.parametrize("case", [WALLS[0], ARCH], ids=["wall", "arch"])
def test_a_page_has_the_elements_and_their_legends(case):
    """A page has all elements of the pictures, in the same colours and at the same places. A slider moves the
    elements."""
    result = solved(case)
    elements, text = result_elements(result), page(result)
    canvas = Canvas(elements, elements.all_marks)
    groups = re.findall(r'<g class="(\w+)" fill="[^"]*" stroke="([^"]*)"[^>]*>(.*?)</g>', text)
    groups = [group for group in groups if group[0] not in ("rest", "blocks", "supports", "rims")]
    marks = [*elements.loads, *(each for layer in elements.layers.values() for each in layer)]
    assert [group[:2] for group in groups] == [(each.name, each.colour) for each in marks]
    for each, (_, _, drawn) in zip(marks, groups, strict=True):
        begun = {(int(x), int(y)) for x, y in re.findall(r"M(-?\d+) ?(-?\d+)", drawn)}
        assert {tuple(point) for point in canvas.at(each.points[:, 0]).tolist()} <= begun
        moves = each.motion is not None and np.abs(canvas.motions(each.motion)).max() > 10
        assert ("data-motion" in drawn) == moves
    for kind in PICTURE_KINDS:
        entries = re.search(rf'<ul class="{kind}">(.*?)</ul>', text)[1]
        for label in legend([*elements.layers[kind], *elements.loads]):
            assert label in entries


@pytest.mark.parametrize("scene", [WALLS[0], on_a_corner()], ids=["wall", "corner on an edge"])
def test_forces_of_every_joint_are_those_of_the_result(scene):
    result = mo.solve(scene)
    data = data_of(page(result))
    names = np.array(data["blocks"])
    for name in ("first", "second"):
        assert names[data["joints"][name]].tolist() == result.joints[name].tolist()
    for name in ("n", "s", "m", "slip", "opening", "utilisation"):
        expected = result.joints[name].to_numpy()
        got = np.array([np.nan if value is None else value for value in data["joints"][name]])
        nothing = 1e-6 * np.nanmax(np.abs(expected))
        assert got == pytest.approx(expected, rel=6e-5, abs=nothing, nan_ok=True)


def test_blocks_that_move_are_those_of_the_mechanism():
    result = solved(WALLS[0])
    text = page(result)
    drawn = text[text.index('<g class="blocks"') : text.index('<g class="supports"')]
    groups = re.findall(r"<g([^>]*)>(<path.*?)</g>", drawn)
    moves = ["data-motion" in attributes for attributes, inside in groups for _ in re.findall('d="M', inside)]
    speed = np.zeros(len(result.assembly.scene.blocks))
    speed[result.assembly.movable] = np.hypot(result.blocks["vx"], result.blocks["vy"])
    assert moves == (speed > 1e-6 * speed.max()).tolist()
    assert 0 < sum(moves) < len(moves) - 1


NASTY = '<script>alert("$x")</script>&\'</svg>${title}'


@pytest.mark.slow
def test_words_of_the_case_are_words_and_nothing_else():
    named = {"A": {"name": NASTY}}
    result = mo.solve(block_on_floor().replace(title=f"{NASTY} {'very ' * 300}\n long", blocks=named))
    text = page(result)
    assert "<script>alert" not in text
    assert data_of(text)["blocks"][0] == NASTY
    assert unescape(re.search("<title>(.*?)</title>", text)[1]).startswith(NASTY)
    assert "<script" not in result._repr_html_()


def test_the_page_asks_for_nothing():
    text = page(solved(WALLS[0]))
    assert not re.findall(r"(?:src|href|url|@import)\s*[=(]", text)
    assert set(re.findall(r"https?://[^\"' ]*", text)) == {"http://www.w3.org/2000/svg"}


@pytest.mark.parametrize(("scene", "moves"), [(overhanging, True), (pressed_down, False)])
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


@pytest.mark.slow
def test_a_notebook_shows_a_picture_that_clashes_with_no_other():
    result = mo.solve(block_on_floor(4, 2, 0.5))
    text = result._repr_html_()
    assert not re.findall(r"\bid=|<style|<script|url\(", text)
    assert "λ = 0.5" in text
    assert result.plot().source() in text


@pytest.mark.parametrize(("push", "is_left"), [(1.0, True), (-1.0, False)])
def test_the_arrow_of_all_weights_is_in_the_corner_that_the_live_load_leaves(push, is_left):
    """One arrow represents the weights of forty blocks. It is beside the blocks, not above them."""
    wall = small_wall(10, 4)
    blocks = [
        block if block.fixed else block.replace(live_per_weight=(push, 0.0), live=(0.0, 0.0))
        for block in wall.blocks
    ]
    elements = scene_elements(assemble(wall.replace(blocks=blocks)))
    (arrow,) = [marks for marks in elements.loads if marks.label == "direction of all weights"]
    corners = np.concatenate([block.corners() for block in wall.blocks if not block.fixed])
    corners = corners - elements.assembly.geometry.origin
    points = arrow.points.reshape(-1, 2)
    assert points[:, 1].max() <= corners[:, 1].max()
    assert bool(points[:, 0].max() < corners[:, 0].min()) is is_left
    assert bool(points[:, 0].min() > corners[:, 0].max()) is not is_left


@pytest.mark.parametrize("count", [1, 3, 4, 5, 7])
@pytest.mark.parametrize("length", [4, 20, 70])
def test_a_legend_fits_into_the_picture(count, length):
    """The columns of labels and samples are at most 84 characters wide, if one label fits."""
    columns = _legend_columns(["x" * length] * count)
    assert columns == 1 or min(columns, count) * (length + 7) <= 84
    if length == 4:
        assert columns >= min(count, 3)

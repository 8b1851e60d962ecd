"""Pictures of every kind, in every format: the elements and nothing else, and what is refused."""

from pathlib import Path

import matplotlib as mpl
import numpy as np
import pytest
from drawn import solved
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.collections import LineCollection
from matplotlib.font_manager import FontProperties, findfont, get_font
from matplotlib.quiver import Quiver
from matplotlib.text import Text
from scenes import CASES, WALLS, block_on_floor, overhanging, two_blocks

import masonry_opt
import masonry_opt as mo
from masonry_opt.drawing import colours
from masonry_opt.drawing.colours import SERIES
from masonry_opt.drawing.elements import KINDS, START, legend, result_elements
from masonry_opt.drawing.figure import NOTE, boxed

BEGINS = {"png": b"\x89PNG\r\n\x1a\n", "svg": b"<?xml", "pdf": b"%PDF-", "HTML": b"<!doctype html"}


@pytest.fixture(scope="module")
def result():
    return mo.solve(two_blocks())


def points_of(artist):
    """Where the marks of an artist are."""
    if isinstance(artist, LineCollection):
        return np.array(artist.get_segments())
    if isinstance(artist, Quiver):
        return np.stack([artist.XY, artist.XY + np.column_stack([artist.U, artist.V])], axis=1)
    return np.ma.getdata(artist.get_offsets())[:, None]


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("case", [WALLS[0], CASES / "pippard_ashby" / "rib.toml"], ids=["wall", "arch"])
def test_a_picture_has_the_elements_and_their_legend(case, kind):
    result = solved(case)
    elements, figure = result_elements(result), result.plot(kind)
    marks = [each for each in elements.shown(kind) if each.shape != "bar"]
    # Before them come supports, blocks, and outlines at rest.
    artists = figure.axes[0].collections[3 if kind == "mechanism" else 2 :]
    share = START if kind == "mechanism" else 0.0
    for each, artist in zip(marks, artists, strict=True):
        expected = each.moved(share) + elements.assembly.geometry.origin
        assert points_of(artist) == pytest.approx(expected)
    told = [text.get_text() for text in figure.legends[0].get_texts()]
    assert told == ["block", "support", *legend(elements.shown(kind))]
    bars = [axes.get_xlabel() for axes in figure.axes[1:]]
    assert ["utilisation" in label for label in bars] == ([True] if kind == "utilisation" else [])


@pytest.mark.parametrize(("kind", "ending"), list(zip([*KINDS, KINDS[0]], BEGINS, strict=True)))
def test_every_kind_is_written_in_every_format(result, kind, ending, tmp_path):
    """As the ending says; a page shows first the kind asked for."""
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
        ("a.gif", {}),
        ("a", {}),
        ("none/a.html", {}),
        ("none/a.png", {}),
        ("a.html", {"names": True}),
        ("a.html", {"kind": "stress"}),
    ],
)
def test_what_cannot_be_written_is_refused_and_leaves_nothing(result, tmp_path, name, how):
    with pytest.raises(mo.OptionError):
        result.save(tmp_path / name, **how)
    assert not list(tmp_path.iterdir())


def test_a_picture_shows_title_and_load_factor(tmp_path):
    with mpl.rc_context({"svg.fonttype": "none"}):
        mo.solve(WALLS[0], "nonassociative").save(tmp_path / "wall.svg")
    text = (tmp_path / "wall.svg").read_text()
    for words in ("Ferris &amp; Tin-Loi wall 1", "0.63982"):
        assert words in text


@pytest.mark.parametrize("kind", KINDS)
def test_names_are_written_where_asked_for(result, kind):
    for names in (False, True):
        axes = result.plot(kind, names=names).axes[0]
        written = {text.get_text() for text in axes.texts}
        assert ({"A", "B", "floor", "support"} <= written) == names


@pytest.mark.parametrize("kind", ["thrust", "utilisation"])
def test_without_forces_the_picture_says_so(kind):
    axes = mo.solve(overhanging()).plot(kind).axes[0]
    assert [text.get_text() for text in axes.texts] == ["no forces were found to draw"]


@pytest.mark.parametrize("height", [1, 20, 200])
def test_the_scale_keeps_its_label_beside_slender_scenes(height):
    """The bar is up to 12 % of the height long: more than a slender column leaves free beside it."""
    blocks = [
        mo.Block(name=str(y), vertices=[(0, y), (0.5, y), (0.5, y + 1), (0, y + 1)], weight=1, live=(1, 0))
        for y in range(height)
    ]
    floor = mo.Block(name="floor", vertices=[(-1, -1), (2, -1), (2, 0), (-1, 0)], fixed=True)
    scene = mo.Scene(joints=mo.JointDefaults(friction=0.6), blocks=[*blocks, floor])
    figure = mo.solve(scene, "static").plot("thrust")
    canvas = FigureCanvasAgg(figure)
    canvas.draw()
    (label,) = figure.axes[0].texts
    box, axes = label.get_window_extent(), figure.axes[0].bbox
    assert axes.x0 <= box.x0 < box.x1 <= axes.x1
    assert axes.y0 <= box.y0 < box.y1 <= axes.y1


@pytest.fixture(scope="module")
def curved():
    return mo.solve(block_on_floor(), "compliant", curve=True)


def test_a_curve_is_drawn_with_its_load_factor_and_the_first_joints_that_move(curved):
    figure, curve = curved.plot("curve"), curved.curve
    axes = figure.axes[0]
    drawn = {line.get_label(): line.get_xydata() for line in axes.lines}
    states = curve[["displacement", "load_factor"]].to_numpy()
    assert any(np.array_equal(points, states) for points in drawn.values())
    assert any((points[:, 1] == curved.load_factor).all() for points in drawn.values())
    (first,) = np.flatnonzero(curve["starts_opening"])
    assert any(np.array_equal(points, states[first : first + 1]) for points in drawn.values())
    assert {text.get_text() for text in axes.texts} == {"1", "start to open"}
    told = [text.get_text() for text in figure.legends[0].get_texts()]
    assert told == ["load factor λ = 0.5", "associative λ = 0.5", "the first joints open"]
    assert axes.get_xscale() == "log"


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
    assert len(others) > 100
    repeated = named - {colours.BLACK}
    assert not [
        path for path in others if any(colour in path.read_text("utf-8").upper() for colour in repeated)
    ]


#: Of DejaVu Sans, which matplotlib brings, the first two are none.
MISSING, THERE = "石塔", "Gewölbe λ ≥ « مرحبا »"


def named(name):
    scene = block_on_floor()
    blocks = [scene.blocks[0].model_copy(update={"name": name}), scene.blocks[1]]
    return scene.model_copy(update={"title": name, "blocks": blocks})


def texts(figure):
    return [text.get_text() for text in figure.findobj(Text) if text.get_text()]


@pytest.fixture(autouse=True)
def usual_font():
    with mpl.rc_context({"font.family": ["DejaVu Sans"]}):
        yield


def test_boxes_stand_for_what_the_font_lacks():
    letters = get_font(findfont(FontProperties())).get_charmap()
    assert not any(ord(letter) in letters for letter in MISSING)
    assert boxed(f"{MISSING}\n{THERE}") == f"□□\n{THERE}"


@pytest.mark.filterwarnings("error")
def test_a_picture_has_a_note_of_them(tmp_path):
    result, kind = mo.solve(named(MISSING), "static"), "mechanism"
    figure = result.plot(kind, names=True)
    assert any(NOTE.split(":")[1][:20] in text for text in texts(figure))
    assert "□□" in texts(figure)  # the block's
    for ending in ("png", "pdf"):
        result.save(tmp_path / f"a.{ending}", kind, names=True)
    assert not any("□" in text for text in texts(mo.solve(named(THERE), "static").plot(kind, names=True)))

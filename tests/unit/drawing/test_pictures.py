"""Pictures of every kind, in every format: the elements and nothing else, and what is refused."""

from __future__ import annotations

import matplotlib as mpl
import numpy as np
import pytest
from drawn import solved
from matplotlib import _pylab_helpers
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.collections import LineCollection
from matplotlib.quiver import Quiver
from scenes import CASES, WALLS, block_on_floor, overhanging, two_blocks

import masonry_opt as mo
from masonry_opt.drawing.elements import KINDS, START, legend, result_elements

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


@pytest.mark.parametrize("ending", BEGINS)
@pytest.mark.parametrize("kind", KINDS)
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


def test_titles_may_hold_anything(tmp_path):
    scene = block_on_floor().model_copy(update={"title": "costs $\\frac{$ " + "very " * 40})
    mo.solve(scene).save(tmp_path / "picture.png")


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


@pytest.mark.parametrize("height", [1, 4, 12, 20, 28, 60, 200])
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


def test_a_notebook_shows_a_picture_without_pyplot(result):
    assert result.plot()._repr_png_().startswith(BEGINS["png"])
    assert not _pylab_helpers.Gcf.get_all_fig_managers()


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


@pytest.mark.parametrize("ending", BEGINS)
def test_a_curve_is_written_in_every_format(curved, ending, tmp_path):
    curved.save(tmp_path / f"curve.{ending}", "curve")
    written = (tmp_path / f"curve.{ending}").read_bytes()
    assert written.startswith(BEGINS[ending])
    assert (b'src="data:image/svg+xml;base64,' in written) == (ending == "HTML")


def test_without_a_curve_or_with_names_there_is_no_such_picture(result, curved):
    with pytest.raises(mo.OptionError, match="curve=True"):
        result.plot("curve")
    with pytest.raises(mo.OptionError, match="names"):
        curved.plot("curve", names=True)


def test_unknown_kinds_are_refused_and_the_known_ones_named(result):
    with pytest.raises(mo.OptionError) as error:
        result.plot("stress")
    assert all(kind in str(error.value) for kind in ("stress", *KINDS))

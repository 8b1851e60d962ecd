"""Names in letters that the font of pictures does not have: boxes and a note, and no warning."""

from __future__ import annotations

import matplotlib as mpl
import pytest
from matplotlib.font_manager import FontProperties, findfont, get_font
from matplotlib.text import Text
from scenes import block_on_floor

import masonry_opt as mo
from masonry_opt.drawing.figure import NOTE, boxed

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


@pytest.mark.parametrize("kind", ["mechanism", "thrust", "utilisation"])
@pytest.mark.filterwarnings("error")
def test_a_picture_has_a_note_of_them(tmp_path, kind):
    result = mo.solve(named(MISSING), "static")
    figure = result.plot(kind, names=True)
    assert any(NOTE.split(":")[1][:20] in text for text in texts(figure))
    assert "□□" in texts(figure)  # the block's
    for ending in ("png", "svg", "pdf"):
        result.save(tmp_path / f"a.{ending}", kind, names=True)
    assert not any("□" in text for text in texts(mo.solve(named(THERE), "static").plot(kind, names=True)))


@pytest.mark.filterwarnings("error")
def test_a_scene_s_warnings_have_them_too(tmp_path):
    """Two corners that meet, of blocks with such names."""
    scene = named(MISSING)
    apart = scene.model_copy(
        update={
            "blocks": [
                *scene.blocks,
                mo.Block(name="離", vertices=[(1, 2), (2, 2), (2, 3), (1, 3)], weight=1),
            ]
        }
    )
    figure = mo.draw(apart, tmp_path / "a.png", names=True)
    assert any("warning" in text and "□" in text for text in texts(figure))

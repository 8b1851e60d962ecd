"""Pictures of every kind, in every format, and what is refused."""

from __future__ import annotations

import matplotlib as mpl
import pytest
from matplotlib import _pylab_helpers
from scenes import WALLS, two_blocks

import masonry_opt as mo
from masonry_opt.report.pictures.figure import FORMATS
from masonry_opt.report.pictures.result_picture import KINDS

BEGINS = {"png": b"\x89PNG\r\n\x1a\n", "svg": b"<?xml", "pdf": b"%PDF-"}


@pytest.fixture(scope="module")
def result():
    return mo.solve(two_blocks())


@pytest.mark.parametrize("ending", FORMATS)
@pytest.mark.parametrize("kind", KINDS)
def test_every_kind_is_written_in_every_format(result, kind, ending, tmp_path):
    result.save(tmp_path / f"picture.{ending}", kind)
    written = (tmp_path / f"picture.{ending}").read_bytes()
    assert written.startswith(BEGINS[ending])
    assert len(written) > 5000
    assert [path.name for path in tmp_path.iterdir()] == [f"picture.{ending}"]


def test_a_picture_shows_title_and_load_factor(tmp_path):
    with mpl.rc_context({"svg.fonttype": "none"}):
        mo.solve(WALLS[0], "nonassociative").save(tmp_path / "wall.svg")
    text = (tmp_path / "wall.svg").read_text()
    for words in ("Ferris &amp; Tin-Loi wall 1", "0.63982", "sliding joint", "hinging joint"):
        assert words in text


@pytest.mark.parametrize("kind", KINDS)
def test_names_are_written_where_asked_for(result, kind):
    for names in (False, True):
        axes = result.plot(kind, names=names).axes[0]
        written = {text.get_text() for text in axes.texts}
        assert ({"A", "B", "floor", "support"} <= written) == names


def test_a_notebook_shows_a_picture_without_pyplot(result):
    assert result.plot()._repr_png_().startswith(BEGINS["png"])
    assert not _pylab_helpers.Gcf.get_all_fig_managers()


def test_unknown_kinds_are_refused_and_the_known_ones_named(result, tmp_path):
    path = tmp_path / "old.png"
    path.write_bytes(b"old")
    for refused in (lambda: result.plot("stress"), lambda: result.save(path, kind="stress")):
        with pytest.raises(mo.OptionError) as error:
            refused()
        assert all(kind in str(error.value) for kind in ("stress", *KINDS))
    assert path.read_bytes() == b"old"


def test_what_is_no_picture_file_is_refused(result, tmp_path):
    with pytest.raises(mo.OptionError, match=r"\.svg"):
        result.save(tmp_path / "picture.gif")
    with pytest.raises(mo.OptionError, match="no folder"):
        result.save(tmp_path / "none" / "picture.png")
    assert not list(tmp_path.iterdir())

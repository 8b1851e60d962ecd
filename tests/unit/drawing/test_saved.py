"""Results are written as pictures or pages, by the ending of the file's name."""

from __future__ import annotations

import pytest
from scenes import two_blocks

import masonry_opt as mo
from masonry_opt.errors import OptionError


@pytest.fixture(scope="module")
def result():
    return mo.solve(two_blocks())


@pytest.mark.parametrize(
    ("name", "begins"),
    [("a.png", b"\x89PNG"), ("a.pdf", b"%PDF"), ("a.svg", b"<?xml"), ("a.HTML", b"<!DOCTYPE html")],
)
def test_the_ending_says_what_is_written(result, tmp_path, name, begins):
    result.save(tmp_path / name)
    assert (tmp_path / name).read_bytes().lower().startswith(begins.lower())


@pytest.mark.parametrize("kind", ["mechanism", "thrust", "utilisation"])
def test_a_page_shows_first_what_is_asked_for(result, tmp_path, kind):
    result.save(tmp_path / "a.html", kind)
    (chosen,) = [line for line in (tmp_path / "a.html").read_text("utf-8").splitlines() if " checked" in line]
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
    with pytest.raises(OptionError):
        result.save(tmp_path / name, **how)
    assert not list(tmp_path.iterdir())

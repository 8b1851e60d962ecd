"""The gallery: every example asks, holds its answer and stays short. Building the guide runs them all."""

from __future__ import annotations

import ast
import re
from pathlib import Path

import pytest

DOCS = Path(__file__).parents[2] / "docs"
#: The paper's are tested by their command (`tests/reproduce`).
EXAMPLES = sorted(path for path in (DOCS / "gallery").glob("*/*.py") if path.parent.name != "paper")


@pytest.mark.parametrize("path", EXAMPLES, ids=lambda path: path.stem)
def test_example_asks_a_question_answers_it_and_shows_it(path):
    text = path.read_text("utf-8")
    tree = ast.parse(text)
    title = ast.get_docstring(tree).splitlines()[0]
    assert title.endswith("?")
    assert 20 <= len(text.splitlines()) <= 70
    assert any(isinstance(node, ast.Assert) for node in ast.walk(tree))
    last = ast.unparse(tree.body[-1])
    assert re.search(r"\.plot\(.*\)$|^figure$", last), "the last expression is the picture"


def test_there_are_as_many_as_announced():
    assert 20 <= len(EXAMPLES) <= 45
    folders = {path.parent for path in EXAMPLES}
    assert all((folder / "GALLERY_HEADER.rst").is_file() for folder in folders)


def test_figures_are_shown_once_named_or_not(tmp_path, monkeypatch):
    """A figure that is the last expression of a block, and one with a name; neither in the next block."""
    pytest.importorskip("sphinx_gallery")
    monkeypatch.syspath_prepend(str(DOCS / "_ext"))
    from figures import scraper
    from matplotlib.figure import Figure

    paths = iter([tmp_path / f"{number}.png" for number in range(9)])
    variables = {"named": Figure(), "___": Figure(), "other": 3}
    block = {"example_globals": variables, "image_path_iterator": paths}
    shown = scraper(None, block, {"src_dir": str(tmp_path)})
    assert sorted(path.name for path in tmp_path.iterdir()) == ["0.png", "1.png"]
    assert all(name in shown for name in ("0.png", "1.png"))
    variables["___"] = 4
    assert ".png" not in scraper(None, block, {"src_dir": str(tmp_path)})

"""The gallery: every example runs, holds its own answer, and stays short."""

from __future__ import annotations

import ast
import re
import runpy
from pathlib import Path

import pytest

DOCS = Path(__file__).parents[2] / "docs"
#: The paper's are tested by their command (`tests/reproduce`).
EXAMPLES = sorted(path for path in (DOCS / "gallery").glob("*/*.py") if path.parent.name != "paper")

#: Those that take more than a second or two.
SLOW = {
    "arch_on_piers",
    "facade",
    "friction_of_an_arch",
    "friction_sweep",
    "least_thickness",
    "openings",
    "six_walls",
    "uncertain_friction",
}


def examples(*, marked):
    return [
        pytest.param(path, id=path.stem, marks=[pytest.mark.slow] if marked and path.stem in SLOW else [])
        for path in EXAMPLES
    ]


@pytest.mark.parametrize("path", examples(marked=True))
def test_example_runs_and_holds_its_answer(path):
    runpy.run_path(str(path), run_name="__main__")


@pytest.mark.parametrize("path", examples(marked=False))
def test_example_asks_a_question_answers_it_and_shows_it(path):
    text = path.read_text("utf-8")
    tree = ast.parse(text)
    title = ast.get_docstring(tree).splitlines()[0]
    assert title.endswith("?")
    assert 20 <= len(text.splitlines()) <= 70
    assert any(isinstance(node, ast.Assert) for node in ast.walk(tree))
    last = ast.unparse(tree.body[-1])
    assert re.search(r"\.plot\(.*\)$|^figure$", last), "the last expression is the picture"


def test_there_are_as_many_as_announced_and_the_slow_ones_are_there():
    assert 15 <= len(EXAMPLES) <= 25
    assert {path.stem for path in EXAMPLES} >= SLOW
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

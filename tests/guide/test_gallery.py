"""The gallery: every example asks, holds its answer and stays short. Building the guide runs them all."""

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


def test_outputs_of_the_notebook_are_not_stored():
    nbformat = pytest.importorskip("nbformat")
    notebook = nbformat.read(DOCS / "notebook.ipynb", as_version=4)
    nbformat.validate(notebook)
    cells = [cell for cell in notebook.cells if cell.cell_type == "code"]
    assert len(cells) >= 4
    assert all(not cell.outputs and cell.execution_count is None for cell in cells)

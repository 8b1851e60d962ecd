"""The notebook: kept without outputs. Building the guide runs it."""

from __future__ import annotations

from pathlib import Path

import pytest

import masonry_opt as mo

nbformat = pytest.importorskip("nbformat")


@pytest.fixture
def cells():
    notebook = nbformat.read(Path(__file__).parents[2] / "docs" / "notebook.ipynb", as_version=4)
    nbformat.validate(notebook)
    return [cell for cell in notebook.cells if cell.cell_type == "code"]


def test_outputs_are_not_stored(cells):
    assert len(cells) >= 4
    assert all(not cell.outputs and cell.execution_count is None for cell in cells)


def test_the_flow_rule_has_no_influence_on_its_arch(cells):
    """Nothing slides in it."""
    names: dict[str, object] = {}
    exec(cells[0].source, names)
    scene = names["arch"](friction=0.7)
    for method in ("static", "mcp"):
        assert mo.solve(scene, method).load_factor == pytest.approx(0.2049, abs=5e-5)

"""The README shows what the package prints today."""

from __future__ import annotations

import contextlib
import io
import re
from pathlib import Path

import pytest
from scenes import CASES

import masonry_opt as mo
from masonry_opt.report.table1 import table1
from masonry_opt.report.terminal import markdown

README = (Path(__file__).parents[2] / "README.md").read_text()


def blocks(language):
    return re.findall(rf"^```{language}\n(.*?)^```$", README, re.DOTALL | re.MULTILINE)


def test_python_example_prints_what_stands_below_it():
    (example,) = blocks("python")
    (printed,) = blocks("text")
    assert len(example.splitlines()) <= 15
    out = io.StringIO()
    with contextlib.redirect_stdout(out):
        exec(compile(example, "README.md", "exec"), {})
    assert out.getvalue() == printed


def test_case_file_example_is_one(tmp_path):
    (case,) = blocks("toml")
    path = tmp_path / "case.toml"
    path.write_text(case)
    scene = mo.load(path)
    reference = scene.reference["associative"]
    assert mo.solve(scene, "static").load_factor == pytest.approx(reference.value, rel=reference.tolerance)


@pytest.fixture(scope="module")
def table():
    return table1(CASES)


@pytest.mark.parametrize("part", ["table1", "residuals"])
def test_table_is_as_reproduced(table, part):
    """Load factors to the digits shown; residuals, which are rounding and solver noise, to a factor of 2."""
    shown = README.split(f"<!-- {part} -->\n")[1].split(f"<!-- /{part} -->")[0]
    if part == "table1":
        assert shown == markdown(table.load_factors)
        return
    now = markdown(table.residuals.drop(columns=["time (s)", "time, paper (s)"]))
    for line, line_now in zip(shown.splitlines(), now.splitlines(), strict=True):
        for cell, cell_now in zip(line.split("|"), line_now.split("|"), strict=True):
            if "e-" in cell:
                assert float(cell) < 1e-9 or 0.5 < float(cell_now) / float(cell) < 2
            else:
                assert cell == cell_now

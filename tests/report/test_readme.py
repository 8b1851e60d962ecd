"""The README's examples do what it says (its tables: see the slow test of ``reproduce table1``)."""

from __future__ import annotations

import contextlib
import io
import re
from pathlib import Path

import pytest

import masonry_opt as mo

ROOT = Path(__file__).parents[2]
README = (ROOT / "README.md").read_text()


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


def test_pictures_and_pages_exist():
    linked = [link for link in re.findall(r"\]\(([^)]+)\)", README) if "://" not in link]
    assert linked
    for link in linked:
        assert (ROOT / link).is_file(), link

"""The README's examples do what it says (its tables: see the slow test of ``reproduce table1``)."""

from __future__ import annotations

import contextlib
import io
import os
import re
import subprocess
import sys
from pathlib import Path

import pytest
from scenes import block_on_floor, pressed_down

import masonry_opt as mo

ROOT = Path(__file__).parents[2]
README = (ROOT / "README.md").read_text()


def blocks(language):
    return re.findall(rf"^```{language}\n(.*?)^```$", README, re.DOTALL | re.MULTILINE)


def test_python_example_prints_what_stands_below_it():
    example, _ = blocks("python")
    (printed,) = blocks("text")
    assert len(example.splitlines()) <= 15
    out = io.StringIO()
    with contextlib.redirect_stdout(out):
        exec(compile(example, "README.md", "exec"), {})
    assert out.getvalue() == printed


def test_what_the_command_says_is_what_it_says(monkeypatch):
    monkeypatch.chdir(ROOT)
    said = README.split("plain words what moves and at what load:\n\n")[1].split("\n\n")[0]
    assert str(mo.solve("cases/gilbert/two_blocks.toml")) == "\n".join(
        line.removeprefix("    ") for line in said.splitlines()
    )


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


def test_example_of_a_user_s_own_tests_holds_each_case_to_it(tmp_path):
    """λ = 2 is enough, λ = 1/2 is not, and none at all says why."""
    _, example = blocks("python")
    assert len(example.splitlines()) == 10
    (tmp_path / "test_masonry.py").write_text(example)
    (tmp_path / "cases").mkdir()
    scenes = {"enough": block_on_floor(live=(0.25, 0.0)), "weak": block_on_floor(), "none": pressed_down()}
    for name, scene in scenes.items():
        mo.save(scene, tmp_path / "cases" / f"{name}.toml")
    done = subprocess.run(
        [sys.executable, "-m", "pytest", "-q", "--rootdir", str(tmp_path), "-p", "no:cacheprovider", "-rA"],
        cwd=tmp_path,
        env=os.environ | {"PYTHONPATH": str(ROOT)},
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 1, done.stderr
    outcomes = re.findall(r"^(PASSED|FAILED) .*\[(\w+)\]", done.stdout, re.MULTILINE)
    assert {name: word for word, name in outcomes} == {"enough": "PASSED", "weak": "FAILED", "none": "FAILED"}
    assert "unlimited: the live load cannot cause collapse" in done.stdout

"""The command on its own: where it finds case files, and its exit codes."""

from __future__ import annotations

import re
import shutil

import pytest
from scenes import CASES
from typer.testing import CliRunner

from masonry_opt.errors import OptionError
from masonry_opt.studies.cases import case_folder
from masonry_opt.studies.paper.command import app


@pytest.fixture
def elsewhere(tmp_path, monkeypatch):
    """A current folder with nothing in it."""
    monkeypatch.chdir(tmp_path)
    return tmp_path


def run(*arguments):
    return CliRunner().invoke(app, [*map(str, arguments)])


def test_case_files_are_the_packages_own(elsewhere):
    assert case_folder().samefile(CASES)
    (elsewhere / "cases").mkdir()
    assert case_folder().samefile(CASES)  # a folder of that name without the paper's files is none


def test_case_files_here_come_before_the_packages(elsewhere):
    shutil.copytree(CASES, elsewhere / "cases")
    assert case_folder().samefile(elsewhere / "cases")
    assert case_folder(CASES) == CASES


def test_a_result_is_reproduced_anywhere(elsewhere):
    answer = run("fig12", "--out", "out")
    assert answer.exit_code == 0
    assert "wall 6: nonassociative" in answer.stdout
    # Off a terminal a line for each part, and where it all is.
    assert all(re.match(r"fig12(, \d+ s)?: ", line) for line in answer.stderr.splitlines())
    assert "out/index.html" in answer.stderr.splitlines()[-1]
    assert {path.name for path in (elsewhere / "out").iterdir()} == {
        "index.html",
        *(f"fig12.{kind}" for kind in ("csv", "json", "png", "svg")),
    }


@pytest.mark.parametrize("example", ["all", "table1", "stability"])
def test_a_missing_extra_is_said_before_anything_runs(elsewhere, monkeypatch, example):
    monkeypatch.setattr("importlib.util.find_spec", lambda _: None)
    answer = run(example, "--out", "out")
    assert isinstance(answer.exception, OptionError)
    assert ".[mpec]" in str(answer.exception)
    assert list(elsewhere.iterdir()) == []


def test_a_missed_value_ends_with_one(elsewhere):
    cases = shutil.copytree(CASES, elsewhere / "changed")
    wall = cases / "ferris_tinloi" / "wall_6.toml"
    wall.write_text(wall.read_text().replace("value = 0.29649", "value = 0.30649"))
    assert run("fig12", "--cases", cases).exit_code == 1


def test_a_wrong_example_is_named(elsewhere):
    answer = run("fig99")
    assert isinstance(answer.exception, OptionError)
    assert "fig99" in str(answer.exception)
    assert not any(elsewhere.iterdir())

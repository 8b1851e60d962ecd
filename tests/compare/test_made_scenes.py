"""The atlas and the random scenes as case files of a comparison, with the answers known to be right."""

from __future__ import annotations

import pytest
from scenes import CASES
from typer.testing import CliRunner

import masonry_opt as mo
from masonry_opt.answer.status import Status
from masonry_opt.cli import app
from masonry_opt.studies.atlas.entries import ATLAS
from masonry_opt.studies.atlas.entry import Entry, Expectation
from masonry_opt.studies.atlas.large_scenes import LARGE, large_scene
from masonry_opt.studies.atlas.random_scenes import random_scene
from masonry_opt.studies.compare.case_scenes import content_of, find_scenes
from masonry_opt.studies.compare.made_scenes import right_claims, write_atlas, write_large, write_random
from masonry_opt.studies.compare.store import Store


def test_the_atlas_is_written_scene_by_scene_with_its_answers(tmp_path):
    expected = write_atlas(tmp_path, CASES)
    found = {scene.content: scene for scene in find_scenes(expected, expected=expected)}
    assert len(found) == len(expected)
    for entry in ATLAS:
        scene = found[content_of(entry.scene(CASES))]  # the file holds the same scene
        assert right_claims(entry).items() <= scene.expected.items()


@pytest.mark.parametrize(
    ("name", "associative", "coulomb"),
    [
        ("unstable under dead load", Status.UNSTABLE, Status.UNSTABLE),
        ("locking by dilatancy: confined block", Status.LOCKED, "answer"),
        ("live load that does no work", Status.UNLIMITED, Status.UNLIMITED),
        ("gap of 1.01 tolerances", "refused", "refused"),
        # Clarabel is expected to fail there: that says nothing of the scene.
        ("μ very large: wall 1", "answer", "answer"),
    ],
)
def test_right_claims_of_the_atlas(name, associative, coulomb):
    entry = next(entry for entry in ATLAS if entry.name == name)
    assert right_claims(entry) == {"associative": associative, "Coulomb": coulomb}


def test_expected_failures_say_nothing_of_the_scene():
    runs = (Expectation(Status.CYCLING), Expectation(Status.SOLVER_FAILED, "static"))
    assert right_claims(Entry("made up", "", lambda _: random_scene("wall", 0), runs)) == {}


def test_random_scenes_come_by_kind_and_seed(tmp_path):
    paths = write_random(tmp_path, 6)
    assert [path.stem for path in paths] == [
        "wall_0",
        "stack_0",
        "arch_0",
        "tessellation_0",
        "wall_1",
        "stack_1",
    ]
    assert mo.load(paths[4]).blocks == random_scene("wall", 1).blocks


def test_no_random_scenes_are_none(tmp_path):
    assert write_random(tmp_path, 0) == []


def test_the_command_compares_random_scenes(tmp_path):
    arguments = ["--random", "2", "--methods", "static", "--solvers", "highs", "--models", "cvxpy"]
    arguments += ["--tolerances", "1e-9", "--repeats", "1", "--out", str(tmp_path)]
    result = CliRunner().invoke(app, ["compare", *arguments])
    assert result.exit_code == 0, result.output
    assert {row["scene"] for row in Store(tmp_path / "results.csv").rows} == {
        "random/wall_0",
        "random/stack_0",
    }
    assert "named correctly" in result.output
    assert (tmp_path / "success.png").stat().st_size > 1000


def test_large_scenes_come_by_stones_family_and_seed(tmp_path):
    paths = write_large(tmp_path, [40, 20], 2)
    names = [f"{family}_{stones}_{seed}" for stones in (40, 20) for family in LARGE for seed in (0, 1)]
    assert [path.stem for path in paths] == names
    assert mo.load(paths[1]).blocks == large_scene(next(iter(LARGE)), 40, 1).blocks
    assert write_large(tmp_path, [], 2) == []


@pytest.mark.parametrize(("stones", "said"), [("19", "20 stones"), ("6o", "whole numbers")])
def test_a_wrong_number_of_stones_is_refused(stones, said, tmp_path):
    result = CliRunner().invoke(app, ["compare", "--stones", stones, "--out", str(tmp_path)])
    assert isinstance(result.exception, mo.OptionError)
    assert said in str(result.exception)


def test_the_command_compares_large_scenes(tmp_path):
    arguments = ["--stones", "20", "--methods", "mcp", "--repeats", "1", "--out", str(tmp_path)]
    result = CliRunner().invoke(app, ["compare", *arguments])
    assert result.exit_code == 0, result.output
    rows = Store(tmp_path / "results.csv").rows
    assert {row["scene"] for row in rows} == {f"large/{family}_20_0" for family in LARGE}
    assert {(row["method"], row["model"], row["solver"]) for row in rows} == {("mcp", "pyomo", "newton")}

"""The atlas and the random scenes as case files of a comparison, with the answers known to be right."""

from __future__ import annotations

import importlib.util

import pytest
from atlas.entries import ATLAS
from atlas.entry import Entry, Expectation
from atlas.large_scenes import LARGE, large_scene
from atlas.made_scenes import made_scenes, right_claims, write_atlas, write_large, write_random
from atlas.random_scenes import random_scene
from scenes import CASES

import masonry_opt as mo
from masonry_opt.answer.reasons import Status
from masonry_opt.studies.compare.judge import CERTIFIED, NAMED
from masonry_opt.studies.compare.runs import content_of


def test_the_atlas_is_written_scene_by_scene_with_its_answers(tmp_path):
    expected = write_atlas(tmp_path, CASES)
    found = {scene.content: scene for scene in made_scenes(expected)}
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


def test_large_scenes_come_by_stones_family_and_seed(tmp_path):
    paths = write_large(tmp_path, [40, 20], 2)
    names = [f"{family}_{stones}_{seed}" for stones in (40, 20) for family in LARGE for seed in (0, 1)]
    assert [path.stem for path in paths] == names
    assert mo.load(paths[1]).blocks == large_scene(next(iter(LARGE)), 40, 1).blocks
    assert write_large(tmp_path, [], 2) == []


def test_verdicts_on_random_scenes_and_large_ones(tmp_path):
    """The benchmark's command, on scenes of any kind but the atlas's; no answer is wrong."""
    spec = importlib.util.spec_from_file_location("verdicts", CASES.parent / "benchmarks" / "verdicts.py")
    benchmark = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(benchmark)
    asked = ["--no-atlas", "--random", "2", "--stones", "20", "--methods", "mcp", "--out", str(tmp_path)]
    comparison = benchmark.verdicts(benchmark.arguments(asked))
    large = {f"large/{family}_20_0" for family in LARGE}
    assert set(comparison.results["scene"]) == {
        "random/wall_0",
        "random/stack_0",
        *large,
    }
    assert set(comparison.summary["verdict"]) <= {CERTIFIED, NAMED}
    assert {"random/wall_0", "random/stack_0"} <= set(comparison.best)  # of the registry beside the atlas
    assert (tmp_path / "success.png").stat().st_size > 1000

"""The atlas and the random scenes as case files of a comparison, with the answers known to be right."""

import importlib.util

import pytest
from atlas.entries import ATLAS
from atlas.large_scenes import LARGE
from atlas.made_scenes import made_scenes, right_claims, write_atlas
from scenes import CASES

from masonry_opt.studies.compare.judge import CERTIFIED, NAMED
from masonry_opt.studies.compare.runs import content_of


def test_the_atlas_is_written_scene_by_scene_with_its_answers(tmp_path):
    expected = write_atlas(tmp_path, CASES)
    found = {scene.content: scene for scene in made_scenes(expected)}
    assert len(found) == len(expected)
    for entry in ATLAS:
        scene = found[content_of(entry.scene(CASES))]  # the file holds the same scene
        assert right_claims(entry).items() <= scene.expected.items()


@pytest.mark.slow
def test_verdicts_on_random_scenes_and_large_ones(tmp_path):
    """The benchmark's command, on scenes of any kind but the atlas's; no answer is wrong."""
    spec = importlib.util.spec_from_file_location("verdicts", CASES.parent / "benchmarks" / "verdicts.py")
    benchmark = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(benchmark)
    asked = ["--no-atlas", "--random", "1", "--stones", "20", "--methods", "mcp", "--out", str(tmp_path)]
    comparison = benchmark.verdicts(benchmark.arguments(asked))
    large = {f"large/{family}_20_0" for family in LARGE}
    assert set(comparison.results["scene"]) == {"random/wall_0", *large}
    assert set(comparison.summary["verdict"]) <= {CERTIFIED, NAMED}
    assert "random/wall_0" in comparison.best  # of the registry beside the atlas
    assert (tmp_path / "time_error_coulomb.png").stat().st_size > 1000

"""The atlas and random scenes as case files of a comparison, and verdicts by their known answers."""

import importlib.util

import pytest
from atlas.entries import ATLAS
from atlas.large_scenes import LARGE
from atlas.made_scenes import judged_by_hand, right_claims, write_atlas
from lines import line
from scenes import CASES

from masonry_opt.solution.reasons import Status
from masonry_opt.studies.compare.judge import CERTIFIED, FAILED, REASON_NAMED, WRONG, summary
from masonry_opt.studies.compare.runs import content_of, find_scenes


@pytest.mark.slow
def test_the_atlas_is_written_scene_by_scene_with_its_answers(tmp_path):
    expected = write_atlas(tmp_path, CASES)
    found = {scene.content: expected[scene.path] for scene in find_scenes(expected)}
    assert len(found) == len(expected)
    for entry in ATLAS:
        known = found[content_of(entry.scene(CASES))]  # the file holds the same scene
        assert right_claims(entry).items() <= known.items()


CONFINED = {"associative": Status.LOCKED, "Coulomb": "answer"}
REFUSED = {"associative": "refused"}


@pytest.mark.parametrize(
    ("known", "method", "claims", "verdicts"),
    [
        (CONFINED, "static", [Status.LOCKED, Status.UNLIMITED, "answer"], [REASON_NAMED, WRONG, WRONG]),
        (CONFINED, "static", [Status.SOLVER_FAILED], [FAILED]),
        (CONFINED, "coulomb", ["answer", Status.UNSTABLE, Status.CYCLING], [CERTIFIED, WRONG, FAILED]),
        (REFUSED, "static", ["refused", "answer"], [REASON_NAMED, WRONG]),
    ],
)
def test_what_the_atlas_says_of_a_scene_decides_what_is_right(known, method, claims, verdicts):
    for claim, verdict in zip(claims, verdicts, strict=True):
        row = line(scene="a", method=method)
        if claim != "answer":
            row |= {"load_factor": None, "ended" if claim == "refused" else "status": claim}
        judged = judged_by_hand(summary([row], {}, {}), {"a": known})
        assert judged["verdict"].tolist() == [verdict]


@pytest.mark.slow
def test_verdicts_on_random_scenes_and_large_ones(tmp_path):
    """The benchmark command gives no wrong verdict on random and large scenes."""
    spec = importlib.util.spec_from_file_location("verdicts", CASES.parent / "benchmarks" / "verdicts.py")
    benchmark = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(benchmark)
    asked = ["--no-atlas", "--random", "1", "--stones", "20", "--methods", "coulomb", "--out", str(tmp_path)]
    comparison = benchmark.verdicts(benchmark.arguments(asked))
    large = {f"large/{family}_20_0" for family in LARGE}
    assert set(comparison.results["scene"]) == {"random/wall_0", *large}
    assert set(comparison.summary["verdict"]) <= {CERTIFIED, REASON_NAMED}
    assert "random/wall_0" in comparison.best  # from the file best_known.toml of the atlas
    assert (tmp_path / "time_error_coulomb.png").stat().st_size > 1000

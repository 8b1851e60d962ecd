"""Medians, Pareto front and success on made-up runs whose answers are seen."""

import math

import pandas as pd
import pytest
from lines import line

from masonry_opt.studies.compare import frames
from masonry_opt.studies.compare.accuracy import CertifiedBounds

BOUNDS = {name: CertifiedBounds(1 - 1e-12, 1 + 1e-12) for name in ("a", "b", "c")}


def test_times_are_medians_without_what_all_share():
    rows = [
        line(repeat=repeat, wall=wall, scene_seconds=0.25, dead_load_seconds=0.25, scene="a")
        for repeat, wall in enumerate((1.5, 9.5, 2.5), start=1)
    ]
    (only,) = frames.summary(rows, BOUNDS, {}, {}).to_dict("records")
    assert only["time"] == 2.0
    assert only["repeats"] == 3


def test_one_bad_repeat_makes_a_bad_run():
    rows = [line(scene="a"), line(scene="a", repeat=2, flow=1.0), line(scene="a", repeat=3)]
    (only,) = frames.summary(rows, BOUNDS, {}, {}).to_dict("records")
    assert only["verdict"] == "wrong"


def test_of_answers_one_that_bounds_can_be_held_against_is_told():
    """A parabola's has no error, and is no nearer to the bounds than the chords'."""
    rows = [line(scene="a", load_factor=1.005, crushing="parabola")]
    rows += [line(scene="a", solver="highs", wall=9.0, crushing="chords")]
    summary = frames.summary(rows, BOUNDS, {}, {})
    assert list(summary["verdict"]) == ["certified", "certified"]
    assert list(frames.answers(summary)["solver"]) == ["highs"]


def test_runs_without_a_tolerance_are_kept():
    assert len(frames.summary([line(method="refined", tolerance=None)], {}, {}, {})) == 1


def test_pareto_front():
    """Times 1 to 5: the second is slower and worse, the fourth fails, the fifth is slower and no better."""
    frame = pd.DataFrame({"time": [1.0, 2.0, 3.0, 4.0, 5.0], "error": [1e-3, 1e-2, 1e-6, 1e-9, 1e-6]})
    frame["verdict"] = ["certified"] * 3 + ["wrong", "certified"]
    assert list(frames.pareto(frame)["time"]) == [1.0, 3.0]


def test_success_counts_every_end():
    """Five ends of one pair: two certified in 1 s and 3 s, one of them off by 5e-5; one named, ..."""
    rows = [
        line(scene="a"),
        line(scene="b", load_factor=1.00005, wall=3.0),
        line(scene="c", flow=1.0, wall=50.0),
        line(scene="d", load_factor=None, status="not converged: cycling", wall=50.0),
        line(scene="e", load_factor=None, status="unstable under dead load", wall=50.0),
    ]
    unstable = {"e": {"associative": "unstable under dead load"}}
    (counted,) = frames.success(frames.summary(rows, BOUNDS, {}, unstable)).to_dict("records")
    verdicts = ("scenes", "certified", "named correctly", "failed but said so", "wrong")
    assert [counted[verdict] for verdict in verdicts] == [5, 2, 1, 1, 1]
    assert (counted["success"], counted["largest error"]) == (0.6, pytest.approx(5e-5))
    assert counted["time"] == 2.0


def test_success_of_a_pair_that_never_answers_has_no_time():
    rows = [line(scene="a", ended="crashed", load_factor=None)]
    (counted,) = frames.success(frames.summary(rows, BOUNDS, {}, {})).to_dict("records")
    assert (counted["success"], math.isnan(counted["time"])) == (0, True)

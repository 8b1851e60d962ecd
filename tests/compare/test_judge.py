"""Verdicts and errors: a wrong answer is never a good one, and every end has its name."""

from __future__ import annotations

import pytest
from lines import line

from masonry_opt.compare.accuracy import Bounds
from masonry_opt.compare.best_known import BestKnown
from masonry_opt.compare.judge import CERTIFICATE_FAILS, FAILED, GOOD, NAMED_STATUS, judge

BOUNDS = Bounds(0.5 - 1e-11, 0.5 + 1e-11)
BEST = BestKnown(0.4, "refined")


def test_the_error_of_an_associative_answer_is_its_distance_from_the_certified_one():
    judged = judge(line(load_factor=0.5005), BOUNDS, BEST)
    assert judged["verdict"] == GOOD
    assert judged["error"] == pytest.approx(1e-3)


def test_no_error_is_smaller_than_what_is_certified():
    assert judge(line(load_factor=0.5), BOUNDS, BEST)["error"] == pytest.approx(2e-11)


@pytest.mark.parametrize(
    ("load_factor", "gap", "below"), [(0.41, 0.025, False), (0.4, 1e-7, False), (0.39, 0.025, True)]
)
def test_the_gap_of_a_coulomb_answer_is_to_the_best_exact_state(load_factor, gap, below):
    judged = judge(line(method="refined", load_factor=load_factor), BOUNDS, BEST)
    assert judged["error"] == pytest.approx(gap)
    assert judged["below"] == below


def test_without_a_reference_there_is_no_error():
    assert judge(line(), None, None)["error"] is None
    assert judge(line(method="refined"), BOUNDS, None)["error"] is None


@pytest.mark.parametrize(
    ("known", "verdict", "reason"),
    [
        ({"complementarity": 2e-4}, CERTIFICATE_FAILS, "complementarity 2.0e-04 > 1e-04"),
        ({"flow": float("nan")}, CERTIFICATE_FAILS, "flow nan"),
        ({"yield": None}, CERTIFICATE_FAILS, "no certificate"),
        ({"method": "nonassociative", "yield": 0.05}, GOOD, ""),
        ({"method": "nonassociative", "yield": 0.5}, CERTIFICATE_FAILS, "yield 5.0e-01 > 1e-01"),
        ({"method": "mpec", "yield": 1e-5}, CERTIFICATE_FAILS, "yield 1.0e-05 > 1e-06"),
        ({"load_factor": None, "status": "not converged: cycling"}, NAMED_STATUS, "cycling"),
        ({"load_factor": None, "status": "solver failed", "message": "at 3"}, FAILED, "solver failed: at 3"),
        ({"load_factor": None, "ended": "time limit", "message": "over 2 s"}, FAILED, "time limit: over 2 s"),
        ({"load_factor": None, "ended": "crashed", "message": "why"}, FAILED, "crashed: why"),
    ],
)
def test_verdicts(known, verdict, reason):
    judged = judge(line(**known), BOUNDS, BEST)
    assert judged["verdict"] == verdict
    assert reason in judged["reason"]

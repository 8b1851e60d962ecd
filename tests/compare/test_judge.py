"""Verdicts and errors: a wrong answer is never a good one, and every end has its name."""

from __future__ import annotations

import pytest
from lines import line

from masonry_opt.answer.infeasibility import Existence
from masonry_opt.answer.status import Status
from masonry_opt.studies.compare.accuracy import CertifiedBounds
from masonry_opt.studies.compare.best_known import BestKnown
from masonry_opt.studies.compare.judge import (
    CERTIFIED,
    FAILED,
    NAMED,
    WRONG,
    VerdictReason,
    judge,
    reason_text,
)
from masonry_opt.studies.compare.runs import residuals_over_limit

BOUNDS = CertifiedBounds(0.5 - 1e-11, 0.5 + 1e-11)
BEST = BestKnown(0.4, "refined")


def test_the_error_of_an_associative_answer_is_its_distance_from_the_certified_one():
    judged = judge(line(load_factor=0.50004), BOUNDS, BEST, {})
    assert judged["verdict"] == CERTIFIED
    assert judged["error"] == pytest.approx(8e-5)


def test_no_error_is_smaller_than_what_is_certified():
    assert judge(line(load_factor=0.5), BOUNDS, BEST, {})["error"] == pytest.approx(2e-11)


@pytest.mark.parametrize(
    ("load_factor", "gap", "below"), [(0.41, 0.025, False), (0.4, 1e-6, False), (0.39, 0.025, True)]
)
def test_the_gap_of_a_coulomb_answer_is_to_the_best_exact_state(load_factor, gap, below):
    judged = judge(line(method="refined", load_factor=load_factor), BOUNDS, BEST, {})
    assert judged["error"] == pytest.approx(gap)
    assert judged["below"] == below


def test_bounds_of_chords_say_nothing_of_the_parabola():
    """Of the arch of two piers in `tests/validation/test_crushing.py`: 0.6 % above, and as right."""
    row = line(load_factor=0.503, crushing="parabola")
    judged = judge(row, BOUNDS, None, {})
    assert (judged["verdict"], judged["error"]) == (CERTIFIED, None)
    assert judge(row | {"crushing": "chords"}, BOUNDS, None, {})["verdict"] == WRONG
    assert judge(row | {"flow": 1.0}, BOUNDS, None, {})["verdict"] == WRONG


def test_without_a_reference_there_is_no_error():
    assert judge(line(), None, None, {})["error"] is None
    assert judge(line(method="refined"), BOUNDS, None, {})["error"] is None


@pytest.mark.parametrize(
    ("known", "verdict", "reason"),
    [
        ({"complementarity": 2e-4}, WRONG, VerdictReason.RESIDUAL),
        ({"flow": float("nan")}, WRONG, VerdictReason.RESIDUAL),
        ({"yield": None}, WRONG, VerdictReason.NO_CERTIFICATE),
        ({"method": "nonassociative", "yield": 0.05}, CERTIFIED, VerdictReason.NONE),
        ({"method": "nonassociative", "yield": 0.5}, WRONG, VerdictReason.RESIDUAL),
        ({"method": "mpec", "yield": 1e-5}, WRONG, VerdictReason.RESIDUAL),
        ({"load_factor": None, "status": "not converged: cycling"}, FAILED, VerdictReason.NO_ANSWER),
        (
            {"load_factor": None, "status": "solver failed", "message": "at 3"},
            FAILED,
            VerdictReason.NO_ANSWER,
        ),
        ({"load_factor": 0.5002}, WRONG, VerdictReason.ABOVE_BOUND),
        ({"load_factor": 0.4998}, WRONG, VerdictReason.BELOW_BOUND),
        ({"method": "refined", "load_factor": 0.5002}, WRONG, VerdictReason.ABOVE_BOUND),
        ({"method": "refined", "load_factor": 0.4}, CERTIFIED, VerdictReason.NONE),
        ({"load_factor": None, "status": Status.UNSTABLE}, WRONG, VerdictReason.FALSE_CLAIM),
        ({"load_factor": None, "status": Status.LOCKED}, WRONG, VerdictReason.FALSE_CLAIM),
        ({"method": "mpec", "load_factor": None, "status": Status.JAMMED}, WRONG, VerdictReason.FALSE_CLAIM),
        (
            {"method": "mpec", "load_factor": None, "status": Status.UNSTABLE},
            FAILED,
            VerdictReason.UNCONFIRMED,
        ),
        ({"load_factor": None, "ended": "refused"}, FAILED, VerdictReason.UNCONFIRMED),
        ({"load_factor": None, "ended": "time limit"}, FAILED, VerdictReason.TIME_LIMIT),
        ({"load_factor": None, "ended": "memory limit"}, FAILED, VerdictReason.MEMORY_LIMIT),
        ({"load_factor": None, "ended": "crashed", "message": "why"}, FAILED, VerdictReason.CRASHED),
        ({"load_factor": None, "ended": "died"}, FAILED, VerdictReason.DIED),
    ],
)
def test_verdicts(known, verdict, reason):
    judged = judge(line(**({"load_factor": 0.5} | known)), BOUNDS, BEST, {})
    assert (judged["verdict"], judged["reason"]) == (verdict, reason)


def test_residuals_over_their_limits():
    """Complementarity is relative to λ: 2e-4 of 0.5 is four times the limit."""
    row = line(load_factor=0.5, complementarity=2e-4)
    assert residuals_over_limit(row) == {"complementarity": pytest.approx(4e-4)}


def test_what_is_right_is_told_beside_a_false_claim():
    row = line(load_factor=None, status=Status.UNSTABLE)
    assert judge(row, BOUNDS, BEST, {})["right"] == "answer"
    row |= {"method": "mpec", "status": Status.JAMMED}
    assert judge(row, BOUNDS, BEST, {})["right"] == ""


@pytest.mark.parametrize("reason", VerdictReason)
def test_every_reason_but_none_has_its_text(reason):
    row = line(reason=reason, right="", flow=1.0)
    assert bool(reason_text(row)) == (reason != VerdictReason.NONE)


INF = float("inf")
FALLS, UNLIMITED, UNKNOWN = CertifiedBounds(-INF, -INF), CertifiedBounds(INF, INF), CertifiedBounds(-INF, INF)


@pytest.mark.parametrize(
    ("bounds", "method", "claim", "verdict"),
    [
        (FALLS, "static", Status.UNSTABLE, NAMED),
        (FALLS, "refined", Status.UNSTABLE, NAMED),
        (FALLS, "static", 0.5, WRONG),
        (FALLS, "nonassociative", 0.5, WRONG),
        (FALLS, "static", Status.UNLIMITED, WRONG),
        (UNLIMITED, "static", Status.LOCKED, NAMED),
        (UNLIMITED, "kinematic", Status.UNLIMITED, NAMED),
        (UNLIMITED, "static", Status.UNSTABLE, WRONG),
        (UNLIMITED, "static", 0.5, WRONG),
        # Without dilatancy there may be a load factor all the same, or not.
        (UNLIMITED, "refined", 0.5, CERTIFIED),
        (UNLIMITED, "refined", Status.JAMMED, FAILED),
        (UNKNOWN, "static", 0.5, CERTIFIED),
        (UNKNOWN, "static", Status.UNSTABLE, FAILED),
        (None, "static", Status.LOCKED, FAILED),
    ],
)
def test_what_the_bounds_say_of_a_scene_decides_what_is_right(bounds, method, claim, verdict):
    assert judge(_claiming(method, claim), bounds, None, {})["verdict"] == verdict


@pytest.mark.parametrize(
    ("method", "claim", "verdict"),
    [
        ("static", Status.LOCKED, NAMED),
        ("static", Status.UNLIMITED, WRONG),
        ("static", 0.5, WRONG),
        ("static", Status.SOLVER_FAILED, FAILED),
        ("refined", 0.5, CERTIFIED),
        ("refined", Status.UNSTABLE, WRONG),
        ("refined", Status.CYCLING, FAILED),
    ],
)
def test_what_the_atlas_says_of_a_scene_is_what_is_right(method, claim, verdict):
    confined = {"associative": Status.LOCKED, "Coulomb": "answer"}
    assert judge(_claiming(method, claim), None, None, confined)["verdict"] == verdict


def test_a_scene_that_must_be_refused():
    expected = {"associative": "refused"}
    assert judge(line(ended="refused", load_factor=None), None, None, expected)["verdict"] == NAMED
    assert judge(line(), None, None, expected)["verdict"] == WRONG


def _claiming(method, claim):
    """A line with a load factor and a clean certificate, or with a status alone."""
    if isinstance(claim, Status):
        return line(method=method, load_factor=None, status=claim)
    return line(method=method, load_factor=claim)


@pytest.mark.parametrize("scale", [1.0, 1e4])
def test_complementarity_is_relative(scale):
    """A live load 10⁴ times smaller makes λ and the energy in units of it so many times larger."""
    bounds = CertifiedBounds(0.5 * scale, 0.5 * scale)
    for left, verdict in ((2e-5, CERTIFIED), (2e-4, WRONG)):
        row = line(load_factor=0.5 * scale, complementarity=left * scale)
        assert judge(row, bounds, None, {})["verdict"] == verdict


@pytest.mark.parametrize("status", [Status.JAMMED, Status.CYCLING, Status.SOLVER_FAILED])
def test_a_proof_that_no_load_factor_exists_is_the_right_answer(status):
    row = line(method="mcp", load_factor=None, status=status, existence=str(Existence.NO_STATE))
    judged = judge(row, UNLIMITED, None, {})
    assert (judged["verdict"], judged["reason"]) == (NAMED, VerdictReason.RIGHT_CLAIM)
    row |= {"existence": str(Existence.UNBOUNDED)}
    assert judge(row, UNLIMITED, None, {})["verdict"] == FAILED

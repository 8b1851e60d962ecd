"""Verdicts and errors of runs, medians of repeats, the Pareto front, and rates of success."""

import math

import pandas as pd
import pytest
from lines import line

from masonry_opt.solution.answer import Existence
from masonry_opt.solution.reasons import Status
from masonry_opt.studies.compare import judge as judging
from masonry_opt.studies.compare.accuracy import CertifiedBounds
from masonry_opt.studies.compare.judge import CERTIFIED, FAILED, REASON_NAMED, WRONG, BestKnown, judge

BOUNDS = CertifiedBounds(0.5 - 1e-11, 0.5 + 1e-11)
BEST = BestKnown(0.4, "coulomb")


@pytest.mark.parametrize(("load_factor", "error"), [(0.50004, 8e-5), (0.5, 2e-11)])
def test_the_error_of_an_associative_answer_is_its_distance_from_the_certified_one(load_factor, error):
    """The error is the distance from the certified bounds, and at least the width of the bounds."""
    judged = judge(line(load_factor=load_factor), BOUNDS, BEST)
    assert (judged["verdict"], judged["error"]) == (CERTIFIED, pytest.approx(error))


@pytest.mark.parametrize(
    ("found", "gap", "below"), [(0.41, 0.025, False), (0.4, 1e-6, False), (0.39, 0.025, True)]
)
def test_the_gap_of_a_coulomb_answer_is_to_the_best_exact_state(found, gap, below):
    judged = judge(line(method="coulomb", load_factor=found), BOUNDS, BEST)
    assert judged["error"] == pytest.approx(gap)
    assert judged["below"] == below
    assert judge(line(method="coulomb"), BOUNDS, None)["error"] is None


def test_bounds_of_chords_say_nothing_of_the_parabola():
    """With the parabola of crushing, λ may be 0.6 % above the bound by chords and is certified.

    The value is that of the arch on two piers in `tests/validation/test_crushing.py`.
    """
    row = line(load_factor=0.503, crushing="parabola")
    judged = judge(row, BOUNDS, None)
    assert (judged["verdict"], judged["error"]) == (CERTIFIED, None)
    assert judge(row | {"crushing": "chords"}, BOUNDS, None)["verdict"] == WRONG
    assert judge(row | {"flow": 1.0}, BOUNDS, None)["verdict"] == WRONG


def test_what_holds_for_cones_holds_for_their_sides_from_above_alone():
    """With polygons, λ may lie below the bounds by cones, here by 0.3 %, but not above.

    If cones carry any load, polygons, which have less friction, may still have a load factor.
    """
    row = line(load_factor=0.4985, friction_law="polygon of 24 sides")
    judged = judge(row, BOUNDS, None)
    assert (judged["verdict"], judged["error"]) == (CERTIFIED, pytest.approx(3e-3))
    assert judge(row | {"friction_law": "cone"}, BOUNDS, None)["verdict"] == WRONG
    assert judge(row | {"load_factor": 0.503}, BOUNDS, None)["verdict"] == WRONG
    unlimited = CertifiedBounds(float("inf"), float("inf"))
    assert judge(row, unlimited, None)["verdict"] == CERTIFIED
    assert judge(row | {"friction_law": "cone"}, unlimited, None)["verdict"] == WRONG


@pytest.mark.parametrize(
    ("known", "verdict", "reason"),
    [
        ({"complementarity": 2e-4}, WRONG, "complementarity 4.0e-04 > 1e-04"),
        ({"flow": float("nan")}, WRONG, "flow nan > 1e-04"),
        ({"yield": None}, WRONG, "no certificate"),
        ({"method": "nonassociative", "yield": 0.05}, CERTIFIED, ""),
        ({"method": "nonassociative", "yield": 0.5}, WRONG, "yield 5.0e-01 > 1e-01"),
        ({"method": "mpec", "yield": 1e-5}, WRONG, "yield 1.0e-05 > 1e-06"),
        ({"load_factor": None, "status": "not converged: cycling"}, FAILED, "not converged: cycling"),
        ({"load_factor": None, "status": "solver failed", "message": "at 3"}, FAILED, "solver failed: at 3"),
        ({"load_factor": 0.5002}, WRONG, "λ above its certified bound"),
        ({"load_factor": 0.4998}, WRONG, "λ below its certified bound"),
        ({"method": "coulomb", "load_factor": 0.5002}, WRONG, "λ above its certified bound"),
        ({"method": "coulomb", "load_factor": 0.4}, CERTIFIED, ""),
        ({"load_factor": None, "status": Status.UNSTABLE}, WRONG, f"{Status.UNSTABLE} (right: answer)"),
        ({"load_factor": None, "status": Status.LOCKED}, WRONG, f"{Status.LOCKED} (right: answer)"),
        (
            {"method": "mpec", "load_factor": None, "status": Status.JAMMED},
            WRONG,
            f"{Status.JAMMED} (right: not this)",
        ),
        ({"method": "mpec", "load_factor": None, "status": Status.UNSTABLE}, FAILED, Status.UNSTABLE),
        ({"load_factor": None, "ended": "refused"}, FAILED, "refused"),
        ({"load_factor": None, "ended": "time limit"}, FAILED, "time limit"),
        ({"load_factor": None, "ended": "memory limit"}, FAILED, "memory limit"),
        ({"load_factor": None, "ended": "crashed", "message": "why"}, FAILED, "crashed: why"),
        ({"load_factor": None, "ended": "died"}, FAILED, "died"),
    ],
)
def test_verdicts(known, verdict, reason):
    """Each verdict has its reason; the reason of a false claim also states the right claim.

    The residual of complementarity is divided by λ, here 0.5.
    """
    judged = judge(line(**({"load_factor": 0.5} | known)), BOUNDS, BEST)
    assert judged["verdict"] == verdict
    assert judged["reason"] == reason


INF = float("inf")
FALLS = CertifiedBounds(-INF, -INF)
UNLIMITED = CertifiedBounds(INF, INF)
UNKNOWN = CertifiedBounds(-INF, INF)


@pytest.mark.parametrize(
    ("known", "method", "claim", "verdict"),
    [
        (FALLS, "static", Status.UNSTABLE, REASON_NAMED),
        (FALLS, "coulomb", Status.UNSTABLE, REASON_NAMED),
        (FALLS, "static", 0.5, WRONG),
        (FALLS, "nonassociative", 0.5, WRONG),
        (FALLS, "static", Status.UNLIMITED, WRONG),
        (UNLIMITED, "static", Status.LOCKED, REASON_NAMED),
        (UNLIMITED, "kinematic", Status.UNLIMITED, REASON_NAMED),
        (UNLIMITED, "static", Status.UNSTABLE, WRONG),
        (UNLIMITED, "static", 0.5, WRONG),
        # Without dilatancy, a load factor may exist or not.
        (UNLIMITED, "coulomb", 0.5, CERTIFIED),
        (UNLIMITED, "coulomb", Status.JAMMED, FAILED),
        (UNKNOWN, "static", 0.5, CERTIFIED),
        (UNKNOWN, "static", Status.UNSTABLE, FAILED),
        (None, "static", Status.LOCKED, FAILED),
    ],
)
def test_what_bounds_say_of_a_scene_decides_what_is_right(known, method, claim, verdict):
    row = line(method=method, load_factor=None)
    row["load_factor" if isinstance(claim, float) else "status"] = claim
    assert judge(row, known, None)["verdict"] == verdict


@pytest.mark.parametrize(("scale", "unit"), [(1.0, 1.0), (1e4, 1.0), (1e-6, 1e-6)])
def test_complementarity_is_relative(scale, unit):
    """The residual of complementarity is divided by λ, so that the size of the live load has no effect.

    With a live load 10⁴ times smaller, λ and the energy in units of the live load are 10⁴ times larger. With
    a live load 10⁶ times as large as the dead load, they are 10⁶ times smaller.
    """
    bounds = CertifiedBounds(0.5 * scale, 0.5 * scale)
    for left, over in ((2e-5, {}), (2e-4, {"complementarity": pytest.approx(4e-4)})):
        row = line(load_factor=0.5 * scale, load_factor_unit=unit, complementarity=left * scale)
        assert judging.residuals_over_limit(row) == over
        assert judge(row, bounds, None)["verdict"] == (WRONG if over else CERTIFIED)


@pytest.mark.parametrize("status", [Status.JAMMED, Status.CYCLING, Status.SOLVER_FAILED])
def test_a_proof_that_no_load_factor_exists_is_the_right_answer(status):
    row = line(method="coulomb", load_factor=None, status=status, existence=str(Existence.NO_STATE))
    judged = judge(row, UNLIMITED, None)
    assert (judged["verdict"], judged["reason"]) == (REASON_NAMED, status)
    row |= {"existence": str(Existence.UNBOUNDED)}
    assert judge(row, UNLIMITED, None)["verdict"] == FAILED


ABOUT_ONE = {name: CertifiedBounds(1 - 1e-12, 1 + 1e-12) for name in ("a", "b", "c")}
REPEATED = [
    line(repeat=n, wall=wall, scene_seconds=0.25, dead_load_seconds=0.25, scene="a")
    for n, wall in enumerate((1.5, 9.5, 2.5))
]


@pytest.mark.parametrize(
    ("rows", "expected"),
    [
        (REPEATED, {"time": 2.0, "repeats": 3}),  # medians, without the times that all runs share
        ([line(scene="a", repeat=n, flow=float(n == 2)) for n in (1, 2, 3)], {"verdict": "wrong"}),
        ([line(scene="a", method="coulomb", tolerance=None)], {"repeats": 1}),
    ],
)
def test_repeats_of_a_run_are_one_line(rows, expected):
    (only,) = judging.summary(rows, ABOUT_ONE, {}).to_dict("records")
    assert {name: only[name] for name in expected} == expected


def test_of_answers_one_that_bounds_can_be_held_against_is_told():
    """The answer shown is the one by chords, because an answer by the parabola has no error to the bounds."""
    rows = [line(scene="a", load_factor=1.005, crushing="parabola")]
    rows += [line(scene="a", solver="highs", wall=9.0, crushing="chords")]
    summary = judging.summary(rows, ABOUT_ONE, {})
    assert list(summary["verdict"]) == ["certified", "certified"]
    assert list(judging.answers(summary)["solver"]) == ["highs"]


def test_pareto_front():
    """Five runs take 1 to 5 s, and the first and the third are on the Pareto front.

    The second is slower and less accurate, the fourth is wrong, and the fifth is slower and not better.
    """
    frame = pd.DataFrame({"time": [1.0, 2.0, 3.0, 4.0, 5.0], "error": [1e-3, 1e-2, 1e-6, 1e-9, 1e-6]})
    frame["verdict"] = ["certified"] * 3 + ["wrong", "certified"]
    assert list(judging.pareto(frame)["time"]) == [1.0, 3.0]


def test_success_counts_every_end():
    """Five runs of one pair count as two certified, one named correctly, one failed and one wrong.

    The certified runs take 1 s and 3 s, and one of them has an error of 5e-5.
    """
    rows = [
        line(scene="a"),
        line(scene="b", load_factor=1.00005, wall=3.0),
        line(scene="c", flow=1.0, wall=50.0),
        line(scene="d", load_factor=None, status="not converged: cycling", wall=50.0),
        line(scene="e", load_factor=None, status="unstable under dead load", wall=50.0),
    ]
    (counted,) = judging.success(judging.summary(rows, ABOUT_ONE | {"e": FALLS}, {})).to_dict("records")
    verdicts = ("scenes", "certified", "named correctly", "reported failure", "wrong")
    assert [counted[verdict] for verdict in verdicts] == [5, 2, 1, 1, 1]
    assert (counted["success"], counted["largest error"]) == (0.6, pytest.approx(5e-5))
    assert counted["time"] == 2.0


def test_success_of_a_pair_that_never_answers_has_no_time():
    rows = [line(scene="a", ended="crashed", load_factor=None)]
    (counted,) = judging.success(judging.summary(rows, ABOUT_ONE, {})).to_dict("records")
    assert (counted["success"], math.isnan(counted["time"])) == (0, True)

"""Verdicts and errors: a wrong answer is never a good one, and every end has its name."""

import pytest
from lines import line

from masonry_opt.answer.infeasibility import Existence
from masonry_opt.answer.reasons import Status
from masonry_opt.studies.compare.accuracy import CertifiedBounds
from masonry_opt.studies.compare.judge import (
    CERTIFIED,
    FAILED,
    NAMED,
    WRONG,
    BestKnown,
    judge,
)
from masonry_opt.studies.compare.runs import residuals_over_limit

BOUNDS = CertifiedBounds(0.5 - 1e-11, 0.5 + 1e-11)
BEST = BestKnown(0.4, "refined")


@pytest.mark.parametrize(("load_factor", "error"), [(0.50004, 8e-5), (0.5, 2e-11)])
def test_the_error_of_an_associative_answer_is_its_distance_from_the_certified_one(load_factor, error):
    """No error is smaller than what is certified."""
    judged = judge(line(load_factor=load_factor), BOUNDS, BEST, {})
    assert (judged["verdict"], judged["error"]) == (CERTIFIED, pytest.approx(error))


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


def test_what_holds_for_cones_holds_for_their_sides_from_above_alone():
    """Some .3 % below the cone, as right, and off by as much; locked by the cone alone, where there is less
    friction by sides."""
    row = line(load_factor=0.4985, friction_law="polygon of 24 sides")
    judged = judge(row, BOUNDS, None, {})
    assert (judged["verdict"], judged["error"]) == (CERTIFIED, pytest.approx(3e-3))
    assert judge(row | {"friction_law": "cone"}, BOUNDS, None, {})["verdict"] == WRONG
    assert judge(row | {"load_factor": 0.503}, BOUNDS, None, {})["verdict"] == WRONG
    unlimited = CertifiedBounds(float("inf"), float("inf"))
    assert judge(row, unlimited, None, {})["verdict"] == CERTIFIED
    assert judge(row | {"friction_law": "cone"}, unlimited, None, {})["verdict"] == WRONG


def test_without_a_reference_there_is_no_error():
    assert judge(line(), None, None, {})["error"] is None
    assert judge(line(method="refined"), BOUNDS, None, {})["error"] is None


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
        ({"method": "refined", "load_factor": 0.5002}, WRONG, "λ above its certified bound"),
        ({"method": "refined", "load_factor": 0.4}, CERTIFIED, ""),
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
    """Of complementarity as a share of λ, here .5. What is right is told beside a false claim."""
    judged = judge(line(**({"load_factor": 0.5} | known)), BOUNDS, BEST, {})
    assert judged["verdict"] == verdict
    assert judged["reason"] == reason


INF = float("inf")
FALLS, UNLIMITED, UNKNOWN = CertifiedBounds(-INF, -INF), CertifiedBounds(INF, INF), CertifiedBounds(-INF, INF)


CONFINED = {"associative": Status.LOCKED, "Coulomb": "answer"}
REFUSED = {"associative": "refused"}


@pytest.mark.parametrize(
    ("known", "method", "claim", "verdict"),
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
        (CONFINED, "static", Status.LOCKED, NAMED),
        (CONFINED, "static", Status.UNLIMITED, WRONG),
        (CONFINED, "static", 0.5, WRONG),
        (CONFINED, "static", Status.SOLVER_FAILED, FAILED),
        (CONFINED, "refined", 0.5, CERTIFIED),
        (CONFINED, "refined", Status.UNSTABLE, WRONG),
        (CONFINED, "refined", Status.CYCLING, FAILED),
        (REFUSED, "static", "refused", NAMED),
        (REFUSED, "static", 0.5, WRONG),
    ],
)
def test_what_bounds_or_the_atlas_say_of_a_scene_decides_what_is_right(known, method, claim, verdict):
    bounds, expected = (None, known) if isinstance(known, dict) else (known, {})
    row = line(method=method, load_factor=None)
    if isinstance(claim, float):
        row["load_factor"] = claim
    else:
        row["ended" if claim == "refused" else "status"] = claim
    assert judge(row, bounds, None, expected)["verdict"] == verdict


@pytest.mark.parametrize("scale", [1.0, 1e4])
def test_complementarity_is_relative(scale):
    """A live load 10⁴ times smaller makes λ and the energy in units of it so many times larger."""
    bounds = CertifiedBounds(0.5 * scale, 0.5 * scale)
    for left, over in ((2e-5, {}), (2e-4, {"complementarity": pytest.approx(4e-4)})):
        row = line(load_factor=0.5 * scale, complementarity=left * scale)
        assert residuals_over_limit(row) == over
        assert judge(row, bounds, None, {})["verdict"] == (WRONG if over else CERTIFIED)


@pytest.mark.parametrize("status", [Status.JAMMED, Status.CYCLING, Status.SOLVER_FAILED])
def test_a_proof_that_no_load_factor_exists_is_the_right_answer(status):
    row = line(method="mcp", load_factor=None, status=status, existence=str(Existence.NO_STATE))
    judged = judge(row, UNLIMITED, None, {})
    assert (judged["verdict"], judged["reason"]) == (NAMED, status)
    row |= {"existence": str(Existence.UNBOUNDED)}
    assert judge(row, UNLIMITED, None, {})["verdict"] == FAILED

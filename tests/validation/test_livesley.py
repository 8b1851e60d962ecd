"""Livesley's wedges: section 5.1 and Fig. 8."""

import math

import pytest
from scenes import CASES, solved

import masonry_opt as mo

WEDGES = CASES / "livesley" / "wedges.toml"


def t(angle: float) -> float:
    return math.tan(math.radians(angle))


#: Uplift over the weight of a wedge, φ = 9°, abutments leaning by 10°.
associative = 1 + (t(9) - t(1)) / (t(9) + t(1))
coulomb = 1 + (t(9) - t(1)) / (t(9) + t(19))


@pytest.mark.parametrize(
    ("method", "model"), [("static", "cvxpy"), ("static", "pyomo"), ("kinematic", "pyomo")]
)
def test_associative(method, model):
    """Linear programs solved to 1e-9."""
    assert associative == pytest.approx(1.80147, abs=5e-6)
    assert solved(WEDGES, method, model=model).load_factor == pytest.approx(associative, rel=1e-7)


def test_coulomb():
    """Proven least, and the only state; the case file has twelve digits of tan 9° and tan 10°."""
    assert coulomb == pytest.approx(1.28034, abs=5e-6)
    result = solved(WEDGES, "global")
    assert result.status is mo.Status.OPTIMAL
    assert result.load_factor == pytest.approx(coulomb, rel=1e-9)
    assert solved(WEDGES).load_factor == pytest.approx(coulomb, rel=1e-9)


def test_the_loop_ends_exactly_there():
    """Its own λ is 9e-5 below, where the small cohesion and the last slope leave it; the exact end, 1e-6."""
    result = solved(WEDGES, "nonassociative")
    assert result.load_factor == pytest.approx(coulomb, rel=1e-6)
    assert result.certificate.complementarity < 1e-7
    assert solved(WEDGES, "nonassociative", finish=False).load_factor == pytest.approx(coulomb, rel=2e-4)


def test_mechanisms_differ_in_the_sense_of_the_unloaded_wedge():
    """Fig. 8: it rises in (a) and does not in (b); the loaded one, of live load 1, rises by 1 in both."""
    dilatant, true = (solved(WEDGES, method).blocks for method in ("static", "global"))
    for blocks in (dilatant, true):
        assert list(blocks["block"]) == ["left", "right"]
        assert blocks["vy"][0] == pytest.approx(1, rel=1e-6)
    assert dilatant["vy"][1] > 0
    assert true["vy"][1] < 0

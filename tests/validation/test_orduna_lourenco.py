"""The 792-block wall of Orduña & Lourenço, section 5.3 and Fig. 13."""

import pytest
from scenes import CASES, solved

import masonry_opt as mo

WALL = CASES / "orduna_lourenco" / "wall.toml"


def test_associative():
    """Published 0.545034; 0.5450342 to more digits (an independent program)."""
    result = solved(WALL, "static")
    assert (result.size.blocks, result.size.joints) == (792, 2265)
    assert result.load_factor == pytest.approx(0.5450342, abs=1e-6)
    assert result.certificate.worst < 1e-5


@pytest.mark.slow
def test_loop_with_rough_sub_problems():
    """Another state, lower than the published one (by accurate ones: the example "fig13"), whose certificate
    holds: λ is an upper bound of the least of the many that the Coulomb problem has."""
    result = solved(WALL, "nonassociative")
    assert result.status is mo.Status.CONVERGED
    assert 0.53 < result.load_factor <= 0.53886
    assert result.certificate.flow < 1e-7
    assert result.certificate.complementarity < 1e-4

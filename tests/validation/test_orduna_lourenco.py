"""The 792-block wall of Orduña & Lourenço, section 5.3 and Fig. 13."""

import pytest
from scenes import CASES, solved

import masonry_opt as mo


@pytest.mark.slow
def test_loop_with_rough_sub_problems():
    """Another state, lower than the published one (by accurate ones: the example "fig13"), whose certificate
    holds: λ is an upper bound of the least of the many that the Coulomb problem has."""
    result = solved(CASES / "orduna_lourenco" / "wall.toml", "nonassociative")
    assert result.status is mo.Status.CONVERGED
    assert 0.53 < result.load_factor <= 0.53886
    assert result.certificate.flow < 1e-7
    assert result.certificate.complementarity < 1e-4

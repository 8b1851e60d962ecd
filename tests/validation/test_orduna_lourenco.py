"""Test of the wall of 792 blocks of Orduña & Lourenço, section 5.3 and Fig. 13."""

import pytest
from scenes import CASES, solved

import masonry_opt as mo


@pytest.mark.slow
def test_loop_with_rough_sub_problems():
    """With rough sub-problems, the loop ends in another state, lower than the published one, with a valid
    certificate.

    Its λ is an upper bound on the least of the many Coulomb states. The example "fig13" has accurate
    sub-problems.
    """
    result = solved(CASES / "orduna_lourenco" / "wall.toml", "nonassociative")
    assert result.status is mo.Status.CONVERGED
    assert 0.53 < result.load_factor <= 0.53886
    assert result.certificate.flow < 1e-7
    assert result.certificate.complementarity < 1e-4

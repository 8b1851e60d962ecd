"""Oppenheim (1992), The masonry arch as a four-link mechanism under base motion: 0.370 g."""

import numpy as np
import pytest
from hinges import four_hinge_load_factors, radial_joints
from scenes import CASES, solved

import masonry_opt as mo

PATH = CASES / "oppenheim" / "seven_voussoirs.toml"
SCENE = mo.load(PATH)
ARCH = SCENE.case.arch[0]


def by_enumeration() -> float:
    angles = np.radians(np.linspace(*ARCH.angles, ARCH.voussoirs + 1))
    half = ARCH.thickness / 2
    # An annular sector's weight and centroid.
    angle = np.radians(157.5 / 7)
    outer, inner = ARCH.radius + half, ARCH.radius - half
    area = angle / 2 * (outer**2 - inner**2)
    distance = 2 / 3 * np.sin(angle / 2) / (angle / 2) * (outer**3 - inner**3) / (outer**2 - inner**2)
    middles = (angles[1:] + angles[:-1]) / 2
    at = distance * np.stack([np.cos(middles), np.sin(middles)], axis=1)
    found = four_hinge_load_factors(radial_joints(ARCH), np.full(7, area), at)
    np.testing.assert_allclose(found, found[0], rtol=1e-9)
    return float(found[0])


def test_four_hinges_give_the_published_acceleration():
    assert by_enumeration() == pytest.approx(0.370, abs=5e-4)


@pytest.mark.parametrize("method", ["static", "mcp", "nonassociative"])
def test_load_factor(method):
    """Nothing slides, so that the flow rule has no influence."""
    assert solved(PATH, method).load_factor == pytest.approx(by_enumeration(), rel=1e-8)


def test_no_coulomb_state_is_lower():
    result = solved(PATH, "global")
    assert result.status is mo.Status.OPTIMAL
    assert result.load_factor == pytest.approx(by_enumeration(), rel=1e-9)

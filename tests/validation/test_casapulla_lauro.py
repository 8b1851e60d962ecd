"""The semicircular arch of section 5.2 and Fig. 9, against published values and closed forms."""

import numpy as np
import pytest
from continuous_arch import least_friction_to_hinge, least_friction_to_stand, least_thickness_ratio
from hinges import four_hinge_load_factors, radial_joints
from paper_scripts import definitions
from scenes import CASES, solved

import masonry_opt as mo

SCENE = mo.load(CASES / "casapulla_lauro" / "arch.toml")
ARCH = SCENE.case.arch[0]
FIG9 = definitions("fig9")
thinnest, transitions = FIG9.thinnest, FIG9.transitions


def variant(**changes):
    return ARCH.model_copy(update=changes)


@pytest.mark.parametrize(
    ("weights", "references"),
    [("sector", ["least_thickness", "least_thickness_sector"]), ("straight", ["least_thickness_straight"])],
)
def test_least_thickness_of_27_voussoirs(weights, references):
    """10.68 % of the radius (paper: four digits); 10.6776 % and 10.672 % by an independent computation."""
    found = thinnest(variant(weights=weights), 0.5)
    for name in references:
        known = SCENE.reference[name]
        assert found.value == pytest.approx(known.value, rel=known.tolerance)
    assert found.evaluations <= 30


def test_closed_forms_are_the_published_ones():
    """Cocchetti & Rizzi (2020) with weights on the centreline; Milankovitch with true centroids."""
    assert least_thickness_ratio("centreline") == pytest.approx(0.107426, abs=6e-7)
    assert least_thickness_ratio("sector") == pytest.approx(0.107478, abs=6e-7)
    assert least_friction_to_hinge("centreline") == pytest.approx(0.395832, abs=1e-6)
    assert least_friction_to_stand() == pytest.approx(0.309215, abs=1e-6)


@pytest.mark.slow
def test_many_voussoirs_come_to_the_closed_form():
    """With true centroids; fig9's script has weights on the centreline."""
    thickness, hinging, sliding = transitions(variant(voussoirs=242))
    assert thickness == pytest.approx(10 * least_thickness_ratio("sector"), rel=1e-4)
    assert hinging == pytest.approx(least_friction_to_hinge("sector"), rel=1e-4)
    assert sliding == pytest.approx(least_friction_to_stand(), rel=1e-4)


def test_load_factor_of_the_case_by_enumeration():
    """The thrust through four hinges that stays within the arch is the one at collapse (Heyman)."""
    ring = SCENE.blocks[:27]
    weight = np.array([block.weight for block in ring])
    at = np.array([block.weight_at for block in ring])
    found = four_hinge_load_factors(radial_joints(ARCH), weight, at)
    assert found.size
    known = SCENE.reference["associative"]
    np.testing.assert_allclose(found, known.value, rtol=known.tolerance)
    assert solved(SCENE, "static").load_factor == pytest.approx(known.value, rel=known.tolerance)

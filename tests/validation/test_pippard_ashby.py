"""The arch rib of section 5.2: where do associative and Coulomb load factors coincide?"""

import pytest
from paper_scripts import definitions
from scenes import CASES, solved

import masonry_opt as mo

RIB = mo.load(CASES / "pippard_ashby" / "rib.toml")
ARCH = RIB.case.arch[0]
rib = definitions("rib").rib


@pytest.mark.parametrize("friction", [0.07, 0.3])
def test_associative_and_coulomb_coincide(friction):
    """Published: for μ above about 0.11. With the geometry assumed, below it too. The loop to its own
    tolerance (1e-5), the exact refinement to 1e-7. The example "rib" has more, and searches."""
    scene = rib(friction)
    associative = solved(scene, "static").load_factor
    assert solved(scene, "nonassociative", always=True).load_factor == pytest.approx(associative, rel=2e-5)
    exact = solved(scene, "refined")
    assert exact.status is mo.Status.CONVERGED
    assert exact.load_factor == pytest.approx(associative, rel=1e-7)


def test_the_rib_has_the_geometry_stated():
    """Intrados of span 10 ft and rise 2.5 ft, 10 in deep; a voussoir weighs 1."""
    first, last = RIB.blocks[0].vertices[0], RIB.blocks[14].vertices[3]
    intrados = ARCH.radius - ARCH.thickness / 2
    assert last[0] - first[0] == pytest.approx(10, rel=1e-9)
    assert intrados - first[1] == pytest.approx(2.5, rel=1e-9)
    assert 12 * ARCH.thickness == pytest.approx(10, rel=1e-9)
    assert RIB.blocks[0].weight == pytest.approx(1, rel=1e-9)

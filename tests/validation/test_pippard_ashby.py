"""Test of the geometry of the arch rib of section 5.2; the example "rib" computes its load factors."""

import pytest
from scenes import CASES

import masonry_opt as mo

RIB = mo.load(CASES / "pippard_ashby" / "rib.toml")
ARCH = RIB.case.arch[0]


def test_the_rib_has_the_geometry_stated():
    """The intrados has a span of 10 ft and a rise of 2.5 ft; the rib is 10 in deep, and a voussoir weighs
    1."""
    first, last = RIB.blocks[0].vertices[0], RIB.blocks[14].vertices[3]
    intrados = ARCH.radius - ARCH.thickness / 2
    assert last[0] - first[0] == pytest.approx(10, rel=1e-9)
    assert intrados - first[1] == pytest.approx(2.5, rel=1e-9)
    assert 12 * ARCH.thickness == pytest.approx(10, rel=1e-9)
    assert ARCH.blocks(RIB.thickness)[0].weight == pytest.approx(1, rel=1e-9)

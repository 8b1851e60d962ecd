"""The programs that stand beside the package for blocks in space: each other, LMGC90, values kept."""

import pytest
from space.boxes import push
from space.cone_program import by_cones
from space.contact_dynamics import load_carried
from space.reference_values import OUTWARDS, REFERENCES

#: Programs end to this; what is carried lies below by less than the second.
EXACT, LAST_INCREMENT = 1e-6, 6.3e-4


@pytest.mark.parametrize("reference", [r for r in REFERENCES if r.blocks <= 20], ids=str)
def test_cones(reference):
    wall = push(reference.boxes, OUTWARDS)
    assert (len(wall.dead), len(wall.area)) == (6 * reference.blocks, reference.points)
    assert by_cones(wall, reference.friction) == pytest.approx(reference.associative, abs=EXACT)


@pytest.mark.parametrize(
    "reference",
    [pytest.param(r, id=str(r), marks=pytest.mark.slow) for r in REFERENCES if r.blocks <= 20],
)
def test_load_carried(reference):
    """Rigid blocks in LMGC90 begin to leave within 3.5 % of it."""
    found = load_carried(push(reference.boxes, OUTWARDS), reference.friction)
    assert found == pytest.approx(reference.carried, abs=LAST_INCREMENT)
    assert found < reference.associative + EXACT
    if reference.lmgc90 is not None:
        assert found == pytest.approx(reference.lmgc90[0], rel=0.035)

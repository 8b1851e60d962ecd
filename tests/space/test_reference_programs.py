"""The programs that stand beside the package for blocks in space: closed forms, LMGC90, values kept."""

import numpy as np
import pytest
from space.boxes import Boxes, contacts, facade, push, pushed, single_box
from space.cone_program import by_cones
from space.contact_dynamics import load_carried, of_wall
from space.reference_values import OUTWARDS, REFERENCES

#: Programs end to this; what is carried lies below by less than the second.
EXACT, LAST_INCREMENT = 1e-6, 6.3e-4


def carries(found: float, load_factor: float) -> bool:
    return load_factor - LAST_INCREMENT < found < load_factor + EXACT


def overturning(a: float, b: float, h: float, angle: float) -> float:
    """A box a × b × h pushed at its centroid turns about an edge at min(a/(h |cos θ|), b/(h |sin θ|))."""
    with np.errstate(divide="ignore"):
        return float(min(a / abs(h * np.cos(angle)), b / np.abs(h * np.sin(angle))))


@pytest.mark.parametrize("friction", [0.2, 0.6])
@pytest.mark.parametrize("angle", [0.0, 1.0, -1.9])
@pytest.mark.parametrize("size", [(1, 2, 4), (2, 1, 1)])
def test_a_box_slides_or_overturns(size, angle, friction):
    wall = push(single_box(*size), (np.cos(angle), np.sin(angle), 0))
    expected = min(friction, overturning(*size, angle))
    assert by_cones(wall, friction) == pytest.approx(expected, abs=EXACT)


@pytest.mark.parametrize(("size", "friction"), [((1, 2, 4), 0.2), ((2, 1, 1), 0.2), ((1, 1, 4), 0.6)])
def test_a_box_carries_what_it_slides_or_overturns_at(size, friction):
    wall = push(single_box(*size), (np.cos(2.0), np.sin(2.0), 0))
    assert carries(load_carried(wall, friction), min(friction, overturning(*size, 2.0)))


def test_cohesion_acts_on_the_whole_face():
    """μ W + c A resists sliding; overturning is far off on so flat a box."""
    wall = push(single_box(2, 1, 0.5), (np.cos(0.3), np.sin(0.3), 0))
    expected = 0.3 + 0.2 * 2 / 1  # W = 1, A = 2
    assert by_cones(wall, 0.3, cohesion=0.2) == pytest.approx(expected, abs=EXACT)
    assert carries(load_carried(wall, 0.3, cohesion=0.2, increment=0.08), expected)


def test_torque_about_the_vertical():
    """Four corners at √(a² + b²)/2 from the middle: μ W √(a² + b²)/2, however they share the weight."""
    box = single_box(2, 1, 1)
    dead, live = np.zeros((2, 2, 6))
    dead[0, 2], live[0, 5] = -2.0, 1.0
    wall = pushed(contacts(box), box.centre, box.fixed, dead, live)
    expected = 0.6 * 2 * np.hypot(2, 1) / 2
    assert by_cones(wall, 0.6) == pytest.approx(expected, abs=EXACT)
    assert carries(load_carried(wall, 0.6, increment=0.08), expected)


def test_what_overhangs_too_far_does_not_stand():
    one = single_box(2, 1, 1)
    upper = np.array([[1.1, 0.0, 1.0]])  # its centroid is .1 beyond the lower box
    boxes = Boxes(
        np.vstack([one.low, one.low[:1] + upper]),
        np.vstack([one.high, one.high[:1] + upper]),
        np.arange(3) == 1,
    )
    wall = push(boxes, OUTWARDS)
    with pytest.raises(ArithmeticError, match="PrimalInfeasible"):
        by_cones(wall, 0.6)
    with pytest.raises(ArithmeticError, match="falls under its weight"):
        load_carried(wall, 0.6)


def test_a_wall_at_rest_is_in_balance_within_the_cones():
    wall = push(facade(4, 3, 3), OUTWARDS)
    springs = of_wall(wall, 0.6)
    state = springs.unloaded
    for load in (wall.dead, wall.dead + 0.3 * wall.live, wall.dead + 0.5 * wall.live):
        state = springs.at_rest(load, state)
        assert state is not None
        normal, shear = state.forces[:, 0], np.hypot(*state.forces[:, 1:].T)
        assert np.abs(wall.B @ state.forces.ravel() + load).max() < 1e-5
        assert normal.min() >= 0
        assert (shear - 0.6 * normal).max() < 1e-9
    # Some points have slid: the last state is none of springs alone.
    assert (shear > 0.6 * normal - 1e-9)[normal > 1e-3].any()


#: Walls on which the programs give the values kept again, as they gave those of the larger ones.
SMALL = [reference for reference in REFERENCES if reference.blocks <= 20]


@pytest.mark.parametrize("reference", SMALL, ids=str)
def test_cones(reference):
    wall = push(reference.boxes, OUTWARDS)
    assert (len(wall.dead), len(wall.area)) == (6 * reference.blocks, reference.points)
    assert by_cones(wall, reference.friction) == pytest.approx(reference.associative, abs=EXACT)


@pytest.mark.slow
@pytest.mark.parametrize("reference", SMALL, ids=str)
def test_load_carried(reference):
    """Rigid blocks in LMGC90 begin to leave within 3.5 % of it."""
    found = load_carried(push(reference.boxes, OUTWARDS), reference.friction)
    assert found == pytest.approx(reference.carried, abs=LAST_INCREMENT)
    assert found < reference.associative + EXACT
    if reference.lmgc90 is not None:
        assert found == pytest.approx(reference.lmgc90, rel=0.035)

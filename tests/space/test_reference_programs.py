"""Contact dynamics, the program beside the package for blocks in space: closed forms, LMGC90, values kept."""

from math import degrees, hypot

import numpy as np
import pytest
from scenes_in_space import box_on_floor, facade, pushed_box
from space.contact_dynamics import load_carried, of_scene
from space.reference_values import REFERENCES
from space.test_closed_forms import overturning

import masonry_opt as mo

#: What is carried lies below the load factor by less than the second.
EXACT, LAST_INCREMENT = 1e-6, 6.3e-4


#: The flat box, of weight 1 and area 2, slides at μ W + c A, overturns far above. About the vertical four
#: corners at √(a² + b²)/2 from the middle bear μ W √(a² + b²)/2, however they share the weight.
BY_HAND = {
    "slides": (pushed_box((2, 1, 1), 0.2, degrees(2.0)), 0.2),
    "overturns": (pushed_box((1, 1, 4), 0.6, degrees(2.0)), overturning((1, 1, 4), degrees(2.0))),
    "cohesion": (pushed_box((2, 1, 0.5), 0.3, degrees(0.3)).replace(cohesion=0.1), 0.3 + 0.1 * 2),
    "torque": (
        box_on_floor((2, 1, 1), 0.6, live=(0, 0, 0), live_moment=(0, 0, 1)),
        0.6 * hypot(2, 1) / 2,
    ),
}


@pytest.mark.parametrize("name", BY_HAND)
def test_a_box_carries_what_brings_it_down_by_hand(name):
    scene, expected = BY_HAND[name]
    found = load_carried(scene, increment=0.08)
    assert expected - LAST_INCREMENT < found < expected + EXACT


def test_what_overhangs_too_far_does_not_stand():
    """By .1 of 2."""
    floor = mo.box("floor", (-1, 0.9), (0, 1), (-1, 0), fixed=True)
    box = mo.box("A", (0, 2), (0, 1), (0, 1), weight=1, live=(0, -1, 0))
    with pytest.raises(ArithmeticError, match="falls under its weight"):
        load_carried(mo.Scene(joints={"friction": 0.6}, blocks=[floor, box]))


def test_a_wall_at_rest_is_in_balance_within_the_cones():
    springs = of_scene(facade(4, 3, 3))
    wall, state = springs.wall, springs.unloaded
    for load_factor in (0.0, 0.3, 0.5):
        load = wall.dead + load_factor * wall.live
        state = springs.at_rest(load, state)
        assert state is not None
        normal, shear = state.forces[:, 0], np.hypot(*state.forces[:, 1:].T)
        assert np.abs(wall.B @ state.forces.ravel() + load).max() < 1e-5
        assert normal.min() >= 0
        assert (shear - 0.6 * normal).max() < 1e-9
    # Some points have slid: the last state is none of springs alone.
    assert (shear > 0.6 * normal - 1e-9)[normal > 1e-3].any()


@pytest.mark.slow
@pytest.mark.parametrize("reference", [of for of in REFERENCES if of.blocks <= 20], ids=str)
def test_load_carried(reference):
    """As it gave it of the larger walls. Rigid blocks in LMGC90 begin to leave within 3.5 % of it."""
    found = load_carried(reference.scene)
    assert found == pytest.approx(reference.carried, abs=LAST_INCREMENT)
    assert found < reference.associative + EXACT
    if reference.lmgc90 is not None:
        assert found == pytest.approx(reference.lmgc90, rel=0.035)

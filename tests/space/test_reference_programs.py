"""Contact dynamics in space compared with closed forms, LMGC90 and values of an implicit program."""

from math import degrees, hypot

import pytest
from contact_dynamics import QUICK, collapse_load
from scenes_in_space import box_on_floor, pushed_box
from space.reference_values import REFERENCES
from space.test_closed_forms import overturning

#: Relative error of load factors by contact dynamics. The load grows until the unbalanced forces exceed a
#: fraction of it, so that a collapse is detected slightly late.
LATE = 0.005

#: Boxes of weight 1 and their load factors by hand. The flat box with cohesion slides at μ W + c A, with
#: A = 2. The moment about the vertical is μ W √(a² + b²)/2, for any distribution of the weight.
BY_HAND = {
    "slides": (pushed_box((2, 1, 1), 0.2, degrees(2.0)), 0.2),
    "overturns": (pushed_box((1, 1, 4), 0.6, degrees(2.0)), overturning((1, 1, 4), degrees(2.0))),
    "cohesion": (pushed_box((2, 1, 0.5), 0.3, degrees(0.3)).replace(cohesion=0.1), 0.3 + 0.1 * 2),
    "torque": (box_on_floor((2, 1, 1), 0.6, live=(0, 0, 0), live_moment=(0, 0, 1)), 0.6 * hypot(2, 1) / 2),
}


@pytest.mark.parametrize("name", BY_HAND)
def test_a_box_carries_what_brings_it_down_by_hand(name):
    scene, expected = BY_HAND[name]
    found = collapse_load(scene, 1.3 * expected, QUICK)
    assert found == pytest.approx(expected, rel=LATE)


@pytest.mark.slow
@pytest.mark.parametrize("reference", [of for of in REFERENCES if of.blocks <= 20], ids=str)
def test_load_carried(reference):
    """The load carried in explicit dynamics is that of an implicit, viscous program, to 0.5 %.

    The load at which rigid blocks in LMGC90 begin to move agrees to 3.5 %.
    """
    found = collapse_load(reference.scene, 1.3 * reference.carried, QUICK)
    assert found == pytest.approx(reference.carried, rel=LATE)
    assert found < reference.associative * (1 + LATE)
    if reference.lmgc90 is not None:
        assert found == pytest.approx(reference.lmgc90, rel=0.035)

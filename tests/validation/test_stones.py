"""Tests of stones with notches, in parts, and on corners, against moments by hand."""

import pytest
from scenes import on_floor, solved

import masonry_opt as mo
from masonry_opt.scene.blocks import rectangle
from masonry_opt.solution.reasons import Status

METHODS = ("static", "kinematic", "nonassociative", "coulomb")


def load_factor(scene, method):
    result = solved(scene, method)
    assert result.certificate is not None
    # Joints that slide contract by a thousandth of the friction in the loop.
    assert result.certificate.worst < (1e-3 if method == "nonassociative" else 1e-7)
    return result.required()


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize(("towards", "expected"), [(1.0, 1.25 / 1.25), (-1.0, 0.75 / 1.25)])
def test_an_l_overturns_about_the_end_of_its_foot(method, towards, expected):
    """A weight of 1 at (0.75, 1.25) is pushed there: λ h is the distance to the toe, at x = 2 or x = 0."""
    outline = [(0, 0), (2, 0), (2, 1), (1, 1), (1, 3), (0, 3)]
    stone = mo.Block(name="A", vertices=outline, weight=1, live=(towards, 0))
    assert load_factor(on_floor(stone, friction=5.0), method) == pytest.approx(expected, rel=1e-7)


@pytest.mark.parametrize("method", METHODS)
def test_a_stone_on_two_levels_overturns_about_the_upper_one(method):
    """An inverted L on two levels turns about (3, 1) if it is pushed to the right: λ (1.25 − 1) = 3 − 1.25.

    It rests on the ground (x 0 to 1) and on a step of height 1 (x 2 to 3), on which it cannot slide. The
    centroid of [0,1]×[0,2] and [1,3]×[1,2] is x = (2·0.5 + 2·2)/4 = 1.25, y = (2·1 + 2·1.5)/4 = 1.25. The
    foot of the stone rises at least twice as fast as it slips, as a dilatancy of 1.5 allows.
    """
    outline = [(0, 0), (1, 0), (1, 1), (3, 1), (3, 2), (0, 2)]
    stone = mo.Block(name="A", vertices=outline, weight=1, live=(1, 0))
    step = mo.Block(name="step", vertices=rectangle(2, 4, 0, 1), fixed=True)
    rough = mo.Joint(between=("A", "step"), friction=float("inf"))
    scene = on_floor(stone, step, friction=1.5, exceptions=[rough])
    assert load_factor(scene, method) == pytest.approx(7.0, rel=1e-6)


@pytest.mark.parametrize("method", METHODS)
def test_a_beam_on_a_corner_lifts_off_its_far_bearing(method):
    """By moments about a corner at x = 1, λ · 1 = 1 · 1: the weight acts at x = 2, and the live load at
    x = 0.

    The far bearing of the beam is from x = 3 to x = 4.
    """
    beam = mo.Block(name="A", vertices=rectangle(0, 4, 0, 1), weight=1, live=(0, -1), live_at=(0, 1))
    prop = mo.Block(name="prop", vertices=[(1, 0), (0.5, -1), (1.5, -1)], fixed=True)
    wall = mo.Block(name="wall", vertices=rectangle(3, 4, -1, 0), fixed=True)
    scene = mo.Scene(joints={"friction": 5.0}, blocks=[beam, prop, wall])
    assert load_factor(scene, method) == pytest.approx(1.0, rel=1e-7)
    joints = solved(scene, method).joints
    at = joints["length"] == 0
    assert joints["m"][at].tolist() == [0.0]
    # When the far bearing lifts off, the corner carries both loads.
    assert joints["n"][at].tolist() == pytest.approx([2.0], rel=1e-6)


def test_a_block_pushed_against_a_corner_is_held():
    """The push and the force of the corner act at one height: they are in equilibrium at every load
    factor."""
    block = mo.Block(name="A", vertices=rectangle(0, 1, 0, 1), weight=1, live=(1, 0))
    prop = mo.Block(name="prop", vertices=[(1, 0.5), (2, 0.1), (2, 0.9)], fixed=True)
    assert solved(on_floor(block, prop, friction=5.0), "static").status is Status.UNLIMITED

"""How joints move in a mechanism."""

import numpy as np
import pytest
from scenes import CASES, overhanging

import masonry_opt as mo
from masonry_opt.answer.motion import joint_motion


def motion_of(result):
    return joint_motion(result.assembly, result.solution)


def test_the_mechanism_of_a_crushing_block_is_one():
    """Pressed down in its middle until the joint's whole length crushes."""
    block = mo.Block(name="A", vertices=[(0, 0), (2, 0), (2, 1), (0, 1)], weight=1, live=(0, -1))
    floor = mo.Block(name="floor", vertices=[(-1, -1), (3, -1), (3, 0), (-1, 0)], fixed=True)
    scene = mo.Scene(joints=mo.JointDefaults(friction=0.5, strength=2.0), blocks=[block, floor])
    result = mo.solve(scene, "static")
    assert result.load_factor == pytest.approx(3.0, rel=1e-6)  # 2.0 × 2 - 1
    motion = motion_of(result)
    assert (motion.crushes[0], motion.slides[0], motion.hinges[0]) == (True, False, False)


def test_what_opens_and_slips_and_carries_nothing_separates():
    """A keystone that is pulled out: a joint keeps an edge in touch, but presses on nothing."""
    result = mo.solve(CASES / "closed_forms" / "keystone.toml")
    motion = motion_of(result)
    idle = result.joints["n"].abs().to_numpy() < 1e-9
    opens = result.joints["opening"].to_numpy() > 0.01
    assert (idle & opens).any()
    assert motion.separates[idle & opens].all()


def test_a_block_that_turns_about_an_edge_hinges_whatever_presses_there():
    """Blocks of a pile of diamonds turn about a corner that they share with a neighbour at rest, on which
    they do not press; another comes off. (Of its many mechanisms one has three that turn so, one two.)"""
    result = mo.solve(CASES / "paterson_zwick" / "diamond_4.toml")
    motion, joints = motion_of(result), result.joints
    farther = (joints["opening"] + joints["rotation"].abs() * joints["length"] / 2).to_numpy()
    nearer = (joints["opening"] - joints["rotation"].abs() * joints["length"] / 2).to_numpy()
    stays = (np.abs(nearer) < 1e-6) & (joints["slip"].abs().to_numpy() < 1e-6) & (farther > 0.1)
    idle = joints["n"].abs().to_numpy() < 1e-9
    assert (stays & idle).sum() >= 2
    assert motion.hinges[stays].all()
    assert not motion.separates[stays].any()
    assert motion.separates.any()


@pytest.mark.parametrize("beyond", [1.0, 1e-3, 1e-5])
def test_a_block_that_falls_off_an_edge_turns_about_it(beyond):
    """By hand: of 3 by 1, its centroid 0.5 above the edge and a beyond it, it begins to turn as a pendulum
    does, by a / ((3² + 1²) / 12 + a² + 0.5²) of gravity (0.48 for a = 1); friction holds the edge."""
    result = mo.solve(overhanging(beyond))
    motion = motion_of(result)
    speed = beyond / (10 / 12 + beyond**2 + 0.25)
    assert result.blocks["omega"][0] == pytest.approx(-speed, rel=1e-4)
    assert (motion.hinges[0], motion.slides[0], motion.separates[0]) == (True, False, False)
    assert motion.hinge[0] + result.assembly.geometry.origin == pytest.approx([1.5 - beyond, 0])


def test_a_block_that_slides_off_keeps_its_friction():
    """On a slope of 1 in 2, friction 0.2, by associative flow: its speed is what gravity leaves along the
    direction in which it slides and lifts off."""
    block = mo.Block(name="A", vertices=[(0, 0), (2, 1), (1, 3), (-1, 2)], weight=1, live=(1, 0))
    ground = mo.Block(name="ground", vertices=[(-4, -2), (6, 3), (6, -3)], fixed=True)
    result = mo.solve(mo.Scene(joints=mo.JointDefaults(friction=0.2), blocks=[block, ground]))
    motion = motion_of(result)
    slope, friction_angle = np.arctan(0.5), np.arctan(0.2)
    speed = np.hypot(result.blocks["vx"][0], result.blocks["vy"][0])
    assert speed == pytest.approx(np.sin(slope - friction_angle), rel=1e-6)
    assert (motion.slides[0], motion.hinges[0], motion.separates[0]) == (True, False, False)

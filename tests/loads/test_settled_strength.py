"""Tests of settlements of scenes whose joints have a limited strength, of scenes with ties, and of roads."""

import math

import numpy as np
import pytest
from scenes import block_on_floor
from scipy.optimize import brentq
from settled_scenes import SINKS, beam, block, joined_circles
from speeds import slow

import masonry_opt as mo
from masonry_opt.drawing.forces import load_marks
from masonry_opt.finite_motion.settled_contacts import Contacts
from masonry_opt.finite_motion.settled_state import settled_scene
from masonry_opt.problem.assembly import assemble
from masonry_opt.problem.fill import Road


def rotation_by_hand(strength: float) -> float:
    """Return the rotation of the beam after its right pier has settled by 0.02; the piers crush at their
    edges.

    Each pier crushes over a depth N/f_c. Its resultant is in the middle of this depth and its hinge at the
    end. Moments about the left resultant determine the right reaction.
    """

    def reactions(right: float) -> tuple[float, float]:
        """Return the depths over which the left and the right pier crush."""
        return (10 - right) / strength, right / strength

    def moment(right: float) -> float:
        left_depth, right_depth = reactions(right)
        return right * (4 - right_depth / 2 + left_depth / 2) - 10 * (1.5 + left_depth / 2)

    left_depth, right_depth = reactions(brentq(moment, 1, 9))
    return -0.02 / (4 + left_depth - right_depth)


@pytest.mark.parametrize("strength", [5.1, *slow(20.0, 1000.0)])
def test_a_beam_settles_on_piers_that_crush(strength):
    """The settled rotation agrees with the closed form; chords in place of the strength's parabola change
    it by less than 1e-4."""
    after = settled_scene(beam().replace(strength=strength), SINKS)
    assert after.settled.poses[-1, 2] == pytest.approx(rotation_by_hand(strength), rel=2e-4)
    assert mo.solve(after, "static").load_factor is not None


@pytest.mark.slow
def test_a_great_strength_is_as_good_as_an_unlimited_one():
    expected = settled_scene(beam(), SINKS).settled.poses
    after = settled_scene(beam().replace(strength=1e7), SINKS)
    np.testing.assert_allclose(after.settled.poses, expected, atol=1e-7)


@pytest.mark.parametrize("turn", [-0.1, 0.05])
def test_a_block_that_turns_with_its_floor_crushes_as_if_it_were_drawn_so(turn):
    scene = block_on_floor(1.0, 2.0, friction=0.9).replace(strength=40.0)
    cos, sin = math.cos(turn), math.sin(turn)
    drawn = []
    for one in scene.blocks:
        corners = np.array(one.vertices) @ [[cos, sin], [-sin, cos]]
        drawn.append(one.replace(vertices=[tuple(corner) for corner in corners]))
    expected = mo.solve(scene.replace(blocks=drawn), "static").load_factor
    found = mo.solve(scene, "static", settled={"floor": (0, 0, turn)}).load_factor
    assert found == pytest.approx(expected, rel=1e-7)


def test_a_tie_keeps_its_length():
    """A beam on a pier and a tie settles as a linkage.

    The beam rotates about the corner of its pier, and the end of the tie moves on a circle about its anchor.
    The intersection of the two circles determines the rotation.
    """
    rod = mo.Tie(between=("beam", "ground"), at=((4.5, 0.5), (4.5, 2.0)), strength=30)
    blocks = [block("R", 0, 1, -1, 0, fixed=True), block("beam", 0, 5, 0, 1, weight=10)]
    scene = mo.Scene(joints=mo.JointDefaults(friction=0.6), blocks=blocks, ties=[rod])
    after = settled_scene(scene, {"R": (0, -0.2)})
    hinge, fixed = np.array([0.0, -0.2]), np.array([4.5, 0.5])
    end = joined_circles((hinge, math.hypot(4.5, 0.5)), (np.array([4.5, 2.0]), 1.5), fixed)
    turn = math.atan2(end[1] + 0.2, end[0]) - math.atan2(0.5, 4.5)
    assert after.settled.poses[-1, 2] == pytest.approx(turn, abs=1e-9)
    first, second = (action.point for action in assemble(after).limited[0].actions)
    assert math.dist(first, second) == pytest.approx(1.5, abs=1e-9)


def filled_beam() -> mo.Scene:
    """Return the beam below a fill of depth 1, through which axle loads spread at 45°."""
    fill = mo.Fill(road=[(0, 3), (5, 3)], unit_weight=1.0, pressure=False, spread=45.0)
    axles = mo.Axles(name="one", loads=[10.0])
    return beam(live=(0, 0)).replace(fills=[fill], axles=[axles])


@pytest.mark.parametrize("rise", [-0.5, 0.5])
def test_a_road_sinks_and_rises_with_its_bridge(rise):
    """If all supports move by the same amount, the depth of the fill and the spread of axle loads do not
    change."""
    scene = filled_beam()
    position, load = np.array([0.3, 2.0, 4.9]), np.array([10.0, 20.0, 30.0])
    at_rest = assemble(scene)
    expected = Road(scene, at_rest.geometry, scene.fills[0].road).on_blocks(position, load)
    after = settled_scene(scene, {"L": (0, rise), "R": (0, rise)})
    road = Road(after, assemble(after).geometry, scene.fills[0].road, at_rest=at_rest.geometry)
    np.testing.assert_allclose(road.line[:, 1], 3 + rise, atol=1e-9)
    np.testing.assert_allclose(road.on_blocks(position, load), expected, atol=1e-9)


def test_a_road_keeps_its_height_above_a_beam_that_turns():
    """A road stays 1 above the top of a beam that rotates, measured vertically, and slopes as the beam
    does."""
    after = settled_scene(filled_beam(), SINKS)
    assembly = assemble(after)
    origin, at_rest = assembly.geometry.origin, assembly.at_rest.geometry
    road = after.settled.road(after, at_rest, np.array([[0.5, 3], [4.5, 3]]) - origin) + origin
    (left, right), turn = road[[0, -1]], after.settled.poses[-1, 2]
    assert (right[1] - left[1]) / (right[0] - left[0]) == pytest.approx(math.tan(turn), rel=1e-6)
    # The vertical line through the hinge at (1, 1) meets the top of the beam at the height 1 + 1/cos(turn).
    height = left[1] + (1 - left[0]) * math.tan(turn)
    assert height == pytest.approx(2 + 1 / math.cos(turn), abs=1e-6)


@pytest.mark.slow
def test_loads_are_drawn_and_followed_where_they_act_after_the_settlement():
    """A load on the top of a block is drawn on the block after its floor has risen, and its displacement
    is unchanged."""
    scene = block_on_floor(1.0, 2.0, friction=0.9)
    (name,) = [one.name for one in scene.blocks if not one.fixed]
    top = np.array(scene[name].vertices).max(axis=0)
    scene = scene.replace(blocks={name: {"live_at": (float(top[0]) - 0.5, float(top[1]))}})
    result = mo.solve(scene, "static", settled={"floor": (0.3, 0.7)})
    motion = np.zeros((len(scene.blocks), 3))
    (live,) = [marks for marks in load_marks(result.assembly, motion) if marks.name == "live"]
    expected = top + np.array([0.3 - 0.5, 0.7]) - result.assembly.geometry.origin
    assert np.hypot(*(live.points[0] - expected).T).min() == pytest.approx(0, abs=1e-9)
    at_rest = mo.capacity(mo.solve(scene, "static"), steps=4)
    curve = mo.capacity(result, steps=4)
    assert curve.displacement == pytest.approx(at_rest.displacement, rel=1e-9)


@pytest.mark.parametrize("depths", [(0.2, 0.1), (0.1, 0.2)])
def test_two_blocks_overlap_as_deep_as_the_joint_that_crushes_most(depths):
    """Two blocks overlap by the greater of the crushed depths of their two joints, times the rotation.

    The block has two feet of width 1 each and rotates by 0.01.
    """
    outline = [(0, 0), (1, 0), (1, 1), (2, 1), (2, 0), (3, 0), (3, 2), (0, 2)]
    blocks = [block("floor", 0, 3, -1, 0, fixed=True), mo.Block(name="A", vertices=outline, weight=1)]
    assembly = assemble(mo.Scene(joints={"friction": 0.6}, blocks=blocks))
    joints = assembly.joints
    touches, slides = np.zeros(len(joints.joint), dtype=bool), np.zeros(len(joints.extent), dtype=bool)
    poses = np.array([[0.0, 0.0, 0.0], [0.0, 0.0, 0.01]])
    contacts = Contacts(assembly, touches, slides, poses, np.array([0]), joints.point, np.array(depths))
    (overlap,) = contacts.crushed_overlaps(poses).values()
    assert overlap == pytest.approx(0.2 * 0.01 + assembly.geometry.contact_tolerance)

"""Blocks of other shapes than convex ones, and corners that stand on edges."""

import numpy as np
import pytest

import masonry_opt as mo
from masonry_opt.answer.reasons import Code
from masonry_opt.scene.contacts.find import find_joints
from masonry_opt.scene.geometry import geometry

FLOOR = mo.Block(name="floor", vertices=[(-9, -1), (9, -1), (9, 0), (-9, 0)], fixed=True)
L_SHAPE = [(0, 0), (2, 0), (2, 1), (1, 1), (1, 3), (0, 3)]
PORTAL = [(0, 0), (1, 0), (1, 2), (3, 2), (3, 0), (4, 0), (4, 3), (0, 3)]


def scene(*blocks, friction=0.5, **joints):
    return mo.Scene(joints=mo.JointDefaults(friction=friction, **joints), blocks=list(blocks))


def joints_of(*blocks):
    whole = scene(*blocks)
    return find_joints(whole, geometry(whole))


def stone(outline, name="A", **more):
    return mo.Block(**({"name": name, "vertices": outline, "weight": 1.0} | more))


def test_area_and_centroid_of_notches_parts_and_holes():
    as_parts = mo.Block(
        name="A", parts=[[(0, 0), (2, 0), (2, 1), (0, 1)], [(0, 1), (1, 1), (1, 3), (0, 3)]], unit_weight=1
    )
    shapes = [geometry(scene(block, FLOOR)) for block in (stone(L_SHAPE), as_parts)]
    for shape in shapes:
        # Two squares beside two squares: (2·1 + 2·0.5)/4 and (2·0.5 + 2·2)/4.
        assert shape.size[0] == pytest.approx(4.0)
        assert shape.centroid[0] + shape.origin == pytest.approx([0.75, 1.25])
        assert not shape.convex[0]
        assert shape.convex[1]
    holed = geometry(
        scene(
            stone([(0, 0), (2, 0), (2, 2), (0, 2)], holes=[[(0.5, 1), (1, 1), (1, 1.5), (0.5, 1.5)]]), FLOOR
        )
    )
    assert holed.size[0] == pytest.approx(3.75)
    assert holed.centroid[0] + holed.origin == pytest.approx(
        [(4 - 0.25 * 0.75) / 3.75, (4 - 0.25 * 1.25) / 3.75]
    )


def test_a_portal_stands_on_two_joints():
    joints = joints_of(stone(PORTAL), FLOOR)
    ends = np.sort(np.stack([joints.start, joints.end])[..., 0], axis=0)
    assert joints.extent == pytest.approx([1.0, 1.0])
    assert np.sort(ends[1] - ends[0]) == pytest.approx([1.0, 1.0])
    assert joints.normal == pytest.approx(np.array([[0, 1], [0, 1]]))


def test_a_stone_in_a_notch_touches_its_three_sides():
    notch = stone([(0, 0), (6, 0), (6, 2), (4, 2), (4, 1), (2, 1), (2, 2), (0, 2)])
    joints = joints_of(notch, stone([(2, 1), (4, 1), (4, 3), (2, 3)], "B"), FLOOR)
    of_stone = joints.first + joints.second == 1
    assert sorted(joints.extent[of_stone]) == pytest.approx([1.0, 1.0, 2.0])
    # Into the notched block, A: down from below the stone, and outwards from its sides.
    assert joints.normal[of_stone].sum(axis=0) == pytest.approx([0, -1])


@pytest.mark.parametrize("turned", [False, True])
def test_a_corner_on_an_edge_is_a_joint_without_length(turned):
    prop = stone([(1, 0), (0.5, -1), (1.5, -1)], "prop", weight=None, fixed=True)
    beam = stone([(0, 0), (4, 0), (4, 1), (0, 1)])
    wall = stone([(3, 0), (4, 0), (4, -1), (3, -1)], "wall", weight=None, fixed=True)
    blocks = (prop, beam, wall) if turned else (beam, prop, wall)
    joints = joints_of(*blocks)
    at = int(np.flatnonzero(joints.extent == 0)[0])
    assert len(joints.extent) == 2
    into_first = -1 if turned else 1
    assert joints.normal[at] == pytest.approx([0, into_first])
    assert joints.start[at] + geometry(scene(*blocks)).origin == pytest.approx([1, 0])


def test_corner_on_corner_is_reported_unless_both_blocks_are_held_there():
    def unit(name, x, y, **more):
        return stone([(x, y), (x + 1, y), (x + 1, y + 1), (x, y + 1)], name, **more)

    # Four corners of a stack bond: each of the two diagonal pairs is held by the others.
    stack = [unit("A", 0, 0), unit("B", 1, 0), unit("C", 0, 1), unit("D", 1, 1), FLOOR]
    assert joints_of(*stack).without_normal == []
    steps = [unit("A", 0, 0), unit("D", 1, 1), unit("post", 2, 1, weight=None, fixed=True), FLOOR]
    assert joints_of(*steps).without_normal == [(0, 1)]
    pushed = [
        block.model_copy(update={"live": (1.0, 0.0)}) if block.name == "A" else block for block in steps
    ]
    (warning,) = mo.solve(scene(*pushed), "static").warnings
    assert warning.code is Code.CORNERS_MEET
    assert warning.values["pairs"] == [["A", "D"]]


def test_properties_of_an_exception_hold_for_every_joint_of_the_pair():
    whole = mo.Scene(
        joints=mo.JointDefaults(friction=0.5, strength=7),
        blocks=[stone(PORTAL), FLOOR],
        exceptions=[mo.Joint(between=("floor", "A"), friction=0.3, strength=9)],
    )
    joints = find_joints(whole, geometry(whole))
    assert joints.friction.tolist() == [0.3, 0.3]
    assert joints.strength.tolist() == [9.0, 9.0]

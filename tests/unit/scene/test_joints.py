"""Joints found from the geometry, and what is refused or repaired on the way."""

import re

import numpy as np
import pytest

import masonry_opt as mo
from masonry_opt.scene.contacts.find import find_joints
from masonry_opt.scene.geometry import geometry


def square(name, x, y, size=1.0, **more):
    properties = {"weight": 1.0} | more
    if more.get("fixed"):
        properties.pop("weight")
    corners = [(x, y), (x + size, y), (x + size, y + size), (x, y + size)]
    return mo.Block(name=name, vertices=corners, **properties)


def parted(name, part):
    return mo.Block(name=name, parts=[[(8, 8), (9, 8), (9, 9)], part], weight=1)


FLOOR = mo.Block(name="floor", vertices=[(-9, -1), (9, -1), (9, 0), (-9, 0)], fixed=True)


def scene(*blocks, **more):
    return mo.Scene(joints={"friction": 0.5}, blocks=[*blocks, FLOOR], **more)


def joints_of(scene):
    return find_joints(scene, geometry(scene))


def pairs(scene):
    joints = joints_of(scene)
    names = [block.name for block in scene.blocks]
    return {(names[i], names[j]) for i, j in zip(joints.first, joints.second, strict=True)}


def test_each_pair_that_shares_an_edge_has_one_joint_and_a_corner_makes_none():
    grid = scene(*(square(f"{i}{j}", i, j) for i in range(2) for j in range(2)))
    beside, below = {("00", "10"), ("01", "11")}, {("00", "01"), ("10", "11")}
    assert pairs(grid) == beside | below | {("00", "floor"), ("10", "floor")}


def test_joint_spans_the_shared_length_and_its_normal_points_into_the_first_block():
    shapes = geometry(scene(square("A", 0, 0), square("B", 0.25, 1)))
    joints = find_joints(scene(square("A", 0, 0), square("B", 0.25, 1)), shapes)
    joint = list(zip(joints.first, joints.second, strict=True)).index((0, 1))
    assert joints.extent[joint] == pytest.approx(0.75)
    assert joints.middle[joint] + shapes.origin == pytest.approx([0.625, 1.0])
    assert joints.normal[joint] == pytest.approx([0, -1])


def test_orientation_and_straight_or_repeated_corners_do_not_matter():
    plain = scene(square("A", 0, 0))
    clockwise = mo.Block(name="A", vertices=[(0, 1), (1, 1), (1, 0), (0.5, 0), (0, 0), (0, 0)], weight=1)
    one, other = joints_of(plain), joints_of(scene(clockwise))
    assert len(other.first) == 1
    np.testing.assert_allclose(one.extent, other.extent)
    np.testing.assert_allclose(one.normal, other.normal, atol=1e-15)


@pytest.mark.parametrize("gap", [-3e-7, 3e-7])
def test_hairline_gaps_and_overlaps_within_the_tolerance_are_joints(gap):
    assert pairs(scene(square("A", 0, gap))) == {("A", "floor")}


def test_joint_properties_come_from_defaults_and_exceptions():
    special = scene(
        square("A", 0, 0),
        square("B", 1, 0),
        exceptions=[mo.Joint(between=("floor", "A"), friction=0.9, cohesion=2)],
    )
    joints = joints_of(special)
    friction = dict(zip(zip(joints.first, joints.second, strict=True), joints.friction, strict=True))
    assert friction == {(0, 1): 0.5, (0, 2): 0.9, (1, 2): 0.5}
    assert sorted(joints.cohesion) == [0, 0, 2]


def test_fixed_blocks_may_touch_and_overlap_and_get_no_joint():
    wedge = square("wedge", 3, -0.5, fixed=True)
    beside = mo.Block(name="floor2", vertices=[(9, -1), (12, -1), (12, 0), (9, 0)], fixed=True)
    mixed = scene(square("A", 0, 0), wedge, beside)
    assert pairs(mixed) == {("A", "floor")}
    assert joints_of(mixed).fixed_pairs == 1


@pytest.mark.parametrize(
    ("blocks", "message"),
    [
        ([square("A", 0, 0), square("B", 0.9, 0)], "blocks 'A' and 'B' overlap"),
        ([square("A", 0, 0), square("B", 2.5, 3)], "'B' touches no other block: 'A'.* 2\\.5 away"),
        ([square("A", 0, 0), square("B", 1, 1)], "'B' touches no other block: it meets 'A'"),
        ([square("A", 0, 0), square("B", 4, 3), square("C", 5, 3)], "'B' reaches no fixed block.*'C'"),
        ([mo.Block(name="A", vertices=[(0, 0), (1, 0), (2, 0)], weight=1)], "'A' has no area"),
        ([mo.Block(name="A", vertices=[(0, 0), (2, 0), (2, 2), (0, 1), (1, 2)], weight=1)], "crosses itself"),
        ([parted("A", [(0, 0), (1, 0), (2, 0)])], "'A' has a part without area"),
        ([parted("A", [(0, 0), (3, 2), (3, 0), (0, 1)])], "'A' has a part that crosses itself"),
        ([square("A", 0, 0, holes=[[(3, 3), (4, 3), (4, 4)]])], "'A' has a hole that is not inside"),
        ([mo.Block(name="A", vertices=[(0, 0), (2, 1), (2, 0), (0, 1)], weight=1)], "'A' crosses itself"),
        ([mo.Block(name="A", vertices=[(0, 0), (0, 0), (1, 0)], weight=1)], "'A' has no area"),
    ],
)
def test_impossible_geometry_is_refused_by_name(blocks, message):
    with pytest.raises(mo.CaseError, match=message):
        joints_of(scene(*blocks))


@pytest.mark.parametrize(
    ("left", "rounded"), [(0.9, False), (1 - 1.01e-2, False), (1 - 0.99e-2, True), (1 - 1e-5, True)]
)
@pytest.mark.parametrize("shift", [0.0, 2000.0])
def test_an_overlap_is_told_by_place_and_area_and_blamed_on_rounding_only_if_shallow(left, rounded, shift):
    """B over the right end of A, by 1 - left: its middle lies half of that left of x = 1, at half height.
    Sliver or not is a matter of its least width, which is the overlap."""
    blocks = [square("A", shift, 0), square("B", shift + left, 0)]
    ground = [(shift - 5, -1), (shift + 5, -1), (shift + 5, 0), (shift - 5, 0)]
    floor = mo.Block(name="floor", vertices=ground, fixed=True)
    both = mo.Scene(joints={"friction": 0.5}, blocks=[*blocks, floor])
    with pytest.raises(mo.CaseError, match="blocks 'A' and 'B' overlap") as error:
        joints_of(both)
    area, x, y = map(float, re.search(r"area of (\S+) round \((\S+), (\S+)\)", str(error.value)).groups())
    assert area == pytest.approx(1 - left, rel=1e-4)
    assert (x, y) == pytest.approx((shift + (1 + left) / 2, 0.5), rel=1e-5)
    assert ("tolerance" in str(error.value)) is rounded


def test_an_exception_between_blocks_that_do_not_touch_is_refused():
    apart = scene(square("A", 0, 0), square("B", 4, 0), exceptions=[mo.Joint(between=("A", "B"), friction=1)])
    with pytest.raises(mo.CaseError, match="do not touch"):
        joints_of(apart)


@pytest.mark.parametrize("gap", [1e-4, 5e-4])
def test_faces_that_nearly_touch_are_reported_and_joined_by_a_larger_tolerance(gap):
    apart = [square("A", 0, 0), square("B", 1 + gap, 0)]
    found = joints_of(scene(*apart))
    assert found.gaps == {(0, 1): pytest.approx(gap)}
    assert pairs(scene(*apart)) == {("A", "floor"), ("B", "floor")}
    joined = scene(*apart, tolerance=1e-3)
    assert pairs(joined) == {("A", "floor"), ("B", "floor"), ("A", "B")}
    assert joints_of(joined).gaps == {}


@pytest.mark.parametrize("tolerance", [1e-6, 1e-3, 2e-2])
@pytest.mark.parametrize("share", [1.1, 2.5])
def test_a_bed_that_gapes_at_one_end_is_a_small_gap_and_no_meeting_of_corners(tolerance, share):
    """B touches A at its left corner, and stands up by share · tolerance at its right one, a length of 1."""
    gap = share * tolerance
    stones = [
        square("A", 0, 0),
        mo.Block(name="B", vertices=[(0, 1), (1, 1 + gap), (1, 2), (0, 2)], weight=1),
    ]
    wall = mo.Block(name="wall", vertices=[(1, 0), (2, 0), (2, 2), (1, 2)], fixed=True)
    found = joints_of(scene(*stones, wall, tolerance=tolerance))
    assert (found.gaps, found.without_normal) == ({(0, 1): pytest.approx(gap, rel=1e-3)}, [])
    assert ("A", "B") in pairs(scene(*stones, wall, tolerance=gap))
    # Alone, B is refused for the gap that it stands above.
    with pytest.raises(mo.CaseError, match=rf"'B' touches no other block: 'A', which it faces, .*{gap:.2g}"):
        joints_of(scene(*stones, tolerance=tolerance))

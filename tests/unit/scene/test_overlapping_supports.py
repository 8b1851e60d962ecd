"""A block that rests on two supports where these overlap has one joint there, so nothing counts twice."""

from itertools import pairwise

import numpy as np
import pytest
from atlas.small_scenes import rectangle
from mappings import mapped, turned
from speeds import slow
from touching_solids import contacts_of

import masonry_opt as mo

#: Supports of a block from x = 0 to 1, as the intervals of x over which they extend.
LAYOUTS = {
    "half each": [(-5, 0.7), (0.3, 6)],
    "one inside": [(-5, 6), (0.3, 0.6)],
    "one over all": [(0, 1), (-5, 6)],
    "both over all": [(-5, 6), (-4, 5)],
    "three": [(-5, 0.5), (0.3, 0.9), (0.4, 6)],
    "beside": [(-5, 0.5), (0.5, 6)],
    "alone": [(-5, 6)],
}


def on_supports(*spans, **joints):
    """Return a block of width 1, height 2 and weight 10 on supports with given spans, pushed at its centroid.

    The supports differ in depth, so that they also overlap below the joints.
    """
    blocks = [
        rectangle(f"{number}", left, -1 - number, right, 0) for number, (left, right) in enumerate(spans)
    ]
    block = rectangle("A", 0, 0, 1, 2, weight=10, live=(1, 0))
    return mo.Scene(joints=mo.JointDefaults(**({"friction": 0.6} | joints)), blocks=[block, *blocks])


def layouts():
    """Return each layout with its supports in both orders."""
    return [
        pytest.param(spans, id=f"{name} {number}")
        for name, layout in LAYOUTS.items()
        for number, spans in enumerate((layout, layout[::-1]))
    ]


@pytest.mark.parametrize("shaped", [lambda scene: scene, mo.extrude], ids=["plane", "space"])
@pytest.mark.parametrize("spans", layouts())
def test_cohesion_counts_once(spans, shaped):
    """The block slides at 0.1 · 10 + 2 · 1 = 3. If cohesion counted twice, it would slide at up to 5."""
    scene = shaped(on_supports(*spans, friction=0.1, cohesion=2))
    joints = contacts_of(scene)
    assert joints.extent.sum() == pytest.approx(1.0)
    result = mo.solve(scene, descent=False)
    assert result.lowest == pytest.approx(3.0)
    assert result.incremental == pytest.approx(3.0)
    assert not result.warnings


@pytest.mark.parametrize("spans", layouts())
def test_strength_counts_once(spans):
    """With strength 20, the weight 10 needs a length of 1 / 2 at the edge. The block tips at 10 · (1 / 2 - 1
    / 4) = 2.5.

    If strength counted twice, the crushed length would be 10 / 40, and the load factor 3.75.
    """
    result = mo.solve(on_supports(*spans, strength=20), method="static", solver="clarabel")
    assert result.load_factor == pytest.approx(2.5)


@pytest.mark.parametrize("angle", [0.0, 0.3, np.pi / 4, np.pi / 2])
@pytest.mark.parametrize("shaped", [lambda scene: scene, mo.extrude], ids=["plane", "space"])
def test_joints_of_overlapping_supports(angle, shaped):
    """The first support has the joint on the overlap. The second joint begins where the first ends, at each
    rotation."""
    scene = shaped(mapped(on_supports((-5, 0.7), (0.3, 6)), turned(angle)))
    joints = contacts_of(scene)
    assert joints.second.tolist() == [1, 2]
    assert joints.extent == pytest.approx([0.7, 0.3])
    assert joints.overlaps.tolist() == [[0, 1, 2]]
    distance = np.linalg.norm(joints.middle[1] - joints.middle[0])
    assert distance == pytest.approx(0.5)


@pytest.mark.parametrize("shaped", [lambda scene: scene, mo.extrude], ids=["plane", "space"])
@pytest.mark.parametrize("order", [1, -1])
def test_the_support_with_the_larger_joint_has_the_overlap(order, shaped):
    """The floor has the whole joint, and the support in the middle has none, in either order of the supports.

    Without the other support, the floor would have a joint of length 1, and the support in the middle 0.3.
    """
    scene = shaped(on_supports(*[(0.3, 0.6), (-5, 6)][::order]))
    middle, floor = (1, 2)[::order]
    joints = contacts_of(scene)
    assert joints.second.tolist() == [floor]
    assert joints.extent == pytest.approx([1])
    assert joints.overlaps.tolist() == [[0, floor, middle]]


@pytest.mark.parametrize("order", [1, -1])
@pytest.mark.parametrize("start", [0.1, 0.5, 0.8])
def test_a_support_below_a_corner(start, order):
    """The block slides at 0.1 · 10 + 2 · 1 = 3, in either order of the supports.

    The pedestal below a corner would otherwise leave an L-shaped joint to the floor. Sliding along such a
    joint is less accurate, because its cohesion acts at six corners.
    """
    floor = mo.box("floor", (-5, 5), (-5, 5), (-1, 0), fixed=True)
    pedestal = mo.box("pedestal", (start, 2), (start, 2), (-2, 0), fixed=True)
    block = mo.box("A", (0, 1), (0, 1), (0, 2), weight=10, live=(1, 0, 0))
    joint = mo.JointDefaults(friction=0.1, cohesion=2)
    scene = mo.Scene(joints=joint, blocks=[block, *[pedestal, floor][::order]])
    assert mo.solve(scene, method="static").load_factor == pytest.approx(3.0)


@pytest.mark.parametrize("shaped", [lambda scene: scene, mo.extrude], ids=["plane", "space"])
def test_a_support_leaves_a_joint_on_either_side(shaped):
    """The support in the middle is 0.015 above the floor, so the floor has two joints."""
    block = rectangle("A", 0, 0, 1, 2, weight=10, live=(1, 0))
    middle, floor = rectangle("middle", 0.3, -2, 0.6, 0), rectangle("floor", -5, -1, 6, -0.015)
    joint = mo.JointDefaults(friction=0.6)
    joints = contacts_of(
        shaped(mo.Scene(joints=joint, blocks=[block, middle, floor], contact_tolerance=0.02))
    )
    assert sorted(zip(joints.second.tolist(), joints.extent.round(9).tolist(), strict=True)) == [
        (1, 0.3),
        (2, 0.3),
        (2, 0.4),
    ]


@pytest.mark.parametrize("start", [0.5, 0.98])
def test_a_short_rest_of_a_joint(start):
    """The joint with the second support is two tolerances long, whether or not the first support overlaps it.

    The block slides at 0.1 · 10 + 2 · 1 = 3.
    """
    scene = on_supports((-5, 0.98), (start, 6), friction=0.1, cohesion=2).replace(tolerance=0.01)
    assert contacts_of(scene).extent == pytest.approx([0.98, 0.02])
    assert mo.solve(scene, method="static").load_factor == pytest.approx(3.0)


def test_a_support_in_the_middle_of_a_face():
    """The second joint is a square with a square hole, and has the remaining area of the face.

    The pedestal has the first joint, because it is 0.015 above the floor.
    """
    floor = mo.box("floor", (-5, 5), (-5, 5), (-1, -0.015), fixed=True)
    pedestal = mo.box("pedestal", (0.25, 0.75), (0.25, 0.75), (-2, 0), fixed=True)
    block = mo.box("A", (0, 1), (0, 1), (0, 2), weight=10, live=(1, 0, 0))
    joint = mo.JointDefaults(friction=0.1, cohesion=2)
    scene = mo.Scene(joints=joint, blocks=[block, pedestal, floor], contact_tolerance=0.02)
    joints = contacts_of(scene)
    assert joints.extent == pytest.approx([0.25, 0.75])
    assert np.bincount(joints.joint).tolist() == [4, 8]
    assert mo.solve(scene, descent=False).lowest == pytest.approx(3.0)


@pytest.mark.parametrize("shaped", [lambda scene: scene, mo.extrude], ids=["plane", "space"])
@pytest.mark.parametrize("start", [0.3, 0.45, 0.7])
@pytest.mark.parametrize("order", [1, -1])
def test_the_nearer_support_has_the_joint(order, start, shaped):
    """The block touches the slab. The floor is 0.015 lower, and also has a joint, because gaps up to 0.02 are
    bridged.

    The block slides at 0.1 · 10 + 2 · 1 = 3, wherever the slab begins below it.
    """
    floor, slab = rectangle("floor", -5, -1, 6, -0.015), rectangle("slab", start, -0.5, 6, 0)
    block = rectangle("A", 0, 0, 1, 2, weight=10, live=(1, 0))
    joint = mo.JointDefaults(friction=0.1, cohesion=2)
    scene = shaped(mo.Scene(joints=joint, blocks=[block, *[floor, slab][::order]], contact_tolerance=0.02))
    joints = contacts_of(scene)
    names = [scene.blocks[index].name for index in joints.second]
    extents = dict(zip(names, joints.extent, strict=True))
    assert extents == pytest.approx({"floor": start, "slab": 1 - start})
    assert mo.solve(scene, method="static").load_factor == pytest.approx(3.0)


def test_supports_that_overlap_beside_two_sides_of_a_block():
    """The block touches the floor below and the wall beside it, and the two supports overlap below both."""
    scene = on_supports((-5, 6))
    joints = contacts_of(scene.replace(blocks=[*scene.blocks, rectangle("wall", 1, -1, 2, 3)]))
    assert sorted(joints.extent.tolist()) == pytest.approx([1, 2])
    assert not len(joints.overlaps)


@pytest.mark.parametrize("shaped", [lambda scene: scene, mo.extrude], ids=["plane", "space"])
@pytest.mark.parametrize("penetration", [0.0, 0.006, 0.012])
def test_supports_on_opposite_sides_of_a_thin_block(penetration, shaped):
    """Cohesion acts below and above the block. It slides at 0.1 · 1 + 2 · 2 = 4.1.

    The bisecting lines of the two joints are closer to each other than the contact tolerance.
    """
    below = rectangle("below", -5, -1, 6, penetration)
    above = rectangle("above", -5, 0.03 - penetration, 6, 1)
    block = rectangle("A", 0, 0, 1, 0.03, weight=1, live=(1, 0))
    joint = mo.JointDefaults(friction=0.1, cohesion=2)
    scene = shaped(mo.Scene(joints=joint, blocks=[block, below, above], contact_tolerance=0.02))
    assert contacts_of(scene).extent == pytest.approx([1, 1])
    assert mo.solve(scene, descent=False).lowest == pytest.approx(4.1)


def test_many_supports_that_overlap():
    """Each of five supports overlaps the next one by half of its width. The joints adjoin each other."""
    supports = [rectangle(f"{n}", n, -1, n + 1.5, 0) for n in range(5)]
    scene = mo.Scene(
        joints=mo.JointDefaults(friction=0.5), blocks=[rectangle("A", 0, 0, 5.5, 2, weight=1), *supports]
    )
    joints = contacts_of(scene)
    assert joints.extent == pytest.approx([1.5, 1, 1, 1, 1])
    assert joints.overlaps.tolist() == [[0, *pair] for pair in pairwise(range(1, 6))]


@pytest.mark.parametrize("spans", [[(-5, 0.7), (0.3, 6)], [(-5, 6), (0.3, 0.6)]])
def test_joints_with_different_properties_are_refused(spans):
    """If the two joints have the same properties, they are accepted, even if one of them has no length."""
    scene = on_supports(*spans, friction=0.1)
    one, other = (mo.Joint(between=("A", name), friction=0.3, cohesion=1) for name in "01")
    message = "supports '0' and '1' overlap where block 'A' rests on both, .* differ in friction and cohesion"
    with pytest.raises(mo.CaseError, match=message):
        mo.solve(scene.replace(exceptions=[other]))
    same = scene.replace(exceptions=[one, other])
    assert mo.solve(same).lowest == pytest.approx(0.3 * 10 + 1)
    with pytest.raises(mo.CaseError, match="differ in friction:"):
        mo.solve(same.replace(exceptions=[one, other.replace(friction=0.2)]))


@pytest.mark.parametrize("shaped", [lambda scene: scene, mo.extrude], ids=["plane", "space"])
@pytest.mark.parametrize("order", [1, -1])
def test_joints_with_a_small_overlap_may_have_different_properties(order, shaped):
    """The supports overlap by 0.004, less than 1 % of both joints, and the larger joint has the overlap.

    Only cohesion acts. The block slides at 1 · 0.6 + 3 · 0.4 = 1.8.
    """
    scene = on_supports(*[(-5, 0.6), (0.596, 6)][::order], friction=0, cohesion=1)
    right = "10"[::order][0]
    exception = mo.Joint(between=("A", right), friction=0, cohesion=3)
    scene = shaped(scene.replace(exceptions=[exception]))
    assert mo.solve(scene, method="static").load_factor == pytest.approx(1.8)


def test_joints_with_a_larger_overlap_must_have_the_same_properties():
    """The supports overlap by 0.006, more than 1 % of the smaller joint, whose length is 0.4."""
    scene = on_supports((-5, 0.606), (0.6, 6), friction=0.1)
    exception = mo.Joint(between=("A", "1"), friction=0.3)
    with pytest.raises(mo.CaseError, match="supports '0' and '1' overlap where block 'A' rests on both"):
        mo.solve(scene.replace(exceptions=[exception]))


def test_supports_that_overlap_cannot_settle_apart():
    """The shared part of the joint would move with either of the two. A third support can settle."""
    scene = on_supports((-5, 0.4), (0.2, 0.6), (0.7, 6))
    message = "supports '0' and '1' overlap where block 'A' rests on both"
    for name in "01":
        with pytest.raises(mo.OptionError, match=message):
            mo.settle(scene, name, (0, -1))
        with pytest.raises(mo.OptionError, match=message):
            mo.solve(scene, settled={name: (0, -0.01)})
    # Without the third support the block remains stable. An upward force at x = 0.7 makes it tip about x = 0.
    settlement = mo.settle(scene, "2", (0, -1))
    assert settlement.least.reaction == pytest.approx(0.0, abs=1e-9)
    assert settlement.greatest.reaction == pytest.approx(10 * 0.5 / 0.7)


@pytest.mark.parametrize(
    "spans", [[(-5, 0.7), (0.3, 6)], *slow([(-5, 6), (0.3, 0.6)], [(0.3, 0.6), (-5, 6)])]
)
def test_supports_that_overlap_settle_together(spans):
    """The two supports carry the whole weight 10. After both have moved by 0.01, the block still tips at 10 ·
    0.5 / 1 = 5."""
    scene = on_supports(*spans)
    settlement = mo.settle(scene, ["0", "1"], (0, -1))
    assert settlement.least.reaction == pytest.approx(10.0)
    assert settlement.greatest.reaction == pytest.approx(10.0)
    result = mo.solve(scene, settled={"0": (0, -0.01), "1": (0, -0.01)})
    assert result.load_factor == pytest.approx(5.0)


def test_supports_that_overlap_cannot_move_differently():
    """The supports may not have different translations, and may not turn, each about its own centroid."""
    scene = on_supports((-5, 0.7), (0.3, 6))
    message = "overlap where block 'A' rests on both, so they can settle only together and without rotation"
    for second in ((0, -0.02), (0.01, -0.01), (0, -0.01, 0.001)):
        with pytest.raises(mo.OptionError, match=message):
            mo.solve(scene, settled={"0": (0, -0.01), "1": second})
    with pytest.raises(mo.OptionError, match=message):
        mo.settle(scene, ["0", "1"], (0, -1), turns=True)

"""Joints of blocks in space, found from their geometry: areas, corners and normals in closed form."""

import math
import re

import numpy as np
import pytest
from atlas.random_scenes_in_space import KINDS, random_scene_in_space
from touching_solids import FLOOR, box, contacts_of, hull, joints, parted, scene

import masonry_opt as mo
from masonry_opt.reporting.sentences import sentences
from masonry_opt.scene.space.shapes import shapes
from masonry_opt.solution.reasons import Code, Status


def same_points(found, expected):
    found, expected = (np.array(sorted(np.round(points, 9).tolist())) for points in (found, expected))
    assert found.shape == expected.shape
    np.testing.assert_allclose(found, expected, atol=1e-9)


def ridge(name, along, below, **keys):
    """Return a triangular prism, 3 long, with a ridge on z = 0 and the rest below or above."""
    z = -1.0 if below else 1.0
    corners = [(at, off, height) for at in (-1.5, 1.5) for off, height in ((0, 0), (-1, z), (1, z))]
    return hull(name, [(y, x, z) for x, y, z in corners] if along else corners, **keys)


def test_a_box_on_another_shares_the_overlap_of_their_faces():
    blocks = scene(box("A", (0, 2), (0, 1), (1, 2)), box("B", (0.5, 3), (-1, 0.75), (0, 1)), FLOOR)
    (pair, area, normal, points), below = joints(blocks)
    assert pair == ("A", "B")
    assert area == pytest.approx(1.5 * 0.75)
    assert normal == pytest.approx([0, 0, 1])  # from the second block, B, up into A
    same_points(points, [(0.5, 0, 1), (2, 0, 1), (2, 0.75, 1), (0.5, 0.75, 1)])
    assert below[:1] == (("B", "floor"),)
    found = contacts_of(blocks)
    assert np.abs(found.tangent[0]) == pytest.approx([1, 0, 0])  # the tangent is along the longest side
    np.testing.assert_array_equal(found.joint, [0] * 4 + [1] * 4)


def test_a_square_turned_by_45_degrees_on_a_square_shares_an_octagon():
    r = math.sqrt(0.5)
    turned = hull("A", [(x, y, z) for z in (1, 2) for x, y in ((r, 0), (0, r), (-r, 0), (0, -r))])
    (_, area, _, points), _ = joints(scene(turned, box("B", (-0.5, 0.5), (-0.5, 0.5), (0, 1)), FLOOR))
    # A regular octagon around a circle of radius 1/2 has the area 8 tan(π/8) / 4.
    assert area == pytest.approx(2 * math.tan(math.pi / 8), rel=1e-9)
    t = math.tan(math.pi / 8) / 2
    same_points(points, [(x, y, 1) for a, b in ((0.5, t), (t, 0.5)) for x in (-a, a) for y in (-b, b)])


def test_a_solid_of_parts_has_one_joint_of_their_outline_and_one_with_each_wall_of_its_corner():
    corner = parted("L", ((0, 3), (0, 1), (0, 1)), ((0, 1), (1, 3), (0, 1)))
    blocks = scene(corner, box("A", (1, 2), (1, 2.5), (0, 1)), FLOOR)
    found = list(joints(blocks))
    assert [pair for pair, *_ in found] == [("L", "A"), ("L", "A"), ("L", "floor"), ("A", "floor")]
    walls = {tuple(np.round(normal).astype(int)): area for _, area, normal, _ in found[:2]}
    assert walls == {(-1, 0, 0): pytest.approx(1.5), (0, -1, 0): pytest.approx(1.0)}
    _, area, normal, points = found[2]
    assert area == pytest.approx(5)
    assert normal == pytest.approx([0, 0, 1])
    same_points(points, [(0, 0, 0), (3, 0, 0), (3, 1, 0), (1, 1, 0), (1, 3, 0), (0, 3, 0)])


def test_a_ring_on_a_floor_has_the_corners_of_its_hole_too():
    sides = ((0, 4), (0, 1)), ((3, 4), (1, 4)), ((0, 3), (3, 4)), ((0, 1), (1, 3))
    frame = parted("ring", *((x, y, (0, 0.5)) for x, y in sides))
    blocks = scene(frame, FLOOR)
    ((_, area, _, points),) = joints(blocks)
    assert area == pytest.approx(16 - 4)
    same_points(points, [(x, y, 0) for ends in ((0, 4), (1, 3)) for x in ends for y in ends])
    found = contacts_of(blocks)
    outer, inner = (found.point[found.ring == ring] for ring in (0, 1))
    assert np.ptp(outer, axis=0) == pytest.approx([4, 4, 0])
    assert np.ptp(inner, axis=0) == pytest.approx([2, 2, 0])


def tip(name, z, x=0.0, y=0.0, **keys):
    """Return a tetrahedron with one corner at z = 0 and its opposite face at a height z, which may be
    negative."""
    return hull(name, [(x, y, 0), (-1, -1, z), (1, -1, z), (0, 1, z)], **keys)


SHORT, ABOVE = (box("floor", (-a, a), (-a, a), z, fixed=True) for a, z in ((1, (-1, 0)), (5, (0, 1))))
LOWER = ridge("lower", 1, below=True, fixed=True)


@pytest.mark.parametrize(
    ("blocks", "upwards", "expected"),
    [
        # A wedge touches along its edge, or along the part of the edge that is above the floor.
        ((ridge("A", 1, below=False), FLOOR), 1, [(0, -1.5, 0), (0, 1.5, 0)]),
        ((ridge("A", 0, below=False), SHORT), 1, [(-1, 0, 0), (1, 0, 0)]),
        # A corner touches a face from above or from below.
        ((tip("A", 1, 0.25, 0.5), FLOOR), 1, [(0.25, 0.5, 0)]),
        ((tip("A", -1, 0.25, 0.5), ABOVE), -1, [(0.25, 0.5, 0)]),
        # Two ridges cross, and the normal is perpendicular to both.
        ((ridge("A", 0, below=False), LOWER), 1, [(0, 0, 0)]),
        ((LOWER, ridge("A", 0, below=False)), -1, [(0, 0, 0)]),
    ],
)
def test_edges_and_corners_touch_at_points_without_an_area(blocks, upwards, expected):
    ((pair, area, normal, points),) = joints(scene(*blocks))
    assert (pair, area) == (tuple(block.name for block in blocks), 0)
    assert normal == pytest.approx([0, 0, upwards])
    same_points(points, expected)
    if len(expected) == 2:
        along = np.abs(np.sign(expected[1]))
        assert np.abs(contacts_of(scene(*blocks)).tangent[0]) == pytest.approx(along)


@pytest.mark.parametrize("lower", [tip("B", -1, fixed=True), ridge("B", 0, below=True, fixed=True)])
def test_what_has_no_normal_is_no_joint_and_told(lower):
    blocks = scene(tip("A", 1), lower)
    found = contacts_of(blocks, floating=True)
    assert len(found.first) == 0
    assert found.point.shape == (0, 3)
    assert found.without_normal == [(0, 1)]
    with pytest.raises(mo.CaseError, match=r"'A'.*'B'"):
        contacts_of(blocks)


@pytest.mark.parametrize(("gap", "joint"), [(0.9e-3, True), (-0.9e-3, True), (1.1e-3, False)])
def test_the_tolerance_bounds_gaps_and_overlaps(gap, joint):
    blocks = scene(box("A", (0, 1), (0, 1), (gap, 1 + gap)), FLOOR, tolerance=1e-3)
    found = contacts_of(blocks, floating=True)
    assert len(found.first) == joint
    if joint:
        assert found.extent == pytest.approx([1])
        assert found.point[:, 2] + shapes(blocks).origin[2] == pytest.approx(4 * [gap / 2])
    else:
        assert found.gaps == {(0, 1): pytest.approx(gap)}
        with pytest.raises(mo.CaseError, match=r"'floor'.*0\.0011 away.*'tolerance' to 0\.0011"):
            contacts_of(blocks)


@pytest.mark.parametrize(("rise", "points"), [(0.9e-3, 4), (1.1e-3, 2)])
def test_faces_may_lean_as_far_as_the_tolerance_over_what_they_share(rise, points):
    corners = [(x, y, z + rise * x) for x in (0, 1) for y in (0, 1) for z in (0, 1)]
    found = contacts_of(scene(hull("A", corners), FLOOR, tolerance=1e-3))
    assert len(found.point) == points
    # The joint is in the plane that bisects the faces, or in the plane of the floor if only an edge touches.
    slope = math.atan(rise) / 2 if points == 4 else 0.0
    assert found.normal[0] == pytest.approx([-math.sin(slope), 0, math.cos(slope)])


def test_blocks_that_overlap_are_refused_with_place_volume_and_depth():
    blocks = scene(box("A", (0, 1), (0, 1), (0, 1)), box("B", (0.75, 2), (0.5, 3), (0, 1)), FLOOR)
    with pytest.raises(mo.CaseError, match=r"'A' and 'B' overlap.* 0\.125 .*, 0\.25 deep") as error:
        contacts_of(blocks)
    assert "0.875, " in str(error.value)


@pytest.mark.parametrize("off", [-0.05, 0.05])
def test_blocks_drawn_apart_or_into_one_another_touch_within_the_contact_tolerance(off):
    """Feet of 0.2 keep their joints, although they are narrower than ten times the contact tolerance."""
    stone = parted("stone", *(((x, x + 0.2), (0, 1), (off, 2)) for x in (0, 0.8)))
    with pytest.raises(mo.CaseError, match=r"'contact_tolerance' to 0\.05"):
        contacts_of(scene(FLOOR, stone))
    found = contacts_of(scene(FLOOR, stone, contact_tolerance=0.06))
    assert found.extent == pytest.approx([0.2, 0.2])
    assert found.point[:, 2] - found.point[0, 2] == pytest.approx(0)


@pytest.mark.parametrize("inner", [(0, 1), (0.4, 0.5)])
def test_a_block_within_another_is_no_matter_of_tolerance(inner):
    stones = box("outer", (0, 1), (0, 1), (0, 1)), box("inner", inner, inner, (0, 1))
    with pytest.raises(mo.CaseError, match="one block is inside the other") as error:
        contacts_of(scene(FLOOR, *stones))
    assert "tolerance" not in str(error.value)


def test_a_strip_narrower_than_ten_tolerances_is_no_joint():
    def on(width):
        ground = box("floor", (0, 1), (0, 1), (-1, 0), fixed=True)
        blocks = scene(box("A", (1 - width, 2), (0, 1), (0, 1)), ground, tolerance=1e-3)
        return contacts_of(blocks, floating=True)

    assert on(0.011).extent == pytest.approx([0.011])
    narrow = on(0.009)
    assert len(narrow.first) == 0
    assert (narrow.lost.gaps, narrow.without_normal) == ({(0, 1): 0.0}, [])


def test_a_corner_on_a_corner_has_a_joint_after_the_advised_cut():
    """Two pyramids touch apex on apex, and four slack wires keep the upper pyramid upright.

    The wires may stay slack, because the centroid is above the apex: the joint can carry the weight alone.
    """
    base = [(1, 1), (-1, 1), (-1, -1), (1, -1)]
    lower = hull("lower", [*((x, y, 0) for x, y in base), (0, 0, 1)], fixed=True, weight=None)

    def with_upper(*apex):
        upper = hull("upper", [*((x, y, 2) for x, y in base), *apex])
        wires = [
            mo.Tie(between=("upper", "ground"), at=((x, y, 2), (2 * x, 2 * y, 0)), strength=0.1)
            for x, y in base
        ]
        return scene(lower, upper, ties=wires)

    blunt = [(0.01 * x, 0.01 * y, 1) for x, y in base]
    warnings = mo.solve(with_upper((0, 0, 1))).warnings
    assert Code.WITHOUT_NORMAL in [warning.code for warning in warnings]
    cut = mo.solve(with_upper(*blunt))
    assert cut.status is mo.Status.STABLE
    assert cut.warnings == ()
    assert cut.joints["n"].sum() == pytest.approx(1 + (cut.ties["force"] / np.sqrt(6) * 2).sum(), rel=1e-6)


@pytest.mark.parametrize(("width", "lost"), [(0.012, False), (0.009, True), (0.0025, True)])
def test_a_rest_that_is_too_narrow_for_a_joint_is_named_with_the_tolerance_that_makes_it(width, lost):
    """A beam rests on two piers, on one of them with a strip narrower than ten tolerances of 0.001.

    Without the joint on the strip, the beam falls: its centroid is beside the other pier, because
    1 - width + 3.4 < 2 · 3. With a smaller tolerance, both joints carry the beam.
    """
    piers = box("P", (0, 1), (0, 1), (0, 1)), box("Q", (3, 4), (0, 1), (0, 1))
    beam = box("beam", (1 - width, 3.4), (0, 1), (1, 1.3))
    blocks = scene(*piers, beam, FLOOR, tolerance=1e-3)
    named = [warning for warning in mo.solve(blocks).warnings if warning.code == Code.LOST_JOINTS]
    assert bool(named) == lost
    if not lost:
        return
    (warning,) = named
    assert warning.values["pairs"] == [["P", "beam"]]
    (sentence,) = sentences([warning])
    remedy = r"'P'–'beam' \(touching\); set 'tolerance' to less than ([\d.e-]+)$"
    limit = float(re.search(remedy, sentence)[1])
    assert limit == pytest.approx(width / 10, rel=0.02)
    result = mo.solve(blocks.replace(tolerance=0.99 * limit))
    assert result.status == Status.STABLE
    assert not [warning for warning in result.warnings if warning.code == Code.LOST_JOINTS]


@pytest.mark.parametrize("kind", KINDS)
def test_exact_walls_have_no_narrow_rests(kind):
    """Blocks that meet along edges and at corners have no strips, whose joints could be lost."""
    for seed in range(5):
        blocks = random_scene_in_space(kind, seed)
        assert contacts_of(blocks).lost.gaps == {}

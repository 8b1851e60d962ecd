"""Joints are found from the geometry of blocks of any shape, impossible geometry raises errors, and pieces
are convex."""

import re

import numpy as np
import pytest
import shapely
from speeds import slow
from touching_solids import contacts_of

import masonry_opt as mo
from masonry_opt.reporting.sentences import sentences
from masonry_opt.scene.geometry import geometry
from masonry_opt.scene.outlines import convex_pieces
from masonry_opt.solution.reasons import Code


def square(name, x, y, size=1.0, **more):
    properties = {"weight": 1.0} | more
    if more.get("fixed"):
        properties.pop("weight")
    corners = [(x, y), (x + size, y), (x + size, y + size), (x, y + size)]
    return mo.Block(name=name, vertices=corners, **properties)


def parted(name, part):
    return mo.Block(name=name, parts=[[(8, 8), (9, 8), (9, 9)], part], weight=1)


def stone(outline, name="A", **more):
    return mo.Block(**({"name": name, "vertices": outline, "weight": 1.0} | more))


L_SHAPE = [(0, 0), (2, 0), (2, 1), (1, 1), (1, 3), (0, 3)]
FLOOR = mo.Block(name="floor", vertices=[(-9, -1), (9, -1), (9, 0), (-9, 0)], fixed=True)


def scene(*blocks, **more):
    return mo.Scene(**{"joints": {"friction": 0.5}, "blocks": [*blocks, FLOOR]} | more)


#: A scene in the plane, and its extrusion in space.
IN_BOTH = [lambda scene: scene, mo.extrude]


def pairs(scene):
    joints = contacts_of(scene)
    names = [block.name for block in scene.blocks]
    return {(names[i], names[j]) for i, j in zip(joints.first, joints.second, strict=True)}


def test_each_pair_that_shares_an_edge_has_one_joint_and_a_corner_makes_none():
    grid = scene(*(square(f"{i}{j}", i, j) for i in range(2) for j in range(2)))
    beside, below = {("00", "10"), ("01", "11")}, {("00", "01"), ("10", "11")}
    assert pairs(grid) == beside | below | {("00", "floor"), ("10", "floor")}


def test_joint_spans_the_shared_length_and_its_normal_points_into_the_first_block():
    both = scene(square("A", 0, 0), square("B", 0.25, 1))
    joints = contacts_of(both)
    joint = list(zip(joints.first, joints.second, strict=True)).index((0, 1))
    assert joints.extent[joint] == pytest.approx(0.75)
    assert joints.middle[joint] + geometry(both).origin == pytest.approx([0.625, 1.0])
    assert joints.normal[joint] == pytest.approx([0, -1])


def test_orientation_and_straight_or_repeated_corners_do_not_matter():
    plain = scene(square("A", 0, 0))
    clockwise = stone([(0, 1), (1, 1), (1, 0), (0.5, 0), (0, 0), (0, 0)])
    one, other = contacts_of(plain), contacts_of(scene(clockwise))
    assert len(other.first) == 1
    np.testing.assert_allclose(one.extent, other.extent)
    np.testing.assert_allclose(one.normal, other.normal, atol=1e-15)


def test_joint_properties_come_from_defaults_and_from_exceptions_for_every_joint_of_a_pair():
    """An exception changes both joints of a portal with the floor. The joints of a square next to the portal
    keep the defaults."""
    portal = stone([(0, 0), (1, 0), (1, 2), (3, 2), (3, 0), (4, 0), (4, 3), (0, 3)])
    special = mo.Joint(between=("floor", "A"), friction=0.9, cohesion=2, strength=9)
    usual = {"friction": 0.5, "strength": 7}
    joints = contacts_of(scene(portal, square("B", 4, 0), exceptions=[special], joints=usual))
    properties = np.column_stack(
        [joints.first, joints.second, joints.friction, joints.cohesion, joints.strength]
    )
    assert sorted(properties.tolist()) == [[0, 1, 0.5, 0, 7], *[[0, 2, 0.9, 2, 9]] * 2, [1, 2, 0.5, 0, 7]]
    assert joints.extent[joints.second == 2] == pytest.approx([1, 1, 1])


def test_fixed_blocks_may_touch_and_overlap_and_get_no_joint():
    wedge = square("wedge", 3, -0.5, fixed=True)
    beside = mo.Block(name="floor2", vertices=[(9, -1), (12, -1), (12, 0), (9, 0)], fixed=True)
    mixed = scene(square("A", 0, 0), wedge, beside)
    assert pairs(mixed) == {("A", "floor")}
    assert contacts_of(mixed).fixed_pairs == 1


@pytest.mark.parametrize(
    ("blocks", "message"),
    [
        ([stone([(0, 0), (1, 0), (2, 0)])], "'A' has no area"),
        ([stone([(0, 0), (2, 0), (2, 2), (0, 1), (1, 2)])], "crosses itself"),
        ([parted("A", [(0, 0), (1, 0), (2, 0)])], "'A' has a part without area"),
        ([parted("A", [(0, 0), (3, 2), (3, 0), (0, 1)])], "'A' has a part that crosses itself"),
        ([square("A", 0, 0, holes=[[(3, 3), (4, 3), (4, 4)]])], "'A' has a hole that is not inside"),
        ([stone([(0, 0), (2, 1), (2, 0), (0, 1)])], "'A' crosses itself"),
        ([stone([(0, 0), (0, 0), (1, 0)])], "'A' has no area"),
        # The default tolerance is 10⁻⁶ of the scene, which extends to a block in another unit.
        (
            [square("A", 0, 0), square("B", 1e6, 0)],
            "'A' .* is too small for the tolerance 1: use one unit .* remove blocks that are far away",
        ),
    ],
)
def test_impossible_geometry_is_refused_by_name(blocks, message):
    with pytest.raises(mo.CaseError, match=message):
        contacts_of(scene(*blocks))


@pytest.mark.parametrize("shaped", IN_BOTH, ids=["plane", "space"])
@pytest.mark.parametrize(
    ("blocks", "message"),
    [
        ([square("B", 0.9, 0)], "blocks 'A' and 'B' overlap"),
        ([square("B", 2.5, 3)], "'B' touches no other block: the nearest block 'A' is 2\\.5 away"),
        ([square("B", 1, 1)], "'B' touches no other block: it meets 'A'"),
        (
            [square("B", 4, 3), square("C", 5, 3)],
            "'B' .likewise 1 more: 'C'. is not connected to any fixed block or to the ground, directly",
        ),
    ],
)
def test_blocks_in_impossible_places_are_refused_by_name(blocks, message, shaped):
    with pytest.raises(mo.CaseError, match=message):
        contacts_of(shaped(scene(square("A", 0, 0), *blocks)))


@pytest.mark.parametrize(
    ("left", "rounded"), [(0.9, False), (1 - 1.01e-2, False), (1 - 0.99e-2, True), (1 - 1e-5, True)]
)
@pytest.mark.parametrize("shift", [0.0, 2000.0])
def test_an_overlap_is_told_by_place_and_area_and_blamed_on_rounding_only_if_shallow(left, rounded, shift):
    """Block B overlaps the right end of A by 1 - left, with the middle of the overlap at half height. The
    message blames rounding only if the least width of the overlap is below 0.01."""
    blocks = [square("A", shift, 0), square("B", shift + left, 0)]
    ground = [(shift - 5, -1), (shift + 5, -1), (shift + 5, 0), (shift - 5, 0)]
    floor = mo.Block(name="floor", vertices=ground, fixed=True)
    both = mo.Scene(joints={"friction": 0.5}, blocks=[*blocks, floor])
    with pytest.raises(mo.CaseError, match="blocks 'A' and 'B' overlap") as error:
        contacts_of(both)
    area, x, y = map(float, re.search(r"area of (\S+) near \((\S+), (\S+)\)", str(error.value)).groups())
    assert area == pytest.approx(1 - left, rel=1e-4)
    assert (x, y) == pytest.approx((shift + (1 + left) / 2, 0.5), rel=1e-5)
    assert ("'tolerance'" in str(error.value)) is rounded
    assert ("'contact_tolerance'" in str(error.value)) is not rounded


def test_an_exception_between_blocks_that_do_not_touch_is_refused():
    apart = scene(square("A", 0, 0), square("B", 4, 0), exceptions=[mo.Joint(between=("A", "B"), friction=1)])
    with pytest.raises(mo.CaseError, match="do not touch"):
        contacts_of(apart)


@pytest.mark.parametrize("shaped", IN_BOTH, ids=["plane", "space"])
@pytest.mark.parametrize("gap", [1e-4, 5e-4, 4e-3])
def test_faces_that_nearly_touch_are_reported_and_joined_by_a_larger_tolerance(gap, shaped):
    apart, far = [square("A", 0, 0), square("B", 1 + gap, 0)], [square("A", 0, 0), square("B", 1.02, 0)]
    found = contacts_of(shaped(scene(*apart)))
    assert found.gaps == {(0, 1): pytest.approx(gap)}
    assert pairs(shaped(scene(*apart))) == {("A", "floor"), ("B", "floor")}
    joined = shaped(scene(*apart, tolerance=2 * gap))
    assert pairs(joined) == {("A", "floor"), ("B", "floor"), ("A", "B")}
    assert contacts_of(joined).gaps == contacts_of(shaped(scene(*far))).gaps == {}


@pytest.mark.parametrize("shaped", IN_BOTH, ids=["plane", "space"])
@pytest.mark.parametrize("tolerance", [1e-6, *slow(1e-3), 2e-2])
@pytest.mark.parametrize("share", [1.1, 2.5])
def test_a_bed_that_gapes_at_one_end_is_a_small_gap_and_no_meeting_of_corners(tolerance, share, shaped):
    """B touches A at its left corner. At its right corner, at a distance of 1, the gap is share ·
    tolerance."""
    gap = share * tolerance
    stones = [square("A", 0, 0), stone([(0, 1), (1, 1 + gap), (1, 2), (0, 2)], "B")]
    wall = square("wall", 1, 0, 2, fixed=True)
    found = contacts_of(shaped(scene(*stones, wall, tolerance=tolerance)))
    assert (found.gaps, found.without_normal) == ({(0, 1): pytest.approx(gap, rel=1e-3)}, [])
    assert ("A", "B") in pairs(scene(*stones, wall, tolerance=gap))
    # Without the wall, B has no joint, and the error names the gap below it.
    with pytest.raises(mo.CaseError, match=rf"'B' touches no other block: its neighbour 'A' is .*{gap:.2g}"):
        contacts_of(shaped(scene(*stones, tolerance=tolerance)))


def test_area_and_centroid_of_notches_parts_and_holes():
    as_parts = mo.Block(
        name="A", parts=[[(0, 0), (2, 0), (2, 1), (0, 1)], [(0, 1), (1, 1), (1, 3), (0, 3)]], unit_weight=1
    )
    shapes = [geometry(scene(block)) for block in (stone(L_SHAPE), as_parts)]
    for shape in shapes:
        # The L is two rectangles of area 2: its centroid is at (2·1 + 2·0.5)/4 and (2·0.5 + 2·2)/4.
        assert shape.size[0] == pytest.approx(4.0)
        assert shape.centroid[0] + shape.origin == pytest.approx([0.75, 1.25])
        assert not shape.convex[0]
        assert shape.convex[1]
    holed = stone([(0, 0), (2, 0), (2, 2), (0, 2)], holes=[[(0.5, 1), (1, 1), (1, 1.5), (0.5, 1.5)]])
    shape = geometry(scene(holed))
    assert shape.size[0] == pytest.approx(3.75)
    middle = [(4 - 0.25 * 0.75) / 3.75, (4 - 0.25 * 1.25) / 3.75]
    assert shape.centroid[0] + shape.origin == pytest.approx(middle)


def test_a_stone_in_a_notch_touches_its_three_sides():
    notch = stone([(0, 0), (6, 0), (6, 2), (4, 2), (4, 1), (2, 1), (2, 2), (0, 2)])
    joints = contacts_of(scene(notch, stone([(2, 1), (4, 1), (4, 3), (2, 3)], "B")))
    of_stone = joints.first + joints.second == 1
    assert sorted(joints.extent[of_stone]) == pytest.approx([1.0, 1.0, 2.0])
    # Normals point into the notched block A: downwards below the stone, and outwards at its two sides.
    assert joints.normal[of_stone].sum(axis=0) == pytest.approx([0, -1])


@pytest.mark.parametrize("turned", [False, True])
def test_a_corner_on_an_edge_is_a_joint_without_length(turned):
    prop = stone([(1, 0), (0.5, -1), (1.5, -1)], "prop", weight=None, fixed=True)
    beam = stone([(0, 0), (4, 0), (4, 1), (0, 1)])
    wall = square("wall", 3, -1, fixed=True)
    on_prop = scene(blocks=[prop, beam, wall] if turned else [beam, prop, wall])
    joints = contacts_of(on_prop)
    at = int(np.flatnonzero(joints.extent == 0)[0])
    assert len(joints.extent) == 2
    into_first = -1 if turned else 1
    assert joints.normal[at] == pytest.approx([0, into_first])
    assert joints.start[at] + geometry(on_prop).origin == pytest.approx([1, 0])


@pytest.mark.parametrize("shaped", IN_BOTH, ids=["plane", "space"])
def test_corner_on_corner_is_reported_unless_both_blocks_are_held_there(shaped):
    """Two blocks that meet only at a corner cause a warning, unless another block connects them. In space,
    edges meet along their length."""
    # In a stack bond, four corners meet. Each diagonal pair is connected by the other two blocks, or by one
    # of them.
    stack = [square("A", 0, 0), square("D", 1, 1), square("B", 1, 0), square("C", 0, 1)]
    for held in (stack, stack[:3]):
        assert contacts_of(shaped(scene(*held))).without_normal == []
    steps = shaped(scene(square("A", 0, 0, live=(1, 0)), stack[1], square("post", 2, 1, fixed=True)))
    assert contacts_of(steps).without_normal == [(0, 1)]
    (warning,) = mo.solve(steps, "static").warnings
    assert warning.code is (Code.CORNERS_MEET if steps.dimension == 2 else Code.WITHOUT_NORMAL)
    assert warning.values["pairs"] == [["A", "D"]]
    assert "'A'–'D'" in sentences([warning])[0]


def test_an_overlap_of_sides_that_are_not_parallel_is_closed_by_a_contact_tolerance():
    """To make the sides parallel, a tolerance would have to exceed a hundredth of the block, like mortar.

    The block slides on a joint that is tilted by half of the angle, 0.004, so λ = tan(atan 0.5 ± 0.004).
    """
    upper = stone([(0, 0.992), (1, 1), (1, 2), (0, 2)], "B", live=(1, 0))
    overlapping = scene(square("A", 0, 0, fixed=True, weight=None), upper)
    with pytest.raises(mo.CaseError, match=r"inexact, set 'contact_tolerance' to 0\.008"):
        mo.solve(overlapping)
    result = mo.solve(overlapping.replace(contact_tolerance=0.008))
    assert result.load_factor == pytest.approx(0.5, rel=0.02)


PLUS = shapely.union_all([shapely.box(1, 0, 2, 3), shapely.box(0, 1, 3, 2)])
FRAME = shapely.box(0, 0, 3, 3).difference(shapely.box(1, 1, 2, 2))


def star(points, seed):
    """Return a star-shaped polygon with random notches."""
    rng = np.random.default_rng(seed)
    angle = np.sort(rng.uniform(0, 2 * np.pi, points))
    radius = rng.uniform(0.2, 1, points)
    return shapely.Polygon(np.column_stack([radius * np.cos(angle), radius * np.sin(angle)]))


#: A polygon and an upper limit of its number of pieces. The limit is the least possible number, or the bound
#: of Hertel and Mehlhorn: one more than twice the number of reflex corners, with one more cut for a hole.
POLYGONS = {
    "triangle": (shapely.Polygon([(0, 0), (1, 0), (0, 1)]), 1),
    "a convex one": (shapely.Point(0, 0).buffer(1), 1),
    "L": (shapely.Polygon(L_SHAPE), 2),
    "plus": (PLUS, 5),
    "frame": (FRAME, 8),
    "turned L": (shapely.affinity.rotate(shapely.Polygon(L_SHAPE), 33.3), 2),
    "apart": (shapely.union_all([shapely.box(0, 0, 1, 1), shapely.box(2, 0, 3, 1)]), 2),
    **{f"star {seed}": (star(25, seed), 2 * 25) for seed in range(4)},
}


@pytest.mark.parametrize("name", POLYGONS)
def test_pieces_are_convex_and_make_up_the_whole(name):
    polygon, most = POLYGONS[name]
    pieces = convex_pieces(polygon, 1e-9)
    assert len(pieces) <= most
    drawn = shapely.polygons([shapely.linearrings(piece) for piece in pieces])
    assert shapely.is_ccw(shapely.get_exterior_ring(drawn)).all()
    assert shapely.area(drawn).sum() == pytest.approx(polygon.area, rel=1e-12)
    assert shapely.union_all(drawn).symmetric_difference(polygon).area < 1e-12
    for piece in pieces:
        side = np.roll(piece, -1, axis=0) - piece
        following = np.roll(side, -1, axis=0)
        turn = side[:, 0] * following[:, 1] - side[:, 1] * following[:, 0]
        assert (turn > -1e-9).all()
    own = {tuple(corner) for corner in shapely.get_coordinates(polygon)}
    assert {tuple(corner) for piece in pieces for corner in piece} <= own


def test_what_is_thinner_than_the_tolerance_is_no_piece():
    """A flag is on a pole of width 1e-4. A tolerance of 1e-3 leaves out the pole."""
    flag = shapely.union_all([shapely.box(0, 0, 1e-4, 2), shapely.box(1e-4, 1, 1, 2)])
    assert len(convex_pieces(flag, 1e-6)) == 2
    (piece,) = convex_pieces(flag, 1e-3)
    assert shapely.Polygon(piece).area == pytest.approx(1, rel=1e-3)

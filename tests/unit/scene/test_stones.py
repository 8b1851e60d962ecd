"""Blocks of other shapes than convex ones, their convex pieces, and corners that stand on edges."""

import numpy as np
import pytest
import shapely

import masonry_opt as mo
from masonry_opt.answer.reasons import Code
from masonry_opt.scene.contacts.find import find_joints
from masonry_opt.scene.geometry import geometry
from masonry_opt.scene.outlines import convex_pieces

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
    holed = stone([(0, 0), (2, 0), (2, 2), (0, 2)], holes=[[(0.5, 1), (1, 1), (1, 1.5), (0.5, 1.5)]])
    shape = geometry(scene(holed, FLOOR))
    assert shape.size[0] == pytest.approx(3.75)
    middle = [(4 - 0.25 * 0.75) / 3.75, (4 - 0.25 * 1.25) / 3.75]
    assert shape.centroid[0] + shape.origin == pytest.approx(middle)


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
    pushed = steps[0].replace(live=(1.0, 0.0))
    (warning,) = mo.solve(scene(pushed, *steps[1:]), "static").warnings
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


L_POLYGON = shapely.Polygon([(0, 0), (2, 0), (2, 1), (1, 1), (1, 3), (0, 3)])
PLUS = shapely.union_all([shapely.box(1, 0, 2, 3), shapely.box(0, 1, 3, 2)])
FRAME = shapely.box(0, 0, 3, 3).difference(shapely.box(1, 1, 2, 2))


def star(points, seed):
    """A polygon with random notches, convex nowhere near."""
    rng = np.random.default_rng(seed)
    angle = np.sort(rng.uniform(0, 2 * np.pi, points))
    radius = rng.uniform(0.2, 1, points)
    return shapely.Polygon(np.column_stack([radius * np.cos(angle), radius * np.sin(angle)]))


#: A polygon and the most pieces: the fewest there are, or what Hertel and Mehlhorn's bound gives, one more
#: than twice the corners that turn inwards; those of a hole with one more cut.
POLYGONS = {
    "triangle": (shapely.Polygon([(0, 0), (1, 0), (0, 1)]), 1),
    "a convex one": (shapely.Point(0, 0).buffer(1), 1),
    "L": (L_POLYGON, 2),
    "plus": (PLUS, 5),
    "frame": (FRAME, 8),
    "turned L": (shapely.affinity.rotate(L_POLYGON, 33.3), 2),
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
    """A flag on a pole of width 1e-4."""
    flag = shapely.union_all([shapely.box(0, 0, 1e-4, 2), shapely.box(1e-4, 1, 1, 2)])
    assert len(convex_pieces(flag, 1e-6)) == 2
    (piece,) = convex_pieces(flag, 1e-3)
    assert shapely.Polygon(piece).area == pytest.approx(1, rel=1e-3)

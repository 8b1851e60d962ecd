"""Shapes of solids agree with closed forms, wrong solids raise errors, and joints do not depend on the
position of a scene."""

import math

import numpy as np
import pytest
import shapely
from meshes import prism
from scenes_in_space import box_on_floor
from scipy.spatial import ConvexHull, Voronoi
from scipy.spatial.transform import Rotation
from speeds import slow
from touching_solids import (
    FLOOR,
    box,
    contacts_of,
    hull,
    in_triangles,
    joints,
    moved,
    parted,
    scene,
    with_parts,
)

import masonry_opt as mo
from masonry_opt.problem.assembly import assemble
from masonry_opt.scene.space.shapes import shapes

#: A scene with joints of every kind: rotated square prisms, solids of parts, a wedge on its edge, a cone on
#: its tip and two ridges that cross.
TURNED = [(0.7, 0, 0), (0, 0.7, 0), (-0.7, 0, 0), (0, -0.7, 0)]
SCENE = scene(
    parted("L", ((0, 3), (0, 1), (0, 1)), ((0, 1), (1, 3), (0, 1))),
    box("in its corner", (1, 2.2), (1, 2.5), (0, 1)),
    hull("turned", [(x + 0.6, y + 1.8, z) for x, y, _ in TURNED for z in (1, 2.1)]),
    parted("ring", *((x, y, (0, 0.5)) for x, y in [((4, 8), (0, 1)), ((7, 8), (1, 4)), ((4, 7), (3, 4))])),
    hull("wedge", [(5, 2.5, 0), (6, 1.5, 0), *((5.5 + x, 2 + y, 0.8) for x, y, _ in TURNED)]),
    hull("cone", [(2.1, 0.4, 1), (1.8, 0, 2), (2.5, 0.1, 2), (2, 0.9, 2)]),
    hull("ridge", [(x, y, z) for x in (-4, -2) for y, z in ((-1, 0), (0, 1), (1, 0))]),
    hull("across", [(-3 + x, y, z) for y in (-1, 1) for x, z in ((-1, 2), (0, 1), (1, 2))]),
    box("floor", (-5, 9), (-5, 5), (-1, 0), fixed=True),
)


ANY = Rotation.random(random_state=7).as_matrix()
UNTURNED = np.eye(3)
MIRROR = np.diag([1.0, -1.0, 1.0])


def seen_back(blocks, matrix=UNTURNED, shift=(0, 0, 0)):
    """Return all joints in a fixed order, in the frame before a matrix and a shift were applied to the
    corners.

    Each joint has the names of its blocks, its contact points, its area, and its normal into the block whose
    name comes first.
    """
    scale = abs(np.linalg.det(matrix)) ** (1 / 3)
    found = []
    for pair, area, normal, points in joints(blocks):
        into_less = normal if pair[0] < pair[1] else -normal
        points = np.round((points - shift) @ np.linalg.inv(matrix).T, 6) + 0.0
        places = sorted(map(tuple, points.tolist()))
        found.append((tuple(sorted(pair)), places, area / scale**2, into_less @ matrix / scale))
    return sorted(found, key=lambda joint: joint[:2])


def assert_same(found, expected):
    assert [joint[:2] for joint in found] == [joint[:2] for joint in expected]
    for (*_, area, normal), (*_, as_before, before) in zip(found, expected, strict=True):
        assert area == pytest.approx(as_before, rel=1e-9)
        assert normal == pytest.approx(before, abs=1e-9)


EXPECTED = seen_back(SCENE)


def test_the_scene_has_joints_of_every_kind():
    kinds = [(*pair, len(places), area > 0) for pair, places, area, _ in EXPECTED]
    assert kinds == [
        ("L", "cone", 1, False),
        ("L", "floor", 6, True),
        ("L", "in its corner", 4, True),
        ("L", "in its corner", 4, True),
        ("L", "turned", 6, True),
        ("across", "ridge", 1, False),
        ("floor", "in its corner", 4, True),
        ("floor", "ridge", 4, True),
        ("floor", "ring", 8, True),
        ("floor", "wedge", 2, False),
        ("in its corner", "turned", 3, True),
    ]


@pytest.mark.parametrize(
    ("matrix", "shift"),
    [
        (ANY, (0, 0, 0)),
        (MIRROR, (0, 0, 0)),
        (ANY @ MIRROR, (1, 2, 3)),
        (1e3 * np.eye(3), (0, 0, 0)),
        (1e-3 * ANY, (0, 0, 0)),
        (np.eye(3), (1e4, -1e4, 1e4)),
    ],
)
def test_joints_turn_with_the_scene(matrix, shift):
    assert_same(seen_back(moved(SCENE, matrix, shift), matrix, shift), EXPECTED)


def test_tangents_and_the_order_of_contact_points_turn_with_the_scene():
    one, other = contacts_of(SCENE), contacts_of(moved(SCENE, ANY))
    frame = np.stack([one.normal, one.tangent, np.cross(one.normal, one.tangent)], axis=1)
    np.testing.assert_allclose(frame @ frame.mT, np.broadcast_to(np.eye(3), frame.shape), atol=1e-12)
    np.testing.assert_allclose(one.tangent @ ANY.T, other.tangent, atol=1e-9)
    # Positions are relative to the first contact point, because the two scenes have different origins.
    np.testing.assert_allclose((one.point - one.point[0]) @ ANY.T, other.point - other.point[0], atol=1e-9)


@pytest.mark.parametrize("matrix", [np.eye(3), ANY])
def test_joints_do_not_depend_on_numbers_or_on_faces_in_triangles(matrix):
    blocks = moved(SCENE, matrix)
    renumbered = blocks.model_copy(update={"blocks": blocks.blocks[::-1]})
    assert_same(seen_back(renumbered, matrix), EXPECTED)
    assert_same(seen_back(in_triangles(blocks), matrix), EXPECTED)


def cells(count, seed):
    """Return Voronoi cells of random points in a unit cube, one of them fixed, and the area and number of
    corners of each shared face. Points mirrored at the sides of the cube bound the cells."""
    points = np.random.default_rng(seed).random((count, 3))
    mirrored = [np.where(np.arange(3) == k, 2 * side - points, points) for k in range(3) for side in (0, 1)]
    diagram = Voronoi(np.concatenate([points, *mirrored]))
    corners = [diagram.vertices[diagram.regions[diagram.point_region[number]]] for number in range(count)]
    blocks = [hull(f"{number}", own, fixed=number == 0) for number, own in enumerate(corners)]
    faces = {}
    for pair, face in zip(diagram.ridge_points.tolist(), diagram.ridge_vertices, strict=True):
        if max(pair) < count:
            own, normal = diagram.vertices[face], points[pair[1]] - points[pair[0]]
            # The projection along an axis is smaller than the face by that component of its unit normal.
            axis = int(np.abs(normal).argmax())
            seen = ConvexHull(np.delete(own, axis, axis=1)).volume
            area = seen * np.linalg.norm(normal) / abs(normal[axis])
            faces[min(pair), max(pair)] = area, len(face)
    return scene(*blocks), faces


@pytest.mark.slow
@pytest.mark.parametrize("turned", [False, True])
def test_cells_of_a_voronoi_diagram_share_its_faces(turned):
    seed = 1
    blocks, faces = cells(100, seed)
    found = contacts_of(moved(blocks, Rotation.random(random_state=seed).as_matrix()) if turned else blocks)
    tolerance = 3e-6
    shared = {(i, j): a for i, j, a in zip(found.first, found.second, found.extent, strict=True)}
    corners = dict(zip(shared, np.bincount(found.joint), strict=True))
    assert len(shared) == len(found.first)  # one joint per pair
    assert shared.keys() <= faces.keys()
    # Faces without a joint are narrower than ten tolerances. Corners within a tolerance are merged.
    assert all(faces[pair][0] < 10 * tolerance for pair in faces.keys() - shared.keys())
    for pair, area in shared.items():
        assert area == pytest.approx(faces[pair][0], abs=tolerance)
    assert np.mean([corners[pair] == faces[pair][1] for pair in shared]) > 0.97
    assert (found.gaps, found.without_normal) == ({}, [])


@pytest.mark.parametrize("case", [
    "casapulla_lauro/arch", "examples/segmental_arch_on_columns", *slow("ferris_tinloi/wall_6"),
    "gilbert/wedge_blocks", *slow("paterson_zwick/diamond_4"),
])  # fmt: skip
@pytest.mark.parametrize("turned", [False, True])
def test_a_plane_scene_extruded_has_its_joints_as_polygons(case, turned):
    plane = mo.load(f"cases/{case}.toml")
    joints = contacts_of(plane)
    solid = mo.extrude(plane, 0.7)
    found = contacts_of(moved(solid, Rotation.random(random_state=4).as_matrix()) if turned else solid)
    expected = sorted(zip(joints.first, joints.second, joints.extent * 0.7, strict=True))
    shared = sorted(zip(found.first, found.second, found.extent, strict=True))
    np.testing.assert_allclose(shared, expected, rtol=1e-6)
    np.testing.assert_array_equal(np.bincount(found.joint), 4)


CUBE = box("A", (0, 1), (0, 2), (0, 3))


def of_first(blocks):
    """Return the volume, the centroid in scene coordinates and the descending face areas of the first
    block."""
    found = shapes(blocks)
    areas = shapely.area(found.faces.polygon[found.faces.block == 0])
    return found.size[0], found.centroid[0] + found.origin, sorted(areas, reverse=True)


def cube(change):
    """Return a unit cube on a floor, with its vertices and faces changed by a function."""
    unit = scene(box("A", (0, 1), (0, 1), (0, 1)), FLOOR)
    return unit.model_copy(update={"blocks": [with_parts(unit, change).blocks[0], FLOOR]})


def reversed_face(number):
    def change(vertices, faces):
        return vertices, [face[::-1] if number in (None, at) else face for at, face in enumerate(faces)]

    return change


def test_a_box_and_a_pyramid_have_their_volume_centroid_and_faces():
    volume, centroid, areas = of_first(scene(CUBE, FLOOR))
    assert volume == pytest.approx(6)
    assert centroid == pytest.approx([0.5, 1, 1.5])
    assert areas == pytest.approx([6, 6, 3, 3, 2, 2])
    pyramid = hull("A", [(-1, -1, 0), (1, -1, 0), (1, 1, 0), (-1, 1, 0), (0, 0, 2)])
    volume, centroid, areas = of_first(scene(pyramid, FLOOR))
    assert volume == pytest.approx(4 * 2 / 3)
    assert centroid == pytest.approx([0, 0, 0.5])
    assert areas == pytest.approx([4, *4 * [math.sqrt(5)]])


def test_the_middle_of_what_can_move_is_the_origin_and_its_diagonal_gives_the_tolerance():
    found = shapes(scene(CUBE, FLOOR))
    assert found.origin == pytest.approx([0.5, 1, 1.5])
    assert found.tolerance == pytest.approx(1e-6 * math.sqrt(14))
    far = scene(box("A", (1e10, 1e10 + 1), (0, 1), (0, 1)), FLOOR)
    assert shapes(far).tolerance == 8 * np.spacing(1e10)
    assert shapes(scene(CUBE, FLOOR, tolerance=0.01)).tolerance == 0.01


@pytest.mark.parametrize("number", [None, 3])
def test_faces_turned_inwards_are_turned_round(number):
    volume, centroid, areas = of_first(cube(reversed_face(number)))
    assert volume == pytest.approx(1)
    assert centroid == pytest.approx([0.5, 0.5, 0.5])
    assert areas == pytest.approx(6 * [1])


def test_coplanar_pieces_are_one_face():
    assert of_first(in_triangles(scene(CUBE, FLOOR)))[2] == pytest.approx([6, 6, 3, 3, 2, 2])
    # Two parts side by side form a box, which has no face where they meet.
    halves = parted("A", ((0, 1), (0, 1), (0, 3)), ((0, 1), (1, 2), (0, 3)))
    volume, centroid, areas = of_first(scene(halves, FLOOR))
    assert volume == pytest.approx(6)
    assert centroid == pytest.approx([0.5, 1, 1.5])
    assert areas == pytest.approx([6, 6, 3, 3, 2, 2])


def test_a_smaller_part_on_a_larger_one_leaves_a_face_with_a_hole():
    found = shapes(scene(parted("A", ((0, 3), (0, 3), (0, 1)), ((1, 2), (1, 2), (1, 2))), FLOOR))
    (ring,) = (face for face in found.faces.polygon[found.faces.block == 0] if len(face.interiors))
    assert ring.area == pytest.approx(8)
    assert [len(ring.exterior.coords), len(ring.interiors[0].coords)] == [5, 5]


def solid(name, vertices, faces):
    return mo.Solid(name=name, weight=1, vertices=[*map(tuple, vertices)], faces=[[*face] for face in faces])


#: A unit cube with one corner of its top lifted by h = 0.04. To first order in h, the corners of the top are
#: h/4 from the plane through their middle that is normal to the area vector.
LIFTED = cube(lambda at, faces: (at + 0.04 * np.outer(np.arange(8) == 6, [0, 0, 1]), faces))
#: A prism whose outline is a U. Its notch is 0.5 deep, and the walls of the notch are 0.6 apart.
U = prism([(0, 0), (1, 0), (1, 1), (0.8, 1), (0.8, 0.5), (0.2, 0.5), (0.2, 1), (0, 1)], 1.0)
PARTS = parted("A", ((0, 1), (0, 1), (0, 1)), ((0.5, 2), (0, 1), (0, 1)), ((0, 1), (1, 2), (0, 1)))
#: The ten triangles of a projective plane with six corners. Every edge is in two faces, but the faces cannot
#: be oriented consistently.
LOOSE = np.random.default_rng(1).normal(size=(6, 3))
RING = [map(int, face) for face in ("014", "015", "023", "024", "035", "123", "125", "134", "245", "345")]
NO_SOLIDS = {
    "a hole": (cube(lambda at, faces: (at, faces[:-1])), ["face no. 1 ", "no other face"]),
    "a face twice": (cube(lambda at, faces: (at, [*faces, faces[0]])), ["face no. 1 ", "2 other faces"]),
    "not flat": (LIFTED, ["face no. 2 ", "0.01 away", "'tolerance'"]),
    "no volume": (cube(lambda at, faces: (at * [1, 1, 1e-9], faces)), ["volume"]),
    "not convex": (scene(solid("A", *U), FLOOR), ["0.8 ", "'parts'"]),
    "parts that overlap": (
        scene(PARTS, FLOOR),
        ["no. 1 and 2 ", "a volume of 0.5 ", "a depth of 0.5 near (0.75, 0.5, 0.5)"],
    ),
    "no inside": (scene(solid("A", LOOSE, RING), FLOOR), ["face no. ", "inside"]),
}


@pytest.mark.parametrize(("blocks", "words"), NO_SOLIDS.values(), ids=NO_SOLIDS)
def test_what_is_no_solid_is_refused_by_name(blocks, words):
    with pytest.raises(mo.CaseError, match="block 'A'") as error:
        shapes(blocks)
    for word in words:
        assert word in str(error.value)


def test_a_face_is_as_flat_as_the_tolerance():
    assert shapes(LIFTED.model_copy(update={"tolerance": 0.02})).size[0] == pytest.approx(1.01, abs=5e-3)


def test_the_thin_end_of_a_part_has_two_faces():
    """Near its tip, a wedge is thinner than the tolerance, but its upper and lower faces remain separate."""
    low = [(0, 0), (4, 0), (4, 0.02), (0.2, 0.0009), (0, 0.0005)]
    ground = box("ground", (-1, 5), (-1, 2), (-1, 0), fixed=True)
    wedge = solid("wedge", *prism(low, 1.0))
    x, z = np.array(low).T
    area = abs(x @ np.roll(z, -1) - z @ np.roll(x, -1)) / 2
    assert shapes(scene(ground, wedge, tolerance=0.001)).size[1] == pytest.approx(area)


def test_holes_count_against_the_middle():
    """The middle of a joint accounts for holes. For a ring of 4 × 4 with a hole from (1, 1) to (2, 3), the
    middle is (16·(2, 2) − 2·(1.5, 2)) / 14."""
    sides = (((0, 4), (0, 1)), ((0, 4), (3, 4)), ((0, 1), (1, 3)), ((2, 4), (1, 3)))
    ring = parted("ring", *((x, y, (-1, 0)) for x, y in sides), weight=None, fixed=True)
    assembly = assemble(scene(box("plate", (0, 4), (0, 4), (0, 1), live=(1, 0, 0)), ring))
    found = assembly.joints.middle + assembly.geometry.origin
    assert found == pytest.approx(np.array([[29 / 14, 2, 0]]), abs=1e-9)


def test_boxes_and_distances_outside_of_hulls():
    assembly = assemble(box_on_floor((1, 2, 3)))
    shapes = assembly.geometry
    low, high = shapes.boxes
    assert low[0] + shapes.origin == pytest.approx([0, 0, 0])
    assert high[0] + shapes.origin == pytest.approx([1, 2, 3])
    # The points are inside, on a face, 2 in front of a face, and (3, 4, 12) from a corner.
    points = np.array([(0.5, 1, 1), (0, 1, 1), (0.5, 4, 1), (4, 6, 15)]) - shapes.origin
    found = shapes.outside(np.zeros(4, dtype=int), points)
    assert found == pytest.approx([0, 0, 2, 13], abs=1e-6)

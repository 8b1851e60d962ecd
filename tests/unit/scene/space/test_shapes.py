"""Shapes of solids: what they enclose in closed form, and what is turned round, joined or refused."""

import math
import re

import numpy as np
import pytest
import shapely
from scenes_in_space import box_on_floor
from touching_solids import FLOOR, box, hull, in_triangles, parted, scene, with_parts

import masonry_opt as mo
from masonry_opt.problem.assembly import assemble
from masonry_opt.scene.space.shapes import shapes

CUBE = box("A", (0, 1), (0, 2), (0, 3))


def of_first(blocks):
    """Of the first block volume, centroid in the scene's coordinates and areas of faces, falling."""
    found = shapes(blocks)
    areas = shapely.area(found.faces.polygon[found.faces.block == 0])
    return found.size[0], found.centroid[0] + found.origin, sorted(areas, reverse=True)


def cube(change):
    """A cube of unit sides with other vertices and faces, on a floor."""
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
    # Two parts side by side are a box: where they meet is no outer face.
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


def refused(blocks, *words):
    with pytest.raises(mo.CaseError) as error:
        shapes(blocks)
    assert re.match("scene: block 'A'", str(error.value))
    for word in words:
        assert word in str(error.value)


def test_surfaces_with_a_hole_or_a_face_too_many_are_refused():
    refused(cube(lambda vertices, faces: (vertices, faces[:-1])), "face no. 1 ", "no other face")
    refused(cube(lambda vertices, faces: (vertices, [*faces, faces[0]])), "face no. 1 ", "2 other faces")


def test_a_face_that_is_not_flat_is_refused_with_how_much():
    def lifted(vertices, faces):
        vertices = vertices.copy()
        vertices[6, 2] += 0.04
        return vertices, faces

    # A square with one corner lifted by h: its corners lie h/4 off the plane through their middle that is
    # square to the area's normal, to the first order in h.
    refused(cube(lifted), "face no. 2 ", "0.01 off", "'tolerance'")
    raised = cube(lifted).model_copy(update={"tolerance": 0.02})
    assert shapes(raised).size[0] == pytest.approx(1.01, abs=5e-3)


def test_a_solid_without_volume_is_refused():
    flat = cube(lambda vertices, faces: (vertices * [1, 1, 1e-9], faces))
    refused(flat, "volume")


def test_a_solid_that_is_not_convex_needs_parts():
    """A U: its notch is .5 deep, and the far walls of the notch are .6 in front of each other's planes."""
    outline = [(0, 0), (1, 0), (1, 1), (0.8, 1), (0.8, 0.5), (0.2, 0.5), (0.2, 1), (0, 1)]
    count = len(outline)
    faces = [[*range(count)][::-1], [*range(count, 2 * count)]]
    faces += [[k, (k + 1) % count, (k + 1) % count + count, k + count] for k in range(count)]
    vertices = [(x, y, z) for z in (0, 1) for x, y in outline]
    refused(scene(mo.Solid(name="A", vertices=vertices, faces=faces, weight=1), FLOOR), "0.8 ", "'parts'")


def test_parts_of_a_block_that_overlap_are_refused_with_place_and_volume():
    block = parted("A", ((0, 1), (0, 1), (0, 1)), ((0.5, 2), (0, 1), (0, 1)), ((0, 1), (1, 2), (0, 1)))
    refused(scene(block, FLOOR), "no. 1 and 2 ", "0.5 round (0.75, 0.5, 0.5)", "0.5 deep")


def test_a_solid_whose_surface_has_no_inside_is_refused():
    """Six triangles round a ring of a projective plane with six corners, closed by the rest of it: every edge
    is in two faces, and they cannot be turned one way."""
    faces = [
        (0, 1, 4),
        (0, 1, 5),
        (0, 2, 3),
        (0, 2, 4),
        (0, 3, 5),
        (1, 2, 3),
        (1, 2, 5),
        (1, 3, 4),
        (2, 4, 5),
    ]
    faces.append((3, 4, 5))
    vertices = np.random.default_rng(1).normal(size=(6, 3)).tolist()
    block = mo.Solid(name="A", vertices=vertices, faces=[list(face) for face in faces], weight=1)
    refused(scene(block, FLOOR), "face no. ", "inside")


def test_the_thin_end_of_a_part_has_two_faces():
    """Near its tip a wedge is thinner than the tolerance: its upper face is no piece of its lower one."""
    low = [(0, 0), (4, 0), (4, 0.02), (0.2, 0.0009), (0, 0.0005)]
    count = len(low)
    sides = [[i, (i + 1) % count, (i + 1) % count + count, i + count] for i in range(count)]
    faces = [list(range(count))[::-1], list(range(count, 2 * count)), *sides]
    corners = [(x, y, z) for y in (0.0, 1.0) for x, z in low]
    wedge = mo.Solid(name="wedge", weight=1, vertices=corners, faces=faces)
    ground = mo.box("ground", (-1, 5), (-1, 2), (-1, 0), fixed=True)
    scene = mo.Scene(joints=mo.JointDefaults(friction=0.5), blocks=[ground, wedge], tolerance=0.001)
    x, z = np.array(low).T
    area = abs(x @ np.roll(z, -1) - z @ np.roll(x, -1)) / 2
    assert shapes(scene).size[1] == pytest.approx(area)


def on_footing(*parts):
    """A plate of 4 × 4 on a footing of boxes 1 high."""
    footing = [mo.Part(box=(x, y, (-1, 0))) for x, y in parts]
    blocks = [
        mo.box("plate", (0, 4), (0, 4), (0, 1), weight=1.0, live=(1, 0, 0)),
        mo.Solid(name="footing", parts=footing, fixed=True),
    ]
    return assemble(mo.Scene(joints={"friction": 0.6}, blocks=blocks))


def test_holes_count_against_the_middle():
    """A ring of 4 × 4 with a hole from (1, 1) to (2, 3): (16·(2, 2) − 2·(1.5, 2)) / 14."""
    assembly = on_footing(((0, 4), (0, 1)), ((0, 4), (3, 4)), ((0, 1), (1, 3)), ((2, 4), (1, 3)))
    found = assembly.joints.middle + assembly.geometry.origin
    assert found == pytest.approx(np.array([[29 / 14, 2, 0]]), abs=1e-9)


def test_boxes_and_distances_outside_of_hulls():
    assembly = assemble(box_on_floor((1, 2, 3)))
    shapes = assembly.geometry
    low, high = shapes.boxes
    assert low[0] + shapes.origin == pytest.approx([0, 0, 0])
    assert high[0] + shapes.origin == pytest.approx([1, 2, 3])
    # Inside, on a face, 2 in front of one, and off a corner by (3, 4, 12).
    points = np.array([(0.5, 1, 1), (0, 1, 1), (0.5, 4, 1), (4, 6, 15)]) - shapes.origin
    found = shapes.outside(np.zeros(4, dtype=int), points)
    assert found == pytest.approx([0, 0, 2, 13], abs=1e-6)

"""Meshes with several closed surfaces: stones that one object contains, and stones that touch."""

import json
import re
import warnings

import numpy as np
import pytest
from meshes import box, glb, obj, prism, stl

import masonry_opt as mo
from masonry_opt.errors import DrawingWarning

#: Two cubes, one on the other, on the ground. A horizontal load overturns both about an edge at λ = 1/2.
GROUND = box((-1, 2), (-1, 2), (-1, 0))
LOW = box((0, 1), (0, 1), (0, 1))
HIGH = box((0, 1), (0, 1), (1, 2))
GIVEN = {"friction": 0.7, "unit_weight": 10.0, "live": (1, 0, 0)}


def joined(*shapes):
    """Return the corners and faces of several shapes as one shape."""
    corners, faces = [], []
    for own, its_faces in shapes:
        faces += [tuple(len(corners) + corner for corner in face) for face in its_faces]
        corners += own.tolist()
    return np.array(corners), faces


def read(tmp_path, name, data, **keys):
    path = tmp_path / name
    path.write_bytes(data)
    return mo.read_mesh(path, **GIVEN | keys)


@pytest.mark.parametrize("word", ["o", "g"])
def test_a_warning_names_an_object_of_several_stones(tmp_path, word):
    """Programs that write layers as groups join all stones of a layer."""
    several = r"block 'wall' \(2 surfaces\) consists of several closed surfaces, but each block moves"
    with pytest.warns(DrawingWarning, match=several) as warned:
        scene = read(tmp_path, "a.obj", obj({"wall": joined(LOW, HIGH), "fixed": GROUND}, word=word))
    assert len(scene.blocks) == 2
    assert warned[0].filename == __file__
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        apart = read(tmp_path, "b.obj", obj({"low": LOW, "high": HIGH, "fixed": joined(GROUND, LOW)}))
    assert len(apart.blocks) == 3


def test_a_cavity_is_no_second_stone(tmp_path):
    """A hollow stone has two closed surfaces, of which the inner one bounds the cavity."""
    corners, faces = box((0.2, 0.8), (0.2, 0.8), (0.2, 0.8))
    hollow = joined(LOW, (corners, [face[::-1] for face in faces]))
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        scene = read(tmp_path, "hollow.obj", obj({"stone": hollow, "fixed": GROUND}))
    assert len(scene.blocks) == 2


def turned(shape, rng):
    """Return a shape of which some faces are clockwise, as seen from outside."""
    corners, faces = shape
    return corners, [face[:: rng.choice((-1, 1))] for face in faces]


def test_stones_of_one_mesh_touch_although_their_faces_are_turned_at_random(tmp_path):
    """Faces of touching stones share edges. The order of the faces then separates the stones."""
    rng = np.random.default_rng(4)
    mesh = joined(*(turned(shape, rng) for shape in (LOW, HIGH, GROUND)))
    scene = read(tmp_path, "stones.stl", stl({"stones": mesh}), fixed_below=-0.5)
    assert [block.name for block in scene.blocks] == ["stones-0", "stones-1", "stones-2"]
    assert mo.solve(scene, "static").required() == pytest.approx(1 / 2, rel=1e-5)


def test_touching_stones_with_turned_faces_in_no_order_are_refused_with_the_reason(tmp_path):
    """Touching faces are divided along different diagonals, so the stones have no triangles in common."""
    rng = np.random.default_rng(4)
    corners, faces = joined(LOW, HIGH, GROUND)
    faces = [three for a, b, c, d in faces[:6] for three in ((a, b, c), (a, c, d))] + [
        three for a, b, c, d in faces[6:] for three in ((a, b, d), (b, c, d))
    ]
    corners, faces = turned((corners, faces), rng)
    faces = [faces[number] for number in rng.permutation(len(faces))]
    for name, write in (("a.stl", stl), ("a.obj", obj)):
        with pytest.raises(mo.CaseError, match="are oriented inconsistently, so the surfaces cannot be sep"):
            read(tmp_path, name, write({"stones": (corners, faces)}), fixed_below=-0.5)


def test_nodes_without_a_name_of_their_own_are_numbered(tmp_path):
    """Nodes of glTF files need no names, and their names need not differ. Upwards is y."""
    shapes = [(corners[:, [0, 2, 1]] * [1, 1, -1], faces) for corners, faces in (LOW, HIGH, GROUND)]
    meshes = [
        (corners, [three for a, b, c, d in faces for three in ((a, b, c), (a, c, d))])
        for corners, faces in shapes
    ]
    for named, names in (
        ({}, ["stones-0", "stones-1", "stones-2"]),
        ({"name": "Cube"}, ["Cube-0", "Cube-1", "Cube-2"]),
    ):
        data = glb([{"mesh": number} | named for number in range(3)], [[mesh] for mesh in meshes])
        scene = read(tmp_path, "stones.glb", data, fixed_below=-0.5)
        assert [block.name for block in scene.blocks] == names


def obj_of(*named):
    """Return an OBJ file of pairs of a name, which may be empty or repeated, and a shape."""
    data = obj({f"#{number}": shape for number, (_, shape) in enumerate(named)})
    for number, (name, _) in enumerate(named):
        data = data.replace(f"o #{number}\n".encode(), f"o {name}\n".encode())
    return data


@pytest.mark.parametrize("name", ["wall.obj", "other.obj"])
def test_equal_names_are_refused_in_a_file_of_any_name(tmp_path, name):
    data = obj_of(("wall", LOW), ("wall", HIGH), ("fixed", GROUND))
    with pytest.raises(mo.CaseError, match="two blocks are named 'wall': rename one of them"):
        read(tmp_path, name, data)


def test_numbers_of_blocks_without_a_name_skip_existing_names(tmp_path):
    shapes = [box((x, x + 1), (0, 1), (0, 1)) for x in (0, 2, 4, 6)]
    named = zip(("", "a-0", "", "a", "fixed"), [*shapes, GROUND], strict=True)
    scene = read(tmp_path, "a.obj", obj_of(*named))
    assert [block.name for block in scene.blocks] == ["a-1", "a-0", "a-2", "a", "fixed"]


def test_numbers_of_nodes_skip_existing_names(tmp_path):
    """The names of nodes in glTF files need not differ."""
    corners, faces = LOW
    triangles = [three for a, b, c, d in faces for three in ((a, b, c), (a, c, d))]
    nodes = [
        {"mesh": 0, "name": name, "translation": [2 * number, 0, 0]}
        for number, name in enumerate(["a", "a-0", "a", "fixed"])
    ]
    scene = read(tmp_path, "s.glb", glb(nodes, [[(corners, triangles)]]), up="z")
    assert [block.name for block in scene.blocks] == ["a-1", "a-0", "a-2", "fixed"]


def test_all_repeated_names_are_listed(tmp_path):
    one, other = (obj({"a": shape, "b": GROUND}) for shape in (LOW, HIGH))
    with pytest.raises(mo.CaseError, match="several blocks have the same name: a, b: give each block"):
        read(tmp_path, "twice.obj", one + b"\n" + other)


def test_a_warning_names_a_mesh_of_two_stones_in_compas_data(tmp_path):
    def entry(shape):
        corners, faces = shape
        vertices = {
            str(number): dict(zip("xyz", row, strict=True)) for number, row in enumerate(corners.tolist())
        }
        data = {"vertex": vertices, "face": {str(number): list(face) for number, face in enumerate(faces)}}
        return {"dtype": "compas.datastructures/Mesh", "data": data}

    path = tmp_path / "wall.json"
    path.write_text(json.dumps([entry(GROUND), entry(joined(LOW, HIGH))]))
    with pytest.warns(DrawingWarning, match=r"block '1' \(2 surfaces\) consists of several") as warned:
        mo.read_compas(path, **GIVEN, fixed=["0"])
    assert warned[0].filename == __file__


@pytest.mark.parametrize("along", [1, -1])
@pytest.mark.parametrize("error", [0.0, 1e-6])
def test_a_ground_of_two_triangles_is_a_support_as_one_face_is(tmp_path, along, error):
    """glTF, STL and triangulated files divide a plane into triangles. Coordinates may be rounded."""
    corners = np.array([(-5, -5, 0), (5, -5, 0), (5, 5, error), (-5, 5, 0)], dtype=float)
    plane = corners, [(0, 1, 2)[::along], (0, 2, 3)[::along]]
    scene = read(tmp_path, "a.obj", obj({"low": LOW, "high": HIGH, "fixed": plane}))
    assert mo.solve(scene, "static").required() == pytest.approx(1 / 2, rel=1e-5)
    with pytest.raises(mo.CaseError, match="block 'plate' is a single face: give it a thickness"):
        read(tmp_path, "b.obj", obj({"low": LOW, "plate": plane, "fixed": GROUND}))


def test_a_face_that_is_written_twice_is_read_once(tmp_path):
    corners, faces = LOW
    twice = corners, [*faces, faces[2], faces[0][1:] + faces[0][:1]]
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        scene = read(tmp_path, "a.obj", obj({"low": twice, "fixed": GROUND}))
    assert (
        scene.blocks[0].faces == read(tmp_path, "b.obj", obj({"low": LOW, "fixed": GROUND})).blocks[0].faces
    )


@pytest.mark.parametrize("wrong", [{"translation": "abc"}, {"scale": [1, 1]}, {"matrix": [1, 0, 0]}])
def test_a_node_with_a_wrong_transformation_is_not_valid_gltf(tmp_path, wrong):
    corners, faces = LOW
    triangles = [three for a, b, c, d in faces for three in ((a, b, c), (a, c, d))]
    data = glb([{"mesh": 0} | wrong], [[(corners, triangles)]])
    with pytest.raises(mo.CaseError, match="is not valid glTF: a node has a wrong transformation; export"):
        read(tmp_path, "stones.glb", data, fixed_below=-0.5)


@pytest.mark.parametrize("ending", ["json", "obj", "glb", "folder"])
def test_the_parts_of_an_exported_stone_are_no_stones(tmp_path, ending):
    """The package writes the convex parts of a notched stone as closed surfaces."""
    notched = mo.Block(name="stone", vertices=[(0, 0), (3, 0), (3, 2), (2, 2), (2, 1), (0, 1)], weight=1)
    floor = mo.Block(name="fixed floor", vertices=[(-1, -1), (4, -1), (4, 0), (-1, 0)], fixed=True)
    scene = mo.extrude(mo.Scene(joints={"friction": 0.6}, blocks=[notched, floor]), 1.0)
    path = tmp_path if ending == "folder" else tmp_path / f"scene.{ending}"
    mo.export(scene, tmp_path / f"scene.{'obj' if ending == 'folder' else ending}")
    reader = mo.read_compas if ending == "json" else mo.read_mesh
    supports = {"fixed_below": -0.5} if ending == "folder" else {"fixed": ["fixed floor"]}
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert len(reader(path, **GIVEN, **supports).blocks) == 2


def reversed_faces(faces):
    return [face[::-1] for face in faces]


@pytest.mark.parametrize("twice", ["each face in succession", "all faces"])
def test_repeated_faces_are_no_second_stone(tmp_path, twice):
    corners, faces = LOW
    repeated = [face for face in faces for _ in range(2)] if twice == "each face in succession" else faces * 2
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        scene = read(tmp_path, "a.obj", obj({"low": (corners, repeated), "fixed": GROUND}))
        whole = read(tmp_path, "a.stl", stl({"low": (corners, repeated), "fixed": GROUND}), fixed_below=-0.5)
    for each in (scene, whole):
        assert len(each.blocks) == 2
        assert mo.solve(each, "static").required() == pytest.approx(0.7, rel=1e-5)


@pytest.mark.parametrize("height", [0.2, 1.5])
def test_a_stone_in_the_opening_of_another_is_no_cavity(tmp_path, height):
    """The bounding box of the U contains the stone at the lower height, but the U does not."""
    upright = [(0, 0), (3, 0), (3, 1), (2, 1), (2, 0.2), (1, 0.2), (1, 1), (0, 1)]
    corners, faces = prism([(x, 1.2 * z) for x, z in upright], 1.0)
    stone = box((1.2, 1.8), (0.2, 0.8), (height + 0.1, height + 0.6))
    with pytest.warns(DrawingWarning, match=r"block 'u' \(2 surfaces\) consists of several"):
        read(tmp_path, "a.obj", obj({"u": joined((corners, faces), stone), "fixed": GROUND}))


def test_a_stone_in_a_cavity_is_a_second_stone(tmp_path):
    cavity = box((0.2, 0.8), (0.2, 0.8), (0.2, 0.8))
    stone = box((0.4, 0.6), (0.4, 0.6), (0.4, 0.6))
    nested = joined(LOW, (cavity[0], reversed_faces(cavity[1])), stone)
    with pytest.warns(DrawingWarning, match=r"block 'low' \(2 surfaces\) consists of several"):
        read(tmp_path, "a.obj", obj({"low": nested, "fixed": GROUND}))


@pytest.mark.parametrize("size", [1, 2, 12])
def test_two_sided_triangles_are_read_once(tmp_path, size):
    """Some programs write each triangle, each pair of triangles or each stone with its reverse.

    The stones touch. The order of the triangles does not matter.
    """

    def two_sided(shape):
        corners, faces = shape
        own = [three for a, b, c, d in faces for three in ((a, b, c), (a, c, d))]
        pieces = [own[first : first + size] for first in range(0, len(own), size)]
        return corners, [face for piece in pieces for face in [*piece, *reversed_faces(piece)]]

    shapes = {name: two_sided(shape) for name, shape in (("low", LOW), ("high", HIGH), ("ground", GROUND))}
    scene = read(tmp_path, "a.stl", stl(shapes), fixed_below=-0.5)
    assert [block.name for block in scene.blocks] == ["a-0", "a-1", "a-2"]
    assert mo.solve(scene, "static").required() == pytest.approx(1 / 2, rel=1e-5)


def test_a_single_stone_may_have_two_sided_triangles(tmp_path):
    """A triangle and its reverse are no closed surface of a stone."""
    corners, faces = box((0, 1), (0, 1), (0.5, 1.5))
    own = [three for a, b, c, d in faces for three in ((a, b, c), (a, c, d))]
    low = corners, [face for three in own for face in (three, three[::-1])]
    scene = read(tmp_path, "a.stl", stl({"low": low, "ground": GROUND}), fixed_below=-0.5)
    assert [len(block.polyhedra) for block in scene.blocks] == [1, 1]


#: Stone of the area 1.75 and the depth 1, on the ground with the width 2.
NOTCHED = prism([(0, 0), (2, 0), (2, 0.5), (0.5, 0.5), (0.5, 2), (0, 2)], 1.0)


def weight_on_ground(scene):
    """Return the normal force between the only movable block and the ground, under a horizontal live load."""
    return mo.solve(scene, "static").joints["n"].sum()


def test_the_back_faces_of_notched_stones_in_objects_are_left_out(tmp_path):
    """Some programs write each face with its reverse, and each stone as an object.

    The stone weighs 10 × 1.75.
    """
    corners, faces = NOTCHED
    ground, its_faces = GROUND
    shapes = {
        "stone": (corners, faces + reversed_faces(faces)),
        "fixed": (ground, its_faces + reversed_faces(its_faces)),
    }
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        scene = read(tmp_path, "a.obj", obj(shapes))
    assert weight_on_ground(scene) == pytest.approx(17.5, rel=1e-6)


@pytest.mark.parametrize("shape", [LOW, NOTCHED], ids=["convex", "notched"])
def test_a_corner_in_the_middle_of_an_edge_is_no_hole(tmp_path, shape):
    """One of the two faces at an edge has an additional corner in the middle of the edge."""
    corners, faces = shape
    corners = np.concatenate([corners, [(corners[0] + corners[1]) / 2]])
    number = next(number for number, face in enumerate(faces) if 0 in face and 1 in face)
    face = list(faces[number])
    start = face.index(0) if face[face.index(0) - 1] == 1 else face.index(1)
    faces = [*faces[:number], (*face[:start], len(corners) - 1, *face[start:]), *faces[number + 1 :]]
    scene = read(tmp_path, "a.obj", obj({"stone": (corners, faces), "fixed": GROUND}))
    assert weight_on_ground(scene) == pytest.approx(10 if shape is LOW else 17.5, rel=1e-6)


@pytest.mark.parametrize("error", [3e-7, 3e-6, 1e-4])
def test_triangles_with_their_own_inexact_corners_are_one_surface(tmp_path, error):
    """Some programs divide each face of a stone separately, so that common corners differ by rounding.

    Corners within the tolerance are joined, also where the warning counts the surfaces of a block. If the
    corners are farther apart, the message advises a tolerance that joins them.
    """
    rng = np.random.default_rng(0)
    corners, faces = LOW
    own = [three for a, b, c, d in faces for three in ((a, b, c), (a, c, d))]
    apart = np.concatenate([corners[list(face)] for face in own])
    apart += rng.uniform(-error, error, apart.shape)
    triangles = np.arange(len(apart)).reshape(-1, 3).tolist()
    data = obj({"stone": (apart, triangles), "fixed": GROUND})
    tolerance = None
    if error > 1e-6:
        advised = r"its coordinates are inexact: set 'tolerance' to ([\d.e-]+)$"
        with pytest.raises(mo.CaseError, match=advised) as refusal:
            read(tmp_path, "a.obj", data)
        tolerance = float(re.search(advised, str(refusal.value))[1])
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        scene = read(tmp_path, "a.obj", data, tolerance=tolerance)
    assert weight_on_ground(scene) == pytest.approx(10, rel=10 * error)


def test_a_face_outside_of_the_surface_is_to_be_deleted(tmp_path):
    corners, faces = LOW
    fin = (*corners, (0.5, -1, 0)), [*faces, (0, 1, 8)]
    with pytest.raises(mo.CaseError, match=r"block 'stone' is not closed .*: delete this face, which is not"):
        read(tmp_path, "a.obj", obj({"stone": (np.array(fin[0]), fin[1]), "fixed": GROUND}))

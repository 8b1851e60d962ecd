"""Touching stones of one mesh in PLY, OBJ and STL files, with faces in any order and orientation."""

import re
import struct
import warnings

import numpy as np
import pytest
import trimesh
from meshes import box, damaged_copies, obj, stl
from speeds import slow
from touching_solids import contacts_of

import masonry_opt as mo
from masonry_opt.scene.drawings.meshes import Mesh, merge_equal_corners, outwards, volume
from masonry_opt.scene.drawings.surfaces import divide_into_surfaces
from masonry_opt.scene.space.shapes import shapes

#: On the ground, two stones side by side, with a third stone on one of them.
STONES = [
    box((-1, 4), (-1, 2), (-1, 0)),
    box((0, 2), (0, 1), (0, 1)),
    box((2, 3), (0, 1), (0, 1)),
    box((0, 2), (0, 1), (1, 5)),
]
SIZES = [1, 2, 8, 15]
#: Areas of the joints: between the lower stones, below the upper stone, and of each lower stone with the
#: ground.
AREAS = [1, 1, 2, 2]
GIVEN = {"friction": 0.7, "unit_weight": 10.0, "live": (1, 0, 0), "fixed_below": -0.5}


def whole(stones, corners):
    """Return the corners and faces of all stones as one mesh.

    ``corners`` are "of faces" if each face has its own, "of stones", or "shared" by the stones.
    """
    points, faces = [], []
    for own, quads in stones:
        if corners == "of stones":
            faces += [[len(points) + corner for corner in quad] for quad in quads]
            points += own.tolist()
            continue
        for quad in quads:
            faces.append([len(points) + corner for corner in range(4)])
            points += own[list(quad)].tolist()
    if corners == "shared":
        points, number = np.unique(points, axis=0, return_inverse=True)
        faces = number.ravel()[np.array(faces)].tolist()
    return np.array(points, dtype=float), faces


def arranged(faces, orientation, order, rng):
    """Return the faces of the four stones in another order and orientation."""
    if orientation == "one stone inwards":
        faces = [face[::-1] if 6 <= number < 12 else face for number, face in enumerate(faces)]
    elif orientation == "random":
        faces = [face[:: rng.choice((-1, 1))] for face in faces]
    return [faces[number] for number in rng.permutation(len(faces))] if order == "random" else faces


def ply(points, faces, kind="ascii", count="uchar"):
    """Return a PLY file that is written according to the description of the format."""
    order = {"ascii": "", "binary_little_endian": "<", "binary_big_endian": ">"}[kind]
    head = (
        f"ply\nformat {kind} 1.0\ncomment stones\nelement vertex {len(points)}\nproperty double x\n"
        "property double y\nproperty uchar red\nproperty double z\n"
        f"element face {len(faces)}\nproperty list {count} int vertex_indices\nproperty short stone\n"
        "element edge 1\nproperty int vertex1\nend_header\n"
    )
    if kind == "ascii":
        lines = [f"{x} {y} 255 {z}" for x, y, z in points]
        lines += [f"{len(face)} {' '.join(map(str, face))} -1" for face in faces]
        return (head + "\n".join([*lines, "7"]) + "\n").encode()
    rows = [struct.pack(order + "ddBd", x, y, 255, z) for x, y, z in points]
    letter = {"uchar": "B", "int": "i"}[count]
    rows += [struct.pack(f"{order}{letter}{len(face)}ih", len(face), *face, -1) for face in faces]
    return head.encode() + b"".join([*rows, struct.pack(order + "i", 7)])


def read(path, data, **more):
    path.write_bytes(data)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        return mo.read_mesh(path, **(GIVEN | more))


def check(scene):
    assert sorted(shapes(scene).size) == pytest.approx(SIZES, rel=1e-6)
    assert sorted(contacts_of(scene).extent) == pytest.approx(AREAS, rel=1e-5)


@pytest.mark.parametrize("order", [*slow("by stone"), "random"])
@pytest.mark.parametrize("orientation", ["outwards", *slow("one stone inwards"), "random"])
@pytest.mark.parametrize("corners", ["of faces", "of stones", "shared"])
def test_touching_stones_of_quadrilaterals_are_separated(tmp_path, corners, orientation, order):
    points, faces = whole(STONES, corners)
    faces = arranged(faces, orientation, order, np.random.default_rng(5))
    check(read(tmp_path / "a.ply", ply(points, faces)))
    check(read(tmp_path / "a.obj", obj({"a": (points, faces)})))


@pytest.mark.parametrize("order", ["by stone", "random"])
def test_stones_without_common_corners_are_separated_in_any_order(tmp_path, order):
    """Without common corners, all faces together look like one closed surface."""
    stones = [box((-1, 4), (-1, 2), (-1, 0)), box((0, 2), (0, 1), (0, 1)), box((1, 3), (0.1, 0.9), (1, 2))]
    points, faces = whole(stones, "of faces")
    faces = arranged(faces, "outwards", order, np.random.default_rng(5))
    for name, data in (("a.ply", ply(points, faces)), ("a.stl", stl({"a": (points, faces)}))):
        scene = read(tmp_path / name, data)
        assert sorted(shapes(scene).size) == pytest.approx([1.6, 2, 15], rel=1e-5)
        assert sorted(contacts_of(scene).extent) == pytest.approx([0.8, 2], rel=1e-5)


@pytest.mark.parametrize("kind", ["ascii", "binary_little_endian", "binary_big_endian"])
@pytest.mark.parametrize("divided", [0, 1, *slow(24)])
def test_formats_of_ply_with_triangles_and_quadrilaterals(tmp_path, kind, divided):
    """Lists of equal and of different lengths are read."""
    points, quads = whole(STONES, "of stones")
    faces = [three for a, b, c, d in quads[:divided] for three in ([a, b, c], [a, c, d])] + quads[divided:]
    check(read(tmp_path / "a.ply", ply(points, faces, kind, "int")))
    check(read(tmp_path / "b.ply", ply(points, faces, kind).replace(b"vertex_indices", b"vertex_index")))


@pytest.mark.parametrize("end", [b"\r", b"\r\n"])
def test_ply_files_with_other_ends_of_lines_are_read(tmp_path, end):
    points, quads = whole(STONES, "of stones")
    check(read(tmp_path / "a.ply", ply(points, quads).replace(b"\n", end)))
    head, body = ply(points, quads, "binary_little_endian").split(b"end_header\n")
    check(read(tmp_path / "b.ply", (head + b"end_header\n").replace(b"\n", end) + body))


@pytest.mark.parametrize("kind", ["ascii", "binary_big_endian"])
def test_version_1_1_of_ply_is_read_as_version_1_0(tmp_path, kind):
    data = ply(*whole(STONES, "of stones"), kind).replace(b" 1.0\n", b" 1.1\n", 1)
    assert f"format {kind} 1.1\n".encode() in data
    check(read(tmp_path / "a.ply", data))


@pytest.mark.parametrize("encoding", ["ascii", "binary"])
def test_ply_files_of_trimesh_are_read(tmp_path, encoding):
    points, faces = whole(STONES, "of stones")
    triangles = [three for a, b, c, d in faces for three in ((a, b, c), (a, c, d))]
    mesh = trimesh.Trimesh(points, triangles, process=False)
    check(read(tmp_path / "a.ply", trimesh.exchange.ply.export_ply(mesh, encoding=encoding)))


def test_a_notched_polygon_of_ply_is_not_divided_into_a_fan(tmp_path):
    """The stone is an L with the legs 3 × 1 and 1 × 2, and its two ends are polygons of six corners."""
    outline = [(0, 0), (3, 0), (3, 1), (1, 1), (1, 3), (0, 3)]
    points = [(x, y, z) for y in (0, 1) for x, z in outline]
    sides = [[i, (i + 1) % 6, (i + 1) % 6 + 6, i + 6] for i in range(6)]
    corners, quads = whole([box((-1, 4), (-1, 2), (-1, 0))], "of stones")
    ground = [[corner + 12 for corner in quad] for quad in quads]
    faces = [[5, 4, 3, 2, 1, 0], [6, 7, 8, 9, 10, 11], *sides, *ground]
    scene = read(tmp_path / "a.ply", ply([*points, *corners], faces))
    assert sorted(shapes(scene).size) == pytest.approx([5, 15], rel=1e-6)


def test_a_common_face_that_is_drawn_once_is_refused_with_its_place(tmp_path):
    points, faces = whole(STONES, "shared")
    distinct = {frozenset(face): face for face in faces}
    assert len(distinct) == len(faces) - 2
    for name, data in (
        ("a.ply", ply(points, [*distinct.values()])),
        ("a.obj", obj({"a": (points, [*distinct.values()])})),
    ):
        with pytest.raises(mo.CaseError) as refusal:
            read(tmp_path / name, data)
        message = str(refusal.value)
        place = r"\((0|2), (0|1), (0|1)\)"
        pattern = rf"{name}: at the edge from {place} to {place}, two parts share a single face"
        assert re.search(pattern, message)
        assert "export each stone as a separate object" in message


def random_boxes(rng):
    """Return boxes in the cells of a random grid, of which some are empty, and the corners of all boxes."""
    axes = [np.append(0, np.cumsum(rng.uniform(0.5, 2, rng.integers(1, 4)))) for _ in range(3)]
    cells = [cell for cell in np.ndindex(*(len(axis) - 1 for axis in axes)) if rng.random() < 0.8]
    return [box(*(axis[n : n + 2] for axis, n in zip(axes, cell, strict=True))) for cell in cells]


@pytest.mark.parametrize("divided", [*slow(False), True])
def test_random_boxes_with_turned_faces_in_no_order_are_separated(divided):
    """Boxes may touch along edges only, and may enclose a void.

    Triangles have the diagonal through the first corner in the order of coordinates, so touching boxes have
    the same triangles.
    """
    for seed in range(40):
        rng = np.random.default_rng([3, seed])
        stones = random_boxes(rng)
        if len(stones) < 2:
            continue
        points, faces = whole(stones, "of faces")
        if divided:
            first = [min(range(4), key=lambda corner: tuple(points[face[corner]])) for face in faces]
            faces = [face[n:] + face[:n] for face, n in zip(faces, first, strict=True)]
            faces = [three for a, b, c, d in faces for three in ([a, b, c], [a, c, d])]
        faces = arranged(faces, "random", "random", rng)
        parts = divide_into_surfaces(Mesh("a", points, faces))
        sizes = [volume(part.points, outwards(part.points, merge_equal_corners(part))) for part in parts]
        expected = [float(np.prod(np.ptp(corners, axis=0))) for corners, _ in stones]
        assert sorted(sizes) == pytest.approx(sorted(expected)), seed


HEAD = ply(*whole(STONES, "of stones"))
BINARY = ply(*whole(STONES, "of stones"), "binary_little_endian")
BROKEN_PLY = {
    "empty": (b"", "its header is missing"),
    "another format": (b"solid a\nendsolid a\n", "its header is missing"),
    "an unknown format": (HEAD.replace(b"ascii", b"utf8"), "its header has the wrong line 'format utf8 1.0'"),
    "an unknown version": (HEAD.replace(b"1.0", b"2.0"), "its header has the wrong line 'format ascii 2.0'"),
    "no format": (HEAD.replace(b"format ascii 1.0\n", b""), "its header names no format"),
    "an unknown type": (
        HEAD.replace(b"double z", b"long z"),
        "its header has the wrong line 'property long z'",
    ),
    "no z": (HEAD.replace(b"double z", b"double height"), "element 'vertex' has no property 'z'"),
    "no list": (HEAD.replace(b"vertex_indices", b"corners"), "element 'face' has no property 'vertex_ind"),
    "cut off": (HEAD[:-60], "it is cut off, so corners or faces are missing"),
    "binary, cut off": (BINARY[:-60], "it is cut off, so corners or faces are missing"),
    "a huge count": (HEAD.replace(b"vertex 32", b"vertex 999999999999"), "it is cut off"),
    "binary, a huge count": (BINARY.replace(b"vertex 32", b"vertex 999999999999"), "it is cut off"),
    "a decimal comma": (HEAD.replace(b"\n-1.0 ", b"\n-1,0 "), "'-1,0' is not a number"),
    "a missing corner": (HEAD.replace(b"\n4 0 3", b"\n4 0 99"), "a face refers to a corner that does not ex"),
    "half a corner": (
        HEAD.replace(b"\n4 0 3", b"\n4 0 3.5"),
        "'3.5' is not a whole number, but its property has integer type",
    ),
    "a large corner": (
        HEAD.replace(b"\n4 0 3", b"\n4 0 1e99"),
        "'1e99' is too large for an integer property",
    ),
    "a negative length": (HEAD.replace(b"\n4 0 3", b"\n-4 0 3"), "a list has -4 values"),
}


@pytest.mark.parametrize(("data", "named"), BROKEN_PLY.values(), ids=BROKEN_PLY)
def test_broken_ply_files_are_named(tmp_path, data, named):
    with pytest.raises(mo.CaseError) as refusal:
        read(tmp_path / "a.ply", data)
    message = str(refusal.value)
    assert message.startswith(f"{tmp_path / 'a.ply'}: the file is not valid PLY: {named}")
    assert message.endswith("; save the mesh again")


@pytest.mark.parametrize("data", [HEAD, BINARY], ids=["text", "binary"])
def test_any_damage_to_a_ply_file_ends_in_a_scene_or_a_message(tmp_path, data):
    messages = []
    for damaged in damaged_copies(data):
        try:
            shapes(read(tmp_path / "a.ply", damaged))
        except mo.CaseError as error:
            messages.append(str(error))
    assert len(messages) > 20
    assert all("a.ply: " in message for message in messages)

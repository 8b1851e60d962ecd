"""OBJ, PLY and STL to scenes in space: files of boxes, notched and turned blocks written here."""

import random
import re
from itertools import pairwise

import numpy as np
import pytest
from meshes import QUADS, box, obj, ply, prism, stl
from touching_solids import contacts_of

import masonry_opt as mo
from masonry_opt.scene.space.shapes import shapes

#: A high stone on a low one: corners that coincide.
STONES = {
    "fixed ground": box((-1, 3), (-1, 2), (-1, 0)),
    "low": box((0, 2), (0, 1), (0, 1)),
    "high": box((0, 2), (0, 1), (1, 5)),
}
GIVEN = {"friction": 0.7, "unit_weight": 10.0, "live": (1, 0, 0)}


@pytest.fixture
def file(tmp_path):
    def write(data, name="stones.obj"):
        path = tmp_path / name
        path.write_bytes(data)
        return path

    return write


def read(path, **more):
    return mo.read_mesh(path, **(GIVEN | more))


@pytest.mark.parametrize(("write", "name"), [(obj, "a.obj"), (ply, "a.ply"), (stl, "a.stl")])
def test_each_closed_mesh_is_a_block(file, write, name):
    supports = {} if write is obj else {"fixed_below": -1}
    scene = read(file(write(STONES), name), **supports)
    assert [block.fixed for block in scene.blocks] == [True, False, False]
    assert [len(block.faces) for block in scene.blocks] == [6, 6, 6]
    assert shapes(scene).size == pytest.approx([12, 2, 8], rel=1e-6)
    assert sorted(contacts_of(scene).extent) == pytest.approx([2, 2], rel=1e-6)
    # The stone on top overturns: half its width over half its height.
    assert mo.solve(scene, "static").required() == pytest.approx(2 / 5, rel=1e-5)


def test_objects_and_groups_name_blocks(file):
    assert [block.name for block in read(file(obj(STONES))).blocks] == list(STONES)
    assert [block.name for block in read(file(obj(STONES, word="g"))).blocks] == list(STONES)
    nameless = b"\n".join(line for line in obj(STONES).splitlines() if not line.startswith(b"o "))
    assert [block.name for block in read(file(nameless), fixed=["stones-0"]).blocks] == [
        "stones-0",
        "stones-1",
        "stones-2",
    ]


def test_words_may_be_set_apart_by_tabs(file):
    data = obj(STONES)
    assert read(file(data.replace(b" ", b"\t"))).blocks == read(file(data)).blocks


def test_supports_by_layer_name_and_height(file):
    blocks = {"a": STONES["fixed ground"], "b": STONES["low"], "c": STONES["high"]}
    layered = obj(blocks).replace(b"o a\n", b"g Fixed\no a\n").replace(b"o b\n", b"g Stones\no b\n")
    for path, supports in [
        (file(layered, "layered.obj"), {}),
        (file(obj(blocks)), {"fixed": ["a"]}),
        (file(obj(blocks)), {"fixed_below": -0.5}),
        (file(layered), {"fixed_layers": ["rock"], "fixed": ["a"]}),
    ]:
        assert [block.fixed for block in read(path, **supports).blocks] == [True, False, False]
    with pytest.raises(mo.CaseError, match=r"stones\.obj: .*a, b, c.*'fixed_below'.*z = -1\)"):
        read(file(obj(blocks)))
    with pytest.raises(mo.CaseError, match="no block 'd'"):
        read(file(obj(blocks)), fixed=["d"])


def test_axes_and_units(file):
    """As it comes with y upwards, in millimetres: the same scene."""
    turned = {
        name: (1000 * corners[:, [0, 2, 1]] * [1, 1, -1], faces) for name, (corners, faces) in STONES.items()
    }
    one, other = read(file(obj(STONES), "z.obj")), read(file(obj(turned), "y.obj"), up="y", scale=0.001)
    assert shapes(other).size == pytest.approx(shapes(one).size)
    for block, expected in zip(other.blocks, one.blocks, strict=True):
        assert np.array(sorted(block.corners().round(9).tolist())) == pytest.approx(
            np.array(sorted(expected.corners().tolist()))
        )


def test_a_load_in_the_plane_is_refused_by_its_key(file):
    with pytest.raises(mo.CaseError, match="a mesh: key 'live': needs three numbers"):
        read(file(obj(STONES)), live=(1, 0))


U = [(0, 0), (1, 0), (1, 2), (3, 2), (3, 0), (4, 0), (4, 3), (0, 3)]


@pytest.mark.parametrize("flip", [False, True])
def test_notched_blocks_become_convex_parts(file, flip):
    """A portal on two feet, its ends of eight corners; faces of any sense."""
    corners, faces = prism(U, 0.5)
    faces = [face[::-1] if flip and number % 3 else face for number, face in enumerate(faces)]
    scene = read(file(obj({"fixed": box((-1, 5), (-1, 2), (-1, 0)), "portal": (corners, faces)})))
    portal = scene.blocks[1]
    assert 2 <= len(portal.parts) <= 4
    found = shapes(scene)
    assert found.size[1] == pytest.approx(8 * 0.5)
    assert contacts_of(scene).extent == pytest.approx([0.5, 0.5])


def test_a_block_with_a_hole_through_it_and_one_in_the_hole(file):
    """A frame in triangles, with a stone that fills it."""
    outer, inner = [(-1, 0), (2, 0), (2, 3), (-1, 3)], [(0, 1), (1, 1), (1, 2), (0, 2)]
    (corners, outside), (hole, inside) = prism(outer, 1.0), prism(inner, 1.0)
    faces = [*outside[2:], *(tuple(8 + corner for corner in face[::-1]) for face in inside[2:])]
    for i in range(4):
        j = (i + 1) % 4
        faces += [(i, j, 8 + j), (i, 8 + j, 8 + i), (4 + j, 4 + i, 12 + i), (4 + j, 12 + i, 12 + j)]
    frame = np.concatenate([corners, hole]), faces
    ground = box((-1, 2), (0, 1), (-1, 0))
    scene = read(file(obj({"fixed": ground, "frame": frame, "stone": prism(inner, 1.0)})))
    assert shapes(scene).size == pytest.approx([3, 8, 1])
    assert sum(contacts_of(scene).extent) == pytest.approx(3 + 4)


@pytest.mark.parametrize("missing", range(10))
def test_a_notched_block_with_a_face_missing_is_refused(file, missing):
    corners, faces = prism(U, 0.5)
    portal = corners, faces[:missing] + faces[missing + 1 :]
    with pytest.raises(mo.CaseError, match=r"block 'portal' is not closed at its edge from \("):
        read(file(obj({"fixed": box((-1, 5), (-1, 2), (-1, 0)), "portal": portal})))


def test_a_block_with_a_face_inside_is_refused(file):
    corners, faces = STONES["high"]
    with pytest.raises(mo.CaseError, match="block 'high' is not closed at its edge"):
        read(file(obj(STONES | {"high": (corners, [*faces, (0, 1, 6)])})))


def test_a_block_of_two_boxes_in_one_another_is_refused(file):
    (low, faces), (high, _) = box((0, 2), (0, 1), (1, 3)), box((1, 3), (0, 1), (2, 4))
    cross = np.concatenate([low, high]), [*faces, *(tuple(8 + one for one in face) for face in faces)]
    with pytest.raises(mo.CaseError, match="block 'high' has faces that cross"):
        read(file(obj(STONES | {"high": cross})))


def turned(corners, angle=0.3):
    cos, sin = np.cos(angle), np.sin(angle)
    return (
        corners
        @ np.array([[cos, sin, 0], [-sin, cos, 0], [0, 0, 1]])
        @ np.array([[1, 0, 0], [0, cos, sin], [0, -sin, cos]])
    )


@pytest.mark.parametrize("digits", [3, 4, 5])
def test_coordinates_of_few_digits_still_touch(file, digits):
    """A running bond out of all axes, its corners rounded each for itself."""
    wall = {"fixed": box((0, 4), (0, 1), (-0.5, 0))}
    for course in range(3):
        ends = [0, 2, 4] if course % 2 else [0, 1, 3, 4]
        for start, end in pairwise(ends):
            wall[f"{course} {start}"] = box((start, end), (0, 1), (course / 2, course / 2 + 0.5))
    wall = {name: (turned(corners), faces) for name, (corners, faces) in wall.items()}
    scene = read(file(obj(wall, digits)))
    assert scene.tolerance == pytest.approx(2 * 10.0**-digits)
    found = contacts_of(scene)
    # Beds of 4 each, and the head joints of 2, 1 and 2 of 0.5.
    assert sum(found.extent) == pytest.approx(3 * 4 + 5 * 0.5, abs=40 * 10.0**-digits)
    assert len(found.extent) == 3 + 4 + 4 + 5


def test_faces_that_are_not_flat_are_shared_by_triangles(file):
    """Two blocks that meet in a warped face, each with its own first corner: no gap, no overlap."""
    low, _ = box((0, 1), (0, 1), (0, 1))
    high, _ = box((0, 1), (0, 1), (1, 2))
    low[6, 2] = high[2, 2] = 1.2
    faces = [(5, 6, 7, 4) if face == QUADS[1] else face for face in QUADS]
    scene = read(
        file(obj({"fixed": box((0, 1), (0, 1), (-1, 0)), "low": (low, faces), "high": (high, QUADS)}))
    )
    found = contacts_of(scene)
    shared = found.extent[(found.first == 1) & (found.second == 2)]
    assert len(shared) == 2
    assert shapes(scene).size.sum() == pytest.approx(3)


OPEN = (STONES["low"][0], QUADS[1:])
WRONG = {
    "an open block": (obj(STONES | {"low": OPEN}), "block 'low': face no. "),
    "a face alone": (obj(STONES | {"low": (STONES["low"][0], QUADS[:1])}), "block 'low' is a single face"),
    "two of one name": (obj(STONES) + b"\n" + obj({"low": STONES["low"]}), "two blocks 'low'"),
    "a corner that is not there": (obj(STONES) + b"\nf 1 2 99", "not valid OBJ"),
    "no number": (obj(STONES) + b"\nv 1 x 2", "not valid OBJ: line "),
    "infinite": (obj(STONES).replace(b"5.000000000", b"1e999"), "block 'high' has a coordinate"),
    "empty": (b"", "holds no faces"),
    "a grain": (
        obj(STONES | {"dust": box((9, 9 + 1e-9), (0, 1e-9), (0, 1e-9))}, 12),
        "block 'dust' is smaller",
    ),
}


@pytest.mark.parametrize(("data", "named"), WRONG.values(), ids=WRONG)
def test_what_is_wrong_is_named(file, data, named):
    with pytest.raises(mo.CaseError, match=rf"stones\.obj: .*{named}"):
        contacts_of(read(file(data)))


def test_any_damage_ends_with_a_scene_or_a_message(file):
    rng = random.Random(3)
    stones = STONES | {"portal": prism(U, 0.5)}
    written = {"obj": obj(stones, 3), "ply": ply(STONES), "stl": stl(stones)}
    told = []
    for _ in range(60):
        kind = rng.choice(list(written))
        data = bytearray(written[kind])
        for _ in range(rng.randint(1, 6)):
            data[rng.randrange(len(data))] = rng.randrange(256)
        try:
            contacts_of(read(file(bytes(data), f"broken.{kind}"), fixed_below=-0.5))
        except mo.CaseError as error:
            told.append(str(error))
    assert len(told) > 30
    assert all(re.search(r"broken\.(obj|ply|stl): ", message) for message in told)

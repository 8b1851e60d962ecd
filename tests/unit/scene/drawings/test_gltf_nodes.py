"""glTF files with wrong nodes, or with extensions that change shapes, never give a wrong number."""

import json
import struct

import pytest
from meshes import box, glb

import masonry_opt as mo
from masonry_opt.scene.space.shapes import shapes

#: A stone of size 2 on the ground.
STONES = {"fixed": box((-1, 3), (-1, 2), (-1, 0)), "low": box((0, 2), (0, 1), (0, 1))}
GIVEN = {"friction": 0.7, "unit_weight": 10.0, "live": (1, 0, 0)}


def read(tmp_path, node=None, **keys):
    """Write the stones to a .glb file with additional keys in its JSON, and read the scene from it."""
    nodes = [{"name": "fixed", "mesh": 0}, {"name": "low", "mesh": 1} | (node or {})]
    meshes = [
        [
            (
                corners[:, [0, 2, 1]] * [1, 1, -1],
                [three for a, b, c, d in faces for three in ((a, b, c), (a, c, d))],
            )
        ]
        for corners, faces in STONES.values()
    ]
    data = glb(nodes, meshes)
    size = struct.unpack_from("<I", data, 12)[0]
    text = json.dumps(json.loads(data[20 : 20 + size]) | keys).encode()
    text += b" " * (-len(text) % 4)
    rest = data[20 + size :]
    path = tmp_path / "stones.glb"
    head = struct.pack("<4sIII4s", b"glTF", 2, 20 + len(text) + len(rest), len(text), b"JSON")
    path.write_bytes(head + text + rest)
    return mo.read_mesh(path, **GIVEN)


@pytest.mark.parametrize("rotation", [[0, 0, 0, 2], [0, 0.01, 0, 0.9], [0, 0.7, 0, 0.7]])
def test_rounded_quaternions_do_not_change_the_size_of_a_stone(tmp_path, rotation):
    assert shapes(read(tmp_path, {"rotation": rotation})).size == pytest.approx([12, 2], rel=1e-6)


@pytest.mark.parametrize(
    "node",
    [
        {"scale": 2},
        {"translation": 1},
        {"translation": [1, 2]},
        {"rotation": [0, 0, 0, 0]},
        {"scale": ["a"] * 3},
    ],
)
def test_wrong_transformations_are_named(tmp_path, node):
    with pytest.raises(
        mo.CaseError, match=r"stones\.glb: the file is not valid glTF: a node has a wrong trans"
    ):
        read(tmp_path, node)


@pytest.mark.parametrize(
    ("node", "keys"),
    [({"mesh": -1}, {}), ({}, {"scenes": [{"nodes": [0, -1]}]}), ({"children": [-2]}, {})],
)
def test_negative_numbers_do_not_count_from_the_end(tmp_path, node, keys):
    with pytest.raises(mo.CaseError, match=r"stones\.glb: the file is not valid glTF: a part is missing"):
        read(tmp_path, node, **keys)


INSTANCES = {"extensions": {"EXT_mesh_gpu_instancing": {"attributes": {"TRANSLATION": 0}}}}


@pytest.mark.parametrize(
    ("node", "keys", "named"),
    [
        (
            INSTANCES,
            {},
            "has the glTF extension EXT_mesh_gpu_instancing, which cannot be read: export without it",
        ),
        ({}, {"extensionsRequired": ["VENDOR_shape"]}, "has the glTF extension VENDOR_shape, which cannot"),
        (
            {},
            {"extensionsRequired": ["EXT_meshopt_compression"]},
            r"is compressed \(EXT_meshopt_compression\): export without compression",
        ),
    ],
)
def test_extensions_that_change_shapes_are_refused(tmp_path, node, keys, named):
    with pytest.raises(mo.CaseError, match=rf"stones\.glb: the file {named}"):
        read(tmp_path, node, **keys)


def test_other_extensions_are_ignored(tmp_path):
    scene = read(tmp_path, extensionsRequired=["KHR_materials_unlit", "KHR_mesh_quantization"])
    assert mo.solve(scene, "static").required() == pytest.approx(0.7, rel=1e-5)


def test_a_mesh_that_morph_targets_change_is_refused(tmp_path):
    """The corners of a mesh are the sum of its corners and of its weighted targets."""
    data = read(tmp_path) and (tmp_path / "stones.glb").read_bytes()
    size = struct.unpack_from("<I", data, 12)[0]
    meshes = json.loads(data[20 : 20 + size])["meshes"]
    (primitive,) = meshes[1]["primitives"]
    primitive["targets"] = [{"POSITION": primitive["attributes"]["POSITION"]}]
    assert shapes(read(tmp_path, {"weights": [0]}, meshes=meshes)).size == pytest.approx([12, 2], rel=1e-6)
    with pytest.raises(mo.CaseError, match=r"morph targets .* change the shape of mesh 'low': apply them"):
        read(tmp_path, {"weights": [1]}, meshes=meshes)

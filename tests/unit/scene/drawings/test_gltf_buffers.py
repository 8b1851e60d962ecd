"""glTF files with their corners in .bin files, as trimesh writes them."""

import base64
import json
import warnings

import numpy as np
import pytest
import trimesh
from meshes import box

import masonry_opt as mo
from masonry_opt.errors import DrawingWarning
from masonry_opt.scene.drawings import mesh_files
from masonry_opt.scene.space.shapes import shapes

#: A high stone on a low stone on the ground; both together overturn about an edge of the low one at λ = 2/5.
STONES = {
    "fixed": box((-1, 3), (-1, 2), (-1, 0)),
    "low": box((0, 2), (0, 1), (0, 1)),
    "high": box((0, 2), (0, 1), (1, 5)),
}
GIVEN = {"friction": 0.7, "unit_weight": 10.0, "live": (1, 0, 0)}


def write(folder, stem, blocks):
    """Write a .gltf file and its .bin files with trimesh, and return the path of the .gltf file."""
    scene = trimesh.Scene()
    for name, (corners, faces) in blocks.items():
        triangles = [three for a, b, c, d in faces for three in ((a, b, c), (a, c, d))]
        # In glTF, y points upwards: (x, y, z) of the scene is (x, z, -y) in the file.
        mesh = trimesh.Trimesh(corners[:, [0, 2, 1]] * [1, 1, -1], triangles, process=False)
        scene.add_geometry(mesh, geom_name=name, node_name=name)
    for name, content in trimesh.exchange.gltf.export_gltf(scene).items():
        (folder / name.replace("model", stem)).write_bytes(content)
    return folder / f"{stem}.gltf"


def refer(path, uri):
    """Set the URI of the first buffer of a file."""
    tree = json.loads(path.read_text())
    tree["buffers"][0]["uri"] = uri
    path.write_text(json.dumps(tree))


def refusal(path):
    with pytest.raises(mo.CaseError) as error:
        mo.read_mesh(path, **GIVEN)
    return str(error.value)


def test_corners_are_read_from_bin_files_next_to_the_file(tmp_path):
    scene = mo.read_mesh(write(tmp_path, "stones", STONES), **GIVEN)
    assert [(block.name, block.fixed) for block in scene.blocks] == [
        ("fixed", True),
        ("low", False),
        ("high", False),
    ]
    assert shapes(scene).size == pytest.approx([12, 2, 8], rel=1e-6)
    assert mo.solve(scene, "static").required() == pytest.approx(2 / 5, rel=1e-5)


@pytest.mark.parametrize("head", ["data:application/octet-stream;base64", "DATA:;BASE64", "Data:;base64"])
def test_corners_are_read_from_base64_text(tmp_path, head):
    """The scheme of a URI may be in upper case."""
    path = write(tmp_path, "stones", STONES)
    tree = json.loads(path.read_text())
    for buffer in tree["buffers"]:
        content = (tmp_path / buffer["uri"]).read_bytes()
        buffer["uri"] = f"{head},{base64.b64encode(content).decode()}"
    path.write_text(json.dumps(tree))
    assert shapes(mo.read_mesh(path, **GIVEN)).size == pytest.approx([12, 2, 8], rel=1e-6)


def test_messages_show_both_ends_of_a_long_path(tmp_path):
    path = write(tmp_path, "stones", STONES)
    refer(path, f"folder/{5000 * 'x'}.bin")
    message = refusal(path)
    assert f"the file needs 'folder/{21 * 'x'}...{25 * 'x'}.bin', which is missing: " in message
    refer(path, f"{51 * 'x'}/long.bin")
    assert f"the file needs '{51 * 'x'}/long.bin', which is missing: " in refusal(path)


@pytest.mark.parametrize("uri", ["b%20%C3%BC/first.bin", "./b%20ü/first.bin", "b ü\\first.bin"])
def test_bin_files_may_have_escaped_names_and_be_in_subfolders(tmp_path, uri):
    path = write(tmp_path, "stones", STONES)
    (tmp_path / "b ü").mkdir()
    (tmp_path / "gltf_buffer_0.bin").rename(tmp_path / "b ü" / "first.bin")
    refer(path, uri)
    assert shapes(mo.read_mesh(path, **GIVEN)).size == pytest.approx([12, 2, 8], rel=1e-6)


def test_a_case_file_names_a_mesh_with_bin_files(tmp_path):
    (tmp_path / "drawn").mkdir()
    write(tmp_path / "drawn", "stones", STONES)
    case = tmp_path / "case.toml"
    case.write_text(
        "[joints]\nfriction = 0.7\n"
        "[mesh]\nfile = 'drawn/stones.gltf'\nunit_weight = 10\nlive_per_weight = [1, 0, 0]\n"
    )
    assert mo.solve(case, "static").required() == pytest.approx(2 / 5, rel=1e-5)


def test_a_missing_bin_file_is_named_with_its_remedy(tmp_path):
    path = write(tmp_path, "stones", STONES)
    (tmp_path / "gltf_buffer_2.bin").unlink()
    assert refusal(path) == (
        f"{path}: the file needs 'gltf_buffer_2.bin', which is missing: copy it into the folder of the file, "
        "or export one .glb file"
    )


@pytest.mark.parametrize(
    "uri",
    [
        "../secret.bin",
        "..%2Fsecret.bin",
        "..\\secret.bin",
        "{folder}/secret.bin",
        "C:\\secret.bin",
        "file://{folder}/secret.bin",
        "https://example.org/secret.bin",
    ],
)
def test_a_bin_file_outside_the_folder_is_not_read(tmp_path, uri):
    (tmp_path / "drawn").mkdir()
    path = write(tmp_path / "drawn", "stones", STONES)
    (tmp_path / "drawn" / "gltf_buffer_0.bin").rename(tmp_path / "secret.bin")
    refer(path, uri.format(folder=tmp_path))
    message = refusal(path)
    assert "secret.bin', which is not in its folder and was not read: export one .glb file" in message


@pytest.mark.parametrize("uri", ["", ".", "a\0b", "x" * 5000])
def test_a_reference_that_is_no_file_is_missing(tmp_path, uri):
    path = write(tmp_path, "stones", STONES)
    refer(path, uri)
    assert "which is missing: copy it into the folder of the file" in refusal(path)


def test_a_bin_file_that_is_cut_off_is_named(tmp_path):
    path = write(tmp_path, "stones", STONES)
    file = tmp_path / "gltf_buffer_1.bin"
    file.write_bytes(file.read_bytes()[:-7])
    assert "'gltf_buffer_1.bin' is cut off: it has 89 bytes instead of 96: copy it again" in refusal(path)


def test_a_bin_file_of_another_export_is_refused(tmp_path):
    """trimesh gives .bin files the same names in each export, so a second export replaces them."""
    path = write(tmp_path, "stones", STONES)
    write(tmp_path, "others", {"low": box((0, 2), (0, 1), (0, 1.1))})
    assert "'gltf_buffer_1.bin' does not belong to the file" in refusal(path)


def test_bin_files_of_a_folder_belong_to_their_files(tmp_path):
    for name, block in STONES.items():
        path = write(tmp_path, name, {name: block})
        for number in (0, 1):
            (tmp_path / f"gltf_buffer_{number}.bin").rename(tmp_path / f"{name}_{number}.bin")
        path.write_text(path.read_text().replace("gltf_buffer", name))
    scene = mo.read_mesh(tmp_path, **GIVEN)
    assert dict(zip([block.name for block in scene.blocks], shapes(scene).size, strict=True)) == (
        pytest.approx({"fixed": 12, "high": 8, "low": 2}, rel=1e-6)
    )
    (tmp_path / "low_1.bin").unlink()
    (tmp_path / "high_0.bin").unlink()
    lines = refusal(tmp_path).splitlines()
    assert [line[: line.index(",")] for line in lines] == [
        f"{tmp_path}: high.gltf: the file needs 'high_0.bin'",
        f"{tmp_path}: low.gltf: the file needs 'low_1.bin'",
    ]


def test_large_bin_files_are_refused(tmp_path, monkeypatch):
    path = write(tmp_path, "stones", STONES)
    monkeypatch.setattr(mesh_files, "_LARGEST_MESH", path.stat().st_size)
    (tmp_path / "gltf_buffer_3.bin").write_bytes(bytes(path.stat().st_size))
    assert "the file needs more than 0 MB of .bin files: simplify the blocks" in refusal(path)


def test_a_range_of_another_shape_is_named(tmp_path):
    path = write(tmp_path, "stones", STONES)
    tree = json.loads(path.read_text())
    for accessor in tree["accessors"]:
        accessor["min"] = ["a", 0]
    path.write_text(json.dumps(tree))
    why = "'min' and 'max' of an accessor do not have one number for each coordinate"
    assert f"is not valid glTF: {why}; export the blocks again" in refusal(path)


def test_a_range_of_six_digits_is_accepted(tmp_path):
    far = {name: (corners + np.array([123456.7, 0, 0]), faces) for name, (corners, faces) in STONES.items()}
    path = write(tmp_path, "stones", far)
    tree = json.loads(path.read_text())
    for accessor in tree["accessors"]:
        for key in ("min", "max"):
            accessor[key] = [float(f"{value:.6g}") for value in np.ravel(accessor[key])]
    path.write_text(json.dumps(tree))
    assert shapes(mo.read_mesh(path, **GIVEN)).size == pytest.approx([12, 2, 8], rel=0.02)


def test_a_warning_counts_meshes_outside_the_default_scene(tmp_path):
    path = write(tmp_path, "stones", STONES)
    tree = json.loads(path.read_text())
    nodes = {node["name"]: number for number, node in enumerate(tree["nodes"])}
    tree["scenes"] = [{"nodes": [nodes["fixed"], nodes["low"]]}, {"nodes": [nodes["high"]]}]
    path.write_text(json.dumps(tree))
    with pytest.warns(DrawingWarning, match="1 mesh outside the default scene of the file was left out"):
        scene = mo.read_mesh(path, **GIVEN)
    assert [block.name for block in scene.blocks] == ["fixed", "low"]


@pytest.mark.parametrize("mode", [0, 1, 2, 3, 4, 5, 6])
def test_a_warning_counts_no_meshes_of_points_or_lines(tmp_path, mode):
    """Codes 0 to 3 are points and lines, codes 4 to 6 are triangles (glTF 2.0, section 3.7.2.1)."""
    path = write(tmp_path, "stones", STONES)
    tree = json.loads(path.read_text())
    nodes = {node["name"]: number for number, node in enumerate(tree["nodes"])}
    for primitive in tree["meshes"][tree["nodes"][nodes["high"]]["mesh"]]["primitives"]:
        primitive["mode"] = mode
    tree["scenes"] = [{"nodes": [nodes["fixed"], nodes["low"]]}]
    path.write_text(json.dumps(tree))
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        mo.read_mesh(path, **GIVEN)
    counted = [str(warning.message) for warning in caught if "default scene" in str(warning.message)]
    assert len(counted) == (mode >= 4)
    assert all("1 mesh outside the default scene of the file was left out" in text for text in counted)

"""Folders of meshes with one stone in each file, and glTF files."""

import json
import warnings
from pathlib import Path

import numpy as np
import pytest
from meshes import box, damaged_copies, glb, obj, ply, stl
from scenes import run_command
from scipy.spatial.transform import Rotation
from touching_solids import contacts_of

import masonry_opt as mo
from masonry_opt.errors import DrawingWarning
from masonry_opt.scene.space.shapes import shapes

#: A high stone on a low stone on the ground. A horizontal load overturns the high stone, which is 2 wide and
#: 4 high, at λ = (2/2) / (4/2) = 0.5. Both together overturn about an edge of the lower one at λ = 2/5.
GROUND = box((-1, 3), (-1, 2), (-1, 0))
LOW = box((0, 2), (0, 1), (0, 1))
HIGH = box((0, 2), (0, 1), (1, 5))
GIVEN = {"friction": 0.7, "unit_weight": 10.0, "live": (1, 0, 0)}


def triangles(shape):
    corners, faces = shape
    return corners, [three for a, b, c, d in faces for three in ((a, b, c), (a, c, d))]


def turned(shape):
    """Return a shape as glTF stores it, with the y axis upwards."""
    corners, faces = triangles(shape)
    return corners[:, [0, 2, 1]] * [1, 1, -1], faces


@pytest.fixture
def folder(tmp_path):
    path = tmp_path / "stones"
    path.mkdir()
    (path / "ground_fixed.obj").write_bytes(obj({"Cube": GROUND}))
    (path / "stone_10.stl").write_bytes(stl({"Cube": HIGH}))
    (path / "stone_2.ply").write_bytes(ply({"Cube": LOW}))
    (path / "notes.txt").write_text("measured in May")
    (path / "._stone_2.ply").write_bytes(b"not a mesh")
    return path


def test_a_folder_of_meshes_is_a_scene(folder):
    scene = mo.read_mesh(folder, **GIVEN)
    assert [block.name for block in scene.blocks] == ["ground_fixed", "stone_2", "stone_10"]
    assert [block.fixed for block in scene.blocks] == [True, False, False]
    assert shapes(scene).size == pytest.approx([12, 2, 8], rel=1e-6)
    assert mo.solve(scene, "static").required() == pytest.approx(2 / 5, rel=1e-5)


def test_files_of_formats_that_cannot_be_read_are_named(folder):
    for name in ("stone_3.DAE", "stone_11.fbx", "stone_4.blend", "stone_12.3dm"):
        (folder / name).write_bytes(b"a stone")
    with pytest.warns(DrawingWarning) as warned:
        mo.read_mesh(folder, **GIVEN)
    (warning,) = warned
    names = "'stone_3.DAE', 'stone_4.blend', 'stone_11.fbx' and 1 more"
    assert f"4 files of other formats were left out: {names}" in str(warning.message)


def test_a_subfolder_that_cannot_be_read_has_no_meshes(folder, monkeypatch):
    """Hidden files of a subfolder are not meshes either."""
    (folder / "locked").mkdir()
    (folder / "hidden").mkdir()
    (folder / "hidden" / "._stone.ply").write_bytes(b"not a mesh")
    files_of = Path.iterdir

    def iterdir(self):
        if self.name == "locked":
            raise PermissionError(13, "Permission denied")
        return files_of(self)

    monkeypatch.setattr(Path, "iterdir", iterdir)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert len(mo.read_mesh(folder, **GIVEN).blocks) == 3


@pytest.mark.slow
def test_the_command_line_prints_a_warning_about_a_drawing_once(folder, tmp_path, monkeypatch, capsys):
    """The case file is read several times, and the source line of the warning is not printed."""
    (folder / "stone_3.dae").write_bytes(b"a stone")
    case = tmp_path / "case.toml"
    case.write_text(
        "[joints]\nfriction = 0.7\n[mesh]\nfile = 'stones'\nunit_weight = 10\nlive_per_weight = [1, 0, 0]\n"
    )
    options = ["--vary", "joints.friction=0.5:0.7:2", "--method", "static", "--out", tmp_path / "runs"]
    code, _, err = run_command(monkeypatch, capsys, "sweep", case, *options)
    assert code == 0
    assert err.count("1 file of other formats was left out: 'stone_3.dae'") == 1
    assert "mesh_files.py" not in err


def test_a_folder_becomes_a_case_file_or_is_named_by_one(folder, tmp_path, monkeypatch, capsys):
    out = tmp_path / "scene.toml"
    options = ["--friction", "0.7", "--unit-weight", "10", "--live", "1,0,0"]
    code, output, err = run_command(monkeypatch, capsys, "convert", folder, out, *options)
    assert (code, err) == (0, "")
    assert "3 blocks (1 fixed), 0 holes, 2 joints\nsize without supports: " in output
    assert "(unit of length not known)\n" in output
    named = tmp_path / "named.toml"
    named.write_text(
        "[joints]\nfriction = 0.7\n[mesh]\nfile = 'stones'\nunit_weight = 10\nlive_per_weight = [1, 0, 0]\n"
    )
    assert mo.load(named).blocks == mo.load(out).blocks


def test_broken_files_of_a_folder_are_all_named(folder):
    (folder / "a.stl").write_bytes(stl({"Cube": LOW})[:300])
    (folder / "b.obj").write_text("v 0 0 0\nf 1 2 3\n")
    with pytest.raises(mo.CaseError) as refusal:
        mo.read_mesh(folder, **GIVEN)
    lines = str(refusal.value).splitlines()
    assert len(lines) == 2
    assert lines[0].startswith(f"{folder}: a.stl: ")
    assert lines[1].startswith(f"{folder}: b.obj: the file is not valid OBJ")


def test_a_broken_link_in_a_folder_is_named(folder):
    (folder / "stone_3.stl").symlink_to("missing.stl")
    with pytest.raises(mo.CaseError, match=r"stone_3\.stl: no such file"):
        mo.read_mesh(folder, **GIVEN)


def test_a_missing_folder_is_named(tmp_path, monkeypatch, capsys):
    """A missing folder is not called a mesh whose name has a wrong ending."""
    case = tmp_path / "case.toml"
    case.write_text("joints.friction = 0.7\n[mesh]\nfile = 'stones'\nunit_weight = 10\n")
    with pytest.raises(mo.CaseError, match=r"stones: no such file or folder"):
        mo.load(case)
    options = ["--friction", "0.7", "--unit-weight", "10"]
    code, _, err = run_command(
        monkeypatch, capsys, "convert", tmp_path / "stones", tmp_path / "a.toml", *options
    )
    assert code == 2
    assert "stones: no such file or folder" in err


def test_an_open_stone_of_a_folder_is_named_by_its_file(folder):
    (folder / "open.obj").write_bytes(obj({"Cube": (HIGH[0] + 9, HIGH[1][1:])}))
    with pytest.raises(mo.CaseError, match=r"stones: block 'open' is not closed at its edge"):
        mo.read_mesh(folder, **GIVEN)


def test_several_objects_in_one_file_of_a_folder_are_named_by_file_and_object(folder):
    (folder / "stone_10.stl").unlink()
    pair = {"left": (HIGH[0] + [5, 0, -1], HIGH[1]), "right": (HIGH[0] + [7, 0, -1], HIGH[1])}
    (folder / "twins.obj").write_bytes(obj(pair))
    names = [block.name for block in mo.read_mesh(folder, **GIVEN).blocks]
    assert names == ["ground_fixed", "stone_2", "twins left", "twins right"]


def test_a_folder_without_meshes_is_refused(tmp_path):
    with pytest.raises(
        mo.CaseError, match=r"the folder has no meshes: write one file for each block \(\.obj"
    ):
        mo.read_mesh(tmp_path, **GIVEN)


def test_two_files_of_one_name_are_refused(folder):
    (folder / "stone_2.obj").write_bytes(obj({"Cube": (LOW[0] + 9, LOW[1])}))
    with pytest.raises(mo.CaseError, match=r"two blocks are named 'stone_2'"):
        mo.read_mesh(folder, **GIVEN)


def read_glb(tmp_path, data, **more):
    path = tmp_path / "stones.glb"
    path.write_bytes(data)
    return mo.read_mesh(path, **(GIVEN | more))


def test_a_binary_gltf_file_is_a_scene_with_y_upwards(tmp_path):
    """The nodes have translations, a quaternion, a scale and a matrix. A mesh of two materials is one stone.

    The low stone is a unit box that its node scales. The high stone is stored on its side, and its node
    rotates it.
    """
    unit = turned(box((0, 1), (0, 1), (0, 1)))
    lying = turned((HIGH[0] @ Rotation.from_euler("y", 90, degrees=True).as_matrix().T, HIGH[1]))
    # In the file, z of the scene is y, and y of the scene is -z. A rotation about y of the scene is one about
    # -z.
    upright = Rotation.from_euler("z", 90, degrees=True).as_quat().tolist()
    moved = np.eye(4)
    moved[:3, 3] = [-1, -1, 1]
    nodes = [
        {"name": "fixed things", "children": [1]},
        {"name": "ground", "mesh": 0, "matrix": moved.T.ravel().tolist()},
        {"name": "low", "mesh": 1, "scale": [2, 1, 1]},
        {"name": "high", "mesh": 2, "rotation": upright},
    ]
    ground = turned((GROUND[0] - GROUND[0][0], GROUND[1]))
    halves = [(ground[0], ground[1][:5]), (ground[0], ground[1][5:])]
    scene = read_glb(tmp_path, glb(nodes, [halves, [unit], [lying]]))
    assert [(block.name, block.fixed) for block in scene.blocks] == [
        ("ground", True),
        ("low", False),
        ("high", False),
    ]
    assert shapes(scene).size == pytest.approx([12, 2, 8], rel=1e-6)
    assert sorted(contacts_of(scene).extent) == pytest.approx([2, 2], rel=1e-5)
    assert mo.solve(scene, "static").required() == pytest.approx(2 / 5, rel=1e-5)


def test_gltf_files_of_this_package_are_read_again(tmp_path):
    path = tmp_path / "stones.obj"
    path.write_bytes(obj({"fixed": GROUND, "low": LOW, "high": HIGH}))
    scene = mo.read_mesh(path, **GIVEN)
    for end in ("glb", "gltf"):
        out = tmp_path / f"out.{end}"
        mo.export(scene, out)
        again = mo.read_mesh(out, **GIVEN)
        assert [block.name for block in again.blocks] == ["fixed", "low", "high"]
        assert shapes(again).size == pytest.approx([12, 2, 8], rel=1e-6)
        assert mo.read_mesh(out, **GIVEN, up="y").blocks == again.blocks


GOOD = glb([{"name": "stone", "mesh": 0}], [[turned(HIGH)]])


def changed(**keys):
    """Return a text glTF file of a stone, with some keys replaced."""
    size = int.from_bytes(GOOD[12:16], "little")
    return json.dumps(json.loads(GOOD[20 : 20 + size]) | keys).encode()


BROKEN = {
    "cut off": (GOOD[:-100], "is not valid glTF: it is cut off, so corners are missing"),
    "version 1": (GOOD[:4] + b"\1" + GOOD[5:], "has glTF version 1, but only version 2 can be read"),
    "no JSON": (b"solid", "is not valid glTF: "),
    "a list": (b"[]", "is not valid glTF: the JSON part is not an object"),
    "no mesh": (changed(nodes=[{"name": "camera"}]), "has no complete faces"),
    "missing parts": (changed(meshes=[{}]), "is not valid glTF: a part is missing"),
    "another file": (
        changed(buffers=[{"uri": "stone.bin", "byteLength": 400}]),
        r"needs 'stone\.bin', which is missing",
    ),
    "no base64": (
        changed(buffers=[{"uri": "data:;base64,?"}]),
        "is not valid glTF: a buffer is not base64 text",
    ),
    "a node in itself": (changed(nodes=[{"children": [0]}]), "is not valid glTF: a node has two parents"),
    "compressed": (
        changed(
            meshes=[{"primitives": [{"attributes": {}, "extensions": {"KHR_draco_mesh_compression": {}}}]}]
        ),
        r"is compressed \(KHR_draco_mesh_compression\): export without compression",
    ),
}


@pytest.mark.parametrize(("data", "named"), BROKEN.values(), ids=BROKEN)
def test_broken_gltf_files_are_named(tmp_path, data, named):
    with pytest.raises(mo.CaseError, match=rf"stones\.glb: the file {named}"):
        read_glb(tmp_path, data, fixed=["stone"])


def test_any_damage_to_a_gltf_file_ends_in_a_scene_or_a_message(tmp_path):
    data = glb(
        [{"name": "fixed", "mesh": 0}, {"name": "stone", "mesh": 1}], [[turned(GROUND)], [turned(LOW)]]
    )
    messages = []
    for damaged in damaged_copies(data):
        try:
            shapes(read_glb(tmp_path, damaged))
        except mo.CaseError as error:
            messages.append(str(error))
    assert len(messages) > 20
    assert all("stones.glb: " in message for message in messages)


def test_a_subfolder_with_meshes_is_named(folder):
    (folder / "upper").mkdir()
    (folder / "pictures").mkdir()
    (folder / "upper" / "stone_3.obj").write_bytes(obj({"Cube": box((0, 2), (0, 1), (5, 6))}))
    with pytest.warns(DrawingWarning, match="1 subfolder with meshes was left out: 'upper'; move") as warned:
        assert len(mo.read_mesh(folder, **GIVEN).blocks) == 3
    assert len(warned) == 1
    for file in folder.glob("*.*"):
        file.unlink()
    with pytest.raises(mo.CaseError, match=r"the folder has no meshes: .*; its subfolder 'upper' has meshes"):
        mo.read_mesh(folder, **GIVEN)

"""OBJ, PLY and STL files are read as scenes in space, and the command `convert` writes case files."""

import codecs
import random
import re
import shlex
from itertools import pairwise

import ezdxf
import numpy as np
import pytest
from meshes import QUADS, box, divided_box, obj, ply, prism, stl
from scenes import WALLS, run_command
from scipy.spatial.transform import Rotation
from touching_solids import contacts_of

import masonry_opt as mo
from masonry_opt.scene.drawings import holes as mesh_checks
from masonry_opt.scene.space.shapes import shapes

#: A high stone on a low stone on the ground, with corners that coincide.
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
    # Both stones overturn together: their width of 2 over their height of 5.
    assert mo.solve(scene, "static").required() == pytest.approx(2 / 5, rel=1e-5)


@pytest.mark.parametrize(("write", "name"), [(obj, "a.obj"), (ply, "a.ply")])
def test_a_byte_order_mark_of_utf_8_is_ignored(file, write, name):
    data = write(STONES)
    if write is obj:
        data = data[data.index(b"v ") :]  # the first line is then a corner
    plain, marked = (read(file(start + data, name), fixed_below=-0.5) for start in (b"", codecs.BOM_UTF8))
    assert [block.vertices for block in marked.blocks] == [block.vertices for block in plain.blocks]


def test_objects_and_groups_name_blocks_set_apart_by_blanks_or_tabs(file):
    data = obj(STONES)
    assert [block.name for block in read(file(data)).blocks] == list(STONES)
    assert [block.name for block in read(file(obj(STONES, word="g"))).blocks] == list(STONES)
    assert read(file(data.replace(b" ", b"\t"))).blocks == read(file(data)).blocks
    nameless = b"\n".join(line for line in data.splitlines() if not line.startswith(b"o "))
    numbered = [f"stones-{number}" for number in range(3)]
    assert [block.name for block in read(file(nameless), fixed=numbered[:1]).blocks] == numbered


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
    with pytest.raises(mo.CaseError, match="no block is named 'd'"):
        read(file(obj(blocks)), fixed=["d"])
    with pytest.raises(mo.CaseError, match="a mesh: key 'live': needs three numbers"):
        read(file(obj(blocks)), live=(1, 0))


def test_axes_and_units(file):
    """A mesh in millimetres with the y axis upwards becomes the same scene."""
    turned = {name: (1000 * at[:, [0, 2, 1]] * [1, 1, -1], faces) for name, (at, faces) in STONES.items()}
    one, other = read(file(obj(STONES), "z.obj")), read(file(obj(turned), "y.obj"), up="y", scale=0.001)
    assert shapes(other).size == pytest.approx(shapes(one).size)
    for blocks in zip(other.blocks, one.blocks, strict=True):
        found, expected = (np.array(sorted(block.corners().round(9).tolist())) for block in blocks)
        assert found == pytest.approx(expected)


U = [(0, 0), (1, 0), (1, 2), (3, 2), (3, 0), (4, 0), (4, 3), (0, 3)]


@pytest.mark.parametrize("flip", [False, True])
def test_notched_blocks_become_convex_parts(file, flip):
    """A portal has two feet and ends with eight corners. Its faces may be wound inconsistently."""
    corners, faces = prism(U, 0.5)
    faces = [face[::-1] if flip and number % 3 else face for number, face in enumerate(faces)]
    scene = read(file(obj({"fixed": box((-1, 5), (-1, 2), (-1, 0)), "portal": (corners, faces)})))
    portal = scene.blocks[1]
    assert 2 <= len(portal.parts) <= 4
    found = shapes(scene)
    assert found.size[1] == pytest.approx(8 * 0.5)
    assert contacts_of(scene).extent == pytest.approx([0.5, 0.5])


def test_a_block_with_a_hole_through_it_and_one_in_the_hole(file):
    """A frame of triangles has a hole, which another stone fills."""
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


@pytest.mark.parametrize("digits", [3, 4, 5])
def test_coordinates_of_few_digits_still_touch(file, digits):
    """A wall in running bond is rotated, and the corners of each stone are rounded separately."""
    wall = {"fixed": box((0, 4), (0, 1), (-0.5, 0))}
    for course in range(3):
        ends = [0, 2, 4] if course % 2 else [0, 1, 3, 4]
        for start, end in pairwise(ends):
            wall[f"{course} {start}"] = box((start, end), (0, 1), (course / 2, course / 2 + 0.5))
    turn = Rotation.from_euler("zx", [0.3, 0.3])
    wall = {name: (turn.apply(corners), faces) for name, (corners, faces) in wall.items()}
    scene = read(file(obj(wall, digits)))
    assert scene.tolerance == pytest.approx(2 * 10.0**-digits)
    found = contacts_of(scene)
    # The beds have an area of 4 each, and the head joints 0.5: there are 2, 1 and 2 of them.
    assert sum(found.extent) == pytest.approx(3 * 4 + 5 * 0.5, abs=40 * 10.0**-digits)
    assert len(found.extent) == 3 + 4 + 4 + 5


def test_faces_that_are_not_flat_are_shared_by_triangles(file):
    """Two blocks meet at a warped face, which each block starts at another corner. There is neither a gap nor
    an overlap."""
    low, _ = box((0, 1), (0, 1), (0, 1))
    high, _ = box((0, 1), (0, 1), (1, 2))
    low[6, 2] = high[2, 2] = 1.2
    faces = [(5, 6, 7, 4) if face == QUADS[1] else face for face in QUADS]
    stones = {"fixed": box((0, 1), (0, 1), (-1, 0)), "low": (low, faces), "high": (high, QUADS)}
    scene = read(file(obj(stones)))
    found = contacts_of(scene)
    shared = found.extent[(found.first == 1) & (found.second == 2)]
    assert len(shared) == 2
    assert shapes(scene).size.sum() == pytest.approx(3)


GROUND, (PORTAL, SIDES) = box((-1, 5), (-1, 2), (-1, 0)), prism(U, 0.5)
OPEN = (STONES["low"][0], QUADS[1:])
GRAIN = box((9, 9 + 1e-9), (0, 1e-9), (0, 1e-9))
HIGH = box((0, 2), (0, 1), (1, 3))[0]
BESIDE = box((1, 3), (0, 1), (2, 4))[0]
CROSSED = np.concatenate([HIGH, BESIDE]), [*QUADS, *(tuple(8 + corner for corner in face) for face in QUADS)]
WRONG = {
    "an open block": (obj(STONES | {"low": OPEN}), "block 'low' is not closed at its edge"),
    "a face alone": (obj(STONES | {"low": (STONES["low"][0], QUADS[:1])}), "block 'low' is a single face"),
    "two of one name": (obj(STONES) + b"\n" + obj({"low": STONES["low"]}), "two blocks are named 'low'"),
    "a corner that is not there": (obj(STONES) + b"\nf 1 2 99", "not valid OBJ"),
    "no number": (obj(STONES) + b"\nv 1 x 2", "not valid OBJ in line "),
    "decimal commas": (
        obj(STONES).replace(b".", b","),
        r"not valid OBJ in line 3 \('v .*'\): write numbers with a decimal point",
    ),
    "UTF-16": (obj(STONES).decode().encode("utf-16"), "encoding UTF-16: save it in the encoding UTF-8"),
    "infinite": (obj(STONES).replace(b"5.000000000", b"1e999"), "block 'high' has a coordinate"),
    "empty": (b"", "has no complete faces"),
    "a grain": (obj(STONES | {"dust": GRAIN}, 12), "block 'dust' is smaller"),
    "a face inside": (
        obj(STONES | {"high": (HIGH, [*QUADS, (0, 1, 6)])}),
        "block 'high' is not closed at its edge",
    ),
    "two boxes in one another": (obj(STONES | {"high": CROSSED}), "block 'high' has faces that cross"),
}
for number in range(10):
    left = obj({"fixed": GROUND, "portal": (PORTAL, SIDES[:number] + SIDES[number + 1 :])})
    WRONG[f"notched, without face {number}"] = left, r"block 'portal' is not closed at its edge from \("


@pytest.mark.parametrize(("data", "named"), WRONG.values(), ids=WRONG)
def test_what_is_wrong_is_named(file, data, named):
    with pytest.raises(mo.CaseError, match=rf"stones\.obj: .*{named}"):
        contacts_of(read(file(data)))


DIVIDED = divided_box((0, 2), (0, 1), (1, 5), 2)


def without(shape, number):
    """Return a shape without one of its faces."""
    corners, faces = shape
    return corners, faces[:number] + faces[number + 1 :]


@pytest.mark.parametrize("number", [*range(8), *range(8, 48, 8)])
def test_a_missing_triangle_is_refused_with_its_place(file, number):
    """The missing triangle is one of the eight of the first side of a box, or the first of another side."""
    with pytest.raises(mo.CaseError) as refused:
        read(file(obj(STONES | {"high": without(DIVIDED, number)})))
    message = str(refused.value)
    assert re.search(r"stones\.obj: block 'high' is not closed at its edge .*: add the missing", message)
    named = [tuple(map(float, ends.split(","))) for ends in re.findall(r"\(([^()]*)\)", message)]
    missing = DIVIDED[0][list(DIVIDED[1][number])]
    assert len(named) == 2
    assert all(np.abs(missing - end).max(axis=1).min() < 1e-9 for end in named)


@pytest.mark.parametrize(("write", "name"), [(obj, "a.obj"), (stl, "a.stl")])
def test_a_missing_triangle_is_refused_in_each_form_of_mesh(file, tmp_path, write, name):
    path = file(write({"fixed": box((-1, 3), (-1, 2), (0, 1)), "high": without(DIVIDED, 5)}), name)
    with pytest.raises(mo.CaseError, match=r"is not closed at its edge"):
        read(path, fixed_below=0.5)
    case = tmp_path / "case.toml"
    mesh = f'[mesh]\nfile = "{name}"\nunit_weight = 10\nfixed_below = 0.5\n'
    case.write_text(f"[joints]\nfriction = 0.7\n{mesh}")
    with pytest.raises(mo.CaseError, match=r"case\.toml: .*is not closed at its edge"):
        mo.load(case)


def test_a_missing_quadrilateral_is_refused_in_ply(file):
    """In PLY files, each face has separate corners. Corners at one place are merged."""
    path = file(ply(STONES | {"high": without(STONES["high"], 2)}), "a.ply")
    with pytest.raises(mo.CaseError, match=r"a\.ply: block .* is not closed at its edge"):
        read(path, fixed_below=-0.5)


#: Closed blocks that a simple test of edges would call open, each with its volume. The tolerance is 1e-5.
CORNERS, TRIANGLES = divided_box((0, 2), (0, 1), (1, 5), 1)
NEAR_TWIN = np.vstack([CORNERS, CORNERS[0] + 4e-6]), [
    *(tuple(8 if corner == 0 else corner for corner in face) for face in TRIANGLES[:1]), *TRIANGLES[1:]
]  # fmt: skip
MIDDLE = len(PORTAL)
ON_AN_EDGE = np.vstack([PORTAL, PORTAL[:2].mean(axis=0)]), [(0, MIDDLE, *SIDES[0][1:]), *SIDES[1:]]
BENT = DIVIDED[0] + 3e-6 * np.sin(37.0 * DIVIDED[0]), DIVIDED[1]
CLOSED = {
    "corners that nearly coincide": (NEAR_TWIN, 8.0),
    "a corner on the edge of another face": (ON_AN_EDGE, 8 * 0.5),
    "sides that are nearly flat": (BENT, 8.0),
}


@pytest.mark.parametrize(("shape", "volume"), CLOSED.values(), ids=CLOSED)
def test_closed_blocks_are_read_whatever_their_corners(file, shape, volume):
    """The volumes are known by hand: 2 × 1 × 4 for the box, and area times depth for the portal."""
    scene = read(file(obj({"fixed": GROUND, "high": shape})), tolerance=1e-5)
    assert shapes(scene).size[-1] == pytest.approx(volume, rel=1e-4)


@pytest.mark.slow
def test_any_damage_ends_with_a_scene_or_a_message(file):
    rng = random.Random(3)
    stones = STONES | {"portal": prism(U, 0.5)}
    written = {"obj": obj(stones, 3), "ply": ply(STONES), "stl": stl(stones)}
    messages = []
    for _ in range(60):
        kind = rng.choice(list(written))
        data = bytearray(written[kind])
        for _ in range(rng.randint(1, 6)):
            data[rng.randrange(len(data))] = rng.randrange(256)
        try:
            contacts_of(read(file(bytes(data), f"broken.{kind}"), fixed_below=-0.5))
        except mo.CaseError as error:
            messages.append(str(error))
    assert len(messages) > 30
    assert all(re.search(r"broken\.(obj|ply|stl): ", message) for message in messages)


NEEDED = ["--friction", "0.65", "--unit-weight", str(1 / 7)]


@pytest.fixture
def wall(tmp_path, monkeypatch, capsys):
    path = tmp_path / "wall.dxf"
    code, out, err = run_command(monkeypatch, capsys, "convert", WALLS[0], path)
    assert (code, err) == (0, "")
    assert "34 blocks (1 fixed)" in out
    return path


def test_a_drawing_becomes_a_case_file(wall, tmp_path, monkeypatch, capsys):
    for out in (tmp_path / "wall.toml", tmp_path / "wall_out.json"):
        code, output, err = run_command(monkeypatch, capsys, "convert", wall, out, *NEEDED, "--live", "1,0")
        assert (code, err) == (0, "")
        assert "83 joints" in output
        assert mo.solve(out, "static").required() == pytest.approx(0.64286, abs=5e-6)


def test_options_of_dxf(tmp_path, monkeypatch, capsys):
    """One stone of 4 m × 1 m is drawn in millimetres, and all other layers are omitted."""
    document = ezdxf.new()
    document.header["$INSUNITS"] = 4
    space = document.modelspace()
    stone = [(0, 0), (4000, 0), (4000, 1000), (0, 1000)]
    ground = [(-1000, -1000), (9000, -1000), (9000, 0), (-1000, 0)]
    for layer, ring in (("top", stone), ("rock", ground)):
        space.add_lwpolyline(ring, close=True, dxfattribs={"layer": layer})
    space.add_line((0, 0), (1, 1), dxfattribs={"layer": "axes"})
    document.saveas(tmp_path / "stone.dxf")
    options = shlex.split(
        "--friction 0.5 --unit-weight 20 --live-layer top=-0.5,0 --layer top --layer rock --fixed-layer rock "
        "--to-metres --tolerance 1e-5 --outline-tolerance 2e-5 --sagitta 0.01"
    )
    out = tmp_path / "stone.toml"
    code, _, err = run_command(monkeypatch, capsys, "convert", tmp_path / "stone.dxf", out, *options)
    assert (code, err) == (0, "")
    scene = mo.load(out)
    assert scene.tolerance == 1e-5
    assert scene.blocks[0].live_per_weight == (-0.5, 0.0)
    assert mo.solve(scene, "static").required() == pytest.approx(1.0, rel=1e-6)


@pytest.mark.parametrize(
    ("options", "named"),
    [
        ([], "--friction"),
        (["--friction", "0.5"], "--unit-weight"),
        ([*NEEDED, "--live", "1;0"], "--live"),
        ([*NEEDED, "--live-layer", "blocks"], "--live-layer"),
        ([*NEEDED, "--along", "x"], "--along"),
        ([*NEEDED, "--fixed", "1-1"], "--fixed"),
        ([*NEEDED, "--layer", "gone"], "(--layer): layer 'gone' is empty or does not exist"),
        ([*NEEDED, "--live-layer", "gone=1,0"], "(--live-layer): no movable block is on layer 'gone'"),
        ([*NEEDED, "--fixed-layer", "rock"], "(--fixed-layer)"),
        ([*NEEDED, "--friction", "-1"], "'friction'"),
    ],
)
def test_wrong_options_are_named_and_nothing_is_written(wall, tmp_path, monkeypatch, capsys, options, named):
    out = tmp_path / "wall.toml"
    code, output, err = run_command(monkeypatch, capsys, "convert", wall, out, *options)
    assert (code, output) == (2, "")
    assert err.startswith("error: ")
    assert named in err
    assert not out.exists()


@pytest.mark.parametrize("name", ["case.toml", "case.json"])
@pytest.mark.parametrize("options", [[], NEEDED])
def test_what_can_be_done_with_a_case_file_is_told(tmp_path, monkeypatch, capsys, name, options):
    case, out = tmp_path / name, tmp_path / "out.json"
    mo.save(mo.load(WALLS[0]), case)
    code, output, err = run_command(monkeypatch, capsys, "convert", case, out, *options)
    assert (code, output) == (2, "")
    assert f"masonry-opt solve {case}" in err
    assert ".dxf" in err
    assert not out.exists()


def test_a_drawing_with_a_thickness_becomes_solids(wall, tmp_path, monkeypatch, capsys):
    """The drawing is the wall of Table 1. The weights of the solids are unit weight times thickness, and live
    loads may act out of the plane of the wall."""
    out = tmp_path / "wall.toml"
    options = ["--friction", "0.65", "--unit-weight", "1", "--thickness", "0.5"]
    code, output, err = run_command(monkeypatch, capsys, "convert", wall, out, *options, "--live", "1,0")
    assert (code, err) == (0, "")
    assert "83 joints" in output
    solid = mo.load(out)
    assert solid.blocks[0].live_per_weight in ((1, 0, 0), (0, 0, 0))
    weight = sum(block.weight for block in solid.blocks if not block.fixed)
    assert weight == pytest.approx(0.5 * 6 * 5 * 4 * 1.75)  # six courses, each as long as five blocks
    run_command(monkeypatch, capsys, "convert", wall, out, *options, "--live", "0,1,0")
    assert mo.load(out).blocks[-1].live_per_weight in ((0, 1, 0), (0, 0, 0))


MESH = obj({"fixed": box((-1, 3), (-1, 2), (-1, 0)), "stone": box((0, 2), (0, 1), (0, 4))})


@pytest.mark.parametrize("beside", [False, True])
def test_a_mesh_becomes_a_case_file_that_holds_or_names_it(tmp_path, monkeypatch, capsys, beside):
    if beside:
        monkeypatch.setattr("masonry_opt.cli.files._MOST_CORNERS", 10)
    drawn, out = tmp_path / "stones" / "stone.obj", tmp_path / "stone.toml"
    drawn.parent.mkdir()
    drawn.write_bytes(MESH)
    options = shlex.split("--friction 0.9 --unit-weight 20 --live 1,0,0 --scale 0.5")
    code, output, err = run_command(monkeypatch, capsys, "convert", drawn, out, *options)
    assert (code, err) == (0, "")
    assert "1 joint" in output
    assert ('file = "stones/stone.obj"' in out.read_text()) == beside
    read = mo.read_mesh(drawn, friction=0.9, unit_weight=20, live=(1, 0, 0), scale=0.5)
    assert mo.load(out).blocks == read.blocks
    assert mo.solve(out, "static").required() == pytest.approx(2 / 4, rel=1e-6)
    drawn.unlink()
    if beside:
        with pytest.raises(mo.CaseError, match=r"stone\.obj: no such file"):
            mo.load(out)


def box_in_strips(strips: int) -> mesh_checks.Mesh:
    """Return a unit box whose top and bottom are strips of quadrilaterals, with every other strip shifted by
    half of one.

    Corners of one strip are on edges of the next strip, so each of these edges belongs to one face only.
    """
    points: list[tuple[float, float, float]] = []
    faces: list[list[int]] = []

    def add(*corners: tuple[float, float, float]) -> None:
        faces.append([*range(len(points), len(points) + len(corners))])
        points.extend(corners)

    for number in range(strips):
        y, z = number / strips, (number + 1) / strips
        shifted = [0.0, *((step + 0.5) / strips for step in range(strips)), 1.0]
        cuts = shifted if number % 2 else [step / strips for step in range(strips + 1)]
        for a, b in pairwise(cuts):
            add((a, y, 1), (b, y, 1), (b, z, 1), (a, z, 1))
            add((a, y, 0), (a, z, 0), (b, z, 0), (b, y, 0))
        add((0, y, 0), (0, y, 1), (0, z, 1), (0, z, 0))
        add((1, y, 0), (1, z, 0), (1, z, 1), (1, y, 1))
    add((0, 0, 0), (1, 0, 0), (1, 0, 1), (0, 0, 1))
    add((0, 1, 0), (0, 1, 1), (1, 1, 1), (1, 1, 0))
    return mesh_checks.Mesh("box", np.array(points, dtype=float), faces)


def test_edges_on_edges_are_no_holes_and_a_missing_face_among_them_is():
    mesh = box_in_strips(8)
    mesh_checks.refuse_holes(mesh, 1e-6)
    for missing in (0, 40, len(mesh.faces) - 1):
        open_box = mesh_checks.Mesh("box", mesh.points, mesh.faces[:missing] + mesh.faces[missing + 1 :])
        with pytest.raises(ValueError, match="is not closed at its edge"):
            mesh_checks.refuse_holes(open_box, 1e-6)


def test_edges_are_compared_with_few_others(monkeypatch):
    """Each open edge is compared with a few others, however many there are: 0.8 s instead of 27 s for all
    pairs."""
    compared: dict[int, list[int]] = {}
    covered = mesh_checks._is_covered

    def counted(edge, others, tolerance):
        compared[strips].append(len(others))
        return covered(edge, others, tolerance)

    monkeypatch.setattr(mesh_checks, "_is_covered", counted)
    for strips in (5, 10):
        compared[strips] = []
        mesh_checks.refuse_holes(box_in_strips(strips), 1e-6)
    assert len(compared[10]) > 3 * len(compared[5])
    assert np.mean(compared[10]) < 1.5 * np.mean(compared[5])

"""Meshes with rounding errors of other programs, whose corners are off their planes by more than the
tolerance."""

import re
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from brickwork import voussoirs
from meshes import divided_box, obj, prism
from scipy.spatial import ConvexHull
from scipy.spatial.transform import Rotation
from speeds import slow
from touching_solids import contacts_of

import masonry_opt as mo
from masonry_opt.scene.space.shapes import shapes
from masonry_opt.solution.wedges import uneven_sides

#: Two stones of the EPFL data set Rigid-Block-3D, which come from scans of a wall (MIT licence).
SCANNED = Path(__file__).parent / "stones" / "scanned_stone.obj"

#: Corners and faces of two exported frusta with six sides. All faces are closed and consistently wound, and
#: corners are off their planes by up to 6e-6 of the size. Corners are numbered from 1.
FRUSTUM = """
1.00000271 0.00000416 0  0.49999861 0.86601598 0  -0.50000740 0.86602651 0  -1.00000359 0.00000173 0
-0.50000851 -0.86602298 0  0.50000429 -0.86601911 0  1.19999416 0.00000116 0.59999300
0.59998966 1.03923179 0.60000450  -0.60000235 1.03922215 0.59999857  -1.20000079 0.00000438 0.59999653
-0.59998883 -1.03922219 0.59999964  0.59999462 -1.03922477 0.60000310
"""
SIDES = "1 2 8 7, 2 3 9 8, 3 4 10 9, 4 5 11 10, 5 6 12 11, 6 1 7 12"
ENDS = [
    "1 3 2, 1 5 3, 1 6 5, 3 5 4, 7 8 9, 7 9 11, 7 11 12, 9 10 11",
    "1 3 2, 1 4 3, 1 5 4, 1 6 5, 7 8 9, 7 9 10, 7 10 11, 7 11 12",
]


def ring(count, radius):
    angles = 2 * np.pi * np.arange(count) / count
    return radius * np.column_stack([np.cos(angles), np.sin(angles)])


def frustum(low, high, height):
    """Return a solid between two polygons of equally many corners, with its faces counter-clockwise from
    outside."""
    count = len(low)
    corners = np.vstack([np.insert(low, 2, 0.0, axis=1), np.insert(high, 2, height, axis=1)])
    around = [[i, (i + 1) % count, (i + 1) % count + count, i + count] for i in range(count)]
    return corners, [[*range(count)][::-1], [*range(count, 2 * count)], *around]


SQUARE = np.array([(0, 0), (2, 0), (2, 1), (0, 1)], dtype=float)
L = [(0, 0), (2, 0), (2, 1), (1, 1), (1, 2), (0, 2)]
U = [(0, 0), (1, 0), (1, 2), (3, 2), (3, 0), (4, 0), (4, 3), (0, 3)]
ARC = np.linspace(0.9, 1.3, 7)
VOUSSOIR = [(r * np.cos(a), r * np.sin(a)) for r, angles in ((3, ARC), (2.3, ARC[::-1])) for a in angles]
STONES = {
    "frustum on six sides": frustum(ring(6, 1.0), ring(6, 1.2), 0.6),
    "frustum on eight sides": frustum(ring(8, 1.0), ring(8, 0.8), 0.7),
    "box": frustum(SQUARE, SQUARE, 0.5),
    "slab": frustum(SQUARE, SQUARE, 0.1),
    "prism on three sides": frustum(ring(3, 1.0), ring(3, 1.0), 1.0),
    "wedge": frustum(SQUARE, 0.9 * SQUARE, 0.5),
    "box in triangles": divided_box((0, 2), (0, 1), (0, 1.5), 3),
    "box in small triangles": divided_box((0, 2), (0, 1), (0, 1.5), 6),
    "L": prism(L, 1.0),
    "U": prism(U, 1.0),
    "voussoir": prism(VOUSSOIR, 1.0),
}
CONVEX = [name for name in STONES if name not in ("L", "U", "voussoir")]


def volume(corners, faces):
    """Return the volume by the divergence theorem, from tetrahedra between the origin and fans of
    triangles."""
    fans = [(face[0], *edge) for face in faces for edge in pairwise(face[1:])]
    return abs(np.linalg.det(corners[fans]).sum() / 6)


def noisy(seed, names=tuple(STONES)):
    """Return a stone with noise on all corners: its corners and faces, its exact volume, and the noise (a
    length).

    The noise is 3e-7 to 1e-3 of the diagonal. Some stones are rotated, moved or scaled. Their faces are
    polygons, or triangles by either diagonal.
    """
    rng = np.random.default_rng(seed)
    name = names[seed % len(names)]
    corners, faces = STONES[name]
    exact = volume(corners, faces)
    if rng.integers(2):
        faces = [list(np.roll(face, rng.integers(len(face)))) for face in faces]
        faces = [
            (face[0], *edge)
            for face in faces
            if name in CONVEX or len(face) < 5
            for edge in pairwise(face[1:])
        ] + [face for face in faces if name not in CONVEX and len(face) > 4]
    size = np.linalg.norm(np.ptp(corners, axis=0))
    noise = size * 10 ** rng.uniform(np.log10(3e-7), -3)
    corners = corners + noise * rng.uniform(-1, 1, corners.shape) / np.sqrt(3)
    if rng.integers(2):
        corners = Rotation.random(random_state=seed).apply(corners) + size * rng.uniform(-2, 2, 3)
    scale = 10 ** rng.uniform(-2, 3)
    return scale * corners, faces, scale**3 * exact, scale * noise


def refused(seeds, tmp_path, names=tuple(STONES)):
    """Return the seeds of the stones that are refused, or whose weight is wrong by more than the noise on the
    surface.

    Each file is read as a scene, and its solids are checked as in a solution.
    """
    wrong = {}
    for seed in seeds:
        corners, faces, exact, noise = noisy(seed, names)
        low, size = corners.min(axis=0), np.ptp(corners, axis=0).max()
        below = frustum(SQUARE * size, SQUARE * size, size / 2)
        ground = below[0] + low - [0, 0, size], below[1]
        path = tmp_path / "stone.obj"
        path.write_bytes(obj({"stone": (corners, faces), "fixed": ground}, digits=12))
        surface = ConvexHull(corners).area
        try:
            found = shapes(mo.read_mesh(path, friction=0.7, unit_weight=1.0)).size[0]
        except mo.CaseError as error:
            wrong[seed] = str(error)
            continue
        if abs(found - exact) > 1.5 * noise * surface:
            wrong[seed] = f"weighs {found / exact} of its weight"
    return wrong


@pytest.mark.slow
def test_noisy_stones_are_read_and_weigh_what_they_weigh(tmp_path):
    """Two stones of each simple shape have the weight without noise, by the divergence theorem."""
    simple = [name for name in STONES if "triangles" not in name]
    assert refused(range(2 * len(simple)), tmp_path, simple) == {}


@pytest.mark.slow
def test_of_22_noisy_stones_none_is_refused(tmp_path):
    """No stone with noise is refused. A run with all 600 seeds from 1000 on refused none; this test has the
    first 22 of them, two of each shape."""
    assert refused(range(1000, 1000 + 2 * len(STONES)), tmp_path) == {}


@pytest.mark.slow
@pytest.mark.parametrize("ends", ENDS)
def test_a_frustum_as_exported_slides(tmp_path, ends):
    """A stone on level ground under a horizontal load slides at λ = μ."""
    corners = np.array(FRUSTUM.split(), dtype=float).reshape(-1, 3)
    faces = [[int(number) - 1 for number in face.split()] for face in f"{SIDES}, {ends}".split(",")]
    ground = frustum(3 * (2 * SQUARE - [2, 1]), 3 * (2 * SQUARE - [2, 1]), 1.0)
    path = tmp_path / "stone.obj"
    path.write_bytes(obj({"stone": (corners, faces), "floor fixed": (ground[0] - [0, 0, 1], ground[1])}, 8))
    scene = mo.read_mesh(path, friction=0.7, unit_weight=20, live=(1, 0, 0))
    # By hand, the volume of a frustum: h/3 · (A + B + √(AB)), with areas of hexagons of radius 1 and 1.2.
    area = 1.5 * np.sqrt(3)
    assert shapes(scene).size[0] == pytest.approx(0.2 * area * (1 + 1.44 + 1.2), rel=2e-5)
    assert scene.blocks[0].parts is None
    assert mo.solve(scene).required() == pytest.approx(0.7, rel=1e-6)


@pytest.mark.parametrize(("noise", "turned"), [*slow((0.5, False), (1.0, True)), (2.0, True), (3.5, False)])
@pytest.mark.parametrize(("name", "sides", "parts"), [("box in triangles", 6, 1), ("L", 6, 2), ("U", 6, 3)])
def test_noise_of_a_few_tolerances_is_flattened(tmp_path, noise, turned, name, sides, parts):
    """Whatever the noise on its corners, a box keeps its six faces, an L becomes two boxes, and a U three."""
    corners, faces = STONES[name]
    tolerance = 1e-4
    rng = np.random.default_rng(int(10 * noise))
    moved = corners + noise * tolerance * rng.uniform(-1, 1, corners.shape) / np.sqrt(3)
    ground = frustum(9 * (SQUARE - [1, 0.5]), 9 * (SQUARE - [1, 0.5]), 1.0)
    turn = Rotation.from_euler("zyx", [0.4, 0.9, 0.2]) if turned else Rotation.identity()
    stones = {"stone": (turn.apply(moved), faces), "fixed": (ground[0] - [0, 0, 9], ground[1])}
    path = tmp_path / "stone.obj"
    path.write_bytes(obj(stones))
    (stone, _) = mo.read_mesh(path, friction=0.7, unit_weight=1.0, tolerance=tolerance).blocks
    assert len(stone.polyhedra) == parts
    assert all(len(part.faces) == sides for part in stone.polyhedra)


def test_flattened_stones_touch_their_neighbours(tmp_path):
    """Two boxes share noisy corners, and both flatten the shared face to one plane."""
    tolerance = 1e-4
    low, faces = STONES["box"]
    high = low + np.array([0, 0, 0.5])
    noise = 2 * tolerance * np.random.default_rng(0).uniform(-1, 1, (3, 4, 3))
    low, high = low + np.vstack(noise[:2]), high + np.vstack(noise[1:])
    path = tmp_path / "stones.obj"
    path.write_bytes(obj({"fixed": (low, faces), "stone": (high, faces)}))
    found = contacts_of(mo.read_mesh(path, friction=0.7, unit_weight=1.0, tolerance=tolerance))
    assert found.extent == pytest.approx([2.0], rel=1e-3)


@pytest.mark.slow
@pytest.mark.parametrize("tolerance", [None, 1.27e-6, 1e-5])
def test_scanned_stones_are_read(tolerance):
    """The stones are prisms along z of the file, 0.26 m thick, and their faces are wound inconsistently.

    Reference: the thickness times half the area of the faces seen along z.
    """
    points, expected = [], []
    for line in SCANNED.read_text().splitlines():
        word, *rest = line.split()
        if word == "o":
            expected.append(0.0)
        elif word == "v":
            points.append([float(value) for value in rest[:2]])
        elif word == "f":
            flat = np.array([points[int(entry.split("/")[0]) - 1] for entry in rest])
            after = np.roll(flat, -1, axis=0)
            expected[-1] += 0.26 * abs(flat[:, 0] @ after[:, 1] - flat[:, 1] @ after[:, 0]) / 4
    given = {} if tolerance is None else {"tolerance": tolerance}
    scene = mo.read_mesh(
        SCANNED, friction=0.7, unit_weight=20.0, up="x", fixed=["stone_1"], contact_tolerance=0.02, **given
    )
    assert shapes(scene).size == pytest.approx(expected, rel=1e-3)
    assert len(contacts_of(scene).extent) > 0


def test_a_tolerance_that_is_already_sufficient_is_not_advised():
    """The default tolerance is larger than the tolerance that would align the sides of the gaps."""
    scene = mo.read_mesh(SCANNED, friction=0.7, unit_weight=20.0, up="x", fixed=["stone_1"])
    with pytest.raises(mo.CaseError, match="set 'contact_tolerance' to") as refusal:
        contacts_of(scene)
    assert "survey" not in str(refusal.value)


def test_surfaces_that_cross_are_refused_with_a_place_in_both(tmp_path):
    """Two boxes are in one object. The place that the error names is in both of them, at 1 < x < 2 and 2 < z
    < 3."""
    box = frustum(SQUARE, SQUARE, 2.0)
    corners = np.vstack([box[0] + [0, 0, 1], box[0] + [1, 0, 2]])
    faces = [*box[1], *([8 + corner for corner in face] for face in box[1])]
    ground = frustum(3 * SQUARE, 3 * SQUARE, 1.0)
    path = tmp_path / "stones.obj"
    path.write_bytes(obj({"fixed": ground, "stone": (corners, faces)}))
    with pytest.raises(mo.CaseError, match="block 'stone' has faces that cross") as refusal:
        mo.read_mesh(path, friction=0.7, unit_weight=1.0)
    place = re.search(r"near \((.*?)\)", str(refusal.value))[1]
    x, y, z = map(float, place.split(","))
    assert 1 < x < 2
    assert 0 < y < 1
    assert 2 < z < 3


def test_all_broken_blocks_of_a_file_are_named_at_once(tmp_path):
    box = STONES["box"]
    path = tmp_path / "stones.obj"
    lid = box[0], box[1][1:]
    path.write_bytes(obj({"fixed": box, "one": lid, "two": (box[0] + 5, box[1]), "three": lid}))
    with pytest.raises(mo.CaseError) as refusal:
        mo.read_mesh(path, friction=0.7, unit_weight=1.0)
    lines = str(refusal.value).splitlines()
    assert [re.match(rf"{re.escape(str(path))}: block '(\w+)' is not closed", line)[1] for line in lines] == [
        "one",
        "three",
    ]


def test_a_tolerance_above_the_smallest_stone_names_the_stone(tmp_path):
    """The message also advises a smaller tolerance, with which the file can be read."""
    box = STONES["box"]
    path = tmp_path / "stones.obj"
    path.write_bytes(obj({"fixed": box, "pebble": (0.01 * box[0] + [0, 0, 0.5], box[1]), "high": box}))
    given = {"friction": 0.7, "unit_weight": 1.0}
    for tolerance in (0.03, 0.4):
        with pytest.raises(mo.CaseError, match=r"block 'pebble' is too thin for 'tolerance' 0\.") as refusal:
            mo.read_mesh(path, **given, tolerance=tolerance)
        (line,) = str(refusal.value).splitlines()
        advised = float(re.search(r"\(thickness 0.005\): set 'tolerance' to less than ([\d.]+),", line)[1])
        assert len(mo.read_mesh(path, **given, tolerance=0.99 * advised).blocks) == 3


def surveyed_ring(path, error):
    """Write a ring of 9 voussoirs, with gaps of 10 mm and errors of all corners, as meshes, and return its
    supports."""
    rng = np.random.default_rng(0)
    solids = mo.extrude(voussoirs(9, 0.01), thickness=0.5).blocks
    stones = {
        solid.name: (np.add(solid.vertices, rng.uniform(-error, error, (8, 3))), solid.faces)
        for solid in solids
    }
    path.write_bytes(obj(stones))
    return [solid.name for solid in solids if solid.fixed]


@pytest.mark.parametrize("error", [3e-4, pytest.param(2e-3, marks=pytest.mark.slow)])
def test_joints_that_errors_of_a_survey_divide_are_named_with_a_tolerance(tmp_path, error):
    """The corners of a quadrilateral are not in one plane, so its two triangles have separate joints. With
    the advised tolerance the ring has its 10 joints."""
    given = {"friction": 0.6, "unit_weight": 1.0, "live": (1, 0, 0), "contact_tolerance": 0.02}
    given["fixed"] = surveyed_ring(tmp_path / "ring.obj", error)
    assembly = mo.assemble(mo.read_mesh(tmp_path / "ring.obj", **given))
    assert len(assembly.joints.first) > 20
    (warning,) = uneven_sides(assembly)
    assert len(warning.values["pairs"]) == 10
    merged = mo.assemble(mo.read_mesh(tmp_path / "ring.obj", **given, tolerance=warning.values["tolerance"]))
    assert len(merged.joints.first) == 10
    assert not list(uneven_sides(merged))
    surveyed_ring(tmp_path / "exact.obj", 0.0)
    exact = mo.solve(mo.read_mesh(tmp_path / "exact.obj", **given), "static")
    assert mo.solve(merged.scene, "static").load_factor == pytest.approx(exact.load_factor, rel=0.01)


@pytest.mark.parametrize("chords", [4, 16, 40])
def test_curved_sides_are_not_errors_of_a_survey(chords):
    """Layers of a vault touch along arcs in chords, which differ by 0.74 rad divided by their number."""

    def arc(radius, start, end):
        angles = np.linspace(start, end, chords + 1)
        return [*zip((radius * np.cos(angles)).tolist(), (radius * np.sin(angles)).tolist(), strict=True)]

    blocks = [mo.Block(name="base", vertices=[*arc(1.0, 1.2, 1.94), (-0.5, 0), (0.5, 0)], fixed=True)]
    for layer in range(4):
        low, high = 1 + 0.2 * layer, 1.2 + 0.2 * layer
        outline = arc(high, 1.2, 1.94) + arc(low, 1.94, 1.2)
        blocks.append(mo.Block(name=f"layer {layer}", vertices=outline, unit_weight=1))
    assembly = mo.assemble(mo.Scene(joints={"friction": 0.6}, blocks=blocks))
    assert len(assembly.joints.first) == 4 * chords
    assert not list(uneven_sides(assembly))


def test_an_uneven_side_of_a_single_block_is_named_with_a_tolerance():
    """The directions of the two joints differ by 0.02 rad. With the advised tolerance there is one joint."""
    ridge = [(0.0, 0.01), (1.0, 0.02), (2.0, 0.01)]
    block = mo.Block(name="block", vertices=[*ridge, (2.0, 1.0), (0.0, 1.0)], unit_weight=1, live=(1, 0))
    ground = mo.Block(name="ground", vertices=[(0.0, -1.0), (2.0, -1.0), *ridge[::-1]], fixed=True)
    scene = mo.Scene(joints={"friction": 0.6}, blocks=[block, ground])
    assembly = mo.assemble(scene)
    assert len(assembly.joints.first) == 2
    (warning,) = uneven_sides(assembly)
    assert warning.values["angle"] == pytest.approx(0.02, rel=0.01)
    merged = mo.assemble(scene.replace(tolerance=warning.values["tolerance"]))
    assert len(merged.joints.first) == 1

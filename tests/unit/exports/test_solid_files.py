"""Files of solids for other programs contain the blocks, the mechanism and the forces."""

import json
from itertools import pairwise

import numpy as np
import pytest
from scenes import two_blocks
from scenes_in_space import box_on_floor, corner_wall

import masonry_opt as mo
from masonry_opt.drawing.elements import FULL_MOTION
from masonry_opt.scene.space.shapes import shapes
from masonry_opt.solution.motion import fastest


@pytest.fixture(scope="module")
def result():
    return mo.solve(corner_wall(1, 1, 2), "static")


def objects(path):
    """Return the corners of the faces of each object of an OBJ file, by name."""
    found, corners = {}, []
    for line in path.read_text().splitlines():
        kind, *rest = line.split(" ")
        if kind == "o":
            faces = found.setdefault(" ".join(rest), [])
        elif kind == "v":
            corners.append(list(map(float, rest)))
        elif kind == "f":
            faces.append([int(corner) - 1 for corner in rest])
    return {name: [np.array(corners)[face] for face in faces] for name, faces in found.items()}


def expected(result, share):
    """Return the corners of each box, moved by the velocity of its centroid and its rotation, by name."""
    scale = share * FULL_MOTION * 2.0 / fastest(result.assembly, result.solution.d)
    frame = result.blocks.set_index("block")
    moved = {}
    for block in result.assembly.scene.blocks:
        corners = np.array(block.polyhedra[0].vertices, dtype=float)
        if not block.fixed:
            row = frame.loc[block.name]
            velocity, rotation = (row[[f"{kind}{axis}" for axis in "xyz"]].to_numpy(float) for kind in "vw")
            arm = corners - row[["x", "y", "z"]].to_numpy(float)
            corners = corners + scale * (velocity + np.cross(rotation, arm))
        moved[f"fixed {block.name}" if block.fixed else block.name] = corners
    return moved


@pytest.mark.parametrize("share", [0.0, 0.5, 1.0])
def test_obj_has_the_moved_blocks(result, share, tmp_path):
    (path,) = mo.export(result, tmp_path / "a.obj", moved=share)
    found, wanted = objects(path), expected(result, share)
    assert list(found) == list(wanted)
    for name, corners in wanted.items():
        own = np.unique(np.concatenate(found[name]), axis=0)
        assert own == pytest.approx(np.unique(corners, axis=0), abs=1e-9)
        assert len(found[name]) == 6


@pytest.mark.parametrize("ending", ["glb", "gltf"])
def test_gltf_has_the_moved_blocks_with_y_upwards(result, ending, tmp_path):
    trimesh = pytest.importorskip("trimesh", reason="needs the extra meshes")
    (path,) = mo.export(result, tmp_path / f"a.{ending}", moved=1.0)
    scene = trimesh.load(path)
    for name, corners in expected(result, 1.0).items():
        transform, geometry = scene.graph[name]
        mesh = scene.geometry[geometry]
        assert mesh.is_watertight
        assert mesh.volume == pytest.approx(abs(np.linalg.det(np.ptp(corners, axis=0) * np.eye(3))), rel=0.1)
        x, y, z = trimesh.transform_points(mesh.vertices, transform).T
        found = np.column_stack([x, -z, y])
        apart = np.linalg.norm(found[:, None] - corners[None], axis=-1).min(axis=1)
        assert apart.max() < 1e-6


def test_compas_has_forces_in_equilibrium_and_velocities(result, tmp_path):
    """The forces at the interfaces, computed from their frames, balance the weight of each block and λ times
    its live load."""
    (path,) = mo.export(result, tmp_path / "a.json")
    data = json.loads(path.read_text())["data"]
    graph = data["graph"]["data"]
    total = {name: np.zeros(3) for name in graph["node"]}
    for first, others in graph["edge"].items():
        for second, edge in others.items():
            for interface in edge["interfaces"]:
                own = interface["data"]
                x, y = (np.array(own["frame"]["data"][f"{axis}axis"]) for axis in "xy")
                assert len(own["points"]) == len(own["forces"])
                for force in own["forces"]:
                    n = force["c_np"] - force["c_nn"]
                    acts = n * np.cross(x, y) + force["c_u"] * x + force["c_v"] * y
                    total[first] += acts
                    total[second] -= acts
    factor = data["attributes"]["load_factor"]
    assert factor == result.load_factor
    rates = result.blocks.set_index("block")
    for block in result.assembly.scene.blocks:
        node = graph["node"][repr(block.name)]
        assert node["is_support"] == block.fixed
        if block.fixed:
            assert node["displacement"] == [0.0] * 6
            continue
        weight = float(np.prod(np.ptp(block.box, axis=1)))
        assert total[repr(block.name)] == pytest.approx([0, factor * weight, weight], abs=1e-5)
        assert node["displacement"] == rates.loc[block.name][["vx", "vy", "vz", "wx", "wy", "wz"]].tolist()


LOADED = {"unit_weight": 2.0, "live_per_weight": (0.3, 0.2, 0.0)}
VAULT = {"span": 4.0, "rise": 1.2, "thickness": 0.4, **LOADED}
PLAN = [{"name": "front", "axis": [(0.5, 0.5), (5.5, 0.5)], "openings": [{"at": 2, "width": 1, "height": 2}]}]
PLAN += [{"name": "side", "axis": [(0.5, 0.5), (0.5, 4)]}]

#: Meshes have no weights, so the weight of the barrel is computed from straight edges.
GENERATED = {
    "barrel": mo.Barrel(**VAULT, voussoirs=3, length=2, stone=1.0, skewbacks=0.5, weights="straight"),
    "dome": mo.Dome(radius=2.0, thickness=0.3, rings=2, voussoirs=6, at=(0.1, 0.2, 0.3), **LOADED),
    "groin": mo.Groin(**VAULT, voussoirs=4, bay=6, stone=2.0, name="bay 1"),
    "plan": mo.Plan(block=(2, 1), thickness=1, courses=3, walls=PLAN, **LOADED),
    "shaft": mo.Shaft(
        diameter=(1.2, 0.8), height=5.0, drums=3, sides=7, name="24\" \\ of \"Pont d'Arc'", **LOADED
    ),
}


def turned(box, faces):
    """Return a box as a part with some of its faces turned inwards."""
    part = mo.box("part", *box, fixed=True).polyhedra[0]
    kept = [face[::-1] if number in faces else face for number, face in enumerate(part.faces)]
    return mo.Part(vertices=part.vertices.tolist(), faces=kept)


#: Parts that share a whole face or a portion of a face. Some parts are inside out.
PARTS = {
    "T": [mo.Part(box=((0, 3), (0, 1), (1, 2))), turned(((1, 2), (0, 1), (0, 1)), range(6))],
    "two halves": [turned(((0, 1), (0, 2), (0, 2)), (1, 4)), mo.Part(box=((1, 3), (0, 2), (0, 2)))],
    "ring": [
        mo.Part(box=(x, y, (0, 2)))
        for x, y in (((0, 3), (0, 1)), ((0, 3), (2, 3)), ((0, 1), (1, 2)), ((2, 3), (1, 2)))
    ],
}


def of_parts(parts):
    return [
        mo.box("ground", (-1, 4), (-1, 4), (-1, 0), fixed=True),
        mo.Solid(name="stone", parts=parts, **LOADED),
        mo.box("cap", (0, 2), (0, 1), (2, 3), **LOADED),
    ]


BLOCKS = {name: made.blocks() for name, made in GENERATED.items()}
BLOCKS |= {name: of_parts(parts) for name, parts in PARTS.items()}
SLOW = dict.fromkeys(("barrel", "dome", "groin", "plan"), pytest.mark.slow)


IN_FULL = [pytest.param(each, id=name, marks=SLOW.get(name, ())) for name, each in BLOCKS.items()]


@pytest.mark.parametrize("blocks", IN_FULL)
def test_what_is_written_is_read_back(blocks, tmp_path):
    """The blocks that are read have the same names, supports, joints and load factor."""
    scene = mo.Scene(joints={"friction": 0.6}, blocks=blocks)
    wanted = mo.solve(scene, "static")
    given = {"friction": 0.6, "unit_weight": 2.0, "live": LOADED["live_per_weight"]}
    for name, read in (("a.obj", mo.read_mesh), ("a.json", mo.read_compas)):
        (path,) = mo.export(scene, tmp_path / name)
        back = read(path, **given)
        called = [block.name.removeprefix("fixed ") for block in back.blocks]
        assert called == [block.name for block in blocks]
        assert [block.fixed for block in back.blocks] == [block.fixed for block in blocks]
        found = mo.solve(back, "static")
        for end in ("first", "second"):
            assert list(getattr(found.assembly.joints, end)) == list(getattr(wanted.assembly.joints, end))
        assert found.load_factor == pytest.approx(wanted.load_factor, rel=1e-7)


@pytest.mark.parametrize("blocks", BLOCKS.values(), ids=BLOCKS)
def test_surfaces_look_outwards(blocks, tmp_path):
    scene = mo.Scene(joints={"friction": 0.6}, blocks=blocks)
    (path,) = mo.export(scene, tmp_path / "a.obj")
    for faces, volume in zip(objects(path).values(), shapes(scene).size, strict=True):
        inside = sum(np.linalg.det([face[0], one, two]) for face in faces for one, two in pairwise(face[1:]))
        assert inside / 6 == pytest.approx(volume)


@pytest.mark.parametrize(
    ("what", "name", "how"),
    [
        (two_blocks(), "a.obj", {}),
        (two_blocks(), "a.json", {}),
        (box_on_floor(), "a.obj", {"method": "static"}),
        (box_on_floor(), "a.obj", {"moved": 0.5}),
        (box_on_floor(), "a.json", {"moved": 0.5}),
        (box_on_floor(), "a.lp", {"moved": 0.5}),
        (box_on_floor(), "a.stl", {}),
        (box_on_floor(), "none/a.obj", {}),
    ],
)
def test_what_cannot_be_written_is_refused_and_leaves_nothing(what, name, how, tmp_path):
    with pytest.raises(mo.OptionError):
        mo.export(what, tmp_path / name, **how)
    assert not list(tmp_path.iterdir())


def test_what_does_not_move_is_written_at_rest_alone(tmp_path):
    pressed = mo.box("A", (0, 1), (0, 1), (0, 1), unit_weight=1, live=(0, 0, -1))
    floor = mo.box("floor", (-1, 2), (-1, 2), (-1, 0), fixed=True)
    result = mo.solve(mo.Scene(joints={"friction": 0.5}, blocks=[floor, pressed]), "static")
    assert result.status is mo.Status.UNLIMITED
    mo.export(result, tmp_path / "a.obj")
    with pytest.raises(mo.OptionError, match="moved"):
        mo.export(result, tmp_path / "b.obj", moved=1.0)

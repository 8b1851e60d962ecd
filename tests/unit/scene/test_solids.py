"""Solids and scenes of solids: their shapes, the errors of wrong keys, and reading and writing of files."""

import numpy as np
import pytest
from scenes import two_blocks
from scenes_in_space import box_on_floor, corner_wall, volume

import masonry_opt as mo

UNIT = [[0, 1], [0, 1], [0, 1]]
CORNERS = [(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)]
FACES = [[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]]
WEDGE = {"vertices": CORNERS, "faces": FACES}
FLOOR = mo.box("floor", (-9, 9), (-9, 9), (-1, 0), fixed=True)
FLAT = {"name": "flat", "vertices": [(0, 0), (1, 0), (0, 1)], "weight": 1}


def solid(**values):
    return mo.Solid(**({"name": "A", "weight": 1, "live": (1, 0, 0)} | values))


def scene(*blocks, **keys):
    return mo.Scene(**({"joints": {"friction": 0.5}, "blocks": [*blocks, FLOOR]} | keys))


def test_faces_of_a_box_are_counter_clockwise_from_outside():
    (part,) = mo.box("A", (1, 3), (-2, 1), (0.5, 4.5), weight=1).polyhedra
    assert volume(part) == pytest.approx(2 * 3 * 4, rel=1e-14)
    assert part.vertices.min(axis=0).tolist() == [1, -2, 0.5]
    assert part.vertices.max(axis=0).tolist() == [3, 1, 4.5]
    for face in part.faces:
        a, b, c, d = part.vertices[face]
        outwards = np.cross(b - a, c - b)
        # Each face is a rectangle whose normal points away from the middle of the box.
        assert (d - a).tolist() == (c - b).tolist()
        assert outwards @ (a - (2, -0.5, 2.5)) > 0


#: Keys of a wrong solid, and words of the error message: the name of the block, and the keys.
WRONG_SOLIDS = {
    "three corners": ({**WEDGE, "vertices": CORNERS[:3]}, ["'A'", "'vertices'"]),
    "a corner before the first": ({**WEDGE, "faces": [*FACES[:3], [0, -1, 2]]}, ["'A'", "'faces[3][1]'"]),
    "no shape": ({}, ["'A'", "'vertices'", "'box'", "'parts'"]),
    "two shapes": ({"box": UNIT, "parts": [WEDGE]}, ["'A'", "'box'", "'parts'"]),
    "no faces": ({"vertices": CORNERS}, ["'A'", "'vertices'", "'faces'", "'box'"]),
    "faces of a box": ({"box": UNIT, "faces": FACES}, ["'A'", "'vertices'", "'faces'"]),
    "a corner too many": ({**WEDGE, "faces": [*FACES[:3], [0, 3, 4]]}, ["'A'", "no. 4", "'vertices'"]),
    "a corner twice": ({**WEDGE, "faces": [*FACES[:3], [0, 3, 3]]}, ["'A'", "no. 4", "'faces'"]),
    "a corner that is no number": ({**WEDGE, "faces": [*FACES, [0, 1, 2.5]]}, ["'A'", "'faces[4][2]'"]),
    "three faces": ({**WEDGE, "faces": FACES[:3]}, ["'A'", "'faces'"]),
    "corner in the plane": ({**WEDGE, "vertices": [*CORNERS[:3], (0, 0)]}, ["'A'", "'vertices[3]'"]),
    "falling interval": ({"box": [[0, 1], [1, 0], [0, 1]]}, ["'A'", "'box'", " y"]),
    "flat box": ({"box": [[0, 1], [0, 1], [1, 1]]}, ["'A'", "'box'", " z"]),
    "no part": ({"parts": []}, ["'A'", "'parts'"]),
    "part without a shape": ({"parts": [WEDGE, {}]}, ["'A'", "'parts[1]'", "'box'"]),
    "wrong part": (
        {"parts": [WEDGE, {"vertices": CORNERS, "faces": [[0, 1, 9]] * 4}]},
        ["'A'", "'parts[1]'", "no. 1", "'vertices'"],
    ),
    "key of a part": ({"parts": [{"box": UNIT, "weight": 1}]}, ["'A'", "'parts[0].weight'"]),
    "holes": ({"box": UNIT, "holes": []}, ["'A'", "'holes'"]),
    "force in the plane": ({"box": UNIT, "live": (1, 0)}, ["'A'", "'live'"]),
    "a number for a moment": ({"box": UNIT, "live_moment": 1}, ["'A'", "'live_moment'"]),
    "a place without a force": ({"box": UNIT, "dead_at": (0, 0, 0)}, ["'A'", "'dead_at'", "'dead'"]),
    "moment on a support": (
        {"box": UNIT, "live": (0, 0, 0), "dead_moment": (0, 0, 1), "fixed": True},
        ["'A'", "'live'", "'dead_moment'"],
    ),
}


@pytest.mark.parametrize("name", WRONG_SOLIDS)
def test_a_wrong_solid_is_refused_by_name_and_key(name):
    values, words = WRONG_SOLIDS[name]
    with pytest.raises(mo.CaseError) as error:
        solid(**values)
    (line,) = str(error.value).split("\n")
    assert line.startswith("Solid 'A': ")
    for word in words:
        assert word in line


A = {"name": "A", "box": UNIT, "weight": 1}
PUSHED = A | {"live": (1, 0, 0)}

#: Changed keys of a scene of solids, and words of the error message.
WRONG_SCENES = {
    "no gravity": ({"gravity": (0, 0, 0)}, ["'gravity'"]),
    "both kinds": ({"blocks": [PUSHED, FLOOR, FLAT]}, ["'A'", "'flat'"]),
    "gravity in the plane": ({"gravity": (0, -1)}, ["'gravity'", "'A'"]),
    "thickness": ({"thickness": 2}, ["'thickness'", "'A'"]),
    "strength": ({"joints": {"friction": 1, "strength": 9}}, ["'joints'", "'strength'"]),
    "dilatancy by stress": ({"joints": {"friction": 1, "dilatancy_stress": (1, 2)}}, ["'dilatancy_stress'"]),
    "strength of one joint": (
        {"exceptions": [{"between": ("A", "floor"), "strength": 9}]},
        ["['A', 'floor']", "'strength'"],
    ),
    "edge load": ({"edge_loads": [{"start": (0, 0), "end": (1, 0), "pressure": 1}]}, ["'edge_load'"]),
    "load in the plane": ({"loads": [{"block": "A", "live": (1, 0)}]}, ["no. 1", "'A'", "'live'"]),
    "load on a support": ({"loads": [{"block": "floor", "live_moment": (1, 0, 0)}]}, ["no. 1", "'floor'"]),
    "tilt to a side": ({"blocks": [A, FLOOR], "tilt": "left"}, ["'tilt'"]),
    "tilt along gravity": ({"blocks": [A, FLOOR], "tilt": (0, 0, 2)}, ["'tilt'", "gravity"]),
    "tilt of no length": ({"blocks": [A, FLOOR], "tilt": (0, 0, 0)}, ["'tilt'"]),
    "tilt of a force": ({"tilt": (1, 0, 0)}, ["'tilt'", "'A'", "'live'"]),
    "tilt of a moment": (
        {"blocks": [A | {"dead_moment": (1, 0, 0)}, FLOOR], "tilt": (1, 0, 0)},
        ["'tilt'", "'A'", "'dead_moment'"],
    ),
    "tilt of a load's moment": (
        {"blocks": [A, FLOOR], "tilt": (1, 0, 0), "loads": [{"block": "A", "live_moment": (1, 0, 0)}]},
        ["'tilt'", "'A'", "'load'"],
    ),
    "keys of the kind that is meant": (
        {"blocks": [A | {"fcaes": []}, FLAT | {"fixd": True}]},
        ["no. 1 ('A')", "'fcaes'", "'faces'", "no. 2 ('flat')", "'fixd'", "'fixed'"],
    ),
    "no shape, with a force in space": (
        {"blocks": [{"name": "B", "weight": 1, "live": (1, 0, 0)}, FLOOR]},
        ["no. 1 ('B')", "'box'", "'faces'"],
    ),
    "first corner of two numbers": (
        {"blocks": [WEDGE | {"name": "A", "vertices": [(0, 0), *CORNERS[1:]], "weight": 1}, FLOOR]},
        ["no. 1 ('A')", "'vertices[0]'"],
    ),
    "key of a part": (
        {"blocks": [{"name": "F", "parts": [{"box": UNIT}, {"bx": UNIT}], "weight": 1}, FLOOR]},
        ["no. 1 ('F')", "'parts[1].bx'", "'box'"],
    ),
    "parts by corners": (
        {"blocks": [{"name": "B", "weight": 1, "parts": [CORNERS]}, FLOOR]},
        ["no. 1 ('B')", "'parts[0]'", "Part"],
    ),
}


@pytest.mark.parametrize("name", WRONG_SCENES)
def test_a_wrong_scene_of_solids_is_refused(name):
    keys, words = WRONG_SCENES[name]
    with pytest.raises(mo.CaseError) as error:
        mo.Scene(**{"joints": {"friction": 0.5}, "blocks": [PUSHED, FLOOR]} | keys)
    for word in words:
        assert word in str(error.value)


@pytest.mark.parametrize(
    ("keys", "words"),
    [
        ({"gravity": (0, 0, -1)}, ["'gravity'"]),
        ({"tilt": (1, 0, 0)}, ["'tilt'"]),
        ({"loads": [{"block": "flat", "live": (1, 0, 0)}]}, ["'flat'", "'live'"]),
        ({"loads": [{"block": "flat", "live": (1, 0), "at": (1, 0, 0)}]}, ["'flat'", "'at'"]),
        ({"loads": [{"block": "flat", "dead_moment": (1, 0, 0)}]}, ["'flat'", "'dead_moment'"]),
    ],
)
def test_three_numbers_are_refused_in_the_plane(keys, words):
    floor = {"name": "floor", "vertices": [(0, 0), (0, -1), (1, -1)], "fixed": True}
    with pytest.raises(mo.CaseError) as error:
        mo.Scene(joints={"friction": 0.5}, blocks=[FLAT, floor], **keys)
    for word in words:
        assert word in str(error.value)


def test_a_scene_knows_its_dimension_and_what_is_down_there():
    plane = two_blocks()
    assert (plane.dimension, plane.gravity) == (2, (0.0, -1.0))
    space = box_on_floor()
    assert (space.dimension, space.gravity) == (3, (0.0, 0.0, -1.0))
    assert [block.name for block in space.in_space()] == ["A", "floor"]
    assert plane.in_plane() == plane.blocks
    with pytest.raises(mo.OptionError):
        space.in_plane()
    with pytest.raises(mo.OptionError):
        plane.in_space()
    oblique = scene(A, gravity=(0, -3, -4), tilt=(0, 0, 7))
    assert oblique.down == pytest.approx([0, -0.6, -0.8], rel=1e-15)
    # By hand: (0, 0, 1) minus its component along gravity is (0, 0, 1) + 0.8 (0, -0.6, -0.8), here of length
    # 1.
    assert oblique.tilt_direction == pytest.approx([0, -0.8, 0.6], rel=1e-14)


CASE = """
[joints]
friction = 0.6
cohesion = 0.1
[[block]]
name = "A"
vertices = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]]
faces = [[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]]
unit_weight = 6
live = [0, 1, 0]
live_at = [0.25, 0.25, 0.5]
live_moment = [0, 0, 2]
[[block]]
name = "B"
weight = 25
live_per_weight = [0, -0.1, 0]
dead_moment = [0.1, 0, 0]
parts = [{ box = [[-1, 0], [0, 1], [0, 1]] }, { box = [[-2, -1], [0, 1], [0, 0.5]] }]
[[block]]
name = "F"
parts = [{ box = [[-3, 1], [0, 1], [-1, 0]] }, { box = [[1, 2], [0, 1], [-1, 0]] }]
fixed = true
[[joint]]
between = ["A", "B"]
friction = 0.3
dilatancy = 0.1
[[load]]
block = "A"
dead = [0, 0, -1]
at = [0.1, 0.1, 0.5]
"""

WRITTEN = {
    "corners and parts": lambda path: loaded(CASE, path),
    "gravity": lambda path: loaded("gravity = [0, -1, -1]\n" + CASE, path),
    "boxes": lambda path: corner_wall(2, 1, 2),
    "tilt": lambda path: scene(A, tilt=(1, 0.5, 0)),
    "exceptions": lambda path: scene(
        solid(box=UNIT), exceptions=[{"between": ("A", "floor"), "cohesion": 0.3, "friction": float("inf")}]
    ),
}


def loaded(text, path):
    path = path / "case.toml"
    path.write_text(text)
    return mo.load(path)


@pytest.mark.parametrize("ending", [".toml", ".json"])
@pytest.mark.parametrize("name", WRITTEN)
def test_a_scene_of_solids_survives_being_written(name, ending, tmp_path):
    original = WRITTEN[name](tmp_path)
    mo.save(original, tmp_path / f"written{ending}")
    again = mo.load(tmp_path / f"written{ending}")
    assert again == original
    assert again.dimension == 3
    assert again.gravity == original.gravity


def test_arrays_are_accepted_as_lists():
    """Corners, faces, boxes and forces may be NumPy arrays, also inside lists."""
    corners = np.array([(0.0, 0.0, 0.0), (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)])
    faces = np.array([(0, 2, 1), (0, 1, 3), (1, 2, 3), (0, 3, 2)])
    lists = mo.Solid(name="s", vertices=corners.tolist(), faces=faces.tolist(), weight=1, live=(1, 0, 0))
    push = np.array([1, 0, 0])
    for vertices, rows in ((corners, faces), (list(corners), list(faces))):
        assert mo.Solid(name="s", vertices=vertices, faces=rows, weight=1, live=push) == lists
    box = np.array([(0, 1), (0, 2), (0, 3)])
    assert mo.Solid(name="b", box=box, weight=1) == mo.Solid(name="b", box=box.tolist(), weight=1)
    with pytest.raises(mo.CaseError, match="three numbers"):
        mo.Solid(name="b", box=box, weight=1, live=np.array([1, 0]))

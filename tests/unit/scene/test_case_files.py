"""Case files: read, written back, and the same scene built in Python."""

import json
import math
import tomllib

import pytest
from scenes import ALL_CASES, CASES, two_blocks

import masonry_opt as mo


def test_json_holds_the_same_keys(tmp_path):
    toml, js = CASES / "gilbert" / "two_blocks.toml", tmp_path / "case.json"
    js.write_text(json.dumps(tomllib.loads(toml.read_text())))
    assert mo.load(js) == mo.load(toml)


SQUARE = mo.Block(name="A", vertices=[(0, 0), (1, 0), (1, 1), (0, 1)], weight=1, live=(1, 0))


def on_floor(*blocks, **keys):
    floor = mo.Block(name="floor", vertices=[(-9, -1), (9, -1), (9, 0), (-9, 0)], fixed=True)
    return mo.Scene(**{"joints": {"friction": 0.5, "strength": 4.0}, "blocks": [*blocks, floor]} | keys)


WRITTEN = {
    "most keys": on_floor(
        SQUARE.model_copy(update={"live_at": (0.5, 1), "dead": (0, -0.2), "dead_at": (0.25, 1)}),
        mo.Block(name="B", vertices=[(1, 0), (2.5, 0), (2, 1), (1, 1)], unit_weight=20),
        joints={"friction": 0.6, "cohesion": 0.1, "dilatancy": 0.05},
        exceptions=[{"between": ("A", "B"), "friction": math.inf}],
        loads=[{"block": "A", "live": (0.5, 0), "at": (0.5, 1)}, {"block": "B", "weight": 25}],
        gravity=(0.1, -2),
        thickness=0.5,
        tolerance=1e-5,
        title="a stone beside a stone",
        source="by hand",
        reference={"associative": {"value": 0.5, "source": "by hand", "tolerance": 1e-3}},
    ),
    "unlimited friction": two_blocks(),
    "wall": mo.load(ALL_CASES[0]),
    "angles": on_floor(
        SQUARE,
        joints={"friction_angle": 20},
        exceptions=[{"between": ("A", "floor"), "friction_angle": 25, "dilatancy_angle": 0}],
    ),
    "parts": on_floor(
        mo.Block(
            name="A", parts=[SQUARE.vertices, [(4, 0), (5, 0), (5, 1)]], weight=1, live_per_weight=(1, 0)
        )
    ),
    "a hole": on_floor(
        mo.Block(
            name="B",
            vertices=[(-4, 0), (-1, 0), (-1, 3)],
            holes=[[(-2, 1), (-1.5, 1), (-1.5, 1.2)]],
            weight=1,
            live=(1, 0),
        )
    ),
    "edge loads": on_floor(
        SQUARE,
        edge_loads=[
            mo.EdgeLoad(start=(0, 0), end=(0, 1), pressure=(2, 0)),
            mo.EdgeLoad(start=(0, 1), end=(1, 1), force=(0, -1), kind="live"),
        ],
    ),
    "loads": on_floor(SQUARE, loads=[mo.Load(block="A", dead=(0, -1), at=(0.5, 1))]),
    "load cases": on_floor(
        SQUARE,
        loads=[mo.Load(block="A", live=(0, -1), group="wind")],
        load_cases=[
            {"name": "a", "dead": {"weight": 0.5}, "live": {"wind": 1.5}},
            {"name": "b", "earthquake": {"direction": "left"}},
        ],
    ),
    "ties": on_floor(
        SQUARE,
        ties=[mo.Tie(between=("A", "floor"), at=((0.5, 1), (-4, 0)), strength=0.1, prestress=0.02)],
        props=[mo.Prop(between=("A", "floor"), at=((1, 1), (3, 0)), strength=0.5, name="shore")],
    ),
    "dilatancy that falls with stress": on_floor(
        SQUARE,
        joints={"friction": 0.5, "dilatancy": 0.2, "dilatancy_stress": (0.5, 2)},
        exceptions=[{"between": ("A", "floor"), "dilatancy": 0.05, "dilatancy_stress": (0.25, 0.75)}],
    ),
}


@pytest.mark.parametrize("ending", [".toml", ".json"])
@pytest.mark.parametrize("scene", WRITTEN.values(), ids=WRITTEN)
def test_scene_survives_being_written(tmp_path, scene, ending):
    path = tmp_path / f"case{ending}"
    mo.save(scene, path)
    assert mo.load(path) == scene


def test_wall_generator_expands_courses_gaps_and_repeats():
    wall = mo.Wall(
        block=(4, 2),
        weight=3,
        live=(0.5, 0),
        courses=["u", [1, 1, 1]],
        course={"u": [0.5, 1, -1, 0.5]},
        repeat=2,
    )
    blocks = {block.name: block for block in wall.blocks()}
    assert list(blocks) == [*(f"{row}-{number}" for row in range(1, 5) for number in range(1, 4)), "base"]
    assert blocks["1-3"].vertices == [(10, 0), (12, 0), (12, 2), (10, 2)]
    assert blocks["1-3"].weight == 1.5
    assert blocks["1-3"].live_per_weight == (0.5, 0)
    assert blocks["4-1"].vertices[0] == (0, 6)
    assert blocks["base"].fixed


def test_a_file_that_cannot_be_written_leaves_the_old_one(tmp_path, monkeypatch):
    path = tmp_path / "case.toml"
    path.write_text("old")

    def full(*_):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr("os.replace", full)
    with pytest.raises(mo.CaseError, match="cannot be written: No space"):
        mo.save(two_blocks(), path, force=True)
    assert path.read_text() == "old"
    assert list(tmp_path.iterdir()) == [path]


def test_angles_are_kept_as_tangents():
    joints = mo.JointDefaults(friction_angle=33.0, dilatancy_angle=30)
    assert joints.friction == pytest.approx(0.6494075931975106, rel=1e-15)
    assert joints.dilatancy == pytest.approx(1 / math.sqrt(3), rel=1e-15)
    assert joints == mo.JointDefaults(friction=joints.friction, dilatancy=joints.dilatancy)
    exception = mo.Joint(between=("A", "B"), friction_angle=60)
    assert exception.friction == pytest.approx(math.sqrt(3), rel=1e-15)
    assert exception.over(joints).friction == exception.friction
    assert exception.over(joints).dilatancy == joints.dilatancy


@pytest.mark.parametrize(
    ("given", "words"),
    [
        ({"friction": 0.5, "friction_angle": 30}, "'friction' or 'friction_angle', not both"),
        ({"friction": 0.5, "dilatancy": 0.0, "dilatancy_angle": 0}, "'dilatancy' or 'dilatancy_angle'"),
        ({"friction_angle": 90}, "'friction_angle': must be less than 90"),
        ({"friction_angle": -1}, "'friction_angle': must be 0"),
        ({"friction_angle": "30"}, "'friction_angle': must be a number"),
        ({"friction_angle": True}, "'friction_angle': must be a number"),
        ({"friction_angle": math.nan}, "'friction_angle'"),
        ({"friction_angle": 30, "dilatancy_angle": 31}, "'dilatancy' must not exceed 'friction'"),
        ({}, "missing key 'friction'"),
    ],
)
def test_wrong_angles_are_refused_in_one_line(given, words):
    with pytest.raises(mo.CaseError, match=words) as error:
        mo.JointDefaults(**given)
    assert "\n" not in str(error.value)

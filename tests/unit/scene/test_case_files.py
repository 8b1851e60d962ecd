"""Case files: read, written back, and the same scene built in Python."""

from __future__ import annotations

import json
import math

import pytest
from scenes import ALL_CASES, two_blocks

import masonry_opt as mo

TOML = """
title = "two stones"
[joints]
friction = 0.65
cohesion = 0.5
[[block]]
name = "A"
vertices = [[0, 0], [4, 0], [4, 1.75], [0, 1.75]]
weight = 1.0
live = [1.0, 0.0]
live_at = [2.0, 1.75]
[[block]]
name = "base"
vertices = [[-4, -1], [24, -1], [24, 0], [-4, 0]]
fixed = true
[[joint]]
between = ["A", "base"]
friction = 0.8
[reference]
associative = { value = 0.5, source = "nowhere", tolerance = 1e-3 }
"""


def test_general_form_is_read_as_written(tmp_path):
    path = tmp_path / "case.toml"
    path.write_text(TOML)
    scene = mo.load(path)
    assert scene.title == "two stones"
    assert scene.blocks[0].live_at == (2.0, 1.75)
    assert scene.blocks[1].fixed
    assert scene.exceptions[0].friction == 0.8
    assert scene.exceptions[0].over(scene.joints).cohesion == 0.5
    assert scene.reference["associative"].value == 0.5


def test_json_holds_the_same_keys(tmp_path):
    import tomllib

    toml, js = tmp_path / "case.toml", tmp_path / "case.json"
    toml.write_text(TOML)
    js.write_text(json.dumps(tomllib.loads(TOML)))
    assert mo.load(js) == mo.load(toml)


SQUARE = mo.Block(name="A", vertices=[(0, 0), (1, 0), (1, 1), (0, 1)], weight=1, live=(1, 0))


def on_floor(*blocks, **keys):
    floor = mo.Block(name="floor", vertices=[(-9, -1), (9, -1), (9, 0), (-9, 0)], fixed=True)
    return mo.Scene(**{"joints": {"friction": 0.5, "strength": 4.0}, "blocks": [*blocks, floor]} | keys)


WRITTEN = {
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
}


@pytest.mark.parametrize("ending", [".toml", ".json"])
@pytest.mark.parametrize("scene", WRITTEN.values(), ids=WRITTEN)
def test_scene_survives_being_written(tmp_path, scene, ending):
    path = tmp_path / f"case{ending}"
    mo.save(scene, path)
    assert mo.load(path) == scene


def test_unlimited_friction_is_inf_in_both_formats(tmp_path):
    mo.save(two_blocks(), tmp_path / "case.toml")
    mo.save(two_blocks(), tmp_path / "case.json")
    assert "friction = inf" in (tmp_path / "case.toml").read_text()
    assert '"friction": "inf"' in (tmp_path / "case.json").read_text()
    assert math.isinf(mo.load(tmp_path / "case.json").exceptions[0].friction)


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


def test_reading_a_scene_does_not_change_another():
    scene = two_blocks()
    assert scene.read_from("elsewhere").origin == "elsewhere"
    assert scene.origin == "scene"

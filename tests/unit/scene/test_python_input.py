"""Wrong values in Python end in the same kind of message as in a case file."""

import inspect
import pickle

import numpy as np
import pydantic
import pytest
from scenes import two_blocks

import masonry_opt as mo

TRIANGLE = [(0, 0), (1, 0), (0, 1)]
JOINTS = {"friction": 0.5}
ARCH = {"radius": 10, "angles": (180, 0), "thickness": 1, "voussoirs": 7, "unit_weight": 1}


def block(**values):
    return mo.Block(**({"name": "A", "vertices": TRIANGLE, "weight": 1} | values))


#: What is called, and by line of the message what must be in it.
WRONG_CALLS = {
    "missing keys": (lambda: mo.Block(weight=1), [["Block: ", "'name'"]]),
    "no names": (lambda: mo.Block("A", TRIANGLE), [["Block: ", "name, vertices, parts"]]),
    "no shape": (lambda: mo.Block(name="A", weight=1), [["Block 'A': ", "'vertices'", "'parts'"]]),
    "wrong values": (
        lambda: block(weight=-1, vertices=[(0, "0"), *TRIANGLE], live=(1,), fixed=1),
        [
            ["Block 'A': ", "'vertices[0][1]'", "number", "found '0'"],
            ["Block 'A': ", "'weight'", "0 or more", "found -1"],
            ["Block 'A': ", "'live'", "two"],
            ["Block 'A': ", "'fixed'", "True or False", "found 1"],
        ],
    ),
    "name of another type": (lambda: block(name=5), [["Block 5: ", "'name'", "text"]]),
    "name that is an array": (lambda: block(name=np.zeros(2)), [["Block: ", "'name'", "text"]]),
    "name with an escape": (
        lambda: block(name="\x1b[31m\n"),
        [["Block '\\x1b[31m\\n'", "'name'", "control"]],
    ),
    "value of several lines": (lambda: block(live=np.eye(3)), [["Block 'A'", "'live'", "found array("]]),
    "a place without a weight": (
        lambda: mo.Block(name="A", vertices=TRIANGLE, weight_at=(0, 0), fixed=True),
        [["Block 'A': ", "'weight_at'"]],
    ),
    "joint": (
        lambda: mo.Joint(between=("A", "B"), fricton=1),
        [["Joint ('A', 'B')", "'fricton'", "'friction'"]],
    ),
    "joint over defaults": (
        lambda: mo.Joint(between=("A", "B"), dilatancy=0.6).over(mo.JointDefaults(friction=0.5)),
        [["JointDefaults: ", "'dilatancy'", "'friction'"]],
    ),
    "scene": (
        lambda: mo.Scene(joints=0.5, blcks=[]),
        [
            ["Scene: ", "'joints'", "JointDefaults", "found 0.5"],
            ["Scene: ", "'blcks'", "did you mean 'blocks'"],
        ],
    ),
    "scene of tables": (
        lambda: mo.Scene(
            joints={"fricton": 1},
            blocks=({"name": "A", "vertices": TRIANGLE, "wieght": 1}, 5, {"vertices": TRIANGLE}),
            exceptions=[{"between": ["A", "B"], "cohesion": -1}],
        ),
        [
            ["Scene: ", "missing", "'joints.friction'"],
            ["Scene: ", "'joints.fricton'", "did you mean 'friction'"],
            ["Scene: block no. 1 ('A')", "'wieght'", "did you mean 'weight'"],
            ["Scene: block no. 2", "Block", "found 5"],
            ["Scene: block no. 3", "missing", "'name'"],
            ["Scene: joint no. 1 (['A', 'B'])", "'cohesion'", "found -1"],
        ],
    ),
    "wall": (
        lambda: mo.Wall(block=(4, 1), weight=1, courses=["name", [1, "1"]], course={"name": [1, None]}),
        [["Wall: ", "'courses[1][1]'", "found '1'"], ["Wall: ", "'course.name[1]'", "found None"]],
    ),
    "block of a wall": (
        lambda: mo.Wall(block=(4, 1), weight=9e29, courses=[[4]]).blocks(),
        [["Block '1-1': ", "'weight'", "found 3.6e+30"]],
    ),
    "load of an arch": (
        lambda: mo.Arch(**ARCH, point_loads=[{"voussoir": 1, "force": (0, 1), "forc": 1}]),
        [["Arch: ", "'point_loads[0].forc'", "did you mean 'force'"]],
    ),
    "reference": (
        lambda: mo.Reference(value=1, sorce=""),
        [["Reference: ", "'source'"], ["'sorce'", "'source'"]],
    ),
}


@pytest.mark.parametrize("name", WRONG_CALLS)
def test_wrong_call(name):
    call, expected = WRONG_CALLS[name]
    with pytest.raises(mo.CaseError) as error:
        call()
    message = str(error.value)
    lines = message.split("\n")
    for line, words in zip(lines, expected, strict=True):
        for word in words:
            assert word in line
    assert all(line.isprintable() for line in lines)
    assert "http" not in message


@pytest.mark.parametrize(("wrong", "lines"), [(19, 19), (20, 20), (21, 20), (1000, 20)])
def test_message_has_at_most_twenty_lines(wrong, lines):
    with pytest.raises(mo.CaseError) as error:
        block(vertices=[(0, "0")] * wrong)
    assert len(str(error.value).split("\n")) == lines


def test_error_of_a_record_shows_nothing_of_pydantic():
    with pytest.raises(mo.CaseError) as error:
        block(wieght=1)
    assert error.value.__suppress_context__
    assert error.value.__cause__ is None
    assert str(pickle.loads(pickle.dumps(error.value))) == str(error.value)


@pytest.mark.parametrize(
    ("call", "words"),
    [
        (lambda path: mo.load(5), ["path of a case file", "int"]),
        (lambda path: mo.load(None), ["path of a case file", "NoneType"]),
        (lambda path: mo.save(5, path), ["Scene", "int"]),
        (lambda path: mo.save(two_blocks(), 5), ["path of a case file", "int"]),
        (lambda path: mo.save(two_blocks(), path.with_name("a\0.toml")), ["cannot be written"]),
    ],
)
def test_load_and_save_say_what_they_take(call, words, tmp_path):
    with pytest.raises(mo.CaseError) as error:
        call(tmp_path / "case.toml")
    for word in words:
        assert word in str(error.value)
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("record", [mo.Scene, mo.Block, mo.Solid, mo.Wall, mo.Fill])
def test_help_shows_keys_without_what_checks_them(record):
    shown = inspect.signature(record)
    assert list(shown.parameters) == list(record.model_fields)
    assert "Annotated" not in str(shown)
    assert not [name for name in dir(record) if name.startswith("_") or hasattr(pydantic.BaseModel, name)]


def test_a_scene_is_shown_in_two_lines_and_has_blocks_by_name():
    scene = two_blocks()
    assert len(repr(scene).splitlines()) == 2
    assert repr(scene) == str(scene)
    assert scene[scene.blocks[1].name] is scene.blocks[1]
    assert {"blocks", "replace"} <= set(dir(scene))
    with pytest.raises(mo.CaseError, match="'nowhere'"):
        scene["nowhere"]

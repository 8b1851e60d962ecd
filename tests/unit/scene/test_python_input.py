"""Wrong values in Python raise the errors of case files, and records with changed values are solved or
refused."""

import inspect
import math
import pickle

import numpy as np
import pydantic
import pytest
from scenes import CASES, WALLS, block_on_floor, two_blocks
from scenes_in_space import box_on_floor

import masonry_opt as mo

TRIANGLE = [(0, 0), (1, 0), (0, 1)]
ARCH = {"radius": 10, "angles": (180, 0), "thickness": 1, "voussoirs": 7, "unit_weight": 1}


def block(**values):
    return mo.Block(**({"name": "A", "vertices": TRIANGLE, "weight": 1} | values))


#: A call, and for each line of its error message the words that the line must contain, separated by "…".
WRONG_CALLS = {
    "missing keys": (lambda: mo.Block(weight=1), "Block: … 'name'"),
    "no names": (lambda: mo.Block("A", TRIANGLE), "Block: … name, vertices, parts"),
    "no shape": (lambda: mo.Block(name="A", weight=1), "Block 'A': … 'vertices' … 'parts'"),
    "wrong values": (
        lambda: block(weight=-1, vertices=[(0, "0"), *TRIANGLE], live=(1,), fixed=1),
        "Block 'A': … 'vertices[0][1]' … number … found '0'",
        "Block 'A': … 'weight' … 0 or more … found -1",
        "Block 'A': … 'live' … two",
        "Block 'A': … 'fixed' … True or False … found 1",
    ),
    "name of another type": (lambda: block(name=5), "Block 5: … 'name' … text"),
    "name that is an array": (lambda: block(name=np.zeros(2)), "Block: … 'name' … text"),
    "name with an escape": (lambda: block(name="\x1b[31m\n"), "Block '\\x1b[31m\\n' … 'name' … control"),
    "value of several lines": (lambda: block(live=np.eye(3)), "Block 'A' … 'live' … found array("),
    "a place without a weight": (
        lambda: mo.Block(name="A", vertices=TRIANGLE, weight_at=(0, 0), fixed=True),
        "Block 'A': … 'weight_at'",
    ),
    "joint": (lambda: mo.Joint(between=("A", "B"), fricton=1), "Joint ('A', 'B') … 'fricton' … 'friction'"),
    "joint over defaults": (
        lambda: mo.Joint(between=("A", "B"), dilatancy=0.6).over(mo.JointDefaults(friction=0.5)),
        "JointDefaults: … 'dilatancy' … 'friction'",
    ),
    "scene": (
        lambda: mo.Scene(joints=0.5, blcks=[]),
        "Scene: … 'joints' … JointDefaults … found 0.5",
        "Scene: … 'blcks' … did you mean 'blocks'",
    ),
    "scene of tables": (
        lambda: mo.Scene(
            joints={"fricton": 1},
            blocks=({"name": "A", "vertices": TRIANGLE, "wieght": 1}, 5, {"vertices": TRIANGLE}),
            exceptions=[{"between": ["A", "B"], "cohesion": -1}],
        ),
        "Scene: … 'joints.fricton' … did you mean 'friction'",
        "Scene: block no. 1 ('A') … 'wieght' … did you mean 'weight'",
        "Scene: block no. 2 … Block … found 5",
        "Scene: block no. 3 … missing … 'name'",
        "Scene: joint no. 1 (['A', 'B']) … 'cohesion' … found -1",
    ),
    "wall": (
        lambda: mo.Wall(block=(4, 1), weight=1, courses=["name", [1, "1"]], course={"name": [1, None]}),
        "Wall: … 'courses[1][1]' … found '1'",
        "Wall: … 'course.name[1]' … found None",
    ),
    "block of a wall": (
        lambda: mo.Wall(block=(4, 1), weight=9e29, courses=[[4]]).blocks(),
        "Block '1-1': … 'weight' … found 3.6e+30",
    ),
    "load of an arch": (
        lambda: mo.Arch(**ARCH, point_loads=[{"voussoir": 1, "force": (0, 1), "forc": 1}]),
        "Arch: … 'point_loads[0].forc' … did you mean 'force'",
    ),
    "reference": (lambda: mo.Reference(value=1, sorce=""), "Reference: … 'sorce' … 'source'"),
}


@pytest.mark.parametrize("name", WRONG_CALLS)
def test_wrong_call(name):
    call, *expected = WRONG_CALLS[name]
    with pytest.raises(mo.CaseError) as error:
        call()
    message = str(error.value)
    lines = message.split("\n")
    for line, words in zip(lines, expected, strict=True):
        for word in words.split(" … "):
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


BLOCK = block_on_floor(friction=0.4)
CASED = BLOCK.replace(load_cases=[mo.LoadCase(name="push", live={"live": 1.0})]).in_case("push")
STORM = [mo.LoadCase(name="push", live={"live": 2.0})]


def changes(**others: object) -> dict[str, object]:
    return {"blocks": {"A": {"weight": 2.0}}} | others


@pytest.mark.parametrize(
    ("keys", "load_factor"),
    [
        ({"friction": 0.3}, 0.3),
        ({"joints": {"friction": 0.3}}, 0.3),
        ({"joints": mo.JointDefaults(friction=0.3)}, 0.3),
        ({"friction_angle": math.degrees(math.atan(0.3))}, 0.3),
        ({"cohesion": 0.02, "joints": {"friction": 0.3}}, 0.32),
        (changes(), 0.8),
        (changes(friction=0.3), 0.6),
        ({"blocks": {"A": {"unit_weight": 2.0}}}, 1.6),  # replaces the weight
        # ``block`` is the key of case files
        ({"block": [*BLOCK.replace(blocks={"A": {"live": (2.0, 0.0)}}).blocks]}, 0.2),
        ({"loads": [mo.Load(block="A", dead=(0, -1))]}, 0.8),
        ({"exceptions": [mo.Joint(between=("A", "floor"), friction=0.1)]}, 0.1),
    ],
)
def test_a_scene_with_other_values_is_solved_with_these(keys, load_factor):
    """A block of weight W slides at λ H = μ W + c L, with L = 1. The original scene is solved first, and its
    result must not be reused."""
    assert mo.solve(BLOCK, "static").load_factor == pytest.approx(0.4, rel=1e-6)
    other = BLOCK.replace(**keys)
    assert BLOCK.model_copy(update=keys) == other
    assert mo.solve(other, "static").load_factor == pytest.approx(load_factor, rel=1e-6)
    assert block_on_floor(friction=0.4) == BLOCK


@pytest.mark.parametrize(
    ("scene", "keys", "named"),
    [
        (BLOCK, {"frction": 0.3}, "did you mean 'friction'"),
        (BLOCK, {"friction": -1.0}, "joints.friction"),
        (BLOCK, {"joints": {"dilatancy": 0.5}}, "must not exceed"),
        (BLOCK, {"tolerance": -1}, "'tolerance'"),
        (BLOCK, {"joint": [mo.Joint(between=("A", "B"), friction=1)]}, "no block is named 'B'"),
        (BLOCK, {"load": [mo.Load(block="A", live=(1, 0, 0))]}, "two numbers"),
        (BLOCK, {"blocks": BLOCK.blocks[:1]}, "no block is fixed"),
        (BLOCK, {"blocks": {"A": {"weigth": 3}}}, "Block 'A'.*did you mean 'weight'"),
        (BLOCK, {"blocks": {"flor": {"fixed": False}}}, "did you mean 'floor'"),
        (BLOCK, {"blocks": {"A": {"weight": 1, "unit_weight": 1}}}, "both 'weight' and 'unit_weight'"),
        (BLOCK, {"weight": 3}, "'weight' is a key of blocks: change it in a mapping"),
        (BLOCK, {"friction": 0.3, "joints": mo.JointDefaults(friction=1)}, "a key of joints"),
        (BLOCK, {"friction": 0.3, "joints": {"friction": 0.2}}, "a key of joints"),
        (two_blocks(), {"friction": 0.3}, "'friction' is a key of joints and exceptions: change it in a"),
        (box_on_floor((1, 1, 1)), {"strength": 1.0}, "'strength' is only for joints in the plane"),
        (CASED, {"load_cases": []}, "the scene has no load cases, so 'push' cannot be chosen"),
    ],
)
def test_what_a_call_refuses_is_refused(scene, keys, named):
    for changed in (scene.replace, lambda **keys: scene.model_copy(update=keys)):
        with pytest.raises(mo.MasonryError, match=named):
            changed(**keys)


def test_every_record_is_checked():
    assert mo.box("A", (0, 1), (0, 1), (0, 1), weight=1).replace(weight=2).weight == 2
    arch = mo.load(CASES / "casapulla_lauro" / "arch.toml").case.arch[0]
    for record, key in (
        (mo.Solid(name="A", box=((0, 1), (0, 1), (0, 1)), weight=1), "weight"),
        (mo.Tie(between=("A", "ground"), at=((0, 0), (1, 0)), strength=1), "strength"),
        (mo.Earthquake(direction="left"), "coefficient"),
        (arch, "thickness"),
    ):
        with pytest.raises(mo.CaseError, match=f"{type(record).__name__}.*'{key}'"):
            record.replace(**{key: -1.0})


def test_a_scene_stays_where_it_was_read_and_in_its_load_case():
    wall = mo.load(WALLS[0]).replace(title="wall")
    assert (wall.origin, wall.title) == (str(WALLS[0]), "wall")
    assert CASED.replace(friction=0.3).load_case == CASED.load_case
    assert CASED.replace(load_cases=STORM).load_case == STORM[0]


def test_what_is_set_says_what_to_do():
    for record, key in ((BLOCK.blocks[0], "weight"), (BLOCK.joints, "friction"), (BLOCK, "anything")):
        with pytest.raises(mo.CaseError, match=rf"replace\({key}=\.\.\.\)"):
            setattr(record, key, 3.0)
        with pytest.raises(mo.CaseError, match=rf"'{key}' cannot be deleted.*replace\({key}=\.\.\.\)"):
            delattr(record, key)


@pytest.mark.parametrize(
    ("blocks", "written"),
    [
        (mo.load(WALLS[0]).case.wall[0], r"write Wall\(...\).blocks\(\)"),
        ([mo.load(WALLS[0]).case.wall[0], BLOCK.blocks[1]], r"write \*Wall\(...\).blocks\(\)"),
        (BLOCK.blocks[0], "must be a list"),
    ],
)
def test_a_record_that_is_no_list_is_one_mistake(blocks, written):
    with pytest.raises(mo.CaseError, match=written) as refused:
        mo.Scene(joints=BLOCK.joints, blocks=blocks)
    assert len(str(refused.value).splitlines()) == 1


def test_courses_are_lists_of_any_kind_or_names():
    keys = {"block": (1, 1), "weight": 1, "live_per_weight": (1, 0)}
    walls = (mo.Wall(courses=[course], **keys) for course in ([1.0, 1.0], (1.0, 1.0), np.array([1.0, 1.0])))
    one, *others = (wall.blocks() for wall in walls)
    assert others == [one, one]
    with pytest.raises(mo.CaseError, match="must be a list"):
        mo.Wall(courses=[3], **keys)

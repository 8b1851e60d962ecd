"""Case files survive reading and writing, and each mistake in them ends in one clear message."""

import json
import math
import tomllib

import pytest
from scenes import ALL_CASES, CASES, GOOD, run_command, two_blocks
from screens import full_from

import masonry_opt as mo


def test_json_holds_the_same_keys(tmp_path):
    toml, js = CASES / "gilbert" / "two_blocks.toml", tmp_path / "case.json"
    js.write_text(json.dumps(tomllib.loads(toml.read_text())))
    assert mo.load(js) == mo.load(toml)


SQUARE = mo.Block(name="A", vertices=[(0, 0), (1, 0), (1, 1), (0, 1)], weight=1, live=(1, 0))
APART = [(4, 0), (5, 0), (5, 1)]
AROUND = [(-4, 0), (-1, 0), (-1, 3)]
HOLE = [(-2, 1), (-1.5, 1), (-1.5, 1.2)]


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
    "parts": on_floor(mo.Block(name="A", parts=[SQUARE.vertices, APART], weight=1, live_per_weight=(1, 0))),
    "a hole": on_floor(mo.Block(name="B", vertices=AROUND, holes=[HOLE], weight=1, live=(1, 0))),
    "loads": on_floor(
        SQUARE,
        edge_loads=[
            mo.EdgeLoad(start=(0, 0), end=(0, 1), pressure=(2, 0)),
            mo.EdgeLoad(start=(0, 1), end=(1, 1), force=(0, -1), kind="live"),
        ],
        loads=[mo.Load(block="A", dead=(0, -1), at=(0.5, 1))],
    ),
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


def test_a_written_file_has_a_point_on_each_line_and_names_as_they_are(tmp_path):
    upper = mo.Block(name="[up], {b}", vertices=[(0, 1), (1, 1), (1, 2), (0, 2)], weight=1)
    pairs = [("two  spaces, a", "floor"), ("two  spaces, a", "[up], {b}")]
    joints = [mo.Joint(between=pair, friction=0.1) for pair in pairs]
    scene = on_floor(SQUARE.replace(name="two  spaces, a"), upper, exceptions=joints)
    mo.save(scene, tmp_path / "case.toml")
    assert mo.load(tmp_path / "case.toml") == scene
    lines = (tmp_path / "case.toml").read_text("utf-8").splitlines()
    assert "    [0.0, 1.0]," in lines
    assert 'between = ["two  spaces, a", "floor"]' in lines


def test_wall_generator_expands_courses_gaps_and_repeats():
    courses = {"courses": ["u", [1, 1, 1]], "course": {"u": [0.5, 1, -1, 0.5]}, "repeat": 2}
    wall = mo.Wall(block=(4, 2), weight=3, live=(0.5, 0), **courses)
    blocks = {block.name: block for block in wall.blocks()}
    assert list(blocks) == [*(f"{row}-{number}" for row in range(1, 5) for number in range(1, 4)), "base"]
    assert blocks["1-3"].vertices == [(10, 0), (12, 0), (12, 2), (10, 2)]
    assert blocks["1-3"].weight == 1.5
    assert blocks["1-3"].live_per_weight == (0.5, 0)
    assert blocks["4-1"].vertices[0] == (0, 6)
    assert blocks["base"].fixed


def test_a_file_that_cannot_be_written_leaves_the_old_one(tmp_path):
    path = tmp_path / "case.toml"
    path.write_text("old")
    with full_from(0), pytest.raises(mo.CaseError, match="cannot be written: File too large"):
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


WALL = "[joints]\nfriction = 0.5\n[wall]\nblock = [4, 1]\nweight = 1\n"
BESIDE = '[[block]]\nname = "B"\nvertices = [[0.9, 0], [1.9, 0], [1.9, 1], [0.9, 1]]\nweight = 1\n'
TIE = '[[tie]]\nbetween = ["A", "ground"]\nat = [[0, 1]]'
JOINT = '[[joint]]\nbetween = ["A", "{}"]\n'
FALLS = JOINT.format("base") + "dilatancy_stress = [2, 1]"
COURSES = 'courses = ["H"]\ncourse = { G = [1] }'

#: A text in a valid case file, its replacement, and words of the error message. If the text is empty, the
#: replacement is appended.
WRONG_CASES = {
    "duplicate name": ('"base"', '"A"', ["no. 1 and no. 2", "'A'", "rename"]),
    "infinite": ("[1.0, 0.0]", "[inf, 0.0]", ["block no. 1 ('A')", "live[0]", "inf"]),
    "two vertices": (", [1, 1], [0, 1]", "", ["block no. 1 ('A')", "'vertices'", "at least 3"]),
    "negative friction": ("0.6", "-0.6", ["[joints]", "'friction'", "zero or more", "-0.6"]),
    "TOML syntax": ("", "x = = 1", ["not valid TOML", "line 13"]),
    "unknown key": ("weight", "wieght", ["block no. 1 ('A')", "'wieght'", "did you mean 'weight'"]),
    "a key by its name in Python": ("[[block]]", "[[blocks]]", ["'blocks'", "did you mean 'block'"]),
    "unknown table": ("", "[joins]\nx = 1", ["unknown key 'joins'", "did you mean"]),
    "wrong type": ("weight = 1.0", 'weight = "1"', ["block no. 1 ('A')", "'weight'", "number"]),
    "NaN": ("[1, 1]", "[1, nan]", ["block no. 1 ('A')", "vertices[2][1]", "nan"]),
    "huge": ("[1, 1]", "[1, 1e300]", ["vertices[2][1]", "1e+300"]),
    "overlap": ("", BESIDE, ["'A' and 'B' overlap", "move the blocks apart"]),
    "no fixed block": ("fixed = true", "weight = 1", ["no block is fixed", "fixed = true"]),
    "load on a support": (
        "",
        "live = [1.0, 0.0]",
        ["block no. 2 ('base')", "fixed block must have no loads"],
    ),
    "no weight": ("weight = 1.0", "", ["block no. 1 ('A')", "'weight' or 'unit_weight'"]),
    "friction beyond any": ("0.6", "1e9", ["[joints]", "'friction'", "write inf"]),
    "single brackets": ("", '[joint]\nbetween = ["A", "base"]', ["[joint]", "double brackets"]),
    "one coordinate": ("[1, 1]", "[1]", ["vertices[2]", "two numbers"]),
    "joint of one block": ("", '[[joint]]\nbetween = ["A"]', ["'between'", "names of two blocks"]),
    "tie with one end": ("", TIE, ["'at'", "two entries"]),
    "joint of unknown block": ("", JOINT.format("bas"), ["no block is named 'bas'", "did you mean 'base'"]),
    "stresses of a joint that fall": ("", FALLS, ["joint between ['A', 'base']", "'dilatancy_stress'"]),
    "no block": (GOOD, "[joints]\nfriction = 0.5", ["no block"]),
    "empty": (GOOD, "", ["[joints]", "missing"]),
    "wall without blocks": (GOOD, WALL + "courses = [[-1]]", ["[wall]", "course no. 1", "gaps only"]),
    "wall with an unknown course": (GOOD, WALL + COURSES, ["[wall]", "no course is named 'H'", "G"]),
}


def test_a_misspelt_key_is_not_reported_as_missing_too(tmp_path):
    arch = (
        "[joints]\nfriction = 0.6\n[arch]\nspan = 6\nrise = 1.5\nthickness = {}\n{} = 25\nunit_weight = 22\n"
    )
    path = tmp_path / "case.toml"
    path.write_text(arch.format(0.5, "vousoirs"))
    with pytest.raises(mo.CaseError, match="unknown key 'vousoirs'; did you mean 'voussoirs'") as error:
        mo.load(path)
    assert "missing" not in str(error.value)
    path.write_text(arch.format(500, "voussoirs"))
    with pytest.raises(mo.CaseError, match=r"'thickness' is 83\.3 times the span"):
        mo.load(path)


@pytest.mark.parametrize(("thickness", "is_refused"), [(17.9, False), (18.1, True)])
def test_an_arch_thicker_than_three_spans_is_refused(thickness, is_refused):
    """The arch has a span of 6 and a radius of 18.3."""
    keys = {"span": 6, "rise": 0.25, "thickness": thickness, "voussoirs": 25, "unit_weight": 22}
    if is_refused:
        with pytest.raises(mo.CaseError, match=r"'thickness' is 3\.02 times the span"):
            mo.Arch(**keys)
    else:
        assert mo.Arch(**keys).thickness == thickness


@pytest.mark.parametrize("name", WRONG_CASES)
def test_wrong_case_file(name, tmp_path, monkeypatch, capsys):
    old, new, expected = WRONG_CASES[name]
    path = tmp_path / "case.toml"
    path.write_text(GOOD.replace(old, new) if old else GOOD + new)
    code, out, err = run_command(monkeypatch, capsys, "solve", path)
    assert code == 2
    assert out == ""
    assert str(path) in err
    assert "Traceback" not in err
    for words in expected:
        assert words in err


@pytest.mark.parametrize(
    ("name", "content", "words"),
    [
        ("missing.toml", None, "no such file"),
        ("folder.toml", ..., "is a folder"),
        ("list.json", b"[1]", "single JSON object"),
        ("broken.json", b"{", "not valid JSON"),
        ("table.json", b'{"joints": [1]}', "must be a table"),
        ("twice.json", b'{"joints": {"friction": 0.1, "friction": 0.9}}', "'friction' occurs twice"),
        ("case.yaml", b"", ".toml or .json"),
    ],
)
def test_unreadable_file(name, content, words, tmp_path, monkeypatch, capsys):
    path = tmp_path / name
    if content is ...:
        path.mkdir()
    elif content is not None:
        path.write_bytes(content)
    code, out, err = run_command(monkeypatch, capsys, "solve", path)
    assert (code, out) == (2, "")
    assert str(path) in err
    assert words in err
    assert "Traceback" not in err


@pytest.mark.parametrize(
    ("option", "words"),
    [
        (["-o", "beta=0.5"], "no option 'beta'"),
        (["--method", "magic"], "choose from: static"),
        (["--plot", "picture.gif"], ".png"),
        (["--plot", "/no/such/folder/picture.png"], "cannot be written"),
        (["--plot", "picture.png", "--plot-kind", "stress"], "mechanism, thrust, utilisation, curve"),
        (["--plot", "picture.png", "--plot-kind", "curve"], "--option curve=true"),
        (["--plot", "picture.png", "--plot-kind", "curve", "--names"], "names"),
        (["--plot-kind", "thrust"], "--plot FILE"),
        (["--names"], "--plot FILE"),
    ],
)
def test_wrong_option(option, words, tmp_path, monkeypatch, capsys):
    path = tmp_path / "case.toml"
    path.write_text(GOOD)
    code, out, err = run_command(monkeypatch, capsys, "solve", path, *option)
    assert (code, out) == (2, "")
    assert words in err
    assert "Traceback" not in err

"""Bad input ends with one clear message and exit code 1 or 2: never a traceback, never a number."""

import json

import pytest
from scenes import GOOD, run_command

WALL = "[joints]\nfriction = 0.5\n[wall]\nblock = [4, 1]\nweight = 1\n"
BESIDE = '[[block]]\nname = "B"\nvertices = [[0.9, 0], [1.9, 0], [1.9, 1], [0.9, 1]]\nweight = 1\n'


WRONG_CASES = {
    "duplicate name": (GOOD.replace('"base"', '"A"'), ["no. 1 and no. 2", "'A'", "rename"]),
    "infinite": (GOOD.replace("[1.0, 0.0]", "[inf, 0.0]"), ["block no. 1 ('A')", "live[0]", "inf"]),
    "two vertices": (GOOD.replace(", [1, 1], [0, 1]", ""), ["block no. 1 ('A')", "'vertices'", "at least 3"]),
    "negative friction": (GOOD.replace("0.6", "-0.6"), ["[joints]", "'friction'", "zero or more", "-0.6"]),
    "TOML syntax": (GOOD + "x = = 1", ["not valid TOML", "line 13"]),
    "unknown key": (
        GOOD.replace("weight", "wieght"),
        ["block no. 1 ('A')", "'wieght'", "did you mean 'weight'"],
    ),
    "a key by its name in Python": (
        GOOD.replace("[[block]]", "[[blocks]]"),
        ["'blocks'", "did you mean 'block'"],
    ),
    "unknown table": (GOOD + "[joins]\nx = 1", ["unknown key 'joins'", "did you mean"]),
    "wrong type": (GOOD.replace("weight = 1.0", 'weight = "1"'), ["block no. 1 ('A')", "'weight'", "number"]),
    "NaN": (GOOD.replace("[1, 1]", "[1, nan]"), ["block no. 1 ('A')", "vertices[2][1]", "nan"]),
    "huge": (GOOD.replace("[1, 1]", "[1, 1e300]"), ["vertices[2][1]", "1e+300"]),
    "overlap": (GOOD + BESIDE, ["'A' and 'B' overlap", "move them apart"]),
    "no fixed block": (GOOD.replace("fixed = true", "weight = 1"), ["no block is fixed", "fixed = true"]),
    "no live load": (GOOD.replace("live = [1.0, 0.0]", ""), ["no block carries a live load", "live"]),
    "live load on a support": (
        GOOD + "live = [1.0, 0.0]\n",
        ["block no. 2 ('base')", "fixed block carries no load"],
    ),
    "no weight": (GOOD.replace("weight = 1.0", ""), ["block no. 1 ('A')", "'weight' or 'unit_weight'"]),
    "friction beyond any": (GOOD.replace("0.6", "1e9"), ["[joints]", "'friction'", "write inf"]),
    "single brackets": (GOOD + '[joint]\nbetween = ["A", "base"]', ["[joint]", "double brackets"]),
    "one coordinate": (GOOD.replace("[1, 1]", "[1]"), ["vertices[2]", "two numbers"]),
    "joint of one block": (GOOD + '[[joint]]\nbetween = ["A"]', ["'between'", "names of two blocks"]),
    "tie with one end": (GOOD + '[[tie]]\nbetween = ["A", "ground"]\nat = [[0, 1]]', ["'at'", "two entries"]),
    "joint of unknown block": (
        GOOD + '[[joint]]\nbetween = ["A", "bas"]',
        ["no block 'bas'", "did you mean 'base'"],
    ),
    "stresses of a joint that fall": (
        GOOD + '[[joint]]\nbetween = ["A", "base"]\ndilatancy_stress = [2, 1]',
        ["joint between ['A', 'base']", "'dilatancy_stress'"],
    ),
    "no block": ("[joints]\nfriction = 0.5", ["no block"]),
    "empty": ("", ["[joints]", "missing"]),
    "wall without blocks": (WALL + "courses = [[-1]]", ["[wall]", "course no. 1", "no block"]),
    "wall with an unknown course": (
        WALL + 'courses = ["H"]\ncourse = { G = [1] }',
        ["[wall]", "no course is named 'H'", "G"],
    ),
}


@pytest.mark.parametrize("name", WRONG_CASES)
def test_wrong_case_file(name, tmp_path, monkeypatch, capsys):
    text, expected = WRONG_CASES[name]
    path = tmp_path / "case.toml"
    path.write_text(text)
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
        ("list.json", b"[1]", "one JSON object"),
        ("broken.json", b"{", "not valid JSON"),
        ("table.json", b'{"joints": [1]}', "must be a table"),
        ("twice.json", b'{"joints": {"friction": 0.1, "friction": 0.9}}', "'friction' is given twice"),
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
        (["--solver", "mosek"], "takes solver: newton (found 'mosek')"),
        (["--solver", "newton", "--model", "pyomo", "--method", "static"], "with model 'matrices': mcp"),
        (["--tolerance", "1e-6"], "leave 'tolerance' out"),
        (["-o", "beta=0.5"], "no option 'beta'"),
        (["--model", "ampl"], "choose from: cvxpy, pyomo"),
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


# The block hangs over the edge of its support, pushed over and pushed back; falls where nothing
# holds it; is pressed down only; is held in a slot that its own dilatancy jams, friction unlimited.
OVER_THE_EDGE = GOOD.replace("[[0, 0], [1, 0], [1, 1], [0, 1]]", "[[7.7, 0], [10.7, 0], [10.7, 1], [7.7, 1]]")
ROOF = '[[block]]\nname = "roof"\nvertices = [[-4, 1], [9, 1], [9, 2], [-4, 2]]\nfixed = true\n'
NO_LOAD_FACTOR = {
    "falls": (OVER_THE_EDGE, "unstable under dead load", ["'A'", "support"]),
    "falls, though a live load could hold it": (
        OVER_THE_EDGE.replace("live = [1.0", "live = [-1.0"),
        "unstable under dead load",
        ["'A'"],
    ),
    "pressed down": (
        GOOD.replace("live = [1.0, 0.0]", "live = [0.0, -1.0]"),
        "unlimited: the live load cannot cause collapse",
        ["live"],
    ),
    "cannot move": (
        GOOD.replace("friction = 0.6", "friction = inf") + ROOF,
        "unlimited: the live load cannot cause collapse",
        ["no mechanism"],
    ),
}


@pytest.fixture
def solved(tmp_path, monkeypatch, capsys):
    """Solves the text of a case file, with options; gives the exit code and what is printed as JSON."""

    def run(text, *options):
        path = tmp_path / "case.toml"
        path.write_text(text)
        code, out, _ = run_command(monkeypatch, capsys, "solve", path, *options, "--json")
        return code, json.loads(out)

    return run


@pytest.mark.parametrize("method", ["static", "kinematic", "nonassociative", "mcp"])
@pytest.mark.parametrize("name", NO_LOAD_FACTOR)
def test_scene_without_load_factor(name, method, solved):
    text, status, expected = NO_LOAD_FACTOR[name]
    code, answer = solved(text, "--method", method)
    assert code == 1
    assert (answer["status"], answer["load_factor"], answer["certificate"]) == (status, None, None)
    for words in expected:
        assert words in answer["message"]


def test_dilatancy_that_locks_is_told_from_a_load_that_cannot_act(solved):
    code, answer = solved(GOOD + ROOF, "--method", "static")
    assert (code, answer["status"]) == (1, "unlimited: dilatancy locks the blocks")
    code, answer = solved(GOOD + ROOF, "--method", "nonassociative")
    assert (code, answer["load_factor"]) == (0, pytest.approx(0.6, rel=1e-7))
    assert (answer["reasons"][0]["code"], answer["reasons"][0]["remedies"]) == (
        "began again",
        ["start=cohesive"],
    )
    # The roof may press on the block as it likes, λ = μ (1 + 2 n): a pass ends near the least, at 0.6007.
    code, answer = solved(GOOD + ROOF, "--method", "mcp")
    assert code == 0
    assert 0.6 * (1 - 1e-7) <= answer["load_factor"] <= 0.6 * (1 + 5e-3)
    assert solved(GOOD + ROOF)[0] == 0

"""Tests of the advice in messages of refusals: each test follows the advice, which must work."""

import re
import shlex

import pytest
from scenes import CASES, axles_on_a_beam, block_on_floor, two_blocks

import masonry_opt as mo

DRAWN = ("--friction", "0.6", "--unit-weight", "20")
TIED = CASES / "closed_forms" / "anchor_plate.toml"
FILLED = CASES / "bridges" / "arch_with_fill.toml"


def advised(message):
    """Return the commands that a message quotes in parentheses, as lists of arguments."""
    return [shlex.split(found) for found in re.findall(r"\(masonry-opt ([^)]*)\)", message)]


#: Wrong arguments, a part of the expected advice, and the arguments corrected by this advice.
SLIPS = {
    "name of the file": (["solve", "ston.toml"], "did you mean 'stone.toml'?", ["solve", "stone.toml"]),
    "ending of the file": (["solve", "stone"], "did you mean 'stone.toml'?", ["solve", "stone.toml"]),
    "folder": (["solve", "a/stone.toml"], "the folder a does not exist", ["solve", "stone.toml"]),
    "option of the method": (
        ["solve", "stone.toml", "--search", "0.1"],
        "written as -o search=VALUE",
        ["solve", "stone.toml", "-o", "search=0.1"],
    ),
    "unit": (
        ["solve", "stone.toml", "--time-limit", "1min"],
        "write one number without a unit",
        ["solve", "stone.toml", "--time-limit", "60"],
    ),
    "decimal comma": (
        ["least", "stone.toml", "--vary", "joints.friction=0.1:1", "--method", "static", "--load", "0,5"],
        "with a point before decimals",
        ["least", "stone.toml", "--vary", "joints.friction=0.1:1", "--method", "static", "--load", "0.5"],
    ),
    "two numbers": (
        ["settle", "stone.toml", "--support", "floor", "--method", "static", "--direction", "0", "-1"],
        "with commas and without spaces, such as 0,-1",
        ["settle", "stone.toml", "--support", "floor", "--method", "static", "--direction", "0,-1"],
    ),
    "quotation marks": (
        ["report", "stone.toml", "--method", "static", "--units", "m,", "kN"],
        "enclose text that contains spaces in quotation marks",
        ["report", "stone.toml", "--method", "static", "--units", "m, kN"],
    ),
    "no load case": (
        ["solve", "stone.toml", "--load-case", "wind"],
        "the scene has no load cases, so 'wind' cannot be chosen: omit the name",
        ["solve", "stone.toml"],
    ),
    "decimal comma in a file": (
        ["solve", "comma.toml"],
        "write numbers with a decimal point",
        ["solve", "stone.toml"],
    ),
}


@pytest.mark.parametrize(("typed", "advice", "followed"), SLIPS.values(), ids=SLIPS)
def test_a_slip_of_the_command_line_is_answered_with_its_remedy(
    command, monkeypatch, tmp_path, typed, advice, followed
):
    monkeypatch.chdir(tmp_path)
    mo.save(block_on_floor(friction=0.65), "stone.toml")
    content = (tmp_path / "stone.toml").read_text("utf-8")
    assert "friction = 0.65" in content
    (tmp_path / "comma.toml").write_text(content.replace("0.65", "0,65"), "utf-8")
    assert advice in re.sub(r"[\s│]+", " ", command.refused(*typed))
    command(*followed)


def test_supports_of_a_drawing_are_on_their_layer(command, tmp_path):
    drawing, case = tmp_path / "blocks.dxf", tmp_path / "case.toml"
    mo.write_dxf(two_blocks(), drawing)
    error = command.refused("convert", drawing, case, *DRAWN, "--fixed", "support")
    assert "does not take --fixed: draw supports on a layer with 'fixed' in its name, or use" in error
    command("convert", drawing, case, *DRAWN, "--fixed-layer", "fixed")
    assert [block.name for block in mo.load(case).blocks if block.fixed]


@pytest.mark.parametrize("scene", [two_blocks(), mo.extrude(block_on_floor(), 1.0)], ids=["plane", "space"])
def test_a_case_file_is_not_converted(command, monkeypatch, tmp_path, scene):
    monkeypatch.chdir(tmp_path)
    mo.save(scene, "case.toml")
    solve, draw = advised(command.refused("convert", "case.toml", "other.toml"))
    command(*solve, "--method", "static")
    command(*draw)
    assert (tmp_path / draw[-1]).exists()


def test_a_file_that_cannot_be_read_is_refused_before_its_options(command, tmp_path):
    """The message does not ask for the options of a drawing if the file is not a drawing."""
    (tmp_path / "notes.md").write_text("# a wall")
    error = command.refused("convert", tmp_path / "notes.md", tmp_path / "case.toml")
    assert "only drawings (.dxf), meshes (" in error
    assert "--friction" not in error


def test_all_options_that_a_drawing_needs_are_named_at_once(command, tmp_path):
    drawing = tmp_path / "blocks.dxf"
    mo.write_dxf(two_blocks(), drawing)
    error = command.refused("convert", drawing, tmp_path / "case.toml")
    assert [option for option in DRAWN if option.startswith("--") and option in error] == [*DRAWN[::2]]
    command("convert", drawing, tmp_path / "case.toml", *DRAWN)


def test_a_capacity_curve_needs_a_scene_without_ties(command):
    error = command.refused("capacity", TIED, "--method", "static")
    assert (
        "cannot take account of [[tie]] 'rod': omit it, or use 'solve' to compute only the load factor"
        in error
    )
    assert mo.capacity(mo.solve(mo.load(TIED).replace(ties=[]), "static")).steps
    command("solve", TIED, "--method", "static")


def test_a_capacity_curve_is_refused_before_the_scene_is_solved(monkeypatch, tmp_path, command):
    """Joints of limited strength prevent the curve, and the joints alone show it."""
    case = tmp_path / "weak.toml"
    scene = block_on_floor()
    mo.save(scene.replace(joints=scene.joints.replace(strength=2e6)), case)
    monkeypatch.setattr(mo, "solve", None)
    assert "cannot take account of limited 'strength' of joints" in command.refused("capacity", case)


@pytest.mark.parametrize(
    ("wrong", "message"),
    [
        (("--block", "nobody"), "block: there is no movable block 'nobody'"),
        (("--point", "0,1"), "a control point belongs to a block"),
        (("--steps", "1"), "steps must be a whole number, at least 2 (found 1)"),
    ],
)
def test_wrong_arguments_of_a_capacity_curve_are_refused_before_the_scene_is_solved(
    monkeypatch, tmp_path, command, wrong, message
):
    case = tmp_path / "block.toml"
    mo.save(block_on_floor(), case)
    monkeypatch.setattr(mo, "solve", None)
    assert message in command.refused("capacity", case, *wrong)


@pytest.mark.parametrize("pressure", [True, False])
def test_a_capacity_curve_needs_a_scene_without_fill(pressure):
    """A single message covers fill that presses and fill that only weighs: its advice leads to a curve."""
    scene = mo.load(FILLED)
    filled = scene if pressure else scene.replace(fills=[scene.fills[0].replace(pressure=False)])
    omitted = r"\[\[fill\]\]: omit it" if pressure else r"omit \[\[fill\]\]"
    with pytest.raises(mo.OptionError, match=f"{omitted}, or use 'solve' to compute only the load factor"):
        mo.capacity(mo.solve(filled, "static"))
    assert mo.capacity(mo.solve(scene.replace(fills=[]), "static")).steps


def least(command, path, ends, *more, code=2):
    asked = ("least", path, "--vary", f"joints.friction={ends}", *more)
    return command.refused(*asked, code=code) if code else command(*asked)


@pytest.mark.slow
def test_where_a_scene_stands_at_every_value_a_load_factor_shows_the_least(command, tmp_path):
    """A smaller value is advised only if a scene exists for it: a friction cannot be negative."""
    mo.save(two_blocks(), tmp_path / "case.toml")
    error = least(command, tmp_path / "case.toml", "0.2:0.9")
    assert "begin the range at a smaller value" in error
    assert "'load' (--load)" in error
    error = least(command, tmp_path / "case.toml", "0:0.9")
    assert "smaller value" not in error
    assert "'load' (--load)" in error
    output = least(command, tmp_path / "case.toml", "0:0.9", "--load", "0.2", "--method", "static", code=0)
    assert "λ is" in output


def test_a_function_that_fails_outside_of_the_range_is_no_error():
    def scene(friction):
        return two_blocks(friction if friction >= 0.2 else 1 / 0)

    with pytest.raises(mo.OptionError, match=r"intermediate values\): set 'load'"):
        mo.least(scene, 0.2, 0.9, samples=0)


def test_a_load_factor_is_not_advised_without_a_live_load(command, tmp_path):
    path = tmp_path / "none.toml"
    mo.save(block_on_floor(live=(0.0, 0.0)), path)
    error = least(command, path, "0.2:0.9")
    assert "--load" not in error
    assert "begin the range at a smaller value" in error
    # If a load is given, the message says what the search tests without a load.
    assert "without 'load' (--load) the search tests stability under dead load only" in least(
        command, path, "0.2:0.9", "--load", "0.2"
    )


def test_a_load_factor_is_advised_where_axles_move(command, tmp_path):
    """The search moves the axles of a scene only if a load factor is given."""
    path = tmp_path / "axles.toml"
    mo.save(axles_on_a_beam(0.6), path)
    assert "without 'load', live loads are ignored" in least(command, path, "0.2:0.9")


@pytest.mark.slow
def test_most_and_least_name_each_other_as_the_command_has_them(command, tmp_path):
    """The more a block is pushed by its weight, the smaller is its λ: 'least' advises 'most', and the
    reverse."""
    mo.save(block_on_floor(), tmp_path / "case.toml")
    asked = ("least", tmp_path / "case.toml", "--method", "static", "--load", "0.5")
    pushed = ("--vary", "block.A.live.x=0.1:3")
    assert "use 'most' (--most)" in command.refused(*asked, *pushed)
    command(*asked, *pushed, "--most")
    rubbed = ("--vary", "joints.friction=0.1:0.6")
    assert "(the command without --most)" in command.refused(*asked, *rubbed, "--most")
    command(*asked, *rubbed)

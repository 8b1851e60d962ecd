"""Tests of scenes without live load: whether they are stable, and with what reserves, in the plane and in
space.

The values in the docstrings are by hand. They are the same for all units of length and force, and for all
rotations and reflections.
"""

import json
import math
import re
from pathlib import Path

import numpy as np
import pytest
from speeds import slow
from typer.testing import CliRunner

import masonry_opt as mo
from masonry_opt.cli.app import app
from masonry_opt.errors import NoLoadFactorError
from masonry_opt.problem.assembly import assemble
from masonry_opt.reporting.page import headline
from masonry_opt.solution.stability import are_resultants_unique

#: Tolerance of values by bisection, which ends at a relative difference of 2e-4.
BISECTED = 3e-4

FLOOR = [(-9, -1), (9, -1), (9, 0), (-9, 0)]


def rotated(points, angle, mirrored=False):
    c, s = math.cos(angle), math.sin(angle)
    turned = [(c * x - s * y, s * x + c * y) for x, y in points]
    return [(-x, y) for x, y in turned][::-1] if mirrored else turned


def ramp(angle, friction=0.6, size=1.0, weight=2.0, mirrored=False, width=2.0, height=1.0):
    """Return a block of the given width and height on a slope."""
    corners = [(-width / 2, 0), (width / 2, 0), (width / 2, height), (-width / 2, height)]
    floor, block = (
        [(size * x, size * y) for x, y in rotated(shape, angle, mirrored)] for shape in (FLOOR, corners)
    )
    blocks = [mo.Block(name="slope", vertices=floor, fixed=True)]
    blocks.append(mo.Block(name="block", vertices=block, weight=weight))
    return mo.Scene(joints={"friction": friction}, blocks=blocks)


@pytest.mark.parametrize("method", ["coulomb", "incremental", "static", "kinematic", "nonassociative"])
def test_a_stack_of_bricks_is_stable_with_every_method(method):
    """In a stack of 26 bricks, the forces are the weights above, and all act at the middles of the joints."""
    wall = mo.Wall(block=(0.215, 0.077), courses=[[1]], repeat=26, unit_weight=19)
    result = mo.solve(mo.Scene(joints={"friction": 0.6}, blocks=wall.blocks()), method)
    assert (result.status, result.usable, result.load_factor) == ("stable", True, None)
    weight = 0.215 * 0.077 * 19
    assert sorted(result.joints["n"]) == pytest.approx(weight * np.arange(1, 27), rel=1e-9)
    stability = result.stability
    assert stability.unique
    assert max(stability.equilibrium, stability.yield_) < 1e-9
    assert stability.least_friction == stability.least_friction_factor == 0
    assert stability.geometric_margin == 1
    assert stability.worst_joint.distance == pytest.approx(0.215 / 2, rel=1e-6)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("degrees", "size", "weight", "mirrored"),
    [(20, 1, 2, False), (28, 1e-3, 5e4, True), (5, 300, 1e-3, False)],
)
def test_a_block_on_a_slope_needs_the_tangent(degrees, size, weight, mirrored):
    """The least friction is tan α. The resultant acts (h / 2) tan α from the middle of the joint."""
    slope = math.tan(math.radians(degrees))
    result = mo.solve(ramp(math.radians(degrees), 0.6, size, weight, mirrored))
    stability = result.stability
    assert stability.least_friction == pytest.approx(slope, rel=BISECTED)
    assert stability.least_friction_factor == pytest.approx(slope / 0.6, rel=BISECTED)
    assert stability.geometric_margin == pytest.approx(1 - slope / 2, abs=BISECTED)
    assert stability.worst_joint.margin == pytest.approx(1 - slope / 2, rel=1e-6)
    assert stability.worst_joint.distance == pytest.approx(size * (1 - slope / 2), rel=1e-6)


@pytest.mark.parametrize("degrees", [*slow(5), 17])
def test_the_printed_least_friction_is_not_below_the_true_one(degrees):
    """The block slides with less friction than tan α. The number is printed with four digits.

    For 17° the nearest number with four digits is below tan α.
    """
    (line,) = re.findall("least friction +([0-9.]+);", str(mo.solve(ramp(math.radians(degrees)))))
    slope = math.tan(math.radians(degrees))
    assert slope <= float(line) < slope * (1 + BISECTED) + 1e-4


def test_a_block_on_too_steep_a_slope_is_unstable():
    """tan 35° = 0.700 > 0.6: the block slides, and 1.1671 times the friction holds it."""
    result = mo.solve(ramp(math.radians(35)))
    assert (result.status, result.usable, result.stability) == ("unstable under dead load", False, None)
    assert str(result).splitlines()[1] == "unstable under dead load"
    assert "unstable under dead load" in headline(result)  # no live load acts, so no load factor is asked for
    assert "at least 1.168 times as high" in result.message


def test_an_overhanging_brick_names_the_worst_joint():
    """The weight of the upper two of three bricks acts 0.1 from the end of the joint below, which is 0.8
    long."""
    blocks = [mo.Block(name="floor", vertices=FLOOR, fixed=True)]
    for name, x, y in (("a", 0.0, 0.0), ("b", 0.2, 0.3), ("c", 0.6, 0.6)):
        corners = [(x, y), (x + 1, y), (x + 1, y + 0.3), (x, y + 0.3)]
        blocks.append(mo.Block(name=name, vertices=corners, weight=3))
    stability = mo.solve(mo.Scene(joints={"friction": 0.6}, blocks=blocks)).stability
    assert (stability.worst_joint.first, stability.worst_joint.second) == ("a", "b")
    assert stability.worst_joint.distance == pytest.approx(0.1, abs=1e-6)
    assert stability.worst_joint.margin == pytest.approx(0.25, abs=1e-6)
    assert stability.geometric_margin == pytest.approx(0.25, abs=BISECTED)


@pytest.mark.slow
@pytest.mark.parametrize("method", ["coulomb", "static"])
def test_an_arch_fits_its_least_thickness(method):
    """The geometric margin of an arch agrees with its least thickness.

    A semicircular arch needs t/R = 0.1075 (Milankovitch), and one of 27 voussoirs needs 0.10678
    (``mo.least``). An arch of t/R = 0.15 therefore remains stable if its joints shrink to 0.7119 of their
    length.
    """
    arch = mo.Arch(radius=10, angles=(180, 0), thickness=1.5, voussoirs=27, unit_weight=1)
    result = mo.solve(mo.Scene(joints={"friction": 0.7}, blocks=arch.blocks()), method)
    assert not result.stability.unique
    assert 1 - result.stability.geometric_margin == pytest.approx(1.0678 / 1.5, abs=1e-3)
    assert "one of many sets of forces" in result.message


@pytest.mark.slow
def test_the_least_friction_is_a_factor_if_joints_differ():
    """On slopes of 20° and 10°, the first joint needs tan 20° of its 0.5, and the second less of its 0.4."""
    first, second = ramp(math.radians(20), 0.5), ramp(math.radians(10), 0.5)
    moved = [
        block.replace(name=f"other {block.name}", vertices=[(x + 40, y) for x, y in block.vertices])
        for block in second.blocks
    ]
    other = mo.Joint(between=("other slope", "other block"), friction=0.4)
    scene = first.replace(blocks=[*first.blocks, *moved], exceptions=[other])
    stability = mo.solve(scene).stability
    assert stability.least_friction is None
    assert stability.least_friction_factor == pytest.approx(math.tan(math.radians(20)) / 0.5, rel=BISECTED)


def solid(name, low, high, turned=0.0, **keys):
    corners = [(x, y, z) for z in (low[2], high[2]) for y in (low[1], high[1]) for x in (low[0], high[0])]
    c, s = math.cos(turned), math.sin(turned)
    corners = [(c * x - s * z, y, s * x + c * z) for x, y, z in corners]
    faces = [(0, 2, 3, 1), (4, 5, 7, 6), (0, 1, 5, 4), (2, 6, 7, 3), (0, 4, 6, 2), (1, 3, 7, 5)]
    return mo.Solid(name=name, vertices=corners, faces=faces, **keys)


@pytest.mark.slow
@pytest.mark.parametrize("method", ["coulomb", "static"])
def test_a_brick_in_space_overhangs_in_two_directions(method):
    """The margins of a brick that overhangs in two directions agree with hand calculation.

    Brick b covers a on 1.4 × 0.8, and its weight acts 0.4 and 0.3 from the nearest two edges. The weight is
    0.3 and 0.1 from the middle of the joint: margins 1 - 0.3 / 0.7 and 1 - 0.1 / 0.4.
    """
    blocks = [solid("floor", (-5, -5, -1), (5, 5, 0), fixed=True), solid("a", (0, 0, 0), (2, 1, 1), weight=1)]
    blocks.append(solid("b", (0.6, 0.2, 1), (2.6, 1.2, 2), weight=1))
    result = mo.solve(mo.Scene(joints={"friction": 0.5}, blocks=blocks), method)
    assert result.status == "stable"
    assert result.stability.unique
    assert result.stability.worst_joint.margin == pytest.approx(4 / 7, abs=1e-6)
    assert result.stability.worst_joint.distance == pytest.approx(0.3, abs=1e-6)
    assert result.stability.geometric_margin == pytest.approx(4 / 7, abs=BISECTED)


@pytest.mark.slow
def test_a_solid_on_a_slope_needs_the_tangent():
    """The least friction of a solid, with the cone of friction, is tan 25°, as in the plane."""
    angle = math.radians(25)
    blocks = [solid("slope", (-5, -5, -1), (5, 5, 0), angle, fixed=True)]
    blocks.append(solid("block", (-1, -1, 0), (1, 1, 1), angle, weight=3))
    stability = mo.solve(mo.Scene(joints={"friction": 0.6}, blocks=blocks)).stability
    assert stability.least_friction == pytest.approx(math.tan(angle), rel=BISECTED)
    assert stability.geometric_margin == pytest.approx(1 - math.tan(angle) / 2, abs=BISECTED)


def squeezed(friction=0.5):
    """Return a stone between two fixed stones, with no force that presses them together."""
    blocks = [
        mo.Block(name=name, vertices=[(x, 0), (x + 1, 0), (x + 1, 1), (x, 1)], **keys)
        for name, x, keys in (
            ("left", -1, {"fixed": True}),
            ("stone", 0, {"weight": 1}),
            ("right", 1, {"fixed": True}),
        )
    ]
    return mo.Scene(joints={"friction": friction}, blocks=blocks)


def test_a_stone_that_nothing_presses_is_unstable_from_rest_and_held_by_statics_alone():
    """Statics finds normal forces of W / 2μ at both sides. Contacts without forces at rest let the stone
    slide."""
    result = mo.solve(squeezed())
    assert result.status == "unstable under dead load"
    assert [reason.code for reason in result.reasons] == ["wedged"]
    by_statics = mo.solve(squeezed(), "static")
    assert by_statics.status == "stable"
    assert "self-stress" in by_statics.message
    assert "without friction" not in str(by_statics)
    with pytest.raises(NoLoadFactorError, match="no margin to compare"):
        mo.check(squeezed())


def test_without_any_load_the_message_says_what_to_give():
    scene = ramp(0.1, weight=0.0)
    with pytest.raises(mo.CaseError, match="no block carries a load: give the blocks a 'weight'"):
        mo.solve(scene)


@pytest.mark.slow
def test_studies_that_need_a_live_load_say_so(tmp_path):
    scene = ramp(0.1)
    mo.save(scene, tmp_path / "ramp.toml")
    with pytest.raises(mo.CaseError, match=r"no block carries a live load.*use 'solve' to decide if"):
        mo.compare(tmp_path / "ramp.toml", methods=["static"])
    with pytest.raises(mo.CaseError, match="no block carries a live load"):
        mo.prove_least(scene)
    with pytest.raises(mo.CaseError, match="no block carries a live load"):
        mo.export(scene, tmp_path / "ramp.lp")
    with pytest.raises(mo.OptionError, match="a capacity curve needs a live load"):
        mo.capacity(mo.solve(scene))
    with pytest.raises(NoLoadFactorError, match="the scene is stable, but it has no load factor"):
        mo.solve(scene).required()


def test_the_four_programs_agree_on_the_margin_of_a_stack():
    """The margin of one brick on the floor is its weight, by all four programs: one median block weight.

    The joint can lose this whole weight.
    """
    report = mo.check(ramp(0.0))
    assert report.passed
    assert report.table["load_factor"].to_list() == pytest.approx(4 * [1.0], abs=1e-7)
    assert "stable under its dead load" in str(report)


@pytest.fixture
def case(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    mo.save(ramp(math.radians(20)), "ramp.toml")
    mo.save(ramp(math.radians(40)), "steep.toml")
    return tmp_path


@pytest.mark.parametrize(
    ("name", "code", "status"),
    [pytest.param("ramp", 0, "stable", marks=pytest.mark.slow), ("steep", 1, "unstable")],
)
def test_commands_answer_with_status_and_exit_code(case, name, code, status):
    run = CliRunner().invoke(app, ["solve", f"{name}.toml", "--json"])
    answer = json.loads(run.stdout)
    assert run.exit_code == code
    assert answer["status"].partition(" ")[0] == status
    assert (answer["stability"] is None) == bool(code)
    drawn = CliRunner().invoke(app, ["solve", f"{name}.toml", "--plot", "ramp.svg"])
    assert drawn.exit_code == code
    assert code or "resultant" in Path("ramp.svg").read_text()
    reported = CliRunner().invoke(app, ["report", f"{name}.toml", "--out", "page.html"])
    assert reported.exit_code == code
    page = Path("page.html").read_text()
    assert "Stability:" in page
    assert "load factor" not in page.split("<h2>What was checked")[0]


@pytest.mark.slow
def test_pages_pictures_and_json_have_the_reserves(case):
    result = mo.solve("ramp.toml")
    for kind in ("mechanism", "thrust", "utilisation"):
        assert "stable under its dead load" in result.plot(kind).axes[0].get_title()
    result.save("ramp.html", "thrust")
    assert "stable under its dead load" in Path("ramp.html").read_text()
    result.save("page.html")
    (chosen,) = [line for line in Path("page.html").read_text().splitlines() if " checked" in line]
    assert 'value="thrust"' in chosen
    stability = result.as_dict()["stability"]
    assert stability["worst_joint"]["first"] == "slope"
    assert stability["least_friction"] == pytest.approx(math.tan(math.radians(20)), rel=BISECTED)


@pytest.mark.slow
@pytest.mark.parametrize(
    "options", [("--plot-kind", "mechanism"), ("--mechanism", "incremental"), ("--plot-kind", "curve")]
)
def test_a_stable_scene_has_no_mechanism_and_no_curve_to_draw(case, options):
    """The answer is printed, and the message names the available kinds of pictures."""
    with_curve = ["--method", "incremental", "-o", "curve=true"] if "curve" in options else []
    drawn = CliRunner().invoke(app, ["solve", "ramp.toml", "--plot", "no.png", *options, *with_curve])
    assert isinstance(drawn.exception, mo.OptionError)
    assert "stable under its dead load" in drawn.stdout
    assert re.search("thrust.*utilisation", str(drawn.exception))
    assert not Path("no.png").exists()


@pytest.mark.parametrize("order", [1, -1])
@pytest.mark.parametrize("wires", [1, 2])
def test_the_ground_is_no_block_of_a_scene_that_hangs_from_it(order, wires):
    """Resultants are unique on one wire, and not on two.

    A stack of two solids on one wire has no closed loop of connections; on two wires it has one.
    """
    blocks = [
        solid("lower", (-1, -1, 0), (1, 1, 1), weight=1),
        solid("upper", (-1, -1, 1), (1, 1, 2), weight=1),
    ]
    ties = [mo.Tie(between=("lower", "ground"), at=((x, 0, 0.5), (x, 0, 9))) for x in (0, 0.5)[:wires]]
    scene = mo.Scene(joints={"friction": 0.5}, blocks=blocks[::order], ties=ties)
    assert are_resultants_unique(assemble(scene)) == (wires == 1)

"""Tests of least and greatest values: closed forms, thresholds that do not exist or are several, the
command."""

import math
import re
from importlib import import_module

import numpy as np
import pytest
from scenes import CASES, WALLS, block_between_walls, block_on_floor

import masonry_opt as mo
from masonry_opt.errors import NoLoadFactorError
from masonry_opt.solution.reasons import Code
from masonry_opt.studies.many.standing import standing
from masonry_opt.studies.many.threshold_text import rounded_outwards
from masonry_opt.studies.run_columns import ANSWER_COLUMNS

LOAD = {"load": 0.3, "method": "static", "samples": 1}


def tilted(scene: mo.Scene, degrees: float) -> mo.Scene:
    angle = math.radians(degrees)
    return scene.replace(gravity=(math.sin(angle), -math.cos(angle)))


def wide(width: float) -> mo.Scene:
    """Return a block that rocks at λ = width / 4."""
    return block_on_floor(width, 4.0, friction=2.0)


def test_friction_of_a_block_on_a_slope_is_the_tangent():
    found = mo.least(lambda mu: tilted(block_on_floor(2.0, 1.0, friction=mu), 25), 0.01, 2)
    assert found.value == pytest.approx(math.tan(math.radians(25)), rel=1e-8)
    lower, upper = found.interval
    assert lower <= found.value <= upper <= lower * (1 + 1e-6)
    assert found.fails.number < 0 <= found.holds.number + 1e-9
    assert not found.jump
    assert not found.contradictions


def test_greatest_tilt_of_a_block_is_its_slenderness():
    """The greatest tilt of a block is atan(b/h), with a state below it and a mechanism above it.

    The state and the mechanism are those of the dead load alone, and are verified with the matrices.
    """
    found = mo.most(lambda degrees: tilted(block_on_floor(1.0, 2.5, friction=0.9), degrees), 0, 45)
    assert found.value == pytest.approx(math.degrees(math.atan(1 / 2.5)), rel=1e-8)
    assert found.holds.value <= found.value <= found.fails.value
    problem, q = found.holds.result.assembly.problem, found.holds.result.solution.q
    np.testing.assert_allclose(problem.B @ q + problem.dead, 0, atol=1e-8)
    assert problem.slacks(q).min() > -1e-8
    thinner, d = found.fails.result.assembly.problem, found.fails.result.solution.d
    assert thinner.dead @ d > 0
    assert found.fails.certificate.flow < 1e-8


def test_scenes_that_differ_in_friction_share_matrices(watched):
    """Only the first trial is assembled, and the margins equal those of scenes that are assembled anew."""
    assembled = watched(import_module("masonry_opt.studies.many.standing"), "assemble")
    found = mo.least(lambda mu: tilted(block_on_floor(2.0, 1.0, friction=mu), 25), 0.01, 2, samples=0)
    assert len(assembled) == 1
    for trial in (found.holds, found.fails):
        scene = tilted(block_on_floor(2.0, 1.0, friction=trial.value), 25)
        assert trial.number == standing(scene).margin


@pytest.mark.parametrize("search", [mo.least, mo.most])
def test_the_printed_value_holds(search):
    """The printed threshold and ends are rounded outwards, so the scene holds at the printed threshold."""
    sign = 1 if search is mo.least else -1
    found = search(
        lambda x: tilted(block_on_floor(2.0, 1.0, friction=sign * x), 25), *sorted((0.1 * sign, sign))
    )
    printed = [
        float(number) for number in re.findall(r"^\w+(?: value)? +(?:at )?(-?[\d.]+)", str(found), re.M)
    ]
    value, holds, fails = (sign * number for number in printed[:3])
    assert value == holds >= sign * found.holds.value > sign * found.fails.value >= fails
    assert f"interpolated between the holding and the failing value: {found.value:.9g})" in str(found)
    assert value == pytest.approx(math.tan(math.radians(25)), rel=2e-6)


def test_rounding_outwards():
    assert rounded_outwards(0.12345, 3, upwards=True) == "0.124"
    assert rounded_outwards(0.12345, 3, upwards=False) == "0.123"
    assert rounded_outwards(-0.12345, 3, upwards=True) == "-0.123"
    assert {rounded_outwards(0.3, 9, upwards=upwards) for upwards in (True, False)} == {"0.3"}
    assert rounded_outwards(1 / 3, 17, upwards=True) == f"{1 / 3:.17g}"


def test_a_margin_is_not_passed_off_as_a_load_factor():
    """Trials of a search under dead load have no load factor and no tilt angle.

    A solve of the same block, with μ = 0.9 and tilt "right", has both.
    """
    reference = {"associative": mo.Reference(value=0.5, source="by hand")}
    scene = block_on_floor(friction=0.9, live=(0.0, 0.0)).replace(tilt="right", reference=reference)
    assert mo.solve(scene, "static").tilt_angle == pytest.approx(math.degrees(math.atan(0.5)), abs=1e-6)
    found = mo.most(lambda degrees: tilted(scene, degrees), 0, 45, samples=0, tolerance=1e-3)
    for trial in found.trials:
        result = trial.result
        assert (result.load_factor, result.tilt_angle, result.as_dict()["load_factor"]) == (None, None, None)
        assert not result.assembly.scene.reference
        assert result.status is (mo.Status.STABLE if trial.holds else mo.Status.UNSTABLE)
        assert (result.solution.q is None, result.solution.d is None) == (not trial.holds, trial.holds)
        assert "load factor λ" not in str(result)
    assert "collapses at the load factor λ" not in found.fails.result.plot().axes[0].get_title()
    assert [reason.code for reason in found.fails.result.reasons] == [Code.FALLS]


@pytest.mark.slow
def test_a_load_is_not_carried_because_a_run_ended_as_unlimited():
    """A run that ends as "locked" does not show that a load is carried.

    A keystone of weight 1 is pulled up. If friction exceeds the inclination of its faces, the paper's loop
    ends as "locked".
    """
    keystone = mo.load(CASES / "closed_forms" / "keystone.toml")
    asked = {"load": 1.5, "samples": 0, "tolerance": 0.5}

    def rough(mu):
        return keystone.replace(friction=mu)

    with pytest.raises(NoLoadFactorError, match="it could not be decided"):
        mo.least(rough, 0.3, 0.75, method="nonassociative", preset="paper", **asked)
    found = mo.least(rough, 0.3, 0.75, method="static", **asked)
    assert (found.holds.number, found.fails.number) == (math.inf, pytest.approx(1.0, abs=1e-6))


@pytest.mark.parametrize("method", ["static", "coulomb"])
def test_least_friction_that_carries_a_load(method):
    """λ is the friction, up to the slenderness of the block, so that λ = 0.3 needs a friction of 0.3."""
    found = mo.least(lambda mu: block_on_floor(friction=mu), 0.05, 1, load=0.3, method=method, samples=2)
    assert found.value == pytest.approx(0.3, rel=1e-7)
    assert found.fails.number < 0.3 <= found.holds.number + 1e-9
    assert found.history.columns.tolist() == ["value", "holds", "number", *ANSWER_COLUMNS]
    assert found.history["load_factor"].tolist() == [trial.number for trial in found.trials]
    assert found.history["incremental"].isna().all()


def test_the_incremental_load_factor_is_told_where_asked_for():
    found = mo.least(
        lambda mu: block_on_floor(friction=mu), 0.05, 1, load=0.3, samples=0, tolerance=0.5, incremental=True
    )
    history = found.history
    assert history["incremental"].tolist() == pytest.approx(history["load_factor"].tolist(), rel=1e-6)


@pytest.mark.slow
def test_a_load_factor_that_jumps_is_named():
    found = mo.least(
        lambda t: wide(1.0 if t < 0.37 else 2.0), 0, 1, load=0.3, method="static", samples=2, tolerance=1e-3
    )
    assert found.jump == pytest.approx((0.25, 0.5))
    assert found.fails.value < 0.37 <= found.holds.value == found.value
    assert found.value == pytest.approx(0.37, rel=1e-3)


def test_a_wide_interval_is_not_a_jump():
    """The load factor is proportional to the width; its change between both ends is not a jump."""
    found = mo.least(wide, 0.5, 4, load=0.5, method="static", samples=0, tolerance=0.1)
    assert found.holds.number - found.fails.number > 0.01
    assert not found.jump


@pytest.mark.slow
def test_falling_by_itself_is_a_jump_only_where_a_load_was_carried_at_once():
    def steep(t):
        return tilted(block_on_floor(1.0, 2.5, friction=0.9), 30) if t < 0.5 else wide(1.2)

    asked = {"method": "static", "samples": 0, "tolerance": 0.01}
    assert mo.least(steep, 0, 1, load=0.1, **asked).jump == (-math.inf, pytest.approx(0.3))
    # As the block tilts, λ falls to zero without a jump until its weight is above its edge.
    back = mo.most(lambda a: tilted(wide(1), a), 0, 30, load=0.0, method="static", samples=0, tolerance=1e-4)
    assert back.value == pytest.approx(math.degrees(math.atan(0.25)), rel=1e-4)
    assert back.fails.number == -math.inf
    assert not back.jump


@pytest.mark.slow
def test_a_hole_is_told():
    """The load is carried for t from 0.65 on, and in an interval below, which is reported as a
    contradiction."""

    def width(t):
        return wide(2.0 if t >= 0.65 or 0.1 < t < 0.35 else 1.0)

    asked = {"load": 0.3, "method": "static", "samples": 4, "tolerance": 0.01}
    found = mo.least(width, 0, 1, **asked)
    assert found.value == pytest.approx(0.65, rel=0.01)
    assert found.contradictions == (0.2,)
    found = mo.most(lambda t: width(1 - t), 0, 1, **asked)
    assert found.value == pytest.approx(0.35, rel=0.01)
    assert found.contradictions == pytest.approx((0.8,))


@pytest.mark.parametrize(
    ("search", "make", "ends", "asked", "error", "found"),
    [
        (mo.least, wide, (1.5, 3.0), LOAD, mo.OptionError, "begin the range at a smaller value"),
        (mo.least, wide, (0.5, 1.0), LOAD, mo.OptionError, "end the range at a greater value"),
        (mo.most, wide, (1.5, 3.0), LOAD, mo.OptionError, "end the range at a greater value"),
        (mo.most, wide, (0.5, 1.0), LOAD, mo.OptionError, "begin the range at a smaller value"),
        (mo.most, wide, (0.5, 3.0), LOAD, mo.OptionError, "use 'least' .the command without --most."),
        (mo.least, wide, (3.0, 0.5), LOAD, mo.OptionError, "less than upper"),
        (mo.least, wide, (float("nan"), 3.0), LOAD, mo.OptionError, "must be a number"),
        (mo.least, lambda t: wide(2 if 0.3 < t < 0.7 else 1), (0, 1), LOAD, mo.OptionError, r"load at 0\.5:"),
        (mo.least, wide(1.0), (0, 1), {}, mo.OptionError, "function"),
        (mo.least, wide, (1, 2), {"method": "static"}, mo.OptionError, "'load'"),
        (mo.least, lambda mu: block_on_floor(friction=mu), (-1, 1), {}, mo.CaseError, "at -1: "),
    ],
)
def test_what_to_do_is_said(search, make, ends, asked, error, found):
    with pytest.raises(error, match=found):
        search(make, *ends, **asked)


def test_joints_that_crush_are_decided_without_a_margin():
    """A block of weight 1 on a base of width 1 is stable if strength times width is at least its weight."""
    block = block_on_floor(1.0, 2.0)
    found = mo.least(lambda strength: block.replace(strength=strength), 0.5, 2, tolerance=1e-2, samples=0)
    assert found.value == pytest.approx(1.0, rel=1e-2)
    assert not found.jump


def test_smooth_joints_have_no_margin():
    smooth = tilted(block_on_floor(friction=0.0), 10)
    assert standing(smooth).result.status is mo.Status.UNSTABLE
    found = mo.least(lambda mu: tilted(block_on_floor(friction=mu), 10), 0, 1, samples=0)
    assert found.value == pytest.approx(math.tan(math.radians(10)), rel=1e-6)


@pytest.mark.slow
def test_a_scene_without_room_stands():
    """Rounding errors do not make a scene with a margin of zero unstable.

    All joints are smooth, so that nothing presses the block against its wall. The weight moves outwards from
    the middle. The margin is zero until the weight is beyond the edge.
    """

    def eccentric(by):
        scene = block_on_floor(friction=0.0, weight_at=(0.5 - by, 1.0))
        wall = mo.Block(name="wall", vertices=[(1, 0), (2, 0), (2, 2), (1, 2)], fixed=True)
        return scene.replace(blocks=[*scene.blocks, wall])

    found = mo.most(eccentric, 0.1, 0.8, samples=2, tolerance=1e-3)
    assert found.value == pytest.approx(0.5, rel=1e-3)
    assert abs(found.trials[0].number) < 1e-8


def test_a_block_that_only_self_stress_holds_is_unstable_with_any_friction():
    """A block hangs between two walls. Friction holds it only if the walls are pressed onto it, and the dead
    load does not do this. Then "solve" and "least" must agree."""
    assert mo.solve(block_between_walls(2.0)).status == "unstable under dead load"
    with pytest.raises(mo.OptionError, match="the scene is unstable at 0, at 3 and at all"):
        mo.least(block_between_walls, 0.0, 3.0)
    assert standing(block_between_walls(2.0)).margin == -math.inf


def test_a_path_will_do():
    asked = {"load": 0.6, "method": "static", "tolerance": 0.1}
    found = mo.least(lambda t: WALLS[0] if t > 0.5 else WALLS[1], 0, 1, **asked)
    assert found.jump == pytest.approx((0.58, 0.64286), abs=1e-4)


def test_friction_that_carries_a_load(case, command):
    asked = ("--vary", "joints.friction=0.1:1", "--load", "0.3", "--method", "static", "--samples", "1")
    found = command.json("least", case, *asked)
    assert found["value"] == pytest.approx(0.3, rel=1e-6)
    out = command("least", case, *asked)
    # The printed load factors of the two ends differ, lie on their sides of the load asked, and equal those
    # in JSON.
    printed = {
        end: [float(number) for number in re.findall(rf"^{end} +at (\S+): load factor (\S+)", out, re.M)[0]]
        for end in ("holds", "fails")
    }
    assert printed["fails"][1] < 0.3
    assert printed["fails"][1] < printed["holds"][1]
    for end, (value, number) in printed.items():
        assert value == pytest.approx(found[end]["value"], rel=1e-8)
        assert number == pytest.approx(found[end]["number"], rel=1e-6)
    command.refused("least", case, *asked, "-o", "beta=1")
    assert command.json("least", case, *asked, "--time-limit", "60")["value"] == found["value"]
    without_load = (*asked[:2], "--time-limit", "60")
    refused = command.refused("least", case, *without_load)
    assert "time_limit: give a required load factor too with 'load'" in refused


def test_greatest_push_that_a_block_stands(case, command):
    """A dead force in the middle of a block 1 wide and 2 high overturns it at half its weight."""
    asked = ("--vary", "block.A.dead.x=0:1", "--most", "--samples", "1", "--tolerance", "1e-4")
    found = command.json("least", case, *asked)
    assert found["kind"] == "greatest"
    assert found["value"] == pytest.approx(0.5, rel=1e-6)
    assert "block.A.dead.x" in command("least", case, *asked).splitlines()[0]


@pytest.mark.parametrize(
    "vary", ["joints.friction", "joints.friction=1", "joints.friction=a:b", "joints.frictoin=0:1"]
)
def test_what_is_wrong_with_the_command_is_said(case, vary, command):
    assert "joints.friction" in command.refused("least", case, "--vary", vary)

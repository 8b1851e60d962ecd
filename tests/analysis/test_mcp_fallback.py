"""Where no pass ends in a state the loop takes over; what has no load factor, and what the method takes."""

from __future__ import annotations

from dataclasses import replace

import pytest
from passes import assert_descended, assert_one_pass, one_pass
from scenes import WALLS, overhanging, pressed_down, small_wall, solved, two_blocks
from scenes import values_of as values

import masonry_opt as mo
from masonry_opt.answer.acceptance import LIMITS, Kind
from masonry_opt.answer.reasons import Code
from masonry_opt.methods.mcp import one_pass as method
from masonry_opt.methods.mcp.rules import Rules

#: No patience: given up after the first step at which the gap has not halved.
IMPATIENT = Rules(patience=-1)


@pytest.fixture
def no_pass_ends(monkeypatch):
    monkeypatch.setattr(method, "ATTEMPTS", (IMPATIENT, IMPATIENT))


def test_the_loop_takes_over_where_no_pass_ends(no_pass_ends):
    seen = []
    result, loop = mo.solve(WALLS[0], "mcp", progress=seen.append), mo.solve(WALLS[0], "nonassociative")
    assert result.status is mo.Status.CONVERGED
    assert result.load_factor == loop.load_factor
    assert [reason.code for reason in result.reasons] == [
        Code.LOOP_TOOK_OVER,
        *(reason.code for reason in loop.reasons),
    ]
    assert values(result, Code.LOOP_TOOK_OVER)["word"]
    # Both histories, one after the other: attempts 1 and 2, and the loop's sub-problems.
    steps = result.history["gap"].notna()
    assert set(result.history.loc[steps, "attempt"]) == {1, 2}
    assert (~steps).sum() == len(loop.history) == values(result, Code.SUB_PROBLEMS)["count"]
    assert steps.to_list() == sorted(steps, reverse=True)
    assert len(seen) == len(result.history)


def test_without_any_rules_and_without_the_loop_there_is_no_load_factor(no_pass_ends):
    result = mo.solve(WALLS[0], "mcp", fallback=False)
    assert result.status is mo.Status.SOLVER_FAILED
    assert result.load_factor is None
    assert [reason.code for reason in result.reasons] == [Code.PASS_STOPPED, Code.AT_MOST]
    assert result.range == (None, pytest.approx(0.64286, abs=5e-6))
    assert values(result, Code.PASS_STOPPED)["attempts"] == 2
    assert set(result.history["attempt"]) == {1, 2}


def test_the_next_rules_follow_where_the_first_stall(monkeypatch):
    monkeypatch.setattr(method, "ATTEMPTS", (IMPATIENT, *method.ATTEMPTS))
    result = mo.solve(WALLS[0], "mcp", descent=False)
    assert_one_pass(result)
    assert_descended(mo.solve(WALLS[0], "mcp"))
    assert values(result, Code.ONE_PASS)["attempt"] == 2
    assert set(result.history["attempt"]) == {1, 2}


def test_an_inexact_end_is_no_answer(monkeypatch):
    """A pass that claims to have ended is not believed where the certificate fails: the loop takes over."""
    monkeypatch.setattr(method, "ATTEMPTS", method.ATTEMPTS[:1])
    never = replace(LIMITS[Kind.ONE_PASS], equilibrium=-1.0)
    monkeypatch.setitem(LIMITS, Kind.ONE_PASS, never)
    result = mo.solve(WALLS[0], "mcp")
    assert result.reasons[0].code is Code.LOOP_TOOK_OVER
    assert result.load_factor == solved(WALLS[0], "nonassociative").load_factor
    assert mo.solve(WALLS[0], "mcp", fallback=False).status is mo.Status.SOLVER_FAILED


# No load factor -----------------------------------------------------------------------------------------


@pytest.mark.parametrize("scene", [overhanging(), pressed_down()], ids=["falls", "unlimited"])
def test_scenes_without_load_factor_end_as_the_loop_s_do(scene):
    result, loop = solved(scene, "mcp"), solved(scene, "nonassociative")
    assert result.status is loop.status
    assert result.status in (mo.Status.UNSTABLE, mo.Status.UNLIMITED)
    assert result.load_factor is None
    assert result.certificate is None
    took_over = (Code.LOOP_TOOK_OVER, Code.PASS_LOST)
    own = [reason.code for reason in result.reasons if reason.code not in took_over]
    assert own == [reason.code for reason in loop.reasons]


def test_a_scene_that_falls_needs_no_step():
    assert solved(overhanging(), "mcp").history.empty


# Options ------------------------------------------------------------------------------------------------


def test_its_solver_may_be_named():
    named, plain = solved(two_blocks(), "mcp", solver="newton"), solved(two_blocks(), "mcp")
    assert named.load_factor == plain.load_factor
    assert solved(two_blocks(), "mcp", model="pyomo").load_factor == plain.load_factor


def test_its_answer_is_of_its_own_kind_until_it_is_exact():
    assert one_pass(two_blocks()).solution.kind is Kind.ONE_PASS
    assert solved(two_blocks(), "mcp").solution.kind is Kind.EXACT


# Sizes --------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(("joints", "holds"), [(82, assert_one_pass), (83, assert_descended)])
def test_scenes_of_more_joints_keep_the_pass(joints, holds, monkeypatch):
    """Wall 1 has 83 joints."""
    monkeypatch.setattr(method, "DESCENT_UP_TO", joints)
    holds(mo.solve(WALLS[0], "mcp"))


def test_scenes_of_very_many_joints_are_for_the_loop(monkeypatch):
    monkeypatch.setattr(method, "PASSES_UP_TO", 82)
    result, loop = mo.solve(WALLS[0], "mcp"), solved(WALLS[0], "nonassociative")
    assert [r.code for r in result.reasons] == [Code.TOO_LARGE, *(r.code for r in loop.reasons)]
    assert values(result, Code.TOO_LARGE) == {"joints": 83}
    assert result.load_factor == loop.load_factor
    assert_one_pass(mo.solve(WALLS[0], "mcp", descent=False, fallback=False))


@pytest.fixture
def far_at_once(monkeypatch):
    """The loop begins on wall 1, and leaves it to a pass after its second sub-problem."""
    monkeypatch.setattr(method, "PASSES_UP_TO", 82)
    monkeypatch.setattr(method, "FAR", {2: 0.0})


def steps_of(result):
    """Of the loop's sub-problems, and of a pass."""
    of_pass = result.history["gap"].notna()
    return int((~of_pass).sum()), int(of_pass.sum())


def test_a_pass_takes_over_where_the_loop_is_far_from_the_true_law(far_at_once):
    seen = []
    result, loop = mo.solve(WALLS[0], progress=seen.append), mo.solve(WALLS[0], "nonassociative")
    assert result.status is mo.Status.CONVERGED
    assert result.solution.kind is Kind.ONE_PASS
    assert result.certificate.worst < 1e-6
    assert [r.code for r in result.reasons] == [Code.LOOP_FAR, Code.ONE_PASS]
    first, steps = steps_of(result)
    assert (first, steps) == (2, values(result, Code.ONE_PASS)["steps"])
    assert len(seen) == first + steps
    second = loop.history.iloc[1]
    assert values(result, Code.LOOP_FAR)["off"] == pytest.approx(second["mismatch"] / second["load_factor"])
    assert result.associative == pytest.approx(0.64286, abs=5e-6)
    # Published: 0.63898 by an MPEC, 0.64286 with associative flow; nothing between them is a mistake.
    assert 0.63898 - 5e-6 <= result.load_factor <= 0.64286


def test_a_pass_that_stalls_near_a_state_ends_in_exact_forces(far_at_once, monkeypatch):
    near = Rules(**vars(method.OF_LARGE) | {"patience": 0})
    monkeypatch.setattr(method, "OF_LARGE", near)
    monkeypatch.setattr(method, "NEARLY", 1.0)
    result = mo.solve(WALLS[0])
    assert [r.code for r in result.reasons] == [Code.LOOP_FAR, Code.PASS_NEAR]
    told = values(result, Code.PASS_NEAR)
    assert (2, told["steps"]) == steps_of(result)
    assert told["gap"] > 1e-4
    certificate = result.certificate
    assert max(certificate.equilibrium, certificate.yield_, certificate.flow) < 1e-6
    assert certificate.complementarity < 1e-3 * result.load_factor
    assert result.associative == pytest.approx(0.64286, abs=5e-6)
    assert result.load_factor <= result.associative * (1 + 1e-8)


def test_the_loop_has_the_scene_again_where_the_pass_ends_in_nothing(far_at_once, monkeypatch):
    monkeypatch.setattr(method, "OF_LARGE", IMPATIENT)
    result, loop = mo.solve(WALLS[0]), solved(WALLS[0], "nonassociative")
    assert result.reasons[0].code is Code.LOOP_TOOK_OVER
    assert result.load_factor == loop.load_factor
    first, steps = steps_of(result)
    assert (first, steps > 0) == (2 + len(loop.history), True)


def test_the_loop_keeps_a_large_scene_whose_flow_is_soon_near_the_true_law(monkeypatch):
    monkeypatch.setattr(method, "PASSES_UP_TO", 82)
    monkeypatch.setattr(method, "FAR", {2: 1.0})
    result = mo.solve(WALLS[0])
    assert result.reasons[0].code is Code.TOO_LARGE
    assert "gap" not in result.history


def test_shears_that_nothing_determines_end_no_pass():
    """A block on two rough floors side by side: how they share its shear is open; λ = w/h by overturning."""
    scene = mo.Scene(
        joints=mo.JointDefaults(friction=float("inf")),
        blocks=[
            mo.Block(name="A", vertices=[(0, 0), (2, 0), (2, 1), (0, 1)], weight=1, live=(1, 0)),
            mo.Block(name="left", vertices=[(-1, -1), (1, -1), (1, 0), (-1, 0)], fixed=True),
            mo.Block(name="right", vertices=[(1, -1), (3, -1), (3, 0), (1, 0)], fixed=True),
        ],
    )
    result = solved(scene, "mcp", fallback=False)
    assert result.reasons[0].code is Code.ONE_PASS
    assert result.load_factor == pytest.approx(2.0, rel=1e-9)


@pytest.mark.slow
def test_a_solid_wall_of_thousands_of_blocks_that_the_loop_leaves_ends_in_a_pass(monkeypatch):
    """2898 blocks, 8543 joints, of more than which passes are not tried first."""
    monkeypatch.setattr(method, "FAR", {2: 0.0})
    scene = small_wall(36, 80)
    result, static = mo.solve(scene), mo.solve(scene, "static")
    assert (result.size.blocks, result.size.joints) == (2898, 8543)
    assert [r.code for r in result.reasons] == [Code.LOOP_FAR, Code.ONE_PASS]
    assert steps_of(result)[0] == 2
    assert result.certificate.worst < 1e-6
    assert 0.95 * static.load_factor < result.load_factor < static.load_factor
    # The loop's first sub-problem, solved to 1e-4 in units of the load, stands for the associative program.
    assert result.associative == pytest.approx(static.load_factor, rel=1e-3)

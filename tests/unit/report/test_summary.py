"""What a result is said to be: facts by their labels, compared with each other, not read."""

from __future__ import annotations

import re
from dataclasses import replace

import pytest
from scenes import block_on_floor, small_wall, two_blocks

import masonry_opt as mo
from masonry_opt.answer.answer import Found
from masonry_opt.answer.reasons import Code, reason
from masonry_opt.words.sentences import message
from masonry_opt.words.summary import facts


def associative():
    """Two blocks whose joints dilate as classical limit analysis assumes."""
    scene = two_blocks()
    return scene.model_copy(update={"joints": mo.JointDefaults(friction=0.1, dilatancy=0.1)})


@pytest.mark.parametrize(
    "scene",
    [associative(), small_wall(friction=float("inf")), block_on_floor(friction=0.0)],
    ids=["all dilate", "nothing slides", "no friction"],
)
def test_where_the_flow_rule_is_associative_no_lower_state_is_spoken_of(scene):
    """All methods answer one question there, and say the same of it."""
    one_pass, linear = mo.solve(scene, "mcp"), mo.solve(scene, "static")
    assert one_pass.exact
    assert one_pass.load_factor == pytest.approx(linear.load_factor, rel=1e-6, abs=1e-6)
    assert facts(one_pass)["how sure"] == facts(linear)["how sure"]


def test_of_coulomb_s_joints_lower_states_are_spoken_of():
    dilating, coulomb = facts(mo.solve(associative(), "mcp")), facts(mo.solve(two_blocks(), "mcp"))
    assert coulomb["how sure"] != dilating["how sure"]


def numbers(result):
    """The numbers of the line of load factors that stand before a bracket."""
    return [float(number) for number in re.findall(r"([\d.]+) \(", facts(result)["load factors"])]


def test_the_three_load_factors_stand_in_one_line():
    result = mo.solve(two_blocks(), "mcp")
    assert numbers(result) == pytest.approx([0.15, result.expected, 0.25], rel=1e-4)
    assert numbers(result.at_expected) == numbers(result)[1:]
    assert len(facts(result)["load factors"].splitlines()) == 1
    assert "load factors" not in facts(mo.solve(two_blocks(), "static"))


def test_what_is_above_the_load_to_expect_is_not_called_the_least_known():
    """But by rounding, where all are one."""
    result = mo.solve(two_blocks(), "mcp")

    def said(load_factor):
        found = replace(result.solution.answer, load_factor=load_factor)
        line = facts(replace(result, solution=replace(result.solution, found=found)))["load factors"]
        return line.split(" · ")[0].split(" 0.")[0]

    assert said(0.15) == said((1 + 1e-8) * result.expected) != said(0.2)


@pytest.mark.parametrize("code", [Code.NO_PLATEAU, Code.NOT_EXPECTED])
def test_no_plateau_and_none_are_said_by_their_reason(code):
    result = mo.solve(two_blocks(), "mcp")
    why = reason(code, give=1e-6, change=0.02, softer=10.0, load_factor=7.0, joints=9000)
    found = result.solution.expected.found if code is Code.NO_PLATEAU else Found()
    expected = replace(result.solution.expected, found=found, reasons=[why])
    odd = replace(result, solution=replace(result.solution, expected=expected))
    assert message([why]) in facts(odd)["load factors"]
    assert message(result.at_expected.reasons) not in facts(result)["load factors"]
    assert numbers(odd)[:: 2 if odd.expected else 1] == [0.15, 0.25]


def test_which_law_crushes_joints_is_said_with_every_load_factor():
    """The parabola itself or chords; and of a Coulomb answer that what stands beside it crushes alike."""
    weak = small_wall(strength=8.0)
    said = [
        facts(mo.solve(weak, method, **how))["crushing"]
        for method, how in (("static", {}), ("static", {"solver": "highs"}), ("mcp", {}))
    ]
    assert len(set(said)) == 3
    assert "crushing" not in facts(mo.solve(small_wall(), "mcp"))

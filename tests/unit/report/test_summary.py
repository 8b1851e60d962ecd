"""What a result is said to be: facts by their labels, compared with each other, not read."""

from __future__ import annotations

from dataclasses import replace

import pytest
from scenes import block_on_floor, small_wall, two_blocks

import masonry_opt as mo
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
    """All methods answer one question there, and say the same of it; dilatancy is what the scene has."""
    one_pass, linear = mo.solve(scene, "mcp"), mo.solve(scene, "static")
    assert one_pass.exact
    assert one_pass.load_factor == pytest.approx(linear.load_factor, rel=1e-6, abs=1e-6)
    assert facts(one_pass)["how sure"] == facts(linear)["how sure"]
    assert "dilatancy" not in facts(one_pass)


def test_of_coulomb_s_joints_lower_states_and_dilatancy_are_spoken_of():
    dilating, coulomb = facts(mo.solve(associative(), "mcp")), facts(mo.solve(two_blocks(), "mcp"))
    assert coulomb["how sure"] != dilating["how sure"]
    assert "dilatancy" in coulomb


def test_which_law_crushes_joints_is_said_with_every_load_factor():
    """The parabola itself or chords; and of a Coulomb answer that what stands beside it crushes alike."""
    weak = small_wall(strength=8.0)
    said = [
        facts(mo.solve(weak, method, **how))["crushing"]
        for method, how in (("static", {}), ("static", {"solver": "highs"}), ("mcp", {}))
    ]
    assert len(set(said)) == 3
    assert "crushing" not in facts(mo.solve(small_wall(), "mcp"))


def test_of_a_load_factor_that_is_rounding_no_percentage_is_given():
    """The associative value alone, of a rounded zero as of zero itself; nothing where both are zero."""
    solved = mo.solve(two_blocks(), "mcp")

    def said(load_factor, associative):
        found = replace(solved.solution.answer, load_factor=load_factor)
        solution = replace(solved.solution, found=found, associative=associative)
        return facts(replace(solved, solution=solution))["dilatancy"]

    assert said(1e-13, 0.25) == said(-1e-13, 0.25) == said(0.0, 0.25) != said(0.2, 0.25)
    assert said(1e-13, 1e-9) == said(0.25, 0.25) != said(0.0, 0.25)

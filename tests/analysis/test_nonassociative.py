"""The loop: when it runs, what it ends in, and how little its end depends on its parameters."""

from __future__ import annotations

import numpy as np
import pytest
from scenes import WALLS, block_on_floor, solved, two_blocks, values_of

import masonry_opt as mo
from masonry_opt.answer.reasons import Code

WALL_3, WALL_6 = WALLS[2], WALLS[5]

#: The paper's loop and nothing else: no exact state at the end, no second run.
RAW = {"preset": "paper", "remedies": "none"}


def test_it_does_not_run_where_nothing_slides():
    result = solved(block_on_floor(1, 2, 0.8), "nonassociative")
    assert result.status is mo.Status.CONVERGED
    assert result.lp_solves == 1
    assert not result.flow_rule_matters
    assert [reason.code for reason in result.reasons] == [Code.FLOW_RULE_IDLE]
    always = solved(block_on_floor(1, 2, 0.8), "nonassociative", always=True)
    assert always.lp_solves > 1
    assert always.load_factor == pytest.approx(0.5, rel=2e-5)
    assert result.load_factor == pytest.approx(0.5, rel=1e-7)
    assert result.certificate.worst < 1e-6


def test_a_lower_state_elsewhere_is_found_if_asked_for():
    """Fig. 6 beside a slender block that overturns at 0.2: the loop finds 0.15, the early exit not."""
    fig_6 = two_blocks()
    slender = mo.Block(name="C", vertices=[(7, 0), (8, 0), (8, 5), (7, 5)], weight=1, live=(1, 0))
    joints = [*fig_6.exceptions, mo.Joint(between=("C", "floor"), friction=float("inf"))]
    both = mo.Scene(joints=fig_6.joints, blocks=[*fig_6.blocks, slender], exceptions=joints)
    assert solved(both, "nonassociative").load_factor == pytest.approx(0.2, rel=1e-6)
    assert solved(both, "nonassociative", always=True).load_factor == pytest.approx(0.15, rel=1e-3)


def test_it_runs_where_something_slides():
    result = solved(two_blocks(), "nonassociative")
    assert result.flow_rule_matters
    assert values_of(result, Code.SUB_PROBLEMS) == {"count": len(result.history)}
    assert values_of(result, Code.EXACT_END) == {}
    # One more program than sub-problems: the exact state at the end.
    assert result.lp_solves == len(result.history) + 1 > 2
    raw = mo.solve(two_blocks(), "nonassociative", **RAW)
    assert raw.lp_solves == len(raw.history) > 1


@pytest.mark.parametrize(
    ("method", "scene"), [("nonassociative", mo.load(WALLS[0])), ("mpec", two_blocks())], ids=["loop", "mpec"]
)
@pytest.mark.parametrize("size", [2.0**-40, 2.0**40])
def test_live_loads_of_any_size(method, scene, size):
    """A live load 10⁻¹² or 10¹² times as large has a λ as many times as large or small: powers of two round
    nothing, so that all digits but those that the solver leaves are the same."""
    loads = ("live", "live_per_weight")
    pushed = {
        block.name: {key: tuple(size * part for part in getattr(block, key)) for key in loads}
        for block in scene.blocks
    }
    found = [mo.solve(one, method, expected=False) for one in (scene, scene.replace(blocks=pushed))]
    assert found[1].load_factor * size == pytest.approx(found[0].load_factor, rel=1e-8)


def test_history_accounts_for_the_energy():
    """Fig. 12: raising and sliding add up to λ; associative flow spends all of it in raising."""
    history = solved(WALL_6, "nonassociative").history
    np.testing.assert_allclose(history["raising"] + history["sliding"], history["load_factor"], rtol=1e-6)
    assert history["sliding"].iloc[0] == pytest.approx(0, abs=1e-9)
    assert history["sliding"].iloc[-1] > 0.01
    assert (history["seconds"] > 0).all()


def test_step_6_takes_off_what_the_small_cohesion_dissipates():
    result = solved(WALL_3, "nonassociative", finish=False)
    uncorrected = result.history["load_factor"].iloc[-1]
    assert 0 < uncorrected - result.load_factor < 5e-4
    smaller = solved(WALL_3, "nonassociative", c0=1e-6)
    assert smaller.load_factor == pytest.approx(result.load_factor, rel=1e-5)


def test_sliding_hardly_contracts_at_the_end():
    """The loop does not stop while its slope is large: flow departs by no more than α_min μ."""
    scene = block_on_floor(4, 2, 0.65)
    assert solved(scene, "nonassociative").certificate.flow < 1.1e-3


@pytest.mark.parametrize("weight", [pytest.param(1.0, marks=pytest.mark.slow), 10.0])
def test_a_neighbour_that_stands_apart_does_not_matter(weight):
    """A slab 100 blocks long: units are medians, the small cohesion is that of each part. (From 100
    block weights on, the solver's relative accuracy does choose the other end of wall 6.)"""
    wall = mo.load(WALL_6)
    slab = mo.Block(name="slab", vertices=[(100, 0), (500, 0), (500, 1), (100, 1)], weight=weight)
    floor = mo.Block(name="floor", vertices=[(99, -1), (501, -1), (501, 0), (99, 0)], fixed=True)
    beside = mo.Scene(joints=wall.joints, blocks=[*wall.blocks, slab, floor])
    assert solved(beside, "nonassociative").load_factor == pytest.approx(
        solved(wall, "nonassociative").load_factor, rel=5e-4
    )


@pytest.mark.parametrize("number", [*range(1, 6), pytest.param(6, marks=pytest.mark.slow)])
def test_cohesive_start_ends_where_the_associative_start_does(number):
    """Section 6.3: "relatively insensitive to the starting conditions"; wall 6 alone moves, by 8e-4."""
    path = WALLS[number - 1]
    cohesive, associative = (
        mo.solve(path, "nonassociative", start="cohesive"),
        solved(path, "nonassociative"),
    )
    assert cohesive.load_factor == pytest.approx(associative.load_factor, rel=1e-3)


def test_joints_with_their_own_dilatancy():
    """Dilatancy equal to friction is the associative problem; in between λ lies in between."""
    associative = solved(two_blocks(), "static").load_factor
    scene = two_blocks()
    same = mo.Scene(
        joints=mo.JointDefaults(friction=0.1, dilatancy=0.1), blocks=scene.blocks, exceptions=scene.exceptions
    )
    result = solved(same, "nonassociative")
    assert result.load_factor == pytest.approx(associative, rel=1e-7)
    # Fig. 6d: any dilation lifts B, any contraction lets it down.
    for dilatancy, factor in ((0.05, 2.5), (-0.05, 1.5)):
        joints = mo.JointDefaults(friction=0.1, dilatancy=dilatancy)
        some = mo.Scene(joints=joints, blocks=scene.blocks, exceptions=scene.exceptions)
        assert solved(some, "nonassociative", alpha=0.01).load_factor == pytest.approx(factor * 0.1, rel=2e-3)

"""The loop of linear programs: when it runs, its final state, and its dependence on parameters."""

import numpy as np
import pytest
from scenes import CASES, WALLS, block_on_floor, declared, small_wall, solved, two_blocks

import masonry_opt as mo
from masonry_opt.problem.assembly import assemble
from masonry_opt.solution.acceptance import MOST_ENERGY
from masonry_opt.solution.reasons import Code

WALL_3 = WALLS[2]
WALL_6 = WALLS[5]

#: Options for the loop of the paper alone, without an exact state at the end or a second run.
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
    """With ``always``, the loop finds the state of Fig. 6 of the paper at λ = 0.15.

    A slender block in the same scene overturns at 0.2 without sliding, so the loop otherwise ends at 0.2.
    """
    fig_6 = two_blocks()
    slender = mo.Block(name="C", vertices=[(7, 0), (8, 0), (8, 5), (7, 5)], weight=1, live=(1, 0))
    joints = [*fig_6.exceptions, mo.Joint(between=("C", "floor"), friction=float("inf"))]
    both = fig_6.replace(blocks=[*fig_6.blocks, slender], exceptions=joints)
    assert solved(both, "nonassociative").load_factor == pytest.approx(0.2, rel=1e-6)
    assert solved(both, "nonassociative", always=True).load_factor == pytest.approx(0.15, rel=1e-3)


def test_it_runs_where_something_slides():
    result = solved(two_blocks(), "nonassociative")
    assert result.flow_rule_matters
    assert (result.reasons, result.solution.exact_end) == ((), True)
    # The exact state at the end takes one program more than the sub-problems.
    assert result.lp_solves == len(result.history) + 1 > 2
    raw = mo.solve(two_blocks(), "nonassociative", **RAW, incremental=False)
    assert raw.lp_solves == len(raw.history) > 1


def test_history_accounts_for_the_energy():
    """The energies of raising and sliding add up to λ, as in Fig. 12 of the paper, to 1e-6.

    With associative flow, which is the first step, sliding takes no energy.
    """
    history = solved(WALLS[0], "nonassociative").history
    np.testing.assert_allclose(history["raising"] + history["sliding"], history["load_factor"], rtol=1e-6)
    assert history["sliding"].iloc[0] == pytest.approx(0, abs=1e-9)
    assert history["sliding"].iloc[-1] > 0.01
    assert (history["seconds"] > 0).all()


def test_sliding_hardly_contracts_at_the_end():
    """The loop ends only once its slope is at most α_min μ, so the residual of the flow rule is below 1.1e-3.

    With α_min = 0.001, the remaining slope hardly violates the flow rule.
    """
    scene = block_on_floor(4, 2, 0.65)
    assert solved(scene, "nonassociative").certificate.flow < 1.1e-3


def test_a_cohesive_start_ends_where_the_associative_start_does():
    """A cohesive start gives the load factor of the associative start on wall 4, to 1e-3.

    Section 6.3 of the paper: "relatively insensitive to the starting conditions". Of the six walls only
    wall 6 changes, by 8e-4.
    """
    cohesive = mo.solve(WALLS[3], "nonassociative", start="cohesive", incremental=False)
    associative = solved(WALLS[3], "nonassociative")
    assert cohesive.load_factor == pytest.approx(associative.load_factor, rel=1e-3)


#: Friction that acts as unlimited: no joint of these scenes carries a larger ratio of shear to normal force.
AS_GOOD_AS_UNLIMITED = 1e4


def load_factor_and_size(scene, language):
    driver = declared(assemble(scene).problem, language=language)
    return driver.solve().state.load_factor, driver.size()


@pytest.mark.parametrize("language", ["cvxpy", "pyomo"])
def test_joint_with_unlimited_friction_has_no_shear_rows(language):
    rough = two_blocks()
    (joint,) = rough.exceptions
    modelled = rough.replace(exceptions=[joint.replace(friction=AS_GOOD_AS_UNLIMITED)])
    left_out, small = load_factor_and_size(rough, language)
    everything, full = load_factor_and_size(modelled, language)
    assert left_out == pytest.approx(everything, rel=1e-6)
    assert full.rows - small.rows == 2


def test_joint_between_fixed_blocks_is_none():
    wall = small_wall()
    beside = mo.Block(name="base2", vertices=[(16, -1.75), (20, -1.75), (20, 0), (16, 0)], fixed=True)
    longer = wall.replace(blocks=[*wall.blocks, beside])
    plain, result = solved(wall, "static"), solved(longer, "static")
    assert result.size.joints == plain.size.joints
    assert result.load_factor == pytest.approx(plain.load_factor, rel=1e-8)
    assert any("1 joint between fixed blocks" in line for line in result.size.left_out)


FACADE = CASES / "gilbert" / "facade_1x3.toml"
#: Largest residual of complementarity of an exact end. Programs are solved to 1e-9, and the residual is a sum
#: over joints.
EXACT = 1e-7 * 10


def codes(result):
    return [reason.code for reason in result.reasons]


@pytest.mark.slow
def test_a_wall_ends_in_an_exact_state_near_the_loops_own_load_factor():
    result, raw = (solved(WALLS[4], "nonassociative", **how) for how in ({}, {"finish": False}))
    left = result.certificate
    assert max(left.equilibrium, left.yield_) < 1e-8
    assert left.complementarity < EXACT
    assert raw.certificate.yield_ > 1e-5
    assert result.load_factor == pytest.approx(raw.load_factor, abs=1e-5)
    assert codes(result) == codes(raw) == []
    assert result.solution.exact_end
    assert not raw.solution.exact_end
    # The sub-problems before the exact state are the same.
    np.testing.assert_array_equal(result.history["load_factor"], raw.history["load_factor"])


@pytest.mark.slow
@pytest.mark.parametrize("path", [FACADE, WALLS[5]], ids=["façade", "wall 6"])
def test_rough_sub_problems_take_fewer_iterations_to_an_exact_state(path):
    rough, accurate = (solved(path, "nonassociative", sub_problems=asked) for asked in ("rough", "accurate"))
    assert rough.status is mo.Status.CONVERGED
    # Programs are solved to 1e-9 of the load, which is about a hundred block weights, the certificate's unit.
    assert max(rough.certificate.equilibrium, rough.certificate.yield_) < 5e-7
    # The mechanism obeys the true flow rule. No forces near it have a smaller residual of complementarity.
    assert rough.certificate.flow < 1e-7
    assert rough.certificate.complementarity < MOST_ENERGY * rough.load_factor
    assert rough.load_factor <= solved(path, "static", solver="highs-ipm").load_factor
    assert rough.iterations < accurate.iterations


@pytest.mark.slow
def test_a_neighbour_that_stands_apart_does_not_matter():
    """A separate slab, 100 blocks long, changes the load factor of wall 6 by at most 5e-4.

    Units are medians over all blocks, and the small cohesion is chosen for each connected component. With a
    slab of 100 block weights or more, the relative accuracy of the solver leads to another end of wall 6.
    """
    wall = mo.load(WALL_6)
    slab = mo.Block(name="slab", vertices=[(100, 0), (500, 0), (500, 1), (100, 1)], weight=10)
    floor = mo.Block(name="floor", vertices=[(99, -1), (501, -1), (501, 0), (99, 0)], fixed=True)
    beside = mo.Scene(joints=wall.joints, blocks=[*wall.blocks, slab, floor])
    one, both = (solved(scene, "nonassociative").load_factor for scene in (wall, beside))
    assert both == pytest.approx(one, rel=5e-4)

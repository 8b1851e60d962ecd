"""Model no more than a scene needs: the answer is the same with everything modelled."""

from __future__ import annotations

import pytest
from scenes import declared, small_wall, solved, two_blocks

import masonry_opt as mo
from masonry_opt.problem.assembly import assemble

#: No joint of these scenes carries shear beyond this multiple of its normal force.
AS_GOOD_AS_UNLIMITED = 1e4


def load_factor_and_size(scene, language):
    driver = declared(assemble(scene).problem, language=language)
    return driver.solve().state.load_factor, driver.size()


@pytest.mark.parametrize("language", ["cvxpy", "pyomo"])
def test_joint_with_unlimited_friction_has_no_shear_rows(language):
    rough = two_blocks()
    modelled = mo.Scene(
        joints=rough.joints,
        blocks=rough.blocks,
        exceptions=[mo.Joint(between=("B", "support"), friction=AS_GOOD_AS_UNLIMITED)],
    )
    left_out, small = load_factor_and_size(rough, language)
    everything, full = load_factor_and_size(modelled, language)
    assert left_out == pytest.approx(everything, rel=1e-6)
    assert full.rows - small.rows == 2


def test_joint_between_fixed_blocks_is_none():
    wall = small_wall()
    beside = mo.Block(name="base2", vertices=[(16, -1.75), (20, -1.75), (20, 0), (16, 0)], fixed=True)
    longer = mo.Scene(joints=wall.joints, blocks=[*wall.blocks, beside])
    plain, result = solved(wall, "static"), solved(longer, "static")
    assert result.size.joints == plain.size.joints
    assert result.load_factor == pytest.approx(plain.load_factor, rel=1e-8)
    assert any("1 joint between two fixed blocks" in line for line in result.size.left_out)


def test_result_says_what_was_left_out_and_why():
    assert solved(two_blocks(), "static").size.left_out == ("sliding of 1 joint: friction is unlimited",)
    assert solved(small_wall(), "static").size.left_out == ()


def test_normal_forces_are_not_negative_though_no_row_says_so():
    assert solved(small_wall(), "static").joints["n"].min() > -1e-7

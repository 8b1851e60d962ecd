"""Model no more than a scene needs: the answer is the same with everything modelled."""

from __future__ import annotations

import numpy as np
import pytest
from scenes import small_wall, two_blocks

import masonry_opt as mo
from masonry_opt.effort import Stopwatch
from masonry_opt.problem.assembly import assemble
from masonry_opt.problem.problem import ShearLimits
from masonry_opt.solvers.driver import declare
from masonry_opt.solvers.registry import find_solver

#: No joint of these scenes carries shear beyond this multiple of its normal force.
AS_GOOD_AS_UNLIMITED = 1e4


def load_factor_and_size(scene, limits=None, language="cvxpy"):
    problem = assemble(scene).problem
    driver = declare(problem, "static", find_solver(language, None), Stopwatch(), limits)
    return driver.solve().state.load_factor, driver.size()


@pytest.mark.parametrize("language", ["cvxpy", "pyomo"])
def test_joint_with_unlimited_friction_has_no_shear_rows(language):
    rough = two_blocks()
    modelled = mo.Scene(
        joints=rough.joints,
        blocks=rough.blocks,
        exceptions=[mo.Joint(between=("B", "support"), friction=AS_GOOD_AS_UNLIMITED)],
    )
    left_out, small = load_factor_and_size(rough, language=language)
    everything, full = load_factor_and_size(modelled, language=language)
    assert left_out == pytest.approx(everything, rel=1e-6)
    assert full.rows - small.rows == 2


@pytest.mark.parametrize("language", ["cvxpy", "pyomo"])
def test_scene_without_cohesion_has_no_cohesion_terms(language):
    scene = small_wall()
    problem = assemble(scene).problem
    assert ShearLimits.associative(problem).cohesion is None
    modelled = ShearLimits(problem.friction[problem.sliding], np.zeros(len(problem.sliding)))
    left_out, _ = load_factor_and_size(scene, language=language)
    everything, _ = load_factor_and_size(scene, modelled, language)
    assert left_out == pytest.approx(everything, rel=1e-8)


def test_joint_between_fixed_blocks_is_none():
    wall = small_wall()
    beside = mo.Block(name="base2", vertices=[(16, -1.75), (20, -1.75), (20, 0), (16, 0)], fixed=True)
    longer = mo.Scene(joints=wall.joints, blocks=[*wall.blocks, beside])
    plain, result = mo.solve(wall, "static"), mo.solve(longer, "static")
    assert result.size.joints == plain.size.joints
    assert result.load_factor == pytest.approx(plain.load_factor, rel=1e-8)
    assert any("1 joint between two fixed blocks" in line for line in result.size.left_out)


def test_result_says_what_was_left_out_and_why():
    left_out = " | ".join(mo.solve(two_blocks(), "static").size.left_out)
    assert "sliding of 1 joint: friction is unlimited" in left_out
    assert "no joint has cohesion" in left_out
    assert "n ≥ 0" in left_out
    assert "cohesion" not in " | ".join(mo.solve(small_wall(cohesion=0.1), "static").size.left_out)


def test_normal_forces_are_not_negative_though_no_row_says_so():
    assert mo.solve(small_wall(), "static").joints["n"].min() > -1e-7


def test_size_is_that_of_eq_9():
    result = mo.solve(small_wall(), "static")
    b, c = result.size.blocks, result.size.joints
    assert (result.size.rows, result.size.columns) == (3 * b + 4 * c, 3 * c + 1)

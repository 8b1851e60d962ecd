"""Section 6.4: move limits, and turning only the shear limits of joints at yield."""

from __future__ import annotations

import itertools

import numpy as np
import pytest
from scenes import CASES

import masonry_opt as mo
from masonry_opt.effort import Stopwatch
from masonry_opt.methods.loop.options import LoopOptions
from masonry_opt.methods.loop.steps import run_loop
from masonry_opt.problem.assembly import assemble
from masonry_opt.problem.problem import ShearLimits
from masonry_opt.solvers.driver import declare
from masonry_opt.solvers.registry import find_solver

WALL_2 = CASES / "ferris_tinloi" / "wall_2.toml"
WALL_4 = CASES / "ferris_tinloi" / "wall_4.toml"
PAPER = {"pace": "paper", "finish": False}


def steps(path, **options):
    """The problem, and each sub-problem's state and limits."""
    problem = assemble(mo.load(path)).problem
    k = problem.sliding
    limits = ShearLimits(problem.friction[k], problem.cohesion[k])
    driver = declare(problem, "static", find_solver("cvxpy", None), Stopwatch(), limits)
    said = []
    run_loop(problem, driver, LoopOptions(**PAPER, **options).parameters(problem.joints), said.append)
    return problem, said


def turned_about(problem, step):
    """Normal forces about which a sub-problem's shear limits turn: c = c0 + (μ - slope) n."""
    k = problem.sliding
    return step.limits.cohesion / (problem.friction[k] - step.limits.slope)


def test_a_huge_move_limit_is_none():
    ours = mo.solve(WALL_2, **PAPER, move_limit=1e9).history["load_factor"]
    none = mo.solve(WALL_2, **PAPER).history["load_factor"]
    np.testing.assert_array_equal(ours, none)


def test_a_move_limit_bounds_what_the_limits_turn_about():
    """As a share of the force and the mean one; the small cohesion, 1e-5 of the largest force, aside."""
    share = 0.1
    problem, said = steps(WALL_2, move_limit=share)
    about = [turned_about(problem, step) for step in said[1:]]
    assert len(about) > 5
    bound = False
    for before, now in itertools.pairwise(about):
        most = share * (np.abs(before) + np.abs(before).mean())
        change = np.abs(now - before)
        assert (change <= most + 1e-2).all()
        bound = bound or bool((change >= 0.99 * most).any())
    assert bound
    _, free = steps(WALL_2)
    path = [step.load_factor for step in said]
    assert path[1] == free[1].load_factor
    assert path != [step.load_factor for step in free]


def test_only_joints_at_yield_are_turned():
    problem, said = steps(WALL_4, only_at_yield=True)
    k = problem.sliding
    kept = 0
    for before, now in itertools.pairwise(said[1:]):
        limit = before.limits.cohesion + before.limits.slope * before.state.q[0::3][k]
        far = np.abs(before.state.q[1::3][k]) < 0.99 * limit
        np.testing.assert_array_equal(now.limits.slope[far], before.limits.slope[far])
        np.testing.assert_array_equal(now.limits.cohesion[far], before.limits.cohesion[far])
        kept += int(far.sum())
        turned = np.abs(before.state.q[1::3][k]) > limit * (1 - 1e-6)
        assert (now.limits.slope[turned] != before.limits.slope[turned]).any()
    assert kept > 0


def test_turning_only_some_changes_the_path():
    free = mo.solve(WALL_4, **PAPER).history["load_factor"].to_numpy()
    some = mo.solve(WALL_4, **PAPER, only_at_yield=True).history["load_factor"].to_numpy()
    assert some[0] == free[0]
    assert some[1] != pytest.approx(free[1], rel=1e-6)


@pytest.mark.parametrize("wrong", [{"move_limit": 0}, {"move_limit": -1.0}, {"only_at_yield": 1}])
def test_wrong_values_are_refused(wrong):
    with pytest.raises(mo.OptionError, match=next(iter(wrong))):
        mo.solve(WALL_2, **wrong)

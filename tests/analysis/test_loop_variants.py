"""Section 6.4: move limits, and turning only the shear limits of joints at yield."""

from __future__ import annotations

import itertools

import numpy as np
import pytest
from paper_scripts import definitions
from scenes import WALLS, declared

import masonry_opt as mo
from masonry_opt.methods.loop.options import Attempt, LoopOptions
from masonry_opt.methods.loop.run import run
from masonry_opt.methods.loop.steps import LimitUpdate
from masonry_opt.problem.assembly import assemble
from masonry_opt.solvers.registry import find_solver

VARIANTS = definitions("variants")
move_limit, only_at_yield = VARIANTS.move_limit, VARIANTS.only_at_yield
WALL_2, WALL_4 = WALLS[1], WALLS[3]
PAPER = {"sub_problems": "accurate", "finish": False}
CLARABEL = find_solver("cvxpy", None)


def steps(path, revise=LimitUpdate.limits):
    """The problem, and each sub-problem: its state and limits."""
    problem = assemble(mo.load(path)).problem
    parameters = LoopOptions(**PAPER).parameters(problem.joints, CLARABEL)
    said = []
    run(problem, declared(problem), Attempt(parameters, CLARABEL), said.append, revise)
    return problem, [step.solved for step in said]


def turned_about(problem, step):
    """Normal forces about which a sub-problem's shear limits turn: c = c0 + (μ - slope) n."""
    return step.limits.cohesion / (problem.friction - step.limits.slope)


def test_a_huge_move_limit_is_none():
    ours = mo.solve(WALL_2, "nonassociative", **PAPER, revise=move_limit(1e9)).history["load_factor"]
    none = mo.solve(WALL_2, "nonassociative", **PAPER).history["load_factor"]
    np.testing.assert_array_equal(ours, none)


def test_a_move_limit_bounds_what_the_limits_turn_about():
    """As a share of the force and the mean one; the small cohesion, 1e-5 of the largest force, aside."""
    share = 0.1
    problem, said = steps(WALL_2, move_limit(share))
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
    path = [step.state.load_factor for step in said]
    assert path[1] == free[1].state.load_factor
    assert path != [step.state.load_factor for step in free]


def test_only_joints_at_yield_are_turned():
    problem, said = steps(WALL_4, only_at_yield)
    kept = 0
    for before, now in itertools.pairwise(said[1:]):
        limit = before.limits.cohesion + before.limits.slope * (problem.N @ before.state.q)
        shear = np.abs(problem.shears(before.state.q)[0, problem.sliding])
        far = shear < 0.99 * limit
        np.testing.assert_array_equal(now.limits.slope[far], before.limits.slope[far])
        np.testing.assert_array_equal(now.limits.cohesion[far], before.limits.cohesion[far])
        kept += int(far.sum())
        turned = shear > limit * (1 - 1e-6)
        assert (now.limits.slope[turned] != before.limits.slope[turned]).any()
    assert kept > 0


def test_turning_only_some_changes_the_path():
    free = mo.solve(WALL_4, "nonassociative", **PAPER).history["load_factor"].to_numpy()
    some = mo.solve(WALL_4, "nonassociative", **PAPER, revise=only_at_yield).history["load_factor"].to_numpy()
    assert some[0] == free[0]
    assert some[1] != pytest.approx(free[1], rel=1e-6)


def test_a_move_limit_forgets_the_run_before():
    """It keeps the forces that its limits turned about, and begins anew with every run."""
    revise = move_limit(0.1)
    first, again = (
        mo.solve(WALL_2, "nonassociative", **PAPER, revise=revise).history["load_factor"] for _ in range(2)
    )
    np.testing.assert_array_equal(first, again)

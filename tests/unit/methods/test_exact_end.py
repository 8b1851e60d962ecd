"""The loop's exact end and its paces: what they leave, against the loop without them."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from scenes import CASES, block_on_floor

import masonry_opt as mo
from masonry_opt.effort import Stopwatch
from masonry_opt.methods.loop.exact_end import MOST_ENERGY, exact_finish
from masonry_opt.methods.loop.options import FAST_FROM, LoopOptions
from masonry_opt.methods.loop.steps import first_limits, run_loop
from masonry_opt.problem.assembly import assemble
from masonry_opt.solvers.driver import declare
from masonry_opt.solvers.registry import find_solver, rougher

FACADE = CASES / "gilbert" / "facade_1x3.toml"
#: One program more, solved to 1e-9 like every other; energy is a sum over joints.
EXACT = 1e-7 * 10


def wall(number: int):
    return CASES / "ferris_tinloi" / f"wall_{number}.toml"


@pytest.mark.parametrize("number", range(1, 7))
def test_walls_end_in_an_exact_state_near_the_loops_own_load_factor(number):
    result, raw = mo.solve(wall(number)), mo.solve(wall(number), finish=False)
    left = result.certificate
    assert max(left.equilibrium, left.yield_) < 1e-8
    assert left.complementarity < EXACT
    assert raw.certificate.yield_ > 1e-5
    assert result.load_factor == pytest.approx(raw.load_factor, abs=1e-5)
    assert "exact state on their mechanism" in result.message
    assert "exact" not in raw.message
    # The series before it is the same.
    np.testing.assert_array_equal(result.history["load_factor"], raw.history["load_factor"])


@pytest.mark.parametrize("path", [FACADE, wall(6)], ids=["façade", "wall 6"])
def test_fast_pace_takes_fewer_iterations_to_an_exact_state(path):
    fast, paper = mo.solve(path, pace="fast"), mo.solve(path, pace="paper")
    assert fast.status is mo.Status.CONVERGED
    # Solved to 1e-9 in units of the load, here some hundred of the certificate's block weights.
    assert max(fast.certificate.equilibrium, fast.certificate.yield_) < 5e-7
    # The mechanism is of the true flow rule, and what it leaves is what no forces near it avoid.
    assert fast.certificate.flow < 1e-7
    assert fast.certificate.complementarity < MOST_ENERGY * fast.load_factor
    assert fast.load_factor <= mo.solve(path, "static").load_factor
    assert fast.iterations < paper.iterations


def test_pace_is_chosen_by_size():
    options = LoopOptions()
    assert options.parameters(FAST_FROM - 1) == LoopOptions(pace="paper").parameters(FAST_FROM)
    assert options.parameters(FAST_FROM) == LoopOptions(pace="fast").parameters(1)
    assert LoopOptions(pace="fast", alpha=0.2).parameters(1).alpha == 0.2


@pytest.mark.parametrize("solver", ["highs", "highs-ipm"])
def test_solvers_that_cannot_be_rough_keep_the_paper_s_pace(solver):
    """HiGHS's interior point ends "unknown" at 1e-4, its simplex in a vertex all the same."""
    options = LoopOptions()
    assert options.parameters(FAST_FROM, solver) == LoopOptions(pace="paper").parameters(1)
    asked = mo.solve(wall(1), solver=solver, pace="fast")
    assert asked.status is mo.Status.CONVERGED
    assert asked.solver == solver
    assert "with solver" not in asked.message  # nor did another one help it out


@pytest.mark.parametrize("name", ["clarabel", "highs", "highs-ipm"])
def test_tolerance_of_rough_sub_problems_reaches_the_solver(name):
    solver = find_solver("cvxpy", name)
    rough = rougher(solver, 1e-4)
    assert (rough.name, rough.tolerance) == (name, 1e-4)
    changed = {key: value for key, value in rough.options.items() if solver.options.get(key) != value}
    assert {value for value in changed.values() if value is not False} == {1e-4}
    # Never tighter than was asked for.
    assert rougher(rough, 1e-9) == rough


def test_fast_pace_is_solved_roughly(monkeypatch):
    asked = []
    monkeypatch.setattr(
        "masonry_opt.methods.loop.runs.rougher",
        lambda solver, tolerance: asked.append(tolerance) or rougher(solver, tolerance),
    )
    mo.solve(wall(1), pace="paper")
    assert asked == []
    mo.solve(wall(1), pace="fast")
    assert asked == [1e-4]


def test_no_exact_state_on_faces_that_cannot_all_be_at_yield():
    """A block that slides to the right is not at yield to the left; on that mechanism there is no state."""
    scene = block_on_floor(4, 2, 0.65)
    problem = assemble(scene).problem
    state = mo.solve(scene, "static").finding
    p = np.zeros((4, 1))
    p[:2] = 1.0  # slides to both sides at once
    broken = type("State", (), {"p": p, "q": state.q, "d": state.d})()
    exact, solves = exact_finish(problem, broken, state.load_factor, Stopwatch())
    assert exact is None
    assert solves == 2


def test_an_early_end_that_fails_is_tried_again_after_a_pause(monkeypatch):
    """Also where λ stands still all the while, as it does at every step for so large a tolerance."""
    at = []
    problem = assemble(mo.load(wall(1))).problem
    parameters = replace(LoopOptions(pace="fast", tol=0.5).parameters(1), max_iterations=14)
    limits = first_limits(problem, parameters)
    driver = declare(problem, "static", find_solver("cvxpy", None), Stopwatch(), limits)
    seen = []
    monkeypatch.setattr(
        "masonry_opt.methods.loop.steps.rough_finish", lambda *_: at.append(len(seen)) or (None, 2)
    )
    finding, _ = run_loop(problem, driver, parameters, seen.append)
    assert finding.status is mo.Status.ITERATION_LIMIT
    assert len(at) > 2
    assert {later - before for before, later in pairwise(at)} == {2}

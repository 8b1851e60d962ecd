"""The loop: what it touches, how it stops, and what it says when it does not."""

from __future__ import annotations

import highspy
import numpy as np
import pytest
from scenes import CASES, block_on_floor, two_blocks

import masonry_opt as mo
from masonry_opt.effort import Stopwatch
from masonry_opt.methods.loop.options import LoopOptions
from masonry_opt.methods.loop.steps import run_loop
from masonry_opt.problem.assembly import assemble
from masonry_opt.problem.problem import ShearLimits
from masonry_opt.solvers.driver import declare
from masonry_opt.solvers.registry import find_solver

WALL_1 = CASES / "ferris_tinloi" / "wall_1.toml"
WALL_3 = CASES / "ferris_tinloi" / "wall_3.toml"
WALL_6 = CASES / "ferris_tinloi" / "wall_6.toml"


#: The paper's loop and nothing else: no exact state at the end, no second run.
RAW = {"finish": False, "remedies": "none"}


def declared(scene, language="cvxpy"):
    problem = assemble(scene).problem
    k = problem.sliding
    limits = ShearLimits(problem.friction[k], problem.cohesion[k])
    return problem, declare(problem, "static", find_solver(language, None), Stopwatch(), limits)


def compiled_cvxpy(driver):
    """Everything that Clarabel receives: cost, matrix, right-hand side."""
    data, _, _ = driver.model.program.get_problem_data("CLARABEL", solver_opts={})
    matrix = data["A"].tocoo()
    entries = dict(zip(zip(matrix.row.tolist(), matrix.col.tolist(), strict=True), matrix.data, strict=True))
    return entries, data["b"].copy(), data["c"].copy()


def test_loop_changes_nothing_but_the_shear_limits_in_cvxpy():
    problem, driver = declared(mo.load(WALL_1))
    entries, rhs, cost = compiled_cvxpy(driver)
    finding, _ = run_loop(problem, driver, LoopOptions().parameters(problem.joints))
    assert len(finding.history) > 3
    entries_after, rhs_after, cost_after = compiled_cvxpy(driver)

    # Rows 3b ... 3b + 2k are the shear rows; columns 0 ... c the normal forces.
    b3, k, c = 3 * problem.blocks, len(problem.sliding), problem.joints
    columns = {variable.name(): variable for variable in driver.model.program.variables()}
    assert list(columns) == ["load_factor", "n", "s", "m"]
    shear_rows = range(b3, b3 + 2 * k)
    normal_columns = range(1, 1 + c)
    assert entries.keys() == entries_after.keys()
    changed = {at for at in entries if entries[at] != entries_after[at]}
    allowed = {at for at in entries if at[0] in shear_rows and at[1] in normal_columns}
    assert changed == allowed  # every slope was changed, and nothing else
    assert set(np.flatnonzero(rhs != rhs_after)) == set(shear_rows)  # every cohesion, nothing else
    np.testing.assert_array_equal(cost, cost_after)


def compiled_pyomo(driver):
    """Everything that HiGHS holds: matrix entries by (row, column), row bounds, and columns."""
    lp = driver._highs._solver_model.getLp()
    matrix = lp.a_matrix_
    major = np.repeat(np.arange(len(matrix.start_) - 1), np.diff(matrix.start_))
    by_column = matrix.format_ == highspy.MatrixFormat.kColwise
    row, column = (matrix.index_, major) if by_column else (major, matrix.index_)
    entries = {(int(i), int(j)): value for i, j, value in zip(row, column, matrix.value_, strict=True)}
    bounds = np.stack([lp.row_lower_, lp.row_upper_])
    return entries, bounds, np.stack([lp.col_cost_, lp.col_lower_, lp.col_upper_])


def test_loop_changes_nothing_but_the_shear_limits_in_pyomo():
    problem, driver = declared(mo.load(WALL_1), "pyomo")
    entries, bounds, columns = compiled_pyomo(driver)
    finding, _ = run_loop(problem, driver, LoopOptions().parameters(problem.joints))
    assert len(finding.history) > 3
    entries_after, bounds_after, columns_after = compiled_pyomo(driver)

    rows = driver._highs._pyomo_con_to_solver_con_map
    shear_rows = {rows[row] for row in driver.model.program.slide.values()}
    assert len(shear_rows) == 2 * len(problem.sliding)
    names = driver._highs._pyomo_var_to_solver_var_map
    normal_columns = {names[id(n)] for n in driver.model.program.n.values()}
    assert entries.keys() == entries_after.keys()
    changed = {at for at in entries if entries[at] != entries_after[at]}
    assert changed == {at for at in entries if at[0] in shear_rows and at[1] in normal_columns}
    assert set(np.flatnonzero((bounds != bounds_after).any(axis=0))) == shear_rows
    np.testing.assert_array_equal(columns, columns_after)


def test_it_does_not_run_where_nothing_slides():
    result = mo.solve(block_on_floor(1, 2, 0.8))
    assert result.status is mo.Status.CONVERGED
    assert result.lp_solves == 1
    assert not result.flow_rule_matters
    assert "no influence" in result.message
    always = mo.solve(block_on_floor(1, 2, 0.8), always=True)
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
    assert mo.solve(both).load_factor == pytest.approx(0.2, rel=1e-6)
    assert mo.solve(both, always=True).load_factor == pytest.approx(0.15, rel=1e-3)


def test_it_runs_where_something_slides():
    result = mo.solve(two_blocks())
    assert result.flow_rule_matters
    # One more program than sub-problems: the exact state at the end.
    assert result.lp_solves == len(result.history) + 1 > 2
    raw = mo.solve(two_blocks(), **RAW)
    assert raw.lp_solves == len(raw.history) > 1


def test_slopes_halve_from_alpha_to_alpha_min():
    """Step 5, literally: halved while above α_min, which it may undershoot once."""
    alpha = mo.solve(WALL_1, alpha=0.3, alpha_min=0.05).history["alpha"].to_numpy()
    np.testing.assert_allclose(alpha[1:7], [0.3, 0.15, 0.075, 0.0375, 0.05, 0.05])
    assert np.isnan(alpha[0])


def test_history_accounts_for_the_energy():
    """Fig. 12: raising and sliding add up to λ; associative flow spends all of it in raising."""
    history = mo.solve(WALL_6).history
    np.testing.assert_allclose(history["raising"] + history["sliding"], history["load_factor"], rtol=1e-6)
    assert history["sliding"].iloc[0] == pytest.approx(0, abs=1e-9)
    assert history["sliding"].iloc[-1] > 0.01
    assert (history["seconds"] > 0).all()


def test_step_6_takes_off_what_the_small_cohesion_dissipates():
    result = mo.solve(WALL_3, finish=False)
    uncorrected = result.history["load_factor"].iloc[-1]
    assert 0 < uncorrected - result.load_factor < 5e-4
    smaller = mo.solve(WALL_3, c0=1e-6)
    assert smaller.load_factor == pytest.approx(result.load_factor, rel=1e-5)


def test_sliding_hardly_contracts_at_the_end():
    """The loop does not stop while its slope is large: flow departs by no more than α_min μ."""
    scene = block_on_floor(4, 2, 0.65)
    assert mo.solve(scene).certificate.flow < 1.1e-3


@pytest.mark.parametrize("weight", [1.0, 10.0])
def test_a_neighbour_that_stands_apart_does_not_matter(weight):
    """A slab 100 blocks long: units are medians, the small cohesion is that of each part. (From 100
    block weights on, the solver's relative accuracy does choose the other end of wall 6.)"""
    wall = mo.load(WALL_6)
    slab = mo.Block(name="slab", vertices=[(100, 0), (500, 0), (500, 1), (100, 1)], weight=weight)
    floor = mo.Block(name="floor", vertices=[(99, -1), (501, -1), (501, 0), (99, 0)], fixed=True)
    beside = mo.Scene(joints=wall.joints, blocks=[*wall.blocks, slab, floor])
    assert mo.solve(beside).load_factor == pytest.approx(mo.solve(wall).load_factor, rel=5e-4)


#: The shear limits follow the last normal forces alone.
SWINGING = {"alpha": 0.0, "alpha_min": 0.0, "beta": 1.0}


def test_cycling_is_named_with_its_period_and_values():
    result = mo.solve(WALL_6, **SWINGING, **RAW)
    assert result.status is mo.Status.CYCLING
    assert result.load_factor is None
    assert result.certificate is None
    swing = result.history["load_factor"].iloc[-2:]
    assert (
        f"every 2 iterations, between load factors {swing.min():.6g} and {swing.max():.6g}" in result.message
    )
    assert swing.max() - swing.min() > 1e-5
    assert len(result.history) < 80


def test_iteration_limit_is_named():
    result = mo.solve(WALL_6, max_iterations=5, remedies="none")
    assert result.status is mo.Status.ITERATION_LIMIT
    assert result.load_factor is None
    assert len(result.history) == 5
    assert "max_iterations" in result.message


def test_a_sub_problem_without_state_is_named():
    """A large slope caps normal forces at c / (αμ) and locks joints of wall 6."""
    problem, driver = declared(mo.load(WALL_6))
    finding, _ = run_loop(problem, driver, LoopOptions(beta=0.2).parameters(problem.joints))
    assert finding.status is mo.Status.NO_STATE
    assert finding.load_factor is None
    assert "sub-problem 4" in finding.message


def test_the_loop_then_begins_again_with_less_slope_and_says_so():
    """Section 5.3: with β = 0.2 wall 6 takes many iterations (85 in the paper) to the same end."""
    result = mo.solve(WALL_6, beta=0.2)
    assert result.status is mo.Status.CONVERGED
    assert "began again with alpha = 0.1, then with alpha = 0.033;" in result.message
    assert len(result.history) > 60
    assert result.lp_solves > len(result.history)
    assert result.load_factor == pytest.approx(0.29649, rel=1e-3)


@pytest.mark.parametrize("number", range(1, 7))
def test_cohesive_start_ends_where_the_associative_start_does(number):
    """Section 6.3: "relatively insensitive to the starting conditions"; wall 6 alone moves, by 8e-4."""
    path = CASES / "ferris_tinloi" / f"wall_{number}.toml"
    cohesive, associative = mo.solve(path, start="cohesive"), mo.solve(path)
    assert cohesive.load_factor == pytest.approx(associative.load_factor, rel=1e-3)


def test_joints_with_their_own_dilatancy():
    """Dilatancy equal to friction is the associative problem; in between λ lies in between."""
    associative = mo.solve(two_blocks(), "static").load_factor
    scene = two_blocks()
    same = mo.Scene(
        joints=mo.JointDefaults(friction=0.1, dilatancy=0.1), blocks=scene.blocks, exceptions=scene.exceptions
    )
    result = mo.solve(same)
    assert result.load_factor == pytest.approx(associative, rel=1e-7)
    # Fig. 6d: any dilation lifts B, any contraction lets it down.
    for dilatancy, factor in ((0.05, 2.5), (-0.05, 1.5)):
        joints = mo.JointDefaults(friction=0.1, dilatancy=dilatancy)
        some = mo.Scene(joints=joints, blocks=scene.blocks, exceptions=scene.exceptions)
        assert mo.solve(some, alpha=0.01).load_factor == pytest.approx(factor * 0.1, rel=2e-3)


@pytest.mark.parametrize(
    ("option", "value"),
    [
        ("beta", 0),
        ("beta", 1.5),
        ("tol", 0),
        ("alpha", -1),
        ("max_iterations", 0),
        ("start", "warm"),
        ("gamma", 1),
    ],
)
def test_options_out_of_range_are_refused_by_name(option, value):
    with pytest.raises(mo.OptionError, match=option):
        mo.solve(two_blocks(), **{option: value})

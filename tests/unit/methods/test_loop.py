"""Parts of the loop: its steps, its termination, its options, its remedies, and its exact end."""

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from scenes import WALLS, block_on_floor, declared, small_wall, two_blocks

import masonry_opt as mo
from masonry_opt.effort import Effort
from masonry_opt.methods.associative import associative
from masonry_opt.methods.loop import run as loop_run
from masonry_opt.methods.loop.nonassociative import REMEDIES, Shortfall
from masonry_opt.methods.loop.options import PAPER, ROUGH_FROM, Attempt, LoopOptions
from masonry_opt.methods.loop.run import Run, accurate_end, diverges, obeys_own_flow, period, rough_end
from masonry_opt.methods.loop.steps import LimitUpdate, SubProblem, corrected
from masonry_opt.methods.task import Task
from masonry_opt.problem.assembly import assemble
from masonry_opt.problem.problem import State
from masonry_opt.solution.acceptance import MOST_ENERGY
from masonry_opt.solution.answer import certify
from masonry_opt.solution.reasons import Code, Status
from masonry_opt.solvers.registry import Solved, Verdict, find_solver

CLARABEL = find_solver("cvxpy", None)


# Steps of the loop -------------------------------------------------------------------------------------


def an_update(problem, about, alpha=0.3, small_cohesion=0.01):
    """Return an update about the normal forces given; all other values are arbitrary."""
    k = len(problem.sliding)
    solved = Solved(Verdict.OPTIMAL, "", 0.0)
    last = SubProblem(1, solved, None, None, float("nan"), np.zeros(k), False)
    return LimitUpdate(problem, last, alpha, np.full(k, small_cohesion), about)


@pytest.mark.parametrize(("cohesion", "dilatancy"), [(0.0, 0.0), (0.1, 0.2), (0.1, 0.65)])
def test_step_4_turns_each_limit_about_its_normal_force(cohesion, dilatancy):
    """The limit is |s| ≤ c⁰ + (1 + α) n μ − α n' μ. At n' = n it is the true law plus the small cohesion, and
    its slope is tan φ₀ minus α μ. Joints that dilate at their friction angle keep their limits."""
    problem = assemble(small_wall(cohesion=cohesion, dilatancy=dilatancy)).problem
    about = np.linspace(0.5, 4.0, problem.joints)
    limits, small = an_update(problem, about).limits(), 0.01 if dilatancy < 0.65 else 0.0
    slope = dilatancy - 0.3 * problem.friction if small else problem.friction
    np.testing.assert_allclose(limits.slope, slope)
    at = limits.cohesion + limits.slope * about[problem.sliding]
    np.testing.assert_allclose(at, problem.cohesion + problem.friction * about[problem.sliding] + small)


def test_step_6_takes_off_the_small_cohesion_of_every_slip():
    problem = assemble(small_wall()).problem
    k = len(problem.sliding)
    p = np.zeros(problem.faces)
    p[0], p[k + 1], p[-1] = 0.5, 0.25, 1.0
    state = State(0.6, np.ones(3 * problem.joints), np.zeros(3 * problem.blocks), p)
    solved = Solved(Verdict.OPTIMAL, "", 0.0)
    last = SubProblem(9, solved, state, None, 0.001, np.full(k, 0.04), True)
    assert corrected(problem, last) == pytest.approx(0.6 - 0.04 * 0.75 / problem.live_norm)


def test_slopes_halve_from_alpha_to_alpha_min():
    """In step 5 of the paper, α is halved while it is above α_min, so it may be below α_min once."""
    problem = assemble(small_wall(6, 5)).problem
    options, said = LoopOptions(**PAPER | {"alpha_min": 0.05, "always": True}), []
    attempt = Attempt(options.parameters(problem.joints, CLARABEL), CLARABEL)
    Run(problem, declared(problem), attempt).follow(said.append)
    alpha = np.array([step.alpha for step in said])
    np.testing.assert_allclose(alpha[1:7], [0.3, 0.15, 0.075, 0.0375, 0.05, 0.05])
    assert np.isnan(alpha[0])


def test_dilatancy_at_friction_is_the_flow_of_the_first_sub_problem():
    for dilatancy, obeys in ((0.65, True), (0.3, False)):
        problem = assemble(block_on_floor(4, 2, 0.65)).problem
        problem.dilatancy[:] = dilatancy
        assert obeys_own_flow(problem, declared(problem).solve().state) is obeys


def test_joints_that_dilate_at_their_friction_angle_have_no_mismatch():
    """The loop adds its small cohesion only to joints with less dilatancy. The limits of all other joints are
    exact, so their energy has no error, although they slide."""
    problem = assemble(small_wall(dilatancy=0.65)).problem
    options, steps = LoopOptions(c0=0.01, always=True, finish=False), []
    attempt = Attempt(options.parameters(problem.joints, CLARABEL), CLARABEL)
    Run(problem, declared(problem), attempt).follow(steps.append)
    assert len(steps) > 1
    assert all(problem.slip(step.solved.state.p).max() > 0.01 for step in steps)
    assert [step.mismatch for step in steps] == [0.0] * len(steps)


# Termination -------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("load_factors", "expected"),
    [
        ([1.0, 2.1, 4.3, 8.7, 17.5, 35.1], True),  # more than doubles five times
        ([1.0, 2.1, 4.3, 8.7, 17.5, 34.9], False),
        ([1.0, 2.1, 4.3, 8.7, 17.5], False),
        ([-1.0, 2.1, 4.3, 8.7, 17.5, 35.1], False),
        ([1.0, *(1001 * 1.011**step for step in range(31))], True),  # thirty rises by more than 1 %
        ([1.0, *(1001 * 1.009**step for step in range(31))], False),
        ([1.0, *(1.011**step for step in range(31))], False),  # less than a thousand times the first
    ],
)
def test_divergence(load_factors, expected):
    assert diverges(load_factors) is expected


@pytest.mark.parametrize("length", [2, 3, 6])
def test_a_cycle_is_found_when_it_came_back_twice(length):
    swing = np.linspace(0.3, 0.4, length)
    load_factors = [*np.linspace(0.9, 0.5, 5), *np.tile(swing, 3)]
    normal = [np.array([value, 1.0]) for value in load_factors]
    assert period(load_factors, normal) == length
    assert period(load_factors[:-1], normal[:-1]) == 0
    # Only λ repeats, and the forces differ.
    assert period(load_factors, [np.array([1.0 + step, 1.0]) for step in range(len(normal))]) == 0


def test_a_swing_that_dies_away_is_no_cycle():
    damped = [0.3 + 0.05 * (-0.8) ** step for step in range(40)]
    assert period(damped, [np.array([1.0])] * len(damped)) == 0


# Options -----------------------------------------------------------------------------------------------


def test_sub_problems_are_rough_or_accurate_by_size():
    options = LoopOptions()
    accurate, rough = LoopOptions(sub_problems="accurate"), LoopOptions(sub_problems="rough")
    assert options.parameters(ROUGH_FROM - 1, CLARABEL) == accurate.parameters(ROUGH_FROM, CLARABEL)
    assert options.parameters(ROUGH_FROM, CLARABEL) == rough.parameters(1, CLARABEL)
    assert accurate.parameters(1, CLARABEL).tolerance is None
    assert rough.parameters(1, CLARABEL).tolerance == 1e-4
    assert LoopOptions(sub_problems="rough", alpha=0.2).parameters(1, CLARABEL).alpha == 0.2


@pytest.mark.parametrize("solver", ["highs", "highs-ipm", "scs"])
def test_solvers_that_cannot_stop_early_solve_accurately(solver):
    """With a tolerance of 1e-4, the interior-point method of HiGHS ends with "unknown". Its simplex method
    ends in a vertex in any case."""
    solver = find_solver("cvxpy", solver)
    accurate = LoopOptions(sub_problems="accurate").parameters(1, solver)
    assert LoopOptions().parameters(ROUGH_FROM, solver) == accurate
    assert LoopOptions().parameters(ROUGH_FROM, CLARABEL) != accurate


def test_the_preset_is_section_5_and_what_stands_beside_it_counts():
    paper = LoopOptions(preset="paper")
    assert {name: getattr(paper, name) for name in PAPER} == PAPER
    assert (PAPER["alpha"], PAPER["beta"], PAPER["tol"], PAPER["c0"]) == (0.3, 0.6, 1e-5, 1e-5)
    assert LoopOptions(preset="paper", beta=0.2).beta == 0.2
    assert LoopOptions(preset="paper", remedies="none").remedies == "none"
    assert not paper.parameters(10 * ROUGH_FROM, CLARABEL).finish


def test_limits_may_be_revised_in_another_way():
    """Limits that never change are the associative ones, so λ remains 2.5 μ."""
    turns = []

    def left_as_they_are(turn):
        turns.append(turn.last.number)
        return turn.last.limits

    result = mo.solve(two_blocks(), "nonassociative", revise=left_as_they_are, finish=False, always=True)
    np.testing.assert_allclose(result.history["load_factor"], 0.25, rtol=1e-7)
    assert turns == list(range(1, len(result.history)))


FIRST = Attempt(LoopOptions().parameters(1, CLARABEL), CLARABEL)
ROUGH = Attempt(LoopOptions(sub_problems="rough").parameters(1, CLARABEL), CLARABEL)


def series(failure, attempt):
    """Return the names of the remedies for a failure, each applied to the attempt of the previous remedy."""
    names = []
    for remedy in REMEDIES[failure]:
        following = remedy(attempt)
        if following is not None:
            attempt = following
            names.append(attempt.remedy)
    return names


#: Remedies in order, by the failure of the first run.
ORDER = {
    Status.NO_STATE: ["alpha=0.1", "alpha=0.033", "alpha=0.011", "alpha=0.0037", "alpha=0.0012"],
    Status.CYCLING: ["beta=0.3", "beta=0.15", "solver=highs-ipm"],
    Status.ITERATION_LIMIT: [],
    Status.SOLVER_FAILED: ["solver=highs-ipm"],
    Status.LOCKED: ["start=cohesive"],
    Shortfall.INEXACT: ["solver=highs-ipm"],
    Shortfall.ROUGH: [],
}


@pytest.mark.parametrize("failure", REMEDIES)
def test_order_of_the_remedies(failure):
    assert series(failure, FIRST) == ORDER[failure]


NOT_BY_ROUGH = [Status.CYCLING, Status.SOLVER_FAILED, Shortfall.ROUGH, Shortfall.INEXACT]


@pytest.mark.parametrize("failure", NOT_BY_ROUGH)
def test_rough_sub_problems_are_first_solved_accurately(failure):
    """The failure of a run with rough sub-problems proves little, so accurate sub-problems are the first
    remedy."""
    assert series(failure, ROUGH)[0] == "sub_problems=accurate"
    accurate = REMEDIES[failure][0](ROUGH)
    assert accurate.parameters == ROUGH.parameters.model_copy(update={"tolerance": None})
    assert REMEDIES[failure][0](FIRST) is None


def test_another_solver_is_another():
    of_highs = replace(FIRST, solver=find_solver("cvxpy", "highs-ipm"))
    assert series(Status.SOLVER_FAILED, of_highs) == ["solver=clarabel"]


def test_rough_sub_problems_leave_the_associative_load_factor_to_a_program_of_its_own():
    """The associative load factor of wall 2 is 0.58000 (Gilbert, Casapulla & Ahmed 2006, Table 1). Rough
    sub-problems end 4e-4 above it, so a separate program computes it."""
    found = mo.solve(WALLS[1], "nonassociative", sub_problems="rough", incremental=False)
    assert found.associative == pytest.approx(
        mo.solve(WALLS[1], "static", solver="highs").load_factor, rel=1e-9
    )


#: Tolerance of comparisons of programs that are solved to 1e-9, with numbers near 1.
SAME = 1e-7
ENDED = {
    "wall": small_wall(4, 3),
    "cohesion": small_wall(4, 3, cohesion=0.05),
    "dilatancy": small_wall(4, 3, dilatancy=0.1),
    "nothing slides": small_wall(4, 3, friction=float("inf")),
}


@pytest.fixture(scope="module")
def exact_states():
    """Return, for each scene, the problem and the state in which the loop ends."""
    found = {}
    for name, scene in ENDED.items():
        result = mo.solve(scene, "nonassociative", sub_problems="accurate", always=True)
        problem, solution = result.assembly.problem, result.solution
        p = problem.rates(solution.d, problem.dilatancy)
        found[name] = problem, State(result.load_factor, solution.q, solution.d, p)
    return found


@pytest.mark.parametrize("name", ENDED)
def test_a_rough_mechanism_leads_back_to_an_exact_state(name, exact_states):
    problem, state = exact_states[name]
    # An interior-point method leaves the same energy in every face.
    noise = 1e-4
    rough = state.p + noise / np.maximum(problem.slacks(state.q), noise)
    effort = Effort()
    found = rough_end(problem, replace(state, p=rough), CLARABEL, effort)
    assert effort.lp_solves == 2
    # λ may fall by the energy that the noise adds, noise times the number of faces.
    assert found.load_factor == pytest.approx(state.load_factor, rel=1e-2)
    assert problem.slacks(found.q).min() > -SAME
    left = certify(problem, found.load_factor, found.q, found.d, found.slope)
    assert max(left.equilibrium, left.flow) < 10 * SAME
    assert left.complementarity < MOST_ENERGY * found.load_factor


def test_without_a_mechanism_of_its_own_flow_the_sub_problem_s_is_kept(failing, exact_states):
    problem, state = exact_states["wall"]
    asked = []
    failing("cvxpy", lambda engine: asked.append(engine) or len(asked) > 1)
    found = rough_end(problem, state, CLARABEL, Effort())
    assert len(asked) == 2
    np.testing.assert_array_equal(found.d, state.d)


def test_no_forces_no_end(exact_states):
    """With the dead load reversed, every joint of the wall would be in tension. No forces exist for any
    mechanism."""
    problem, state = exact_states["wall"]
    assert rough_end(problem, state, CLARABEL, Effort()) is not None
    effort = Effort()
    assert rough_end(replace(problem, dead=-problem.dead), state, CLARABEL, effort) is None
    assert effort.lp_solves == 1


def test_no_exact_state_on_faces_that_cannot_all_be_at_yield():
    """A block that slides to the right is not at yield to the left. No exact state exists for a mechanism
    with both rates."""
    result = mo.solve(block_on_floor(4, 2, 0.65), "static")
    problem, solution = result.assembly.problem, result.solution
    to_both_sides = np.array([1.0, 1.0, 0.0, 0.0])
    broken = State(result.load_factor, solution.q, solution.d, to_both_sides)
    effort = Effort()
    assert accurate_end(problem, broken, result.load_factor, CLARABEL, effort) is None
    assert effort.lp_solves == 2


def test_an_early_end_that_fails_is_tried_again_after_a_pause(failing):
    """With such a large tolerance, λ counts as constant at every step. The failed end is nevertheless tried
    only at every other step."""
    problem = assemble(mo.load(WALLS[0])).problem
    parameters = LoopOptions(sub_problems="rough", tol=0.5, max_iterations=14).parameters(1, CLARABEL)
    seen, tried_after = [], []

    def exact_end(engine):
        fails = engine._purpose == "exact end"
        tried_after.extend([len(seen)] * fails)
        return fails

    failing("cvxpy", exact_end)
    solution = loop_run.Run(problem, declared(problem), Attempt(parameters, CLARABEL)).follow(seen.append)
    assert solution.status is mo.Status.ITERATION_LIMIT
    assert [reason.code for reason in solution.reasons] == [Code.STILL_CHANGES]
    assert len(tried_after) > 2
    assert {later - before for before, later in pairwise(tried_after)} == {2}


def test_the_dual_answers_where_a_program_ends_short():
    """With more and more iterations of Clarabel, the answer is first missing, then that of the dual, then
    that of the program itself. λ of wall 2 is 0.58000 (Gilbert, Casapulla & Ahmed 2006, Table 1)."""
    problem, solver = assemble(mo.load(WALLS[1])).problem, find_solver("cvxpy", None)
    found = []
    for most in range(10, 15):
        task = Task(problem, replace(solver, options=solver.options | {"max_iter": most}))
        load_factor = associative(task, "kinematic").load_factor
        found.append((task.effort.lp_solves, load_factor))
    answers = [(programs, load_factor) for programs, load_factor in found if load_factor is not None]
    assert found[0] == (2, None)
    assert [answers[0][0], answers[-1][0]] == [2, 1]
    assert [answers[0][1], answers[-1][1]] == pytest.approx([0.58, 0.58], abs=2e-5)

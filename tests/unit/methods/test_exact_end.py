"""The loop's exact end: what it leaves from exact and from rough mechanisms, and when there is none."""

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from scenes import WALLS, block_on_floor, declared, small_wall

import masonry_opt as mo
from masonry_opt.answer.answer import certify
from masonry_opt.answer.reasons import Code
from masonry_opt.effort import Effort
from masonry_opt.methods.associative import associative
from masonry_opt.methods.loop import exact_end
from masonry_opt.methods.loop import run as loop_run
from masonry_opt.methods.loop.exact_end import MOST_ENERGY, accurate_end, rough_end
from masonry_opt.methods.loop.options import Attempt, LoopOptions
from masonry_opt.methods.task import Task
from masonry_opt.models.cvxpy_exact import CvxpyForces, energy_costs
from masonry_opt.problem.assembly import assemble
from masonry_opt.problem.problem import State
from masonry_opt.solvers.cvxpy_engine import has_optimum
from masonry_opt.solvers.registry import find_solver

#: Programs solved to 1e-9 of numbers near one.
SAME = 1e-7
CLARABEL = find_solver("cvxpy", None)
SCENES = {
    "wall": small_wall(4, 3),
    "cohesion": small_wall(4, 3, cohesion=0.05),
    "dilatancy": small_wall(4, 3, dilatancy=0.1),
    "nothing slides": small_wall(4, 3, friction=float("inf")),
}


@pytest.fixture(scope="module")
def exact_states():
    """By scene: the problem and the state that the loop ends in."""
    found = {}
    for name, scene in SCENES.items():
        result = mo.solve(scene, "nonassociative", sub_problems="accurate", always=True)
        problem, solution = result.assembly.problem, result.solution
        p = problem.rates(solution.d, problem.dilatancy)
        found[name] = problem, State(result.load_factor, solution.q, solution.d, p)
    return found


@pytest.mark.parametrize("name", SCENES)
def test_a_rough_mechanism_leads_back_to_an_exact_state(name, exact_states):
    problem, state = exact_states[name]
    # What an interior point leaves: the same energy in every face.
    noise = 1e-4
    rough = state.p + noise / np.maximum(problem.slacks(state.q), noise)
    effort = Effort()
    found = rough_end(problem, replace(state, p=rough), CLARABEL, effort)
    assert effort.lp_solves == 2
    # λ may fall by what noise · faces of energy are worth.
    assert found.load_factor == pytest.approx(state.load_factor, rel=1e-2)
    assert problem.slacks(found.q).min() > -SAME
    left = certify(problem, found.load_factor, found.q, found.d, found.slope)
    assert max(left.equilibrium, left.flow) < 10 * SAME
    assert left.complementarity < MOST_ENERGY * found.load_factor


@pytest.mark.parametrize("number", [1, pytest.param(3, marks=pytest.mark.slow)])
def test_exact_collapse_states_are_left_as_they_are(number):
    """For the mechanism of an exact state no forces do better than none, and their λ is no higher."""
    exact = mo.solve(WALLS[number - 1], "refined")
    problem, d = exact.assembly.problem, exact.solution.d
    p = problem.rates(d, problem.dilatancy)
    model = CvxpyForces(problem, energy_costs(problem, p, 1e3))
    assert has_optimum(model.program, CLARABEL, Effort(), "test")
    load_factor, q = model.statics.forces()
    assert problem.slacks(q) @ p < 10 * SAME
    assert load_factor <= exact.load_factor + SAME


def test_without_a_mechanism_of_its_own_flow_the_sub_problem_s_is_kept(monkeypatch, exact_states):
    problem, state = exact_states["wall"]
    solved = []

    def only_the_first(*arguments, **options):
        solved.append(has_optimum(*arguments, **options))
        return len(solved) == 1 and solved[0]

    monkeypatch.setattr(exact_end, "has_optimum", only_the_first)
    found = rough_end(problem, state, CLARABEL, Effort())
    assert solved == [True, True]
    np.testing.assert_array_equal(found.d, state.d)


def test_no_forces_no_end(exact_states):
    """Hung up, every joint of a wall would have to pull: there are no forces for any mechanism."""
    problem, state = exact_states["wall"]
    assert rough_end(problem, state, CLARABEL, Effort()) is not None
    effort = Effort()
    assert rough_end(replace(problem, dead=-problem.dead), state, CLARABEL, effort) is None
    assert effort.lp_solves == 1


def test_no_exact_state_on_faces_that_cannot_all_be_at_yield():
    """A block that slides to the right is not at yield to the left; on that mechanism there is no state."""
    result = mo.solve(block_on_floor(4, 2, 0.65), "static")
    problem, solution = result.assembly.problem, result.solution
    to_both_sides = np.array([1.0, 1.0, 0.0, 0.0])
    broken = State(result.load_factor, solution.q, solution.d, to_both_sides)
    effort = Effort()
    assert accurate_end(problem, broken, result.load_factor, CLARABEL, effort) is None
    assert effort.lp_solves == 2


def test_an_early_end_that_fails_is_tried_again_after_a_pause(monkeypatch):
    """Also where λ stands still all the while, as it does at every step for so large a tolerance."""
    problem = assemble(mo.load(WALLS[0])).problem
    parameters = LoopOptions(sub_problems="rough", tol=0.5, max_iterations=14).parameters(1, CLARABEL)
    seen, tried_after = [], []
    monkeypatch.setattr(loop_run, "rough_end", lambda *_: tried_after.append(len(seen)))
    solution = loop_run.run(problem, declared(problem), Attempt(parameters, CLARABEL), seen.append)
    assert solution.status is mo.Status.ITERATION_LIMIT
    assert [reason.code for reason in solution.reasons] == [Code.STILL_CHANGES]
    assert len(tried_after) > 2
    assert {later - before for before, later in pairwise(tried_after)} == {2}


def test_the_dual_answers_where_a_program_ends_short():
    """With ever more iterations of Clarabel: nothing, then by the dual, then by the program itself; λ of wall
    2 is .58000 (Gilbert, Casapulla & Ahmed 2006, Table 1: .58000)."""
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

"""The two halves of complementarity (CVXPY, Clarabel) against the same programs in Pyomo and HiGHS."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scenes import CASES, small_wall

import masonry_opt as mo
from masonry_opt.analysis import exact_finish
from masonry_opt.answer.certificate import certify, rates
from masonry_opt.effort import Stopwatch
from masonry_opt.methods.loop.exact_end import rough_finish
from masonry_opt.methods.refined.programs import Refiner
from masonry_opt.problem.assembly import assemble
from masonry_opt.problem.problem import yield_slacks
from masonry_opt.problem.state import State
from masonry_opt.solvers.cvxpy_driver import forces_for, motion_for
from masonry_opt.solvers.driver import declare
from masonry_opt.solvers.registry import find_solver

WALLS = [CASES / "ferris_tinloi" / f"wall_{number}.toml" for number in (1, 3, 5)]
#: Two solvers, each to 1e-9 of energies near one.
SAME = 1e-7

SCENES = {
    "wall": small_wall(6, 5),
    "cohesion": small_wall(4, 3, cohesion=0.05),
    "dilatancy": small_wall(4, 3, dilatancy=0.1),
    "nothing slides": small_wall(4, 3, friction=float("inf")),
}


def energy(problem, slacks, d):
    p = rates(problem, d, problem.dilatancy)
    return float((np.where(np.isfinite(slacks), slacks, 0.0) * p).sum())


@pytest.mark.parametrize("path", WALLS, ids=lambda path: path.stem)
def test_least_energy_of_motion_is_the_simplex_s(path):
    """For forces of less friction, under which nothing slides freely."""
    problem = assemble(mo.load(path)).problem
    weaker = problem.with_friction(0.8 * problem.friction)
    q = declare(weaker, "static", find_solver("cvxpy", None), Stopwatch()).solve().state.q
    slacks = np.maximum(yield_slacks(problem, q), 0.0)
    d = motion_for(problem, slacks, problem.dilatancy[problem.sliding], Stopwatch())
    refiner = Refiner(problem)
    expected, _ = refiner.mechanism(np.maximum(refiner.slack(q), 0.0))
    assert energy(problem, slacks, d) > 1e-3
    assert energy(problem, slacks, d) == pytest.approx(energy(problem, slacks, expected), abs=SAME)
    # No joint's ends pass into each other.
    u = problem.B.T @ d
    assert (u[0::3] - problem.half_length * np.abs(u[2::3])).min() > -SAME


@pytest.mark.parametrize("path", WALLS, ids=lambda path: path.stem)
def test_best_forces_for_an_associative_mechanism_are_the_simplex_s(path):
    """Weight and λ as the refinement has them: z·p + λ Σ|f_L| / 100."""
    result = mo.solve(path, "static")
    problem = result.assembly.problem
    p = rates(problem, result.finding.d, problem.friction)
    load_factor, q = forces_for(problem, p, 100.0, Stopwatch())
    refiner, k = Refiner(problem), problem.sliding
    expected = refiner._least_gap(np.concatenate([p[0][k], p[1][k], p[2], p[3]]))
    balance = problem.B @ expected + problem.dead
    expected_factor = -float(problem.live @ balance) / float(problem.live @ problem.live)

    def cost(load_factor, q):
        return float((yield_slacks(problem, q) * p).sum()) + load_factor * problem.live_norm / 100

    assert cost(load_factor, q) == pytest.approx(cost(expected_factor, expected), abs=10 * SAME)


@pytest.mark.parametrize("path", WALLS, ids=lambda path: path.stem)
def test_exact_collapse_states_are_left_as_they_are(path):
    """For the mechanism of an exact state no forces do better than none, and their λ is no higher."""
    exact = mo.solve(path, "refined", kicks=0)
    problem, d = exact.assembly.problem, exact.finding.d
    load_factor, q = forces_for(problem, rates(problem, d, problem.dilatancy), 1e3, Stopwatch())
    assert energy(problem, yield_slacks(problem, q), d) < 10 * SAME
    assert load_factor <= exact.load_factor + SAME


@pytest.mark.parametrize("name", SCENES)
@pytest.mark.parametrize("noise", [1e-5, 1e-4])
def test_a_rough_mechanism_leads_back_to_an_exact_state(name, noise):
    problem, state = exact_state(name)
    # What an interior point leaves: the same energy in every face.
    slacks = yield_slacks(problem, state.q)
    rough = state.p + np.where(np.isfinite(slacks), noise / np.maximum(slacks, noise), 0.0)
    found, solves = rough_finish(problem, replace(state, p=rough), Stopwatch())
    assert solves == 2
    # λ may fall by what noise · faces of energy are worth.
    assert found.load_factor == pytest.approx(state.load_factor, rel=1e-2)
    assert yield_slacks(problem, found.q).min() > -SAME
    left = certify(problem, found.load_factor, found.q, found.d, found.slope)
    assert max(left.equilibrium, left.flow) < 10 * SAME
    assert left.complementarity < exact_finish.MOST_ENERGY * found.load_factor


def exact_state(name):
    result = mo.solve(SCENES[name], pace="paper", always=True)
    problem, finding = result.assembly.problem, result.finding
    p = rates(problem, finding.d, problem.dilatancy)
    return problem, State(result.load_factor, finding.q, finding.d, p)


def test_without_a_mechanism_of_its_own_flow_the_sub_problem_s_is_kept(monkeypatch):
    problem, state = exact_state("wall")
    monkeypatch.setattr(exact_finish, "motion_for", lambda *_: None)
    found, _ = rough_finish(problem, state, Stopwatch())
    np.testing.assert_array_equal(found.d, state.d)


def test_no_forces_no_end():
    """Hung up, every joint of a wall would have to pull: there are no forces for any mechanism."""
    problem, state = exact_state("wall")
    hung = replace(problem, dead=-problem.dead)
    assert rough_finish(problem, state, Stopwatch())[0] is not None
    assert rough_finish(hung, state, Stopwatch()) == (None, 1)

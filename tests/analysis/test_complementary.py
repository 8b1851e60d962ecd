"""The two halves of complementarity (CVXPY, Clarabel) against the same programs in Pyomo and HiGHS."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scenes import CASES, small_wall

import masonry_opt as mo
from masonry_opt.analysis.exact_finish import rough_finish
from masonry_opt.analysis.refinement import Refiner
from masonry_opt.models.interface import State
from masonry_opt.problem.assembly import assemble
from masonry_opt.problem.problem import yield_slacks
from masonry_opt.solvers.cvxpy_driver import forces_for, motion_for
from masonry_opt.solvers.driver import declare
from masonry_opt.solvers.registry import find_solver
from masonry_opt.timing import Stopwatch

WALLS = [CASES / "ferris_tinloi" / f"wall_{number}.toml" for number in (1, 3, 5)]
#: Two solvers, each to 1e-9 of energies near one.
SAME = 1e-7


@pytest.mark.parametrize("path", WALLS, ids=lambda path: path.stem)
def test_least_energy_of_motion_is_the_simplex_s(path):
    """For forces of less friction, under which nothing slides freely."""
    problem = assemble(mo.load(path)).problem
    weaker = problem.with_friction(0.8 * problem.friction)
    q = declare(weaker, "static", find_solver("cvxpy", None), Stopwatch()).solve().state.q
    slacks = np.maximum(yield_slacks(problem, q), 0.0)
    d = motion_for(problem, slacks, problem.dilatancy[problem.sliding], Stopwatch())
    refiner = Refiner(problem)
    cost = np.maximum(refiner.slack(q), 0.0)
    expected, _ = refiner.mechanism(cost)
    assert energy(problem, slacks, d) > 1e-3
    assert energy(problem, slacks, d) == pytest.approx(energy(problem, slacks, expected), abs=SAME)
    # No joint's ends pass into each other.
    u = problem.B.T @ d
    assert (u[0::3] - problem.half_length * np.abs(u[2::3])).min() > -SAME


def energy(problem, slacks, d):
    u = problem.B.T @ d
    rates = np.stack([-u[1::3], u[1::3], -u[2::3], u[2::3]])
    return float((slacks * np.maximum(rates, 0.0)).sum())


@pytest.mark.parametrize("path", WALLS, ids=lambda path: path.stem)
def test_exact_collapse_states_are_left_as_they_are(path):
    """For the mechanism of an exact state no forces do better than none, and their λ is no higher."""
    exact = mo.solve(path, "refined", kicks=0)
    problem, d = exact.assembly.problem, exact.finding.d
    u = problem.B.T @ d
    rates = np.maximum(np.stack([-u[1::3], u[1::3], -u[2::3], u[2::3]]), 0.0)
    load_factor, q = forces_for(problem, rates, 1e3, Stopwatch())
    assert float((yield_slacks(problem, q) * rates).sum()) < 10 * SAME
    assert load_factor <= exact.load_factor + SAME


@pytest.mark.parametrize("noise", [1e-5, 1e-4])
def test_a_rough_mechanism_leads_back_to_an_exact_state(noise):
    scene = small_wall(6, 5)
    exact = mo.solve(scene, pace="paper")
    problem, finding = exact.assembly.problem, exact.finding
    u = problem.B.T @ finding.d
    rates = np.maximum(np.stack([-u[1::3], u[1::3], -u[2::3], u[2::3]]), 0.0)
    # What an interior point leaves: the same energy in every face.
    rates += noise / np.maximum(yield_slacks(problem, finding.q), noise)
    state = State(exact.load_factor, finding.q, finding.d, rates)
    found, solves = rough_finish(problem, state, Stopwatch())
    assert solves == 2
    assert found.load_factor == pytest.approx(exact.load_factor, abs=30 * noise * exact.load_factor)
    assert yield_slacks(problem, found.q).min() > -SAME


def test_no_forces_no_end():
    """Hung up, every joint of a wall would have to pull: there are no forces for any mechanism."""
    problem = assemble(small_wall(4, 3)).problem
    hung = replace(problem, dead=-problem.dead, live=0 * problem.live)
    everywhere = np.ones((4, problem.joints))
    assert forces_for(problem, everywhere, 30.0, Stopwatch()) is not None
    assert forces_for(hung, everywhere, 30.0, Stopwatch()) is None

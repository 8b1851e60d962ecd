"""Programs solved in units of the load answer as those in the problem's own units do."""

from __future__ import annotations

import numpy as np
import pytest
from scenes import CASES

import masonry_opt as mo
from masonry_opt.effort import Stopwatch
from masonry_opt.problem.assembly import assemble
from masonry_opt.problem.problem import ShearLimits
from masonry_opt.solvers.driver import declare
from masonry_opt.solvers.load_units import DriverInUnitsOfLoad, in_units_of_load
from masonry_opt.solvers.registry import find_solver

WALL = CASES / "ferris_tinloi" / "wall_3.toml"


@pytest.mark.parametrize("language", ["cvxpy", "pyomo"])
def test_states_and_shear_limits_are_in_the_problem_s_units(language):
    problem = assemble(mo.load(WALL)).problem
    solver = find_solver(language, None)
    cohesive = ShearLimits(problem.friction[problem.sliding], np.zeros(len(problem.sliding)))
    plain = declare(problem, "static", solver, Stopwatch(), cohesive)
    scaled = DriverInUnitsOfLoad(problem, "static", solver, Stopwatch(), cohesive)
    assert in_units_of_load(problem).force > 10  # else nothing is tested
    slope = 0.5 * problem.friction[problem.sliding]
    for limits in (cohesive, ShearLimits(slope, np.full(len(slope), 0.7))):
        for driver in (plain, scaled):
            driver.set_shear_limits(limits)
        expected, found = plain.solve().state, scaled.solve().state
        assert found.load_factor == pytest.approx(expected.load_factor, abs=1e-6)
        balance = problem.B @ found.q + found.load_factor * problem.live + problem.dead
        assert np.abs(balance).max() < 1e-6
        assert problem.live @ found.d == pytest.approx(problem.live_norm, rel=1e-6)
        slip = (found.p[0] + found.p[1])[problem.sliding]
        dissipated = limits.cohesion @ slip - problem.dead @ found.d
        assert dissipated == pytest.approx(found.load_factor * problem.live_norm, rel=1e-6)
    assert scaled.solves == plain.solves == 2
    assert scaled.size() == plain.size()

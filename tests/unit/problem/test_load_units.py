"""Programs solved in units of the load answer as those in the problem's own units do."""

from __future__ import annotations

import numpy as np
import pytest
from scenes import WALLS, declared

import masonry_opt as mo
from masonry_opt.problem.assembly import assemble
from masonry_opt.problem.load_units import in_units_of_load
from masonry_opt.problem.problem import ShearLimits


@pytest.mark.parametrize("language", ["cvxpy", "pyomo"])
def test_states_and_shear_limits_are_in_the_problem_s_units(language):
    problem = assemble(mo.load(WALLS[2])).problem
    cohesive = ShearLimits(problem.friction, np.zeros(len(problem.sliding)))
    plain = declared(problem, "static", language, limits=cohesive)
    scaled = declared(problem, "static", language, limits=cohesive, of_load=True)
    assert in_units_of_load(problem).force > 10  # else nothing is tested
    slope = 0.5 * problem.friction
    for limits in (cohesive, ShearLimits(slope, np.full(len(slope), 0.7))):
        for driver in (plain, scaled):
            driver.set_shear_limits(limits)
        expected, found = plain.solve().state, scaled.solve().state
        assert found.load_factor == pytest.approx(expected.load_factor, abs=1e-6)
        balance = problem.B @ found.q + found.load_factor * problem.live + problem.dead
        assert np.abs(balance).max() < 1e-6
        assert problem.live @ found.d == pytest.approx(problem.live_norm, rel=1e-6)
        dissipated = limits.cohesion @ problem.slip(found.p) - problem.dead @ found.d
        assert dissipated == pytest.approx(found.load_factor * problem.live_norm, rel=1e-6)
    assert scaled.effort.lp_solves == plain.effort.lp_solves == 2
    assert scaled.size() == plain.size()

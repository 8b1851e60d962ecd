"""The loop's exact end and its rough sub-problems: what they leave, against the loop without them."""

from __future__ import annotations

import numpy as np
import pytest
from scenes import CASES, WALLS, solved

import masonry_opt as mo
from masonry_opt.answer.reasons import Code
from masonry_opt.methods.loop.exact_end import MOST_ENERGY

FACADE = CASES / "gilbert" / "facade_1x3.toml"
#: One program more, solved to 1e-9 like every other; energy is a sum over joints.
EXACT = 1e-7 * 10


def codes(result):
    return [reason.code for reason in result.reasons]


@pytest.mark.parametrize("path", WALLS, ids=lambda path: path.stem)
def test_walls_end_in_an_exact_state_near_the_loops_own_load_factor(path):
    result, raw = solved(path, "nonassociative"), solved(path, "nonassociative", finish=False)
    left = result.certificate
    assert max(left.equilibrium, left.yield_) < 1e-8
    assert left.complementarity < EXACT
    assert raw.certificate.yield_ > 1e-5
    assert result.load_factor == pytest.approx(raw.load_factor, abs=1e-5)
    assert codes(result) == [Code.SUB_PROBLEMS, Code.EXACT_END]
    assert codes(raw) == [Code.SUB_PROBLEMS]
    assert result.solution.exact_end
    assert not raw.solution.exact_end
    # The series before it is the same.
    np.testing.assert_array_equal(result.history["load_factor"], raw.history["load_factor"])


@pytest.mark.parametrize(
    "path", [pytest.param(FACADE, marks=pytest.mark.slow), WALLS[5]], ids=["façade", "wall 6"]
)
def test_rough_sub_problems_take_fewer_iterations_to_an_exact_state(path):
    rough, accurate = (solved(path, "nonassociative", sub_problems=asked) for asked in ("rough", "accurate"))
    assert rough.status is mo.Status.CONVERGED
    # Solved to 1e-9 in units of the load, here some hundred of the certificate's block weights.
    assert max(rough.certificate.equilibrium, rough.certificate.yield_) < 5e-7
    # The mechanism is of the true flow rule, and what it leaves is what no forces near it avoid.
    assert rough.certificate.flow < 1e-7
    assert rough.certificate.complementarity < MOST_ENERGY * rough.load_factor
    assert rough.load_factor <= solved(path, "static", solver="highs-ipm").load_factor
    assert rough.iterations < accurate.iterations


@pytest.mark.parametrize("solver", ["highs", "highs-ipm"])
def test_a_solver_that_cannot_stop_early_is_kept_even_where_rough_sub_problems_are_asked_for(solver):
    asked = solved(WALLS[0], "nonassociative", solver=solver, sub_problems="rough")
    assert asked.status is mo.Status.CONVERGED
    assert asked.solver == solver
    # Nor did another one help it out.
    assert asked.solvers["sub-problems"] == asked.solvers["exact end"] == [solver]

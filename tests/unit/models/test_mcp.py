"""The mixed complementarity problem: as it is declared, as it is relaxed, and solved on small scenes."""

import numpy as np
import pyomo.environ as pyo
import pytest
from residuals import residuals
from scenes import CASES

import masonry_opt as mo
from masonry_opt.answer.answer import certify
from masonry_opt.models.pyomo_mcp import PyomoMcp, with_slack_variables
from masonry_opt.models.pyomo_mpec import PyomoMpec, PyomoRelaxed
from masonry_opt.models.pyomo_terms import put
from masonry_opt.problem.assembly import assemble
from masonry_opt.problem.problem import State
from masonry_opt.solvers.ipopt import CasadiIpopt

SMALL = [CASES / "gilbert" / "two_blocks.toml", CASES / "livesley" / "wedges.toml"]


def test_as_many_equations_and_pairs_as_unknowns_and_no_objective(problem):
    program = PyomoMcp(problem).program
    unknowns, equations, objectives = (
        len(list(program.component_data_objects(kind))) for kind in (pyo.Var, pyo.Constraint, pyo.Objective)
    )
    assert unknowns == equations + len(program.complementarity)
    assert objectives == 0


def test_residuals_are_the_problem_s(problem, numbers):
    left = residuals(PyomoMcp(problem), numbers)
    expected = {
        "equilibrium": problem.unbalanced(numbers.load_factor, numbers.q),
        "compatibility": problem.departure(numbers.d, numbers.p, problem.dilatancy),
        "live_work": problem.live @ numbers.d - problem.live_norm,
        "z": problem.slacks(numbers.q),
        "p": numbers.p,
    }
    for name, residual in expected.items():
        np.testing.assert_allclose(getattr(left, name), residual, atol=1e-12)


def test_the_complementary_pairs_are_slacks_and_rates(problem, numbers):
    """Both sides as Pyomo reads them from the declaration: v = z, and p as a row."""
    mcp = PyomoMcp(problem)
    mcp.start_from(numbers)
    put(with_slack_variables(mcp, "mpec.standard_form"), np.zeros(problem.faces))
    pairs = list(mcp.program.complementarity.values())
    z = [pyo.value(pair.ve.upper) - pyo.value(pair.ve.body) for pair in pairs]
    np.testing.assert_allclose(z, problem.slacks(numbers.q), atol=1e-12)
    np.testing.assert_array_equal([pyo.value(pair.c.body) for pair in pairs], numbers.p)


@pytest.mark.parametrize("declared", [PyomoMcp, PyomoMpec])
def test_a_relaxation_holds_a_state_and_tells_what_it_leaves(declared, problem, numbers):
    model = PyomoRelaxed(declared(problem))
    model.start_from(numbers)
    read = model.read()
    assert read.load_factor == numbers.load_factor
    for ours, theirs in ((read.q, numbers.q), (read.d, numbers.d), (read.p, numbers.p)):
        np.testing.assert_array_equal(ours, theirs)
    expected = np.maximum(problem.slacks(numbers.q), 0.0) * numbers.p
    np.testing.assert_allclose(model.products(), expected, atol=1e-12)
    assert len(model.complementarity_rows) == problem.faces
    model.epsilon.set_value(0.25)
    rows = zip(model.complementarity_rows, expected, strict=True)
    assert all(pyo.value(row.body) - pyo.value(row.upper) == pytest.approx(z_p - 0.25) for row, z_p in rows)


@pytest.mark.parametrize("path", SMALL, ids=lambda path: path.stem)
def test_ipopt_finds_a_certified_state_of_what_is_declared(path):
    """From rest, and without an objective: any of the states."""
    problem = assemble(mo.load(path)).problem
    mcp = PyomoMcp(problem)
    model = PyomoRelaxed(mcp)
    at_rest = (np.zeros(size) for size in (3 * problem.joints, 3 * problem.blocks, problem.faces))
    model.start_from(State(0.0, *at_rest))
    ipopt = CasadiIpopt(model)
    for epsilon in 10.0 ** -np.arange(10):
        assert ipopt.solve(epsilon).solved
    found = mcp.read()
    left = certify(problem, found.load_factor, found.q, found.d, problem.dilatancy)
    assert max(left.equilibrium, left.yield_, left.flow) <= 1e-6
    assert left.complementarity / found.load_factor <= 1e-4
    # And what the declared equations themselves are left with.
    own = residuals(mcp, found)
    assert max(np.abs(own.equilibrium).max(), np.abs(own.compatibility).max(), abs(own.live_work)) <= 1e-6
    assert min(own.z.min(), own.p.min()) >= -1e-8
    assert own.z @ own.p / problem.live_norm <= 1e-4 * found.load_factor

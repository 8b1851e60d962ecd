"""The certificate sees what it is there to see: each kind of mistake raises its own residual."""

from __future__ import annotations

import numpy as np
import pytest
from scenes import declared, small_wall

from masonry_opt.answer.answer import certify
from masonry_opt.problem.assembly import assemble


@pytest.fixture(scope="module")
def solved():
    problem = assemble(small_wall()).problem
    state = declared(problem, "static", "pyomo").solve().state
    return problem, state


def certificate(problem, state, **changed):
    values = {"load_factor": state.load_factor, "q": state.q, "d": state.d, "slope": problem.friction}
    return certify(problem, **(values | changed))


def test_an_exact_answer_has_none_and_a_wrong_load_factor_breaks_equilibrium(solved):
    problem, state = solved
    assert certificate(problem, state).worst < 1e-10
    wrong = certificate(problem, state, load_factor=state.load_factor * 1.01)
    largest = np.abs(problem.live).max() * 0.01 * state.load_factor
    total = np.abs(problem.dead).sum()
    assert wrong.equilibrium == pytest.approx(largest / total, rel=1e-6)


def test_shear_beyond_friction_and_tension_break_yield(solved):
    problem, state = solved
    q, joint = state.q.copy(), problem.sliding[0]
    problem.shears(q)[0, joint] = problem.friction[0] * problem.normal_forces(q)[joint] + 0.25
    assert certificate(problem, state, q=q).yield_ == pytest.approx(0.25)
    q = state.q.copy()
    q.reshape(3, -1)[:, 0] = [-0.5, 0.0, 0.0]
    assert certificate(problem, state, q=q).yield_ >= 0.5


def test_a_block_pushed_into_another_breaks_the_flow_rule(solved):
    problem, state = solved
    d = state.d.copy()
    d[1] -= np.abs(d).max()  # the first block of the bottom course sinks into the base
    assert certificate(problem, state, d=d).flow > 0.4


def test_an_associative_mechanism_breaks_the_coulomb_flow_rule_where_it_slides(solved):
    problem, state = solved
    assert (problem.slip(state.p) > 1e-6).any()
    assert certificate(problem, state, slope=problem.dilatancy).flow < 1e-10  # it opens more: rocking
    assert certificate(problem, state, slope=problem.dilatancy).complementarity > 1e-3


def test_a_mechanism_where_forces_are_not_at_yield_opens_a_gap(solved):
    problem, state = solved
    q = state.q.copy()
    q[: problem.joints] += 1.0
    assert certificate(problem, state, q=q).complementarity > 0.1


def test_rates_give_back_the_joint_velocities_of_a_solved_mechanism(solved):
    problem, state = solved
    p = problem.rates(state.d, problem.friction)
    assert p.min() >= 0
    np.testing.assert_allclose(problem.D(problem.friction) @ p, problem.B.T @ state.d, atol=1e-10)

"""A state and its certificate: made together, once, and handed on."""

import pickle
from collections import Counter
from dataclasses import FrozenInstanceError, replace

import numpy as np
import pytest
from scenes import WALLS, block_on_floor, declared, overhanging, pressed_down, small_wall, two_blocks

import masonry_opt as mo
from masonry_opt.answer import answer
from masonry_opt.answer.acceptance import Kind
from masonry_opt.answer.answer import certify
from masonry_opt.problem.assembly import assemble


@pytest.fixture
def certificates(monkeypatch):
    """How often each state, by λ, forces, mechanism and flow rule, got its certificate."""
    counts = Counter()
    certify = answer.certify

    def counted(problem, load_factor, q, d, slope):
        counts[load_factor, q.tobytes(), d.tobytes(), slope.tobytes()] += 1
        return certify(problem, load_factor, q, d, slope)

    monkeypatch.setattr(answer, "certify", counted)
    return counts


@pytest.mark.parametrize("method", ["mcp", "static", "nonassociative", "refined"])
def test_a_state_has_one_certificate(method, certificates):
    """However often it is judged, compared and shown. (On small scenes several starts end in one state.)"""
    result = mo.solve(WALLS[0], method)
    assert result.details
    assert result.to_json()
    assert set(certificates.values()) == {1}


def test_an_answer_cannot_be_changed():
    found = mo.solve(two_blocks()).solution.answer
    with pytest.raises(FrozenInstanceError):
        found.load_factor = 0.1


def test_an_associative_answer_is_judged_under_both_flow_rules():
    """It opens by μ as it slides, which lifts the block: work that Coulomb joints do not do."""
    result = mo.solve(block_on_floor(4, 2, 0.5), "static")
    found, problem = result.solution.answer, result.assembly.problem
    assert not found.failing(Kind.ASSOCIATIVE)
    assert found.certified_by(problem, problem.friction) is found
    left = found.certified_by(problem, problem.dilatancy).failing(Kind.EXACT)
    assert left == {"complementarity": pytest.approx(1.0)}
    assert not result.exact


def test_an_answer_of_contacts_that_give_is_judged_with_them_and_with_rigid_ones():
    """Contacts that give by a hundredth leave as much of the flow rule of rigid ones."""
    result = mo.solve(two_blocks(), "compliant", give=0.01)
    found, problem = result.solution.answer, result.assembly.problem
    soft = replace(problem, compliance=found.compliance)
    assert not found.failing(Kind.EXACT)
    assert found.certified_by(soft, problem.dilatancy) is found
    left = found.certified_by(problem, problem.dilatancy)
    assert left.compliance is None
    assert left.failing(Kind.EXACT).keys() == {"flow", "complementarity"}
    assert 1e-3 < left.certificate.flow < 1e-1
    assert not result.exact


@pytest.mark.parametrize(
    "scene", [two_blocks(), pressed_down(), overhanging()], ids=["collapses", "unlimited", "falls"]
)
def test_a_result_can_be_sent_to_another_process(scene):
    result = mo.solve(scene)
    sent = pickle.loads(pickle.dumps(result))
    assert sent.to_json() == result.to_json()
    assert sent.details == result.details


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

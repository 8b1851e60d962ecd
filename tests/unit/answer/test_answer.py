"""A state and its certificate: made together, once, and handed on."""

from __future__ import annotations

import pickle
from collections import Counter
from dataclasses import FrozenInstanceError, replace

import pytest
from scenes import WALLS, block_on_floor, overhanging, pressed_down, two_blocks

import masonry_opt as mo
from masonry_opt.answer import answer
from masonry_opt.answer.acceptance import Kind


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
@pytest.mark.parametrize("number", [1, 6])
def test_a_state_has_one_certificate(number, method, certificates):
    """However often it is judged, compared and shown. (On small scenes several starts end in one state.)"""
    result = mo.solve(WALLS[number - 1], method)
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

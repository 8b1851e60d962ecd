"""The range of load factors in which states are searched for if no state is known."""

from dataclasses import replace

import numpy as np
import pytest
from scenes import two_blocks
from second_program import random_of_any_kind

import masonry_opt as mo
from masonry_opt.methods.bounds.settings import BUDGET
from masonry_opt.methods.coulomb import method
from masonry_opt.methods.coulomb.steps import FurtherStarts, LeastProven
from masonry_opt.problem.assembly import assemble
from masonry_opt.solution.load_history import LoadHistory, LoadStep
from masonry_opt.solution.proof import Proof, StaticConflict


def history_up_to(load_factor: float) -> LoadHistory:
    """Return a load history with one step at the given load factor."""
    nothing, nowhere = np.zeros(1), np.zeros(1, dtype=bool)
    return LoadHistory((LoadStep(1, load_factor, 0.0, False, nowhere, nowhere, nothing, nothing),))


@pytest.mark.parametrize(
    ("associative", "last", "end"), [(2.0, 5.0, 2.0), (-1.0, 5.0, -1.0), (None, 5.0, 50.0), (None, 0.0, None)]
)
def test_the_associative_load_factor_or_the_load_history_ends_the_range(associative, last, end):
    problem = assemble(two_blocks()).problem
    assert BUDGET.range_end(problem, associative, history_up_to(last)) == end
    assert BUDGET.range_end(problem, associative, None) == associative


@pytest.fixture
def without_state(monkeypatch):
    """Let ``mo.prove_least`` start only from a load history up to 0.15, without a state or associative λ."""
    result = mo.solve(two_blocks(), incremental=False)
    history = history_up_to(0.15).steps
    solution = replace(result.solution, state=None, associative=None, proof=None, history=history)
    started = replace(result, solution=solution)
    assert (started.load_factor, started.associative, started.proof) == (None, None, None)
    monkeypatch.setattr("masonry_opt.proving.solve", lambda _: started)


@pytest.mark.usefixtures("without_state")
def test_a_state_within_the_range_of_the_load_history_is_found_and_proven():
    found = mo.prove_least(two_blocks())
    assert found.load_factor == pytest.approx(0.15, rel=1e-9)
    assert str(found).startswith("λ = 0.15 is the least load factor, proven by ")


@pytest.mark.usefixtures("without_state")
def test_a_range_without_a_state_is_proven_to_have_none(monkeypatch):
    monkeypatch.setattr("masonry_opt.proving.BUDGET", replace(BUDGET, load_range=0.5))
    found = mo.prove_least(two_blocks())
    assert found.load_factor is None
    assert found.proof.bound == pytest.approx(0.075, rel=1e-5)
    assert str(found).startswith("no collapse state has a load factor from 0 to 0.075, proven by ")
    assert mo.check_proof(two_blocks(), found.proof).holds


@pytest.mark.slow
def test_a_state_of_a_scene_whose_statics_carry_any_load_is_proven(monkeypatch):
    """The default finds no state without its own proof; test_missing_answers.py has the load factor."""
    steps = [step for step in method.STEPS if not isinstance(step, LeastProven | FurtherStarts)]
    monkeypatch.setattr(method, "STEPS", tuple(steps))
    scene = random_of_any_kind(1400488)
    assert mo.solve(scene).status is mo.Status.JAMMED
    assert mo.prove_least(scene).load_factor == pytest.approx(3.5184944221, rel=1e-9)


def test_a_proof_of_another_kind_is_no_contradiction():
    found = mo.LeastLoadFactor(None, None, "proven: no load factor λ ≥ 0 exists")
    assert str(found) == (
        f"no collapse state was found, and no proof by conflicts excludes collapse states: {found.why}"
    )


@pytest.mark.parametrize(("count", "proven"), [(1, "proven by 1 conflict"), (2, "proven by 2 conflicts")])
def test_a_text_counts_the_conflicts_of_a_proof(count, proven):
    conflict = StaticConflict(*[np.zeros(1)] * 3)
    proof = Proof(0.9, 1.0, 1, (conflict,) * count, (), np.zeros((0, 2), dtype=int))
    assert str(mo.LeastLoadFactor(1.0, proof, "")) == f"λ = 1 is the least load factor, {proven}"
    without_state = str(mo.LeastLoadFactor(None, proof, ""))
    assert without_state == f"no collapse state has a load factor from 0 to 0.9, {proven}"

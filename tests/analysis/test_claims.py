"""Claims about the least load factor, on a scene whose least one is half of the associative one."""

from dataclasses import replace
from pathlib import Path

import pytest

import masonry_opt as mo
from masonry_opt.methods.bounds.settings import SETTINGS

#: A random wall with 13 joints. With few starts, all three load factors are 32.025. The least load factor is
#: 16.4710: method "global" found this state, and its certificate is computed from the matrices alone.
TWO_STATES = Path(__file__).parent / "low_states" / "wall_13_joints.toml"
LOWER = 16.4710


@pytest.mark.slow
def test_the_least_is_claimed_with_a_proof():
    result = mo.solve(TWO_STATES)
    assert result.load_factor == pytest.approx(LOWER, rel=1e-5)
    assert "least, proven" in result.summary
    assert mo.check_proof(TWO_STATES, result.proof).holds


@pytest.mark.slow
def test_the_lowest_found_is_not_claimed_to_be_the_least(no_proof):
    result = mo.solve(TWO_STATES)
    assert result.load_factor >= LOWER * (1 - 1e-5)
    assert "not proven to be the least" in result.summary
    for claim in ("safe", "least, proven", "no state has a lower load factor", "collapses when"):
        assert claim not in result.summary


@pytest.mark.slow
def test_a_bound_that_assumes_something_names_its_assumption(no_proof, monkeypatch):
    """If no relaxation is solved to a vertex, the bound is valid only for limited slips.

    The summary then does not say "least, proven".
    """
    monkeypatch.setattr("masonry_opt.methods.bracket.relaxation.SETTINGS", replace(SETTINGS, most_products=0))
    result = mo.solve(TWO_STATES, "global")
    assert result.load_factor == pytest.approx(LOWER, rel=1e-5)
    assert result.exact
    assert not result.solution.bound_derived
    assert "least, proven" not in result.summary
    assert "(assumed limits)" in result.summary

"""What a pass, and the exact state below it, must show."""

from __future__ import annotations

from scenes import solved
from scenes import values_of as values

import masonry_opt as mo
from masonry_opt.answer.acceptance import Kind
from masonry_opt.answer.reasons import Code

#: What the certificate must not exceed: exact; of a pass, but for what its last gap leaves.
EXACT, GAP = 1e-8, 1e-6


def assert_exact(result):
    left = result.certificate
    assert max(left.equilibrium, left.yield_, left.flow) <= EXACT
    assert left.complementarity <= GAP * abs(result.load_factor)


def one_pass(scene, **options):
    """The state that a pass ends in."""
    return solved(scene, "mcp", descent=False, **options)


def assert_one_pass(result):
    assert result.status is mo.Status.CONVERGED
    assert [reason.code for reason in result.reasons] == [Code.ONE_PASS]
    assert result.solution.kind is Kind.ONE_PASS
    assert values(result, Code.ONE_PASS)["steps"] == len(result.history)
    assert_exact(result)


def assert_descended(result):
    assert result.status is mo.Status.CONVERGED
    assert [reason.code for reason in result.reasons] == [Code.ONE_PASS, Code.EXACT, Code.STATES_MET]
    assert result.solution.kind is Kind.EXACT
    assert values(result, Code.ONE_PASS)["steps"] == len(result.history)
    left = result.certificate
    assert max(left.equilibrium, left.yield_, left.flow, left.complementarity) <= EXACT

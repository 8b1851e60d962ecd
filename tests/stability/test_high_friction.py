"""Friction so high that nothing slides under pressure."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scenes import WALLS

import masonry_opt as mo
from masonry_opt.answer.answer import certified
from masonry_opt.problem.assembly import assemble


@pytest.mark.parametrize("friction", [1e5, 1e6])
def test_default_gives_a_state_that_holds(friction: float) -> None:
    """Statics bound it; exact states may lie lower, where blocks that part slide along each other, which
    associative flow at such friction forbids. Pushes may stop there."""
    result = mo.solve(mo.load(WALLS[0]).replace(friction=friction))
    assert result.exact
    assert result.certificate.worst <= 1e-8
    assert result.load_factor <= result.associative * (1 + 1e-6)
    assert result.expected is None or result.expected <= result.associative * (1 + 1e-5)


def test_certificate_counts_slip_of_rounding_as_rounding() -> None:
    """n = 1 under μ = 1e6 has a slack of 1e6. A slip of 1e-6 is none of rounding."""
    problem = assemble(mo.load(WALLS[0])).problem
    high = replace(problem, law=replace(problem.law, friction=np.full_like(problem.friction, 1e6)))
    q = high.N.T @ np.ones(len(high.sliding))
    turning = np.zeros_like(high.live)
    turning[0] = 1.0  # the first block along
    for slip, counts in ((1e-13, False), (1e-6, True)):
        live = replace(high, live=np.eye(len(turning))[0] / slip)
        energy = certified(live, 1.0, q, slip * turning).certificate.complementarity
        assert (energy > 1e-8) == counts

"""Tests of a live load on blocks much lighter than the blocks below: the right load factor, or none."""

from dataclasses import replace
from math import inf

import numpy as np
import pytest
from atlas.small_scenes import rectangle
from scenes import WALLS

import masonry_opt as mo
from masonry_opt.problem.assembly import assemble
from masonry_opt.solution.acceptance import Kind
from masonry_opt.solution.answer import certified

RUNS = {
    "static": ("static", {}),
    "static, simplex": ("static", {"solver": "highs"}),
    "kinematic, interior point": ("kinematic", {"solver": "highs-ipm"}),
    "kinematic, Pyomo": ("kinematic", {"model": "pyomo"}),
    "loop": ("nonassociative", {}),
    "loop, simplex": ("nonassociative", {"solver": "highs"}),
    "bare loop": ("nonassociative", {"finish": False, "remedies": "none"}),
}


def on_boulder(side, *blocks, friction, rough=()):
    """Return small blocks on a square boulder of the same unit weight, which carries no live load."""
    boulder = rectangle("boulder", 0, 0, side, side, weight=side * side)
    floor = rectangle("floor", -side, -side, 2 * side, 0)
    exceptions = [mo.Joint(between=pair, friction=inf) for pair in rough]
    return mo.Scene(joints={"friction": friction}, blocks=[boulder, *blocks, floor], exceptions=exceptions)


def column(side):
    """Return a column of 1 by 4 on the boulder, which overturns at λ = 1/4."""
    small = rectangle("C", side / 2, side, side / 2 + 1, side + 4, weight=4, live=(4, 0))
    return on_boulder(side, small, friction=0.4)


#: Runs of the first scene. The runs of the loop are slow tests.
TIMED = [pytest.param(run, marks=[pytest.mark.slow] if "loop" in run else []) for run in RUNS]

#: Runs that have an answer at any ratio of weights. Interior points and the loop leave a residual of
#: equilibrium.
ALWAYS = {"static, simplex", "kinematic, interior point", "kinematic, Pyomo"}


@pytest.mark.parametrize("run", TIMED)
def test_the_load_factor_is_right_or_not_given(run):
    """Each run has the right load factor of the scene of Fig. 6, or none.

    A is pushed out from under B, which also rests on a rough support: 2.5 μ with associative flow, 1.5 μ with
    Coulomb friction.
    """
    side, x, (method, options) = 3e3, 1.5e3, RUNS[run]
    A = rectangle("A", x, side, x + 3, side + 1, weight=1, live=(1, 0))
    B = rectangle("B", x - 2, side + 1, x + 1, side + 2, weight=1)
    S = rectangle("S", x - 2, side, x - 1, side + 1, weight=1)
    scene = on_boulder(side, A, B, S, friction=0.1, rough=[("B", "S"), ("S", "boulder")])
    result = mo.solve(scene, method, incremental=False, **options)
    if result.status.usable:
        right = 0.15 if method == "nonassociative" else 0.25
        assert result.load_factor == pytest.approx(right, rel=2e-3)
    else:
        assert run not in ALWAYS
        assert result.load_factor is None
        assert result.reasons


@pytest.mark.parametrize("run", RUNS)
def test_a_moderate_ratio_is_no_reason_to_refuse(run):
    """With weights of 1 : 100, all runs find λ = 1/4 of the column."""
    method, options = RUNS[run]
    assert mo.solve(column(20.0), method, incremental=False, **options).load_factor == pytest.approx(
        0.25, rel=1e-4
    )


def test_a_mechanism_that_the_live_load_does_not_drive_is_refused():
    """The certificate rejects a mechanism on which the live load does no work.

    HiGHS takes loads of 1e-10 for zero, and calls the resulting answer optimal.
    """
    result = mo.solve(column(20.0), "static")
    assert result.kind is Kind.ASSOCIATIVE
    answer = result.solution.answer
    assert answer.failing(result.kind) == {}
    still = certified(
        result.assembly.problem, answer.load_factor, answer.q, np.zeros_like(answer.d), answer.slope
    )
    assert still.failing(result.kind)["work"] == inf


@pytest.mark.slow
def test_default_gives_a_state_that_holds() -> None:
    """The default's state on a wall with μ = 1e6 is exact, and not above the associative load factor.

    Exact states may be lower, if blocks that separate slide along each other; associative flow forbids this
    motion. The load history may end at a lower state.
    """
    result = mo.solve(mo.load(WALLS[0]).replace(friction=1e6))
    assert result.exact
    assert result.certificate.worst <= 1e-8
    assert result.load_factor <= result.associative * (1 + 1e-6)
    assert result.incremental is None or result.incremental <= result.associative * (1 + 1e-5)


def test_certificate_counts_slip_of_rounding_as_rounding() -> None:
    """The certificate counts a slip of 1e-13 as rounding, and a slip of 1e-6 as an error.

    A normal force of 1 with μ = 1e6 has a slack of 1e6.
    """
    problem = assemble(mo.load(WALLS[0])).problem
    high = replace(problem, law=replace(problem.law, friction=np.full_like(problem.friction, 1e6)))
    q = high.N.T @ np.ones(len(high.sliding))
    turning = np.zeros_like(high.live)
    turning[0] = 1.0  # The first block moves along x.
    for slip, counts in ((1e-13, False), (1e-6, True)):
        live = replace(high, live=np.eye(len(turning))[0] / slip)
        energy = certified(live, 1.0, q, slip * turning).certificate.complementarity
        assert (energy > 1e-8) == counts

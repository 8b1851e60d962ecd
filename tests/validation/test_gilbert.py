"""Two blocks and their wedge variants: section 4.1, footnote 2, Figs 6 and 7."""

from __future__ import annotations

import itertools
import math

import pytest
from scenes import CASES, two_blocks

import masonry_opt as mo
from masonry_opt.methods.loop.options import PAPER
from masonry_opt.studies.paper.two_blocks import (
    CONTRACTS,
    EXPANDS,
    FLAT,
    closed_form,
    jump_angle,
    with_dilatancy,
)
from masonry_opt.studies.paper.two_blocks_loop import FLAT_LIMITS, SOLVERS, end_of_loop, follow

#: An exact state, of a case file with twelve digits.
EXACT = 1e-8

VARIANTS = [FLAT, CONTRACTS, EXPANDS]


def test_closed_form_by_numbers():
    """Moments about B's hinge and forces on A, written out for ψ = 4°, μ = 0.1, B sinking."""
    psi, mu = math.radians(4), 0.1
    hinge, touch = 1.0, 3.0
    normal, along = (-math.sin(psi), math.cos(psi)), (math.cos(psi), math.sin(psi))
    force = [n + mu * e for n, e in zip(normal, along, strict=True)]  # on B, for n = 1
    arm = (touch - hinge, (touch - hinge) * math.tan(psi))
    n = 1.0 * (1.5 - hinge) / (arm[0] * force[1] - arm[1] * force[0])
    expected = mu * (1 + n * force[1]) + n * force[0]
    assert closed_form(mu, 4.0, rises=False) == pytest.approx(expected, rel=1e-12)
    assert closed_form(mu, 0.0, rises=True) == pytest.approx(2.5 * mu)
    assert closed_form(mu, 0.0, rises=False) == pytest.approx(1.5 * mu)


@pytest.mark.parametrize("friction", [0.05, 0.1, 0.2])
def test_two_blocks(friction):
    """Fig. 6: λ = 2.5 μ with dilatancy, 1.5 μ with contraction, which the loop finds (1.5 μ, Fig. 7 b)."""
    scene = two_blocks(friction)
    assert mo.solve(scene, "static").load_factor == pytest.approx(2.5 * friction, rel=1e-7)
    assert mo.solve(scene, "nonassociative").load_factor == pytest.approx(1.5 * friction, rel=1e-3)


@pytest.mark.parametrize("variant", VARIANTS, ids=lambda variant: variant.name)
@pytest.mark.parametrize("away", [-1.5, -0.1, 0.1, 1.5])
def test_load_factor_on_either_side_of_the_jump(variant, away):
    """φ₀ a little below and above ψ / 2, in degrees. The loop ends within its own tolerance (1e-5)."""
    scene = mo.load(CASES / variant.file)
    dilatant = with_dilatancy(scene, variant.face / 2 + away)
    expected = closed_form(scene.joints.friction, variant.face, rises=away > 0)
    assert mo.solve(dilatant, "global").load_factor == pytest.approx(expected, rel=EXACT)
    assert mo.solve(dilatant, "nonassociative", **PAPER).load_factor == pytest.approx(expected, rel=1e-5)


@pytest.mark.parametrize("variant", VARIANTS, ids=lambda variant: variant.name)
def test_jump_at_half_the_angle_of_the_face(variant):
    """To the width of the bisection, 0.0006°, on either side."""
    scene = mo.load(CASES / variant.file)
    levels = [closed_form(scene.joints.friction, variant.face, rises) for rises in (False, True)]
    assert jump_angle(scene, sum(levels) / 2) == pytest.approx(variant.face / 2, abs=7e-4)


@pytest.mark.parametrize("asked", SOLVERS, ids=lambda asked: asked.label)
def test_without_contraction_the_loop_ends_between(asked):
    """Fig. 7 (a): 1.5 μ ≤ λ ≤ 2.5 μ, wherever the solver likes; 1e-5 of n_max is the small cohesion."""
    scene = mo.load(CASES / FLAT.file)
    flat = end_of_loop(scene, asked, **FLAT_LIMITS).load_factor
    assert 0.15 * (1 - 1e-4) <= flat <= 0.25 * (1 + 1e-4)
    assert end_of_loop(scene, asked, **PAPER).load_factor == pytest.approx(0.15, rel=1e-3)


def test_solvers_end_at_different_values_without_contraction():
    """Two interior-point solvers and a simplex, each left to itself: any value between is a solution."""
    scene = mo.load(CASES / FLAT.file)
    ends = {
        asked.kind + asked.name: end_of_loop(scene, asked, **FLAT_LIMITS).load_factor
        for asked in SOLVERS
        if asked.name == "clarabel" or not asked.presolve
    }
    assert len(ends) == 3
    assert min(abs(a - b) for a, b in itertools.combinations(ends.values(), 2)) > 0.005


def test_path_between_the_blocks():
    """Fig. 7 (b): the normal force falls from 3/4 to 1/4 of a block; every limit holds what it limits, and
    turns about the last normal force."""
    result, path = follow(mo.load(CASES / FLAT.file), **PAPER)
    assert path[0].n == pytest.approx(0.75, abs=1e-6)
    assert path[-1].n == pytest.approx(0.25, abs=1e-4)
    assert len(path) == len(result.history)
    for step in path:
        assert step.s <= step.cohesion + step.slope * step.n + 1e-7
    second = path[1]
    # At iteration 1's n the second limit is Coulomb's, but for the small cohesion (1e-5 of 1.75).
    assert second.cohesion + second.slope * path[0].n == pytest.approx(0.1 * path[0].n, abs=2e-5)
    assert second.slope == pytest.approx(-0.3 * 0.1)

"""Two blocks and their wedge variants: section 4.1, footnote 2, Fig. 6 (its script is in the guide)."""

import math

import pytest
from paper_scripts import definitions
from scenes import solved

import masonry_opt as mo
from masonry_opt.methods.loop.options import PAPER

FIG6 = definitions("fig6")


def by_numbers(face: float, rises: bool) -> float:
    """Moments about B's hinge and forces on A, written out, for μ = 0.1 and a face at ψ, in degrees."""
    psi, mu = math.radians(face), 0.1
    hinge, touch = (0.0, 2.0) if rises else (1.0, 3.0)
    normal, along = (-math.sin(psi), math.cos(psi)), (math.cos(psi), math.sin(psi))
    force = [n + mu * e for n, e in zip(normal, along, strict=True)]  # on B, for n = 1
    arm = (touch - hinge, (touch - hinge) * math.tan(psi))
    n = 1.0 * (1.5 - hinge) / (arm[0] * force[1] - arm[1] * force[0])
    return mu * (1 + n * force[1]) + n * force[0]


def test_closed_form_by_numbers():
    for face in (0.0, 4.0, -4.0):
        for rises in (False, True):
            assert FIG6.by_hand(face, rises) == pytest.approx(by_numbers(face, rises), rel=1e-12)
    assert FIG6.by_hand(0.0, rises=True) == pytest.approx(0.25)
    assert FIG6.by_hand(0.0, rises=False) == pytest.approx(0.15)


@pytest.mark.parametrize("name", FIG6.VARIANTS)
@pytest.mark.parametrize("away", [-0.1, 0.1])
def test_load_factor_on_either_side_of_the_jump(name, away):
    """φ₀ a little below and above ψ / 2, in degrees. The loop ends within its own tolerance (1e-5), an exact
    state of a case file with twelve digits at 1e-8."""
    face = FIG6.VARIANTS[name][1]
    dilatant = FIG6.dilatant(name, face / 2 + away)
    expected = by_numbers(face, rises=away > 0)
    assert solved(dilatant, "global").load_factor == pytest.approx(expected, rel=1e-8)
    assert mo.solve(dilatant, "nonassociative", **PAPER).load_factor == pytest.approx(expected, rel=1e-5)

"""Load factors that can be worked out on paper."""

from __future__ import annotations

import math

import pytest
from scenes import block_on_floor, solved

import masonry_opt as mo

#: A linear program solved to 1e-9.
EXACT = 1e-7

METHODS = ["static", "kinematic", "nonassociative", "mcp"]


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize(
    ("width", "height", "friction"),
    [(1, 2, 0.3), (1, 2, 0.8), (1, 2, math.inf), (2, 1, 0.8), (2, 1, math.inf), (1, 1, 0.8)],
)
def test_single_block_slides_or_overturns(width, height, friction, method):
    """One block w × h, horizontal live load = weight: λ = min(w/h, μ). The loop ends within its own
    tolerance (1e-5 on λ)."""
    result = solved(block_on_floor(width, height, friction), method)
    tolerance = 2e-5 if method == "nonassociative" else EXACT
    assert result.load_factor == pytest.approx(min(width / height, friction), rel=tolerance)


@pytest.mark.parametrize("angle", [10, 20, 26])
def test_tilting_table(angle):
    """A block on a table tilted by θ slides or overturns when tan θ reaches λ, so with gravity tilted
    by θ the live load along the table still needed is cos θ (λ₀ - tan θ)."""
    tilt = math.radians(angle)
    scene = block_on_floor(1, 2, 0.6).model_copy(update={"gravity": (math.sin(tilt), -math.cos(tilt))})
    expected = math.cos(tilt) * (0.5 - math.tan(tilt))
    assert solved(scene, "static").load_factor == pytest.approx(expected, rel=1e-6)


def test_table_tilted_too_far():
    tilt = math.radians(27)
    scene = block_on_floor(1, 2, 0.6).model_copy(update={"gravity": (math.sin(tilt), -math.cos(tilt))})
    assert solved(scene, "static").status is mo.Status.UNSTABLE


def test_cohesion_adds_its_length():
    """Sliding at μ + c L / weight."""
    scene = block_on_floor(3, 1, 0.3)
    scene = mo.Scene(joints=mo.JointDefaults(friction=0.3, cohesion=0.1), blocks=scene.blocks)
    assert solved(scene, "static").load_factor == pytest.approx(0.6, rel=EXACT)
    assert solved(scene).load_factor == pytest.approx(0.6, rel=2e-5)
    assert solved(scene, "mcp").load_factor == pytest.approx(0.6, rel=EXACT)


def test_live_load_at_the_top_overturns_sooner():
    scene = block_on_floor(1, 2, 0.6, live_at=(0.5, 2.0))
    assert solved(scene, "static").load_factor == pytest.approx(0.25, rel=EXACT)

"""Meriam & Kraige, sample problem 6/5: three blocks on an incline of 30°, the middle one pulled down by P.

Nothing but weights presses the blocks on each other, so the normal forces are known, and with them all
friction. The middle block slides alone, or takes the bottom one along, whichever needs less.
"""

import math

import pytest
from scenes import CASES, solved

import masonry_opt as mo

BLOCKS = CASES / "meriam_kraige" / "three_blocks.toml"

TOP, MIDDLE, BOTTOM = (mass * 9.81 for mass in (30, 50, 40))
SIN, COS = 0.5, math.sqrt(0.75)
ABOVE = 0.30 * TOP * COS
BETWEEN = 0.40 * (TOP + MIDDLE) * COS
BELOW = 0.45 * (TOP + MIDDLE + BOTTOM) * COS

alone = ABOVE + BETWEEN - MIDDLE * SIN
together = ABOVE + BELOW - (MIDDLE + BOTTOM) * SIN


def test_the_closed_form_is_the_published_force():
    assert alone == pytest.approx(103.1, abs=0.05)
    assert min(alone, together) == pytest.approx(93.8, abs=0.05)


@pytest.mark.parametrize("method", ["static", "mcp", "nonassociative"])
def test_load_factor(method):
    """Dilatancy does no harm where the normal forces are given."""
    result = solved(BLOCKS, method)
    assert result.load_factor == pytest.approx(together, rel=1e-8)
    if method == "mcp":  # the middle block takes the bottom one along, and the top one stays
        moves = result.blocks.set_index("block")["vx"]
        assert moves["bottom"] == pytest.approx(moves["middle"], rel=1e-9)
        assert moves["top"] == pytest.approx(0, abs=1e-9)


def test_a_rougher_incline_lets_the_middle_block_slide_alone():
    scene = mo.load(BLOCKS)
    rougher = scene.model_copy(update={"joints": mo.JointDefaults(friction=0.6)})
    assert solved(rougher).load_factor == pytest.approx(alone, rel=1e-8)

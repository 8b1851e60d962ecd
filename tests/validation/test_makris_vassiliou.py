"""Makris & Vassiliou (2013): columns that carry a beam uplift at b/h, as if they carried nothing.

Turned by θ about its toe, a column of b × h lifts and pushes the beam by θ b and θ h, and its own weight by
half of each: the work of every weight under λ times itself vanishes at λ = b/h.
"""

import pytest
from scenes import CASES, solved

import masonry_opt as mo

PATH = CASES / "makris_vassiliou" / "rocking_frame.toml"
SLENDERNESS = 1 / 4


def frame(beam: float, friction: float) -> mo.Scene:
    scene = mo.load(PATH)
    blocks = [
        block.model_copy(update={"weight": beam, "live": (beam, 0.0)}) if block.name == "beam" else block
        for block in scene.blocks
    ]
    return scene.model_copy(update={"blocks": blocks, "joints": mo.JointDefaults(friction=friction)})


@pytest.mark.parametrize("method", ["static", "mcp", "nonassociative"])
@pytest.mark.parametrize("beam", [0.01, 1.0, 5.0, 100.0])
def test_any_beam_uplifts_at_the_slenderness(beam, method):
    found = solved(frame(beam, 0.6), method).load_factor
    assert found == pytest.approx(SLENDERNESS, rel=1e-6)


@pytest.mark.parametrize("beam", [0.01, 5.0])
def test_columns_turn_and_the_beam_is_carried_along(beam):
    blocks = solved(frame(beam, 0.6)).blocks.set_index("block")
    assert blocks["omega"]["left column"] == pytest.approx(blocks["omega"]["right column"], rel=1e-9)
    assert blocks["omega"]["beam"] == pytest.approx(0, abs=1e-9)
    assert blocks["vy"]["beam"] == pytest.approx(SLENDERNESS * blocks["vx"]["beam"], rel=1e-9)


@pytest.mark.parametrize("method", ["static", "mcp"])
def test_with_less_friction_than_slenderness_it_slides(method):
    assert solved(frame(5.0, 0.2), method).load_factor == pytest.approx(0.2, rel=1e-8)

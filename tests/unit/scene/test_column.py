"""The ``[column]`` generator: columns and buttresses that overturn where statics say."""

from __future__ import annotations

import pytest

import masonry_opt as mo

SLENDER = {"width": 1.0, "height": 4.0, "drums": 5, "weight": 8.0}


def load_factor(side=1.0, friction=5.0, **changes):
    column = mo.Column(**SLENDER | {"live": (side, 0.0)} | changes)
    return mo.solve(mo.Scene(joints={"friction": friction}, blocks=column.blocks()), "static").load_factor


@pytest.mark.parametrize("drums", [1, 2, 5])
def test_a_column_overturns_as_one_block(drums):
    assert load_factor(drums=drums) == pytest.approx(1.0 / 4.0, rel=1e-7)
    assert load_factor(drums=drums, friction=0.2) == pytest.approx(0.2, rel=1e-7)


@pytest.mark.parametrize(("batter", "centre"), [("left", None), ("right", None), ("both", 1.5)])
@pytest.mark.parametrize("side", [-1.0, 1.0])
def test_a_buttress_overturns_about_its_toe(batter, centre, side):
    """Foot 3, top 1, height 4, in one piece: a rectangle 1 × 4 and triangles of 2 × 4 / 2 in all."""
    foot, top, height = 3.0, 1.0, 4.0
    rectangle, triangle = top * height, (foot - top) * height / 2
    upright = foot - top / 2 if batter == "left" else top / 2
    slope = (foot - top) * 2 / 3 if batter == "left" else foot - (foot - top) * 2 / 3
    x = centre or (rectangle * upright + triangle * slope) / (rectangle + triangle)
    y = (rectangle * height / 2 + triangle * height / 3) / (rectangle + triangle)
    expected = (foot - x if side > 0 else x) / y
    found = load_factor(side, width=(foot, top), height=height, drums=1, batter=batter)
    assert found == pytest.approx(expected, rel=1e-7)


@pytest.mark.parametrize("batter", ["left", "right", "both"])
def test_drums_share_the_weight_by_their_areas(batter):
    blocks = mo.Column(**SLENDER | {"width": (3.0, 1.0), "drums": 2, "batter": batter}).blocks()
    # Widths 3, 2, 1 at heights 0, 2, 4.
    assert [block.weight for block in blocks[:-1]] == pytest.approx([8.0 * 5 / 8, 8.0 * 3 / 8])
    left = {"left": [0, 1, 2], "right": [0, 0, 0], "both": [0, 0.5, 1]}[batter]
    assert [blocks[0].vertices[0][0], *(block.vertices[3][0] for block in blocks[:-1])] == pytest.approx(left)
    assert blocks[1].vertices[2][1] == 4.0


def test_the_base_is_as_wide_as_the_foot_and_may_be_left_out():
    blocks = mo.Column(**SLENDER).blocks()
    assert [block.name for block in blocks] == ["d1", "d2", "d3", "d4", "d5", "base"]
    assert blocks[-1].fixed
    assert blocks[-1].vertices == [(0.0, -0.8), (1.0, -0.8), (1.0, 0.0), (0.0, 0.0)]
    assert not any(block.fixed for block in mo.Column(**SLENDER, base=False).blocks())

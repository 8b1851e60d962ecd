"""Extents of blocks and middles of joints, by hand."""

from __future__ import annotations

import numpy as np
import pytest
from scenes_in_space import box_on_floor

import masonry_opt as mo
from masonry_opt.problem.assembly import assemble


def on_footing(*parts):
    """A plate of 4 × 4 on a footing of boxes 1 high."""
    footing = [mo.Part(box=(x, y, (-1, 0))) for x, y in parts]
    blocks = [
        mo.box("plate", (0, 4), (0, 4), (0, 1), weight=1.0, live=(1, 0, 0)),
        mo.Solid(name="footing", parts=footing, fixed=True),
    ]
    return assemble(mo.Scene(joints={"friction": 0.6}, blocks=blocks))


def test_the_middle_of_an_angle_is_its_centroid():
    """Legs 4 × 1 and 1 × 3: (4·(2, 0.5) + 3·(0.5, 2.5)) / 7."""
    assembly = on_footing(((0, 4), (0, 1)), ((0, 1), (1, 4)))
    found = assembly.joints.middle + assembly.geometry.origin
    assert found == pytest.approx(np.array([[9.5 / 7, 9.5 / 7, 0]]), abs=1e-9)


def test_holes_count_against_the_middle():
    """A ring of 4 × 4 with a hole from (1, 1) to (2, 3): (16·(2, 2) − 2·(1.5, 2)) / 14."""
    assembly = on_footing(((0, 4), (0, 1)), ((0, 4), (3, 4)), ((0, 1), (1, 3)), ((2, 4), (1, 3)))
    found = assembly.joints.middle + assembly.geometry.origin
    assert found == pytest.approx(np.array([[29 / 14, 2, 0]]), abs=1e-9)


def test_boxes_and_distances_outside_of_hulls():
    assembly = assemble(box_on_floor((1, 2, 3)))
    shapes = assembly.geometry
    low, high = shapes.boxes
    assert low[0] + shapes.origin == pytest.approx([0, 0, 0])
    assert high[0] + shapes.origin == pytest.approx([1, 2, 3])
    # Inside, on a face, 2 in front of one, and off a corner by (3, 4, 12).
    points = np.array([(0.5, 1, 1), (0, 1, 1), (0.5, 4, 1), (4, 6, 15)]) - shapes.origin
    found = shapes.outside(np.zeros(4, dtype=int), points)
    assert found == pytest.approx([0, 0, 2, 13], abs=1e-6)

"""Skewbacks: an arch whose feet slope on level beds, by geometry and equilibrium by hand."""

import math

import numpy as np
import pytest

import masonry_opt as mo
from masonry_opt.problem.assembly import assemble

SEGMENT = {"span": 4.0, "rise": 1.0, "thickness": 0.5, "voussoirs": 9, "unit_weight": 2.0}

#: Of that segment: inner radius 2.5, half angle with sin 0.8 and cos 0.6. Across and up of its foot.
ACROSS, UP = 0.5 * 0.8, 0.5 * 0.6


def segment(**keys):
    return mo.Arch(**SEGMENT | keys)


def named(blocks):
    return {block.name: block for block in blocks}


def solved(blocks, friction=0.9, **keys):
    return mo.solve(mo.Scene(joints={"friction": friction}, blocks=blocks, **keys), "static")


def test_a_skewback_fills_the_corner_between_foot_bed_and_back():
    blocks = named(segment(skewbacks=1.0, live_per_weight=(0.5, 0)).blocks(thickness=0.3))
    left, right = blocks["skewback 1"], blocks["skewback 2"]
    expected = [(-2, 0), (-2 - ACROSS, UP), (-3, UP), (-3, 0)]
    assert np.array(left.vertices) == pytest.approx(np.array(expected), abs=1e-12)
    assert np.array(right.vertices) == pytest.approx(np.array(expected) * [-1, 1], abs=1e-12)
    for block in (left, right):
        assert block.weight == pytest.approx(2.0 * UP * (1.0 - ACROSS / 2) * 0.3)
        assert block.live_per_weight == (0.5, 0)
    # Abutments lie under the beds, as high as the arch is thick.
    assert np.array(blocks["abutment 1"].vertices) == pytest.approx(
        np.array([(-3, -0.5), (-2, -0.5), (-2, 0), (-3, 0)]), abs=1e-12
    )


def test_as_wide_as_the_foot_it_is_a_wedge():
    scene = mo.Scene(joints={"friction": 0.9}, blocks=segment(skewbacks=ACROSS).blocks())
    assembly = assemble(scene)
    left = assembly.geometry.polygons[[block.name for block in scene.blocks].index("skewback 1")]
    assert len(left.exterior.coords) - 1 == 3
    assert left.area == pytest.approx(ACROSS * UP / 2)
    assert len(assembly.joints.extent) == 10 + 2


def test_ends_at_different_heights_have_beds_of_their_own():
    """Of radius and angles, the other way round, moved: the bed is level with the inner end of its foot."""
    arch = mo.Arch(
        radius=2,
        angles=(45, 150),
        thickness=0.4,
        voussoirs=5,
        unit_weight=1,
        skewbacks=0.8,
        at=(1, -1),
        name="a",
    )
    blocks = named(arch.blocks())
    for name, angle, side in (("a skewback 1", 45, 1), ("a skewback 2", 150, -1)):
        x, y = 1.8 * math.cos(math.radians(angle)) + 1, 1.8 * math.sin(math.radians(angle)) - 1
        outer = y + 0.4 * math.sin(math.radians(angle))
        corners = np.array(blocks[name].vertices)
        assert corners[[0, 3]] == pytest.approx(np.array([(x, y), (x + side * 0.8, y)]), abs=1e-12)
        assert corners[1:3, 1] == pytest.approx([outer, outer])


def test_narrow_skewbacks_turn_with_the_arch_and_wide_ones_do_not():
    """The wider the bed the more the arch carries, up to what it does between fixed abutments."""
    loads = [mo.Load(block=f"v{number}", live=(1, 0)) for number in range(1, 10)]
    between = solved(segment().blocks(), loads=loads).load_factor
    widths = (ACROSS, 0.6, 1.0, 2.5, 20.0)
    factors = [solved(segment(skewbacks=width).blocks(), loads=loads).load_factor for width in widths]
    assert all(np.diff(factors) > 0)
    assert factors[0] < 0.3 * between
    assert factors[-1] == pytest.approx(between, rel=1e-6)

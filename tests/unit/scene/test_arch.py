"""The ``[arch]`` generator: areas, centroids, symmetry, skewbacks and errors."""

import math

import numpy as np
import pytest

import masonry_opt as mo
from masonry_opt.problem.assembly import assemble

RING = {"radius": 10.0, "angles": (180.0, 0.0), "thickness": 2.0, "voussoirs": 9, "unit_weight": 3.0}


def arch(**changes):
    return mo.Arch(**({"weights": "sector"} | RING | changes))


def test_weights_are_those_of_annular_sectors_and_balance_there_or_on_the_centreline():
    """A sector between the radii 9 and 11 has the area ∫∫ r dr da. The distance of its centroid is ∫∫ r² cos
    a dr da divided by the area."""
    first, angle = arch().blocks(thickness=1.0)[0], math.pi / 9
    area = angle * (11**2 - 9**2) / 2
    assert first.weight == pytest.approx(3 * area, rel=1e-12)
    distance = 2 * math.sin(angle / 2) * (11**3 - 9**3) / 3 / area
    assert math.hypot(*first.weight_at) == pytest.approx(distance, rel=1e-12)
    on_line = arch(weights="centreline").blocks(thickness=1.0)[0]
    assert on_line.weight == first.weight
    assert math.hypot(*on_line.weight_at) == pytest.approx(10 * np.sinc(angle / 2 / math.pi), rel=1e-12)


def test_joints_are_radial_and_as_long_as_the_arch_is_thick():
    joints = assemble(mo.Scene(joints={"friction": 0.5}, blocks=arch().blocks())).joints
    assert len(joints.extent) == 10
    np.testing.assert_allclose(joints.extent, 2.0, rtol=1e-9)


@pytest.mark.parametrize("thickness", [1e-9, 1e-300])
def test_an_arch_without_thickness_has_no_area(thickness):
    assert math.hypot(*arch(thickness=thickness).blocks()[0].weight_at) == pytest.approx(
        10 * math.sin(math.pi / 18) / (math.pi / 18), rel=1e-14
    )
    for made in (arch(thickness=thickness), by_rise(6.0, thickness=thickness)):
        with pytest.raises(mo.CaseError, match="no area"):
            mo.solve(mo.Scene(joints={"friction": 0.5}, blocks=made.blocks()))


@pytest.mark.parametrize("changes", [{"thickness": 1e30}, {"rise": 1e30}, {"span": 1e-300}, {"rise": 1e-300}])
def test_measures_without_proportion_end_in_a_message(changes):
    with pytest.raises(mo.CaseError):
        mo.solve(mo.Scene(joints={"friction": 0.5}, blocks=by_rise(**{"rise": 6.0} | changes).blocks()))


# Arches by span and rise


def by_rise(rise, **changes):
    given = {"span": 8.0, "rise": rise, "thickness": 1.0, "voussoirs": 8, "unit_weight": 3.0}
    return mo.Arch(**given | changes)


@pytest.mark.parametrize("rise", [1.0, 2.0, 3.5])
def test_a_segment_by_span_and_rise_is_that_by_radius_and_angles(rise):
    """An intrados of span s and rise h has the radius r = (s² / 4 + h²) / (2 h). Half of its angle has the
    sine s / (2 r)."""
    within = (16 + rise**2) / (2 * rise)
    half = math.degrees(math.asin(4 / within))
    circular = mo.Arch(
        radius=within + 0.5,
        angles=(90 + half, 90 - half),
        at=(0.0, rise - within),
        **{key: getattr(by_rise(rise), key) for key in ("thickness", "voussoirs", "unit_weight")},
    )
    for one, other in zip(by_rise(rise).blocks(1.0), circular.blocks(1.0), strict=True):
        assert one.name == other.name
        np.testing.assert_allclose(one.vertices, other.vertices, atol=1e-12)
        assert one.weight == pytest.approx(other.weight, rel=1e-12, abs=0) if one.weight else one.fixed


@pytest.mark.parametrize("rise", [5.0, 4 * math.sqrt(3), 12.0])
def test_a_pointed_arch_springs_level_and_meets_upright(rise):
    """A rise of 4√3 is that of an equilateral arch, where the radius of the arcs is the span."""
    arch = by_rise(rise)
    joints = assemble(mo.Scene(joints={"friction": 0.5}, blocks=arch.blocks())).joints
    assert len(joints.extent) == 9
    blocks = arch.blocks(thickness=1.0)
    radius = (16 + rise**2) / 8
    assert blocks[0].vertices[:2] == [pytest.approx((-4, 0), abs=1e-12), pytest.approx((-5, 0), abs=1e-12)]
    outer = math.sqrt((radius + 1) ** 2 - (radius - 4) ** 2)
    assert blocks[3].vertices[2:] == [pytest.approx((0, outer), abs=1e-9), pytest.approx((0, rise), abs=1e-9)]
    for block in blocks[:8]:
        inner_first, _, _, inner_second = block.vertices
        for x, y in (inner_first, inner_second):
            centre = radius - 4 if x <= 1e-9 else 4 - radius
            assert math.hypot(x - centre, y) == pytest.approx(radius, rel=1e-12)
    for one, other in zip(blocks[:4], reversed(blocks[4:8]), strict=True):
        np.testing.assert_allclose(one.vertices, [(-x, y) for x, y in reversed(other.vertices)], atol=1e-12)
        assert one.weight == other.weight
        assert one.weight_at == pytest.approx((-other.weight_at[0], other.weight_at[1]), abs=1e-12)


@pytest.mark.parametrize("voussoirs", [2, 8])
def test_a_pointed_arch_weighs_what_lies_between_its_arcs(voussoirs):
    """The area between the arcs and its moment about the springing line are integrated by slices. The tests
    of generators cover weights between chords."""
    built = by_rise(6.0, weights="sector", voussoirs=voussoirs).blocks(thickness=1.0)[:voussoirs]
    radius = (16 + 36) / 8
    y = (np.arange(400_000) + 0.5) / 400_000 * 10.0
    within = np.sqrt(np.maximum(radius**2 - y**2, 0)) - (radius - 4)
    beyond = np.sqrt(np.maximum((radius + 1) ** 2 - y**2, 0)) - (radius - 4)
    width = 2 * (np.maximum(beyond, 0) - np.maximum(within, 0))
    area, moment = width.sum() * 10 / 400_000, (width * y).sum() * 10 / 400_000
    assert sum(block.weight for block in built) == pytest.approx(3 * area, rel=1e-6)
    assert sum(block.weight * block.weight_at[1] for block in built) == pytest.approx(3 * moment, rel=1e-6)


SEGMENT = {"span": 4.0, "rise": 1.0, "thickness": 0.5, "voussoirs": 9, "unit_weight": 2.0}

#: Horizontal and vertical extent of the foot of the segment. Its inner radius is 2.5, and its half angle has
#: the sine 0.8 and the cosine 0.6.
ACROSS = 0.5 * 0.8
UP = 0.5 * 0.6


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
    # Abutments are under the beds, and they are as high as the arch is thick.
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
    """The arch has a radius and angles in reverse order, and is moved. Each bed is level with the inner end
    of its foot."""
    ring = {"radius": 2, "angles": (45, 150), "thickness": 0.4, "voussoirs": 5, "unit_weight": 1}
    blocks = named(mo.Arch(**ring, skewbacks=0.8, at=(1, -1), name="a").blocks())
    for name, angle, side in (("a skewback 1", 45, 1), ("a skewback 2", 150, -1)):
        x, y = 1.8 * math.cos(math.radians(angle)) + 1, 1.8 * math.sin(math.radians(angle)) - 1
        outer = y + 0.4 * math.sin(math.radians(angle))
        corners = np.array(blocks[name].vertices)
        assert corners[[0, 3]] == pytest.approx(np.array([(x, y), (x + side * 0.8, y)]), abs=1e-12)
        assert corners[1:3, 1] == pytest.approx([outer, outer])


def test_narrow_skewbacks_turn_with_the_arch_and_wide_ones_do_not():
    """The load factor increases with the width of the bed, up to that of the arch between fixed abutments."""
    loads = [mo.Load(block=f"v{number}", live=(1, 0)) for number in range(1, 10)]
    between = solved(segment().blocks(), loads=loads).load_factor
    widths = (ACROSS, 0.6, 1.0, 2.5, 20.0)
    factors = [solved(segment(skewbacks=width).blocks(), loads=loads).load_factor for width in widths]
    assert all(np.diff(factors) > 0)
    assert factors[0] < 0.3 * between
    assert factors[-1] == pytest.approx(between, rel=1e-6)

"""Tests of loads that spread through fill: conserved sums, closed forms on straight edges, and single
rays."""

import math

import numpy as np
import pytest

import masonry_opt as mo
from masonry_opt.problem.assembly import assemble
from masonry_opt.problem.fill import Road, spread
from masonry_opt.scene.geometry import Profile

BASE = mo.Block(name="base", vertices=[(-3, -1), (9, -1), (9, 0), (-3, 0)], fixed=True)

#: Angle of spread of one horizontal to two vertical, in degrees.
HALF = math.degrees(math.atan(0.5))


def block(name, vertices):
    return mo.Block(name=name, vertices=vertices, weight=1.0)


def over(blocks, road, **keys):
    """Return the assembly of a scene with fill, and the road of this fill."""
    fill = mo.Fill(road=road, unit_weight=1.0, pressure=False, **keys)
    scene = mo.Scene(joints={"friction": 0.6}, blocks=[*blocks, BASE], fills=[fill])
    assembly = assemble(scene)
    return assembly, Road(scene, assembly.geometry, road)


def on_blocks(assembly, road, x, load):
    """Return the downward forces on the movable blocks, and the abscissae of their resultants."""
    forces = road.on_blocks(np.array(x, dtype=float), np.array(load, dtype=float))[assembly.movable]
    down = -forces[:, 1]
    centroid = assembly.geometry.centroid[assembly.movable, 0] + assembly.geometry.origin[0]
    assert not forces[:, 0].any()
    return down, centroid - np.divide(forces[:, 2], down, out=np.zeros_like(down), where=down > 0)


LEFT = block("left", [(0, 0), (2, 0), (2, 1), (0, 1)])
RIGHT = block("right", [(2, 0), (6, 0), (6, 1), (2, 1)])


@pytest.mark.parametrize(("angle", "tangent"), [(30.0, math.tan(math.pi / 6)), (HALF, 0.5), (45.0, 1.0)])
def test_pressure_on_a_level_edge_is_uniform(angle, tangent):
    """The pressure of a point load on a level edge is uniform, and each block carries its share of the width.

    The load at x = 1.8 is 1.5 above the edge, where it is 2 · 1.5 tan(angle) wide. The blocks meet at x = 2.
    """
    assembly, road = over([LEFT, RIGHT], [(0, 2.5), (6, 2.5)], spread=angle)
    half = 1.5 * tangent
    down, at = on_blocks(assembly, road, [1.8], [10.0])
    to_right = half - 0.2
    np.testing.assert_allclose(down, [10 * (half + 0.2) / (2 * half), 10 * to_right / (2 * half)], rtol=1e-12)
    np.testing.assert_allclose(at, [2 - (half + 0.2) / 2, 2 + to_right / 2], rtol=1e-12)


@pytest.mark.parametrize("slope", [-0.4, -1e-5, 0.3, 0.4])
def test_on_an_inclined_edge_the_lower_side_is_met_further_off(slope):
    """On an inclined edge, the mean position of the pressure agrees with the integral over all rays.

    The depth at the distance u from the load is a - m u. A ray of tangent t meets the edge at
    u = a t / (1 + m t). With the tangent T of the spread, the mean of u is

        a / (2 T) ∫ t / (1 + m t) dt = a / (2 T m) (2 T - ln((1 + m T) / (1 - m T)) / m),

    or -a m T² / 3 for an edge that is nearly level.
    """
    under = block("under", [(0, 0), (8, 0), (8, 4 + 4 * slope), (0, 4 - 4 * slope)])
    road = [(0, 9), (8, 9)]
    assembly, above = over([under], road)
    a, m, most = 5.0, slope, math.tan(math.pi / 6)
    mean = a / (2 * most * m) * (2 * most - math.log((1 + m * most) / (1 - m * most)) / m)
    if abs(slope) < 1e-3:
        mean = -a * m * most**2 / 3
    down, at = on_blocks(assembly, above, [4.0], [3.0])
    assert down == pytest.approx([3.0], rel=1e-13)
    assert at[0] - 4 == pytest.approx(mean, rel=1e-9)


def test_an_upright_face_sends_rays_straight_down_beside_it():
    """Rays that meet the vertical face of a step load the end of the lower block.

    The step rises from 3 below the road to 1 below it, at 0.5 to the right of the load. The rays spread at
    45°. Rays of a tangent above 0.5 / 1 pass over the step. Rays between 0.5 / 3 and 0.5 / 1 stop at the
    face, and go straight down to the end of the lower block.
    """
    high = block("high", [(2, 0), (6, 0), (6, 3), (2, 3)])
    assembly, road = over([LEFT, high], [(-2, 4), (6, 4)], spread=45.0)
    down, at = on_blocks(assembly, road, [1.5], [2.0])
    step, left = (0.5 / 1 - 0.5 / 3), (1 + 0.5 / 3)
    # To the left, rays meet the ground beyond the end of the lower block at x = 0, where the depth is 4.
    on_low = 1.5 / 3
    on_ground = 1 - on_low
    np.testing.assert_allclose(down, [left + step - on_ground, 0.5], rtol=1e-12)
    moment = (on_low * 0.75) + (0.5 / 3) * 1.75 + step * 2.0
    assert at[0] == pytest.approx(moment / down[0], rel=1e-12)
    assert at[1] == pytest.approx(2.25, rel=1e-12)


@pytest.mark.parametrize("road", [[(-1.7, 1.5), (1.7, 1.5)], [(-1.7, 1.3), (0.1, 1.25), (1.7, 2.0)]])
def test_over_an_arch_loads_are_conserved_wherever_they_stand(road):
    ring = mo.Arch(span=3, rise=1, thickness=0.25, voussoirs=40, unit_weight=22).blocks()
    assembly, above = over(ring, road)
    for x in np.linspace(-1.7, 1.7, 69):
        down, at = on_blocks(assembly, above, [x], [5.0])
        assert down.sum() == pytest.approx(5.0, rel=1e-12)
        assert (down >= -1e-15).all()
        met = np.array([assembly.geometry.polygons[i].bounds[::2] for i in assembly.movable[down > 0]])
        met += assembly.geometry.origin[0]
        assert ((at[down > 0] >= met[:, 0] - 1e-9) & (at[down > 0] <= met[:, 1] + 1e-9)).all()


@pytest.mark.parametrize("keys", [{"spread": False}, {}])
def test_loads_go_straight_down_where_they_are_told_to_or_there_is_no_depth(keys):
    depth = 1.0 if keys else 0.0
    assembly, road = over(
        [LEFT, block("far", [(3, 0), (4, 0), (4, 0.4), (3, 0.4)])],
        [(0, 1 + depth), (2, 1 + depth), (4, 1)],
        **keys,
    )
    down, at = on_blocks(assembly, road, [0.7], [3.0])
    assert down == pytest.approx([3.0, 0.0], abs=1e-12)
    assert at[0] == pytest.approx(0.7)


def test_rays_one_by_one_come_to_the_same():
    """Shares and moments in closed form agree with sums over rays, for 20 random profiles with steps.

    Each load has 200,000 rays, and each ray is followed to the edge that it meets.
    """
    rng = np.random.default_rng(31)
    for _ in range(20):
        count = int(rng.integers(1, 7))
        x, line = np.sort(rng.uniform(-2, 2, count + 1)), rng.uniform(0.6, 1.0, count + 1)
        pairs = [np.column_stack([of[:-1], of[1:]]) for of in (x, line)]
        profile = Profile(pairs[0], rng.uniform(-2, 0.5, (count, 2)), pairs[1], *(2 * [np.arange(count)]))
        tangent, at = rng.uniform(0.2, 1.5), rng.uniform(x[0], x[-1])
        share, moment = spread(profile, np.array([at]), tangent)
        by_rays = rays(profile, at, tangent, float(np.interp(at, x, line)))
        np.testing.assert_allclose([share[0], moment[0]], by_rays, atol=3e-5)


def rays(profile, x, tangent, height, count=200_001):
    share, moment = np.zeros(len(profile.x)), np.zeros(len(profile.x))
    tangents = ((np.arange(count) + 0.5) / count * 2 - 1) * tangent
    for sense in (1, -1):
        t = np.abs(tangents[np.sign(tangents) == sense])
        last = None
        for i in range(len(profile.x))[::sense]:
            (u0, u1), (h0, h1) = (sense * (profile.x[i] - x))[::sense], (height - profile.y[i])[::sense]
            if u1 <= 0:
                continue
            if u0 < 0:
                u0, h0 = 0.0, h0 - u0 / (u1 - u0) * (h1 - h0)
            stops = (t * h0 <= u0) & (u0 > 0)
            if last is not None:
                share[last] += stops.sum() / count
                moment[last] += (x + sense * u0) * stops.sum() / count
            t = t[~stops]
            over = (u1 - u0) - t * (h1 - h0)
            along = np.divide(t * h0 - u0, over, out=np.full_like(t, 2.0), where=over > 0)
            meets = (along >= 0) & (along <= 1)
            share[i] += meets.sum() / count
            moment[i] += (x + sense * (u0 + along[meets] * (u1 - u0))).sum() / count
            t, last = t[~meets], i
        share[last] += len(t) / count
        moment[last] += len(t) / count * profile.x[last][::sense][1]
    return share, moment

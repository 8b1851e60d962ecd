"""Tests of uniform loads that move with axles: moments about an edge by hand, spread through fill, bad input.

On the slab of ``loads.overhang``, a load beyond the edge of the support at x = 0.5 turns the slab about this
edge. The weight W resists with the moment 0.5 W.
"""

import numpy as np
import pytest
from loads.overhang import OVERHANG, WEIGHT, axles
from speeds import slow

import masonry_opt as mo
from masonry_opt.problem.assembly import assemble
from masonry_opt.problem.fill import Road

HOLDS = 0.5 * WEIGHT  #: Moment of the weight about the edge of the support.
#: A road of which few positions are on the slab: they are a hundredth of the road apart.
LONG = [(-20, 1), (20, 1)]


def strip(load, start, end):
    return mo.UniformLoad(load=load, start=start, end=end)


def alone(*strips, **keys):
    return mo.Axles(**{"name": "crowd", "road": LONG, "uniform": [*strips]} | keys)


@pytest.mark.parametrize(
    ("group", "turns"),
    [
        (alone(strip(8.0, 0.0, 0.5)), 8 * 0.5 * 0.25),
        *slow((alone(strip(8.0, -0.25, 0.25), factor=2.0), 16 * 0.5 * 0.25)),
        # A strip that is longer than the slab is worst if it ends at the edge of the support.
        *slow((alone(strip(8.0, 0.0, 5.0)), 8 * 0.5 * 0.25)),
        # The worst position has the axle at the end of the slab, and the strip behind it from x = 0.6 to 0.9.
        (axles(3.0, road=LONG, uniform=[strip(4.0, 0.1, 0.4)]), 3 * 0.5 + 4 * 0.3 * 0.25),
        # Two strips are worst on the left, with the heavier one at the end: x = -1 to -0.8, and -0.7 to -0.5.
        (alone(strip(4.0, 0.0, 0.2), strip(6.0, 0.3, 0.5), travels="right"), 6 * 0.2 * 0.4 + 4 * 0.2 * 0.1),
        # The strip has a width of 4, of which the scene carries a quarter.
        *slow((alone(strip(8.0, 0.0, 0.5), width=4.0), 8 * 0.5 * 0.25 / 4)),
    ],
)
def test_moments_about_the_edge_of_the_support(group, turns):
    found = mo.crossing(OVERHANG, group, method="static", incremental=False)
    assert found.load_factor == pytest.approx(HOLDS / turns, rel=1e-6)
    assert (1 - 2e-3) * found.load_factor <= found.bound <= found.load_factor * (1 + 1e-9)
    there = mo.solve(found.least.passage.scene(found.position), "kinematic")
    assert there.load_factor == pytest.approx(found.load_factor, rel=1e-6)


def test_between_solved_positions_no_load_is_worse_than_the_bound():
    """No load factor between the solved positions is below the bound, by hand.

    A strip from a to b has the moment w ((b - 0.5)² - (a - 0.5)²) / 2 about the edge: a parabola. Positions
    are solved at 10⁻⁹ of the road's length from the ends of blocks.
    """
    found = mo.crossing(OVERHANG, alone(strip(8.0, 0.0, 0.3), travels="right"), method="static")
    front = np.linspace(0.55, 1.25, 57)
    first, last = np.clip([front - 0.3, front], None, 1.0)
    turns = 8.0 * ((last - 0.5) ** 2 - (first - 0.5) ** 2) / 2 * np.sign(last - first)
    by_hand = HOLDS / turns[turns > 0]
    assert found.bound <= by_hand.min() * (1 + 1e-7)
    assert found.load_factor == pytest.approx(HOLDS / (8 * 0.3 * 0.35), rel=1e-6)


def test_directions_of_a_group_with_uniform_loads():
    assert alone(strip(1.0, 0.0, 3.0)).directions == ("right",)
    assert alone(strip(1.0, 0.0, 1.0), strip(2.0, 1.0, 2.0)).directions == ("right", "left")
    assert axles(1.0, 1.0, distances=[2.0], uniform=[strip(1.0, 0.5, 1.5)]).directions == ("right",)
    assert axles(1.0, 1.0, distances=[2.0], uniform=[strip(1.0, 0.5, 1.4)]).directions == ("right", "left")
    train = [strip(80.0, -20.0, -0.8), strip(80.0, 5.6, 24.8)]
    assert mo.Axles(name="train", set="LM71", uniform=train).directions == ("right",)


@pytest.mark.slow
def test_both_directions_are_mirrors():
    """On a symmetric slab, an axle with a strip behind it has the same least load factor in both
    directions."""
    group = axles(3.0, uniform=[strip(4.0, 0.1, 0.4)])
    found = mo.crossing(OVERHANG, group, method="static", incremental=False)
    least = found.table.groupby("direction")["load_factor"].min()
    assert least["right"] == pytest.approx(least["left"], rel=1e-6)
    assert found.uniform_at[0] == pytest.approx([0.6, 0.9] if found.direction == "right" else [-0.9, -0.6])


def test_a_uniform_load_straight_down_is_exact():
    """A strip of 2 per unit length from x = -0.5 to 0.25 loads each of two slabs by its length on this
    slab."""
    blocks = [
        mo.Block(name=name, vertices=[(x, 0), (x + 1, 0), (x + 1, 1), (x, 1)], weight=1.0)
        for name, x in (("left", -1), ("right", 0))
    ]
    ground = mo.Block(name="ground", vertices=[(-2, -1), (2, -1), (2, 0), (-2, 0)], fixed=True)
    scene = mo.Scene(joints={"friction": 0.5}, blocks=[*blocks, ground])
    road = Road(scene, assemble(scene).geometry, [(-2, 1), (2, 1)])
    forces = road.strips_on_blocks(np.array([-0.5]), np.array([0.25]), np.array([2.0]))
    assert forces[:, 1] == pytest.approx([-1.0, -0.5, 0.0])
    # The moments are about the centroids at x = -0.5 and 0.5.
    assert forces[:, 2] == pytest.approx([-1.0 * 0.25, -0.5 * -0.375, 0.0])


def test_a_uniform_load_spreads_through_fill_as_many_point_loads():
    """Far from its ends, a long strip presses on level blocks as on the road; a short strip acts as 20,000
    point loads."""
    blocks = [
        mo.Block(name=f"b{x}", vertices=[(x, 0), (x + 1, 0), (x + 1, 1), (x, 1)], weight=1.0)
        for x in range(-4, 4)
    ]
    ground = mo.Block(name="ground", vertices=[(-5, -1), (5, -1), (5, 0), (-5, 0)], fixed=True)
    fill = mo.Fill(road=[(-4, 2), (4, 2)], unit_weight=18, pressure=False)
    scene = mo.Scene(joints={"friction": 0.5}, blocks=[*blocks, ground], fills=[fill])
    road = Road(scene, assemble(scene).geometry, fill.road)
    long = road.strips_on_blocks(np.array([-3.0]), np.array([3.0]), np.array([2.0]))
    assert long[2:6, 1] == pytest.approx([-2.0] * 4, rel=1e-9)
    assert long[2:6, 2] == pytest.approx([0.0] * 4, abs=1e-9)
    assert long[:, 1].sum() == pytest.approx(-12.0)
    points = -0.37 + (np.arange(20_000) + 0.5) / 20_000 * 0.61
    summed = road.on_blocks(points, np.full(len(points), 2 * 0.61 / len(points)))
    short = road.strips_on_blocks(np.array([-0.37]), np.array([0.24]), np.array([2.0]))
    np.testing.assert_allclose(short, summed, atol=2e-4 * 2 * 0.61)
    assert short[:, 1].sum() == pytest.approx(-1.22)


def test_case_files_have_uniform_loads(tmp_path):
    scene = OVERHANG.replace(axles=[axles(3.0, uniform=[strip(4.0, 0.1, 0.4)])])
    mo.save(scene, tmp_path / "slab.toml")
    text = (tmp_path / "slab.toml").read_text()
    assert "from = 0.1" in text
    again = mo.load(tmp_path / "slab.toml")
    assert again == scene
    table = mo.sweep(again, {"axles.uniform.load": [4.0, 0.001]}, method="static", workers=1)
    by_hand = [HOLDS / (1.5 + load * 0.3 * 0.25) for load in (4.0, 0.001)]
    assert table["load_factor"].to_list() == pytest.approx(by_hand, rel=1e-6)


@pytest.mark.parametrize(
    ("keys", "words"),
    [
        ({"uniform": [{"load": 1.0, "from": 2.0, "to": 1.0}]}, "'to' must be greater than 'from'"),
        ({"uniform": [{"load": 0.0, "from": 0.0, "to": 1.0}]}, "greater than 0"),
        ({"uniform": [{"load": 1.0, "from": 0.0}]}, r"missing key 'uniform\[0\]\.to'"),
        ({"uniform": []}, "has no load: .*, or loads in 'uniform'"),
        (
            {"uniform": [{"load": 1.0, "from": 0.0, "to": 1.0}], "distances": [1.0]},
            "has no axle: remove 'distances'",
        ),
    ],
)
def test_bad_uniform_loads(keys, words):
    with pytest.raises(mo.CaseError, match=words):
        mo.Axles(name="a", road=LONG, **keys)

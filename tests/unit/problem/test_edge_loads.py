"""Loads on edges: what they do to blocks, by statics of one or two blocks, and where they cannot act."""

import math

import numpy as np
import pytest
from mappings import mirrored, turned
from scenes import block_on_floor, forces_of

import masonry_opt as mo
from masonry_opt.answer.reasons import Code
from masonry_opt.problem.assembly import assemble

BASE = mo.Block(name="base", vertices=[(-9, -1), (9, -1), (9, 0), (-9, 0)], fixed=True)


def block(name, vertices, weight=1.0, **loads):
    return mo.Block(name=name, vertices=vertices, weight=weight, **loads)


def scene(blocks, loads, friction=5.0, **keys):
    made = [mo.EdgeLoad(**load) for load in loads]
    return mo.Scene(joints={"friction": friction}, blocks=[*blocks, BASE], edge_loads=made, **keys)


WIDTH, HEIGHT, DENSITY, WATER = 1.0, 3.0, 2.4, 1.0
WALL = block("wall", [(0, 0), (WIDTH, 0), (WIDTH, HEIGHT), (0, HEIGHT)], DENSITY * WIDTH * HEIGHT)


def water(depth, **keys):
    return {"start": (0, 0), "end": (0, depth), "pressure": (WATER * depth, 0)} | keys


@pytest.mark.parametrize("depth", [0.5, 2.0, 3.0])
def test_water_overturns_a_wall_by_the_moment_of_its_triangle(depth):
    """γ h³ / 6 about the toe against W b / 2."""
    result = mo.solve(scene([WALL], [water(depth, kind="live")]), "static")
    expected = (DENSITY * WIDTH * HEIGHT * WIDTH / 2) / (WATER * depth**3 / 6)
    assert result.load_factor == pytest.approx(expected, rel=1e-7)


def test_each_block_below_a_line_gets_its_part_of_a_linear_pressure():
    """Three blocks side by side, one of them lower: p = 1 + x between 0 and 4, nothing on the lower one."""
    blocks = [
        block("left", [(0, 0), (1, 0), (1, 2), (0, 2)]),
        block("low", [(1, 0), (2, 0), (2, 1), (1, 1)]),
        block("right", [(2, 0), (5, 0), (5, 2), (2, 2)]),
    ]
    assembly = assemble(scene(blocks, [{"start": (0, 2), "end": (4, 2), "pressure": (1, 5)}]))
    acting = forces_of(assembly) + np.array([0, 1, 0])  # without the weights
    # ∫ (1 + x) dx and ∫ (1 + x) (x - xc) dx over each top.
    expected = [[0, -1.5, -1 / 12], [0, 0, 0], [0, -8.0, -(2 / 3 - 4.0)]]
    np.testing.assert_allclose(acting, expected, atol=1e-12)
    assert assembly.bare_edge_loads == pytest.approx([1.0])


def test_what_another_block_covers_bears_no_load():
    """A neighbour covers the upper half of the right face: pressure 3 acts below y = 1 alone."""
    tall = block("tall", [(0, 0), (1, 0), (1, 2), (0, 2)])
    beside = [
        block("foot", [(2, 0), (3, 0), (3, 1), (2, 1)]),
        block("beam", [(1, 1), (3, 1), (3, 2), (1, 2)]),
    ]
    line = {"start": (1, 0), "end": (1, 2), "pressure": 3, "kind": "live"}
    assembly = assemble(scene([tall, *beside], [line]))
    np.testing.assert_allclose(forces_of(assembly, "live")[0], [-3.0, 0.0, -1.5], atol=1e-12)
    np.testing.assert_allclose(forces_of(assembly, "live")[1:], 0)
    assert assembly.bare_edge_loads == pytest.approx([1.0])


def test_pressure_acts_into_the_block_whichever_way_the_line_runs():
    ends = [(0, 0), (0, HEIGHT)]
    for start, end, pressure in ((*ends, (6.0, 2.0)), (*reversed(ends), (2.0, 6.0))):
        assembly = assemble(scene([WALL], [{"start": start, "end": end, "pressure": pressure}]))
        acting = forces_of(assembly)[0] + np.array([0, WALL.weight, 0])
        # 4 · 3 to the right; ∫ p (y - 1.5) dy = -(4 / 3) 1.5³ · 2 / 3, turning clockwise where it is high.
        np.testing.assert_allclose(acting, [12.0, 0.0, 3.0], atol=1e-12)


@pytest.mark.parametrize("point", [mirrored, turned(math.radians(30))], ids=["mirrored", "turned"])
@pytest.mark.parametrize(
    "load", [{"pressure": (3.0, 1.0)}, {"force": (0.4, -0.2)}], ids=["pressure", "force"]
)
def test_mirrored_and_turned_loads_have_the_same_load_factor(point, load):
    def made(of):
        turned_load = {key: of(v) if key == "force" else v for key, v in load.items()}
        blocks = [
            block("A", [of(v) for v in [(0, 0), (2, 0), (1.5, 1), (0.5, 1)]]),
            block("B", [of(v) for v in [(0.5, 1), (1.5, 1), (1, 3)]]),
            BASE.model_copy(update={"vertices": [of(v) for v in BASE.vertices]}),
        ]
        line = mo.EdgeLoad(start=of((0, 0)), end=of((0.5, 1)), kind="live", **turned_load)
        return mo.Scene(joints={"friction": 0.6}, gravity=of((0, -1)), blocks=blocks, edge_loads=[line])

    one, other = mo.solve(made(lambda v: v), "static"), mo.solve(made(point), "static")
    assert one.status.usable
    assert other.load_factor == pytest.approx(one.load_factor, rel=1e-7)


@pytest.mark.parametrize(
    ("line", "words"),
    [
        (((0, 0), (1, 0)), "covered by other blocks"),
        (((2, 0), (4, 0)), "only fixed blocks"),
        (((0, 5), (1, 5)), "no block has an edge"),
        (((0.5, 0), (0.5, 2)), "no block has an edge"),
        (((0, 2), (1, 2.1)), "no block has an edge"),
        (((0, 2), (1e-9, 2)), "no longer than what is nothing"),
    ],
)
def test_a_line_without_a_free_edge_is_refused(line, words):
    loaded = block_on_floor().model_copy(
        update={"edge_loads": [mo.EdgeLoad(start=line[0], end=line[1], pressure=1)]}
    )
    with pytest.raises(mo.CaseError, match=words) as error:
        assemble(loaded)
    assert "edge_load no. 1" in str(error.value)


WRONG = {
    "'pressure' or 'force'": {},
    "not both": {"pressure": 1, "force": (1, 0)},
    "one point": {"pressure": 1, "end": (0, 0)},
    "kind": {"pressure": 1, "kind": "alive"},
}


@pytest.mark.parametrize("words", WRONG)
def test_what_is_no_load_is_refused(words):
    with pytest.raises(mo.CaseError, match=words):
        mo.EdgeLoad(**{"start": (0, 0), "end": (1, 0)} | WRONG[words])


def test_what_a_line_reaches_beyond_its_edges_is_warned_of():
    """A line of length 2 above a block of width 1."""
    floor = mo.Block(name="floor", vertices=[(-5, -1), (6, -1), (6, 0), (-5, 0)], fixed=True)
    block = mo.Block(name="A", vertices=[(0, 0), (1, 0), (1, 1), (0, 1)], weight=1, live=(1, 0))
    load = mo.EdgeLoad(start=(0, 1), end=(2, 1), force=(0, -1))
    scene = mo.Scene(joints={"friction": 0.5}, blocks=[block, floor], edge_loads=[load])
    (warning,) = mo.solve(scene, "static").warnings
    assert warning.code is Code.BARE_EDGE_LOAD
    assert warning.values == {"number": 1, "length": pytest.approx(1.0)}

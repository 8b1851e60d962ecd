"""Loads on blocks and on edges, in the plane and in space, are compared with values by hand, and wrong ones
are refused."""

import math

import numpy as np
import pytest
from mappings import mirrored, turned
from scenes import CASES, block_on_floor, forces_of, irregular
from scenes_in_space import box_on_floor

import masonry_opt as mo
from masonry_opt.problem.assembly import assemble, on_matrices_of
from masonry_opt.problem.loads import loads, weights
from masonry_opt.reporting.summary import facts
from masonry_opt.scene.geometry import geometry
from masonry_opt.scene.space.shapes import shapes
from masonry_opt.solution.reasons import Code

#: Three courses, with two blocks between others. Block "2-2" spans 2 to 6 in x and 1 to 2 in y.
WALL = """
[joints]
friction = 0.7
[wall]
block = [4, 1]
weight = 8
courses = [[1, 1], [0.5, 1, 0.5], [1, 1]]
"""


def loaded(text, tmp_path):
    path = tmp_path / "case.toml"
    path.write_text(text)
    return mo.load(path)


def acting(scene, name, which):
    """Return the force and the moment about the centroid of the loads on one block."""
    assembly = assemble(scene)
    return forces_of(assembly, which)[assembly.names(assembly.movable).index(name)]


def test_forces_of_several_loads_on_a_block_of_a_wall_add_up(tmp_path):
    """The block is inside the wall and has no free edge. Moments are about (4, 1.5)."""
    text = WALL + (
        '[[load]]\nblock = "2-2"\nlive = [3, 0]\nat = [4, 1.75]\n'
        '[[load]]\nblock = "2-2"\nlive = [0, -2]\ndead = [0, -1]\nat = [5, 1.5]\n'
        '[[load]]\nblock = "2-2"\nlive = [1, 1]\n'
    )
    scene = loaded(text, tmp_path)
    assert acting(scene, "2-2", "live") == pytest.approx([4, -1, -3 * 0.25 - 2 * 1])
    assert acting(scene, "2-2", "dead") == pytest.approx([0, -9, -1])
    others = [row for row in forces_of(assemble(scene), "live") if row.any()]
    assert len(others) == 1


def test_a_load_is_what_the_block_s_own_force_is(tmp_path):
    """Forces as properties of a block and the same forces as loads are equal to the last digit."""
    own = {"live": (1.0, 0.5), "live_at": (0.4, 1.9), "dead": (0.1, -0.2), "dead_at": (0.9, 1.0)}
    written = block_on_floor(**own)
    loads = [
        mo.Load(block="A", live=own["live"], at=own["live_at"]),
        mo.Load(block="A", dead=own["dead"], at=own["dead_at"]),
    ]
    by_name = block_on_floor(live=(0.0, 0.0)).replace(loads=loads)
    one, other = (assemble(scene).problem for scene in (written, by_name))
    assert np.array_equal(one.live, other.live)
    assert np.array_equal(one.dead, other.dead)


def test_a_weight_in_place_of_a_generator_s_is_pushed_too(tmp_path):
    """The generator pushes every block sideways by half its weight, also a block whose weight is replaced. A
    column of one drum overturns."""
    column = "[joints]\nfriction = 5\n[column]\nwidth = 1\nheight = 3\ndrums = 1\nweight = 6\n"
    push, load = "live_per_weight = [0.5, 0]\n", '[[load]]\nblock = "d1"\nweight = 20\n'
    scene = loaded(column + push + load, tmp_path)
    assert acting(scene, "d1", "dead") == pytest.approx([0, -20, 0])
    assert acting(scene, "d1", "live") == pytest.approx([10, 0, 0])
    # With a dead push of 1 at the top, W b/2 = λ W/2 h/2 + 3.
    scene = scene.replace(loads=[*scene.loads, mo.Load(block="d1", dead=(1, 0), at=(0, 3))])
    assert mo.solve(scene, "static").load_factor == pytest.approx((20 * 0.5 - 3) / (10 * 1.5), rel=1e-7)


def test_what_the_load_factor_multiplies_is_told():
    """Forces and multiples of weights have different descriptions, and a tilted scene has none."""
    force, times = block_on_floor(), block_on_floor(live=(0, 0), live_per_weight=(1, 0))
    by_name = block_on_floor(live=(0, 0)).model_copy(update={"loads": [mo.Load(block="A", live=(1, 0))]})
    texts = [facts(mo.solve(scene, "static"))["live load"] for scene in (force, times, by_name)]
    assert texts[0] == texts[2] != texts[1]
    tilted = block_on_floor(live=(0, 0)).model_copy(update={"tilt": "left"})
    assert "live load" not in facts(mo.solve(tilted, "static"))


TWICE = 'weight = 1\n[[load]]\nblock = "2-2"\nweight = 2'
WRONG = {
    "no force": ("live = [1, 0]", "", ["load no. 1 ('2-2')", "'live', 'dead', 'weight' or 'mass'"]),
    "a point alone": ("live = [1, 0]", "at = [1, 0]", ["load no. 1 ('2-2')", "'at'"]),
    "unknown key": ("live =", "liv =", ["load no. 1 ('2-2')", "did you mean 'live'"]),
    "no block": ('block = "2-2"\n', "", ["load no. 1", "'block'"]),
    "no such block": ('"2-2"', '"2-4"', ["load no. 1", "'2-4'", "did you mean '2-"]),
    "fixed": ('"2-2"', '"base"', ["load no. 1", "'base'", "fixed"]),
    "a weight twice": ("live = [1, 0]", TWICE, ["load no. 2", "'2-2'", "'weight'"]),
    "one table": ("[[load]]", "[load]", ["[[load]]"]),
}


@pytest.mark.parametrize("mistake", WRONG)
def test_what_is_no_load_is_refused(mistake, tmp_path):
    old, new, words = WRONG[mistake]
    with pytest.raises(mo.CaseError) as error:
        loaded(WALL + '[[load]]\nblock = "2-2"\nlive = [1, 0]\n'.replace(old, new), tmp_path)
    for word in ["case.toml", *words]:
        assert word in str(error.value)


def test_a_tilted_scene_takes_weights_alone():
    scene = block_on_floor(live=(0, 0))
    keys = {"joints": scene.joints, "blocks": scene.blocks, "tilt": "right"}
    heavier = mo.Scene(**keys, loads=[mo.Load(block="A", weight=5)])
    assert acting(heavier, "A", "live") == pytest.approx([5, 0, 0])
    with pytest.raises(mo.CaseError, match="'load' on block 'A'"):
        mo.Scene(**keys, loads=[mo.Load(block="A", dead=(0, 1))])
    pushed = mo.Block(name="B", vertices=[(5, 5), (6, 5), (6, 6)], weight=1, live_per_weight=(1, 0))
    with pytest.raises(mo.CaseError, match="'live_per_weight'"):
        mo.Scene(**keys | {"blocks": [*scene.blocks, pushed]})


def test_other_loads_keep_matrices_and_other_blocks_do_not():
    """The matrices of a scene are reused if only its joint properties and loads change."""
    scene = block_on_floor()
    before, other = assemble(scene), scene.model_copy(update={"loads": [mo.Load(block="A", dead=(0, -1))]})
    same, loaded = on_matrices_of(before, scene), on_matrices_of(before, other)
    assert [one.problem.same_program(before.problem) for one in (same, loaded)] == [True, False]
    assert loaded.problem.matrices is before.problem.matrices
    fresh = assemble(other).problem
    for name in ("dead", "live", "friction", "force_unit"):
        assert np.array_equal(getattr(loaded.problem, name), getattr(fresh, name)), name
    assert on_matrices_of(before, block_on_floor(width=2)) is None


BASE = mo.Block(name="base", vertices=[(-9, -1), (9, -1), (9, 0), (-9, 0)], fixed=True)


def block(name, vertices, weight=1.0, **loads):
    return mo.Block(name=name, vertices=vertices, weight=weight, **loads)


def scene(blocks, loads, friction=5.0, **keys):
    made = [mo.EdgeLoad(**load) for load in loads]
    return mo.Scene(joints={"friction": friction}, blocks=[*blocks, BASE], edge_loads=made, **keys)


def test_each_block_below_a_line_gets_its_part_of_a_linear_pressure():
    """Three blocks are side by side, one of them lower. The pressure is p = 1 + x between 0 and 4, without
    effect on the lower block."""
    blocks = [
        block("left", [(0, 0), (1, 0), (1, 2), (0, 2)]),
        block("low", [(1, 0), (2, 0), (2, 1), (1, 1)]),
        block("right", [(2, 0), (5, 0), (5, 2), (2, 2)]),
    ]
    assembly = assemble(scene(blocks, [{"start": (0, 2), "end": (4, 2), "pressure": (1, 5)}]))
    acting = forces_of(assembly) + np.array([0, 1, 0])  # subtract the weights
    # The forces are ∫ (1 + x) dx, and the moments ∫ (1 + x) (x - xc) dx, over each top.
    expected = [[0, -1.5, -1 / 12], [0, 0, 0], [0, -8.0, -(2 / 3 - 4.0)]]
    np.testing.assert_allclose(acting, expected, atol=1e-12)
    assert assembly.bare_edge_loads == pytest.approx([1.0])


def test_what_another_block_covers_bears_no_load():
    """A neighbour covers the upper half of the right face, so the pressure 3 acts only below y = 1."""
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
    ends, wall = [(0, 0), (0, 3)], block("wall", [(0, 0), (1, 0), (1, 3), (0, 3)])
    for start, end, pressure in ((*ends, (6.0, 2.0)), (*reversed(ends), (2.0, 6.0))):
        assembly = assemble(scene([wall], [{"start": start, "end": end, "pressure": pressure}]))
        acting = forces_of(assembly)[0] + np.array([0, wall.weight, 0])
        # The force is 4 · 3 to the right. The moment is ∫ p (y - 1.5) dy = -(4 / 3) 1.5³ · 2 / 3, clockwise
        # if the pressure is larger at the top.
        np.testing.assert_allclose(acting, [12.0, 0.0, 3.0], atol=1e-12)


@pytest.mark.parametrize("point", [mirrored, turned(math.radians(30))], ids=["mirrored", "turned"])
@pytest.mark.parametrize("load", [{"pressure": (3.0, 1.0)}, {"force": (0.4, -0.2)}])
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
        (((0, 0), (1, 0)), "other blocks cover"),
        (((2, 0), (4, 0)), "belong to fixed blocks"),
        (((0, 5), (1, 5)), "no block has an edge"),
        (((0.5, 0), (0.5, 2)), "no block has an edge"),
        (((0, 2), (1, 2.1)), "no block has an edge"),
        (((0, 2), (1e-9, 2)), "is too short"),
    ],
)
def test_a_line_without_a_free_edge_is_refused(line, words):
    load = mo.EdgeLoad(start=line[0], end=line[1], pressure=1)
    with pytest.raises(mo.CaseError, match=rf"edge_load no\. 1.*{words}"):
        assemble(block_on_floor().replace(edge_loads=[load]))


NO_EDGE_LOADS = {
    "'pressure' and 'force'": {},
    "exactly one of the keys": {"pressure": 1, "force": (1, 0)},
    "the same point": {"pressure": 1, "end": (0, 0)},
    "kind": {"pressure": 1, "kind": "alive"},
}


@pytest.mark.parametrize("words", NO_EDGE_LOADS)
def test_what_is_no_edge_load_is_refused(words):
    with pytest.raises(mo.CaseError, match=words):
        mo.EdgeLoad(**{"start": (0, 0), "end": (1, 0)} | NO_EDGE_LOADS[words])


def test_what_a_line_reaches_beyond_its_edges_is_warned_of():
    """The line has length 2 and is on top of a block of width 1."""
    load = mo.EdgeLoad(start=(0, 2), end=(2, 2), force=(0, -1))
    (warning,) = mo.solve(block_on_floor().replace(edge_loads=[load]), "static").warnings
    assert warning.code is Code.BARE_EDGE_LOAD
    assert warning.values == {"number": 1, "length": pytest.approx(1.0)}


def about_centroids(scene, kind):
    """Return the force and moment of one kind of load about the centroid of each movable block."""
    at = geometry(scene) if scene.dimension == 2 else shapes(scene)
    movable = np.flatnonzero([not block.fixed for block in scene.blocks])
    return getattr(loads(scene, at, movable), kind).about(at.centroid[movable])


# Keys of a box 1 × 2 × 3 with its centroid at (0.5, 1, 1.5), a kind of load, and its force and moment.
BY_HAND = {
    "weight": ({"weight": None, "unit_weight": 5}, "weight", [0, 0, -30, 0, 0, 0]),
    # A weight of 30 at an arm of (0.5, -1, 0) has the moment r × f = (30, 15, 0).
    "weight at an edge": ({"weight": 30, "weight_at": (1, 0, 1.5)}, "weight", [0, 0, -30, 30, 15, 0]),
    "force": ({"live": (1, 2, 3)}, "live", [1, 2, 3, 0, 0, 0]),
    # The force acts at the farthest corner, with the arm (0.5, 1, 1.5).
    "force through the centroid": ({"live": (1, 2, 3), "live_at": (1, 2, 3)}, "live", [1, 2, 3, 0, 0, 0]),
    # The arm is (-0.5, -1, 1.5), and r × (4, 0, 0) = (0, 1.5·4, 1·4).
    "force at a corner": ({"dead": (4, 0, 0), "dead_at": (0, 0, 3)}, "dead", [4, 0, 0, 0, 6, 4]),
    "moment": ({"live": (0, 0, 0), "live_moment": (1, -2, 3)}, "live", [0, 0, 0, 1, -2, 3]),
    "moment and force": (
        {"dead": (0, 4, 0), "dead_at": (0.5, 1, 3), "dead_moment": (7, 1, 0)},
        "dead",
        [0, 4, 0, 7 - 6, 1, 0],
    ),
    # Twice the weight of 30 along y, at the arm (0.5, -1, 0), has the moment r × (0, 60, 0) = (0, 0, 30).
    "multiple of the weight": (
        {"weight": 30, "weight_at": (1, 0, 1.5), "live": (0, 0, 0), "live_per_weight": (0, 2, 0)},
        "live",
        [0, 60, 0, 0, 0, 30],
    ),
    "nothing": ({"live": (0, 0, 0)}, "dead", [0, 0, 0, 0, 0, 0]),
}


@pytest.mark.parametrize("name", BY_HAND)
def test_forces_and_moments_on_a_box(name):
    keys, kind, expected = BY_HAND[name]
    assert about_centroids(box_on_floor((1, 2, 3), **keys), kind) == pytest.approx(expected, abs=1e-14)


def test_loads_by_name_add_up_and_take_moments():
    """One load acts at the middle of the top, with the arm (0, 0, 1.5) and the moment (0, 1.5·2, 0). One acts
    at the centroid, and one replaces the weight."""
    scene = box_on_floor((1, 2, 3), live=(1, 0, 0), dead_moment=(0, 0, 1))
    more = [
        mo.Load(block="A", live=(2, 0, 0), at=(0.5, 1, 3)),
        mo.Load(block="A", live=(0, 1, 0), live_moment=(0, 0, 5), dead_moment=(0, 2, 0)),
        mo.Load(block="A", weight=7),
    ]
    scene = scene.model_copy(update={"loads": more})
    assert about_centroids(scene, "live") == pytest.approx([3, 1, 0, 0, 3, 5])
    assert about_centroids(scene, "dead") == pytest.approx([0, 0, 0, 0, 2, 1])
    assert about_centroids(scene, "weight") == pytest.approx([0, 0, -7, 0, 0, 0])
    assert weights(scene, shapes(scene), np.array([0])).tolist() == [7]


def test_weights_act_along_gravity_and_tilt_square_to_it():
    """The weight of 10 acts along (0, -0.6, -0.8). The tilt towards -y is perpendicular to gravity: (0, -0.8,
    0.6)."""
    scene = box_on_floor(weight=10, live=(0, 0, 0))
    scene = scene.model_copy(update={"gravity": (0.0, -3.0, -4.0), "tilt": (0.0, -5.0, 0.0)})
    assert about_centroids(scene, "weight") == pytest.approx([0, -6, -8, 0, 0, 0])
    assert about_centroids(scene, "live") == pytest.approx([0, -8, 6, 0, 0, 0])


LOADED = {"live": (1, 1), "live_at": (0, 3), "dead": (-1, 0), "dead_at": (2, 0), "live_per_weight": (0.5, 0)}
L_SHAPE = [(0, 0), (2, 0), (2, 1), (1, 1), (1, 3), (0, 3)]
PLANE = {name: mo.load(CASES / f"{name}.toml") for name in ("livesley/wedges", "goodman_bray/slope")}
PLANE["irregular"] = irregular()
PLANE["notched"] = mo.Scene(
    joints={"friction": 1},
    thickness=0.3,
    gravity=(1, -3),
    blocks=[
        mo.Block(name="A", vertices=L_SHAPE, unit_weight=4, **LOADED),
        mo.Block(name="floor", vertices=[(0, 0), (3, 0), (3, -1)], fixed=True),
    ],
    loads=[mo.Load(block="A", live=(0, 3), dead=(1, 0), at=(1, 1))],
)


@pytest.mark.parametrize("plane", PLANE.values(), ids=PLANE)
@pytest.mark.parametrize("thickness", [None, 0.5])
def test_loads_of_an_extruded_scene_are_those_in_the_plane(plane, thickness):
    """A moment m in the plane, from x to y, is a moment -m about the y axis in space."""
    for kind in ("weight", "dead", "live"):
        given = about_centroids(plane, kind).reshape(-1, 3)
        lifted = about_centroids(mo.extrude(plane, thickness), kind).reshape(-1, 6)
        expected = np.zeros_like(lifted)
        expected[:, [0, 2]], expected[:, 4] = given[:, :2], -given[:, 2]
        assert np.abs(lifted - expected).max() <= 1e-13 * max(np.abs(expected).max(), 1)

"""Loads on single blocks by name: what they do, by statics of a few blocks, and what is refused."""

import numpy as np
import pytest
from scenes import block_on_floor, forces_of

import masonry_opt as mo
from masonry_opt.answer.reasons import Code
from masonry_opt.problem.assembly import assemble, on_matrices_of
from masonry_opt.words.summary import facts

#: Three courses, two of whose blocks lie between others; "2-2" spans 2 to 6 and 1 to 2.
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
    """Force, and moment about the centroid, on one block."""
    assembly = assemble(scene)
    return forces_of(assembly, which)[assembly.names(assembly.movable).index(name)]


def test_forces_of_several_loads_on_a_block_of_a_wall_add_up(tmp_path):
    """Inside the wall, where no edge is free; the moments about (4, 1.5)."""
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
    """The same scene with each block's forces written in the block, and by a load, to the last digit."""
    own = {"live": (1.0, 0.5), "live_at": (0.4, 1.9), "dead": (0.1, -0.2), "dead_at": (0.9, 1.0)}
    written = block_on_floor(**own)
    by_name = block_on_floor(live=(0.0, 0.0)).model_copy(
        update={
            "loads": [
                mo.Load(block="A", live=own["live"], at=own["live_at"]),
                mo.Load(block="A", dead=own["dead"], at=own["dead_at"]),
            ]
        }
    )
    one, other = (assemble(scene).problem for scene in (written, by_name))
    assert np.array_equal(one.live, other.live)
    assert np.array_equal(one.dead, other.dead)


def test_a_weight_in_place_of_a_generator_s_is_pushed_too(tmp_path):
    """Sideways by half its weight, as the generator says of every block's; a column of one drum overturns."""
    column = (
        "[joints]\nfriction = 5\n[column]\nwidth = 1\nheight = 3\ndrums = 1\nweight = 6\nlive_per_weight = "
    )
    scene = loaded(column + '[0.5, 0]\n[[load]]\nblock = "d1"\nweight = 20\n', tmp_path)
    assert acting(scene, "d1", "dead") == pytest.approx([0, -20, 0])
    assert acting(scene, "d1", "live") == pytest.approx([10, 0, 0])
    # With a dead push of 1 at its top: W b/2 = λ W/2 h/2 + 3.
    scene = scene.model_copy(update={"loads": [*scene.loads, mo.Load(block="d1", dead=(1, 0), at=(0, 3))]})
    assert mo.solve(scene, "static").load_factor == pytest.approx((20 * 0.5 - 3) / (10 * 1.5), rel=1e-7)


def test_what_the_load_factor_multiplies_is_told():
    """Forces and multiples of weights each in its own words; nothing of a scene that is tilted."""
    force, times = block_on_floor(), block_on_floor(live=(0, 0), live_per_weight=(1, 0))
    by_name = block_on_floor(live=(0, 0)).model_copy(update={"loads": [mo.Load(block="A", live=(1, 0))]})
    told = [facts(mo.solve(scene, "static"))["live load"] for scene in (force, times, by_name)]
    assert told[0] == told[2] != told[1]
    tilted = block_on_floor(live=(0, 0)).model_copy(update={"tilt": "left"})
    assert "live load" not in facts(mo.solve(tilted, "static"))


WRONG = {
    "no force": ("live = [1, 0]", "", ["load no. 1 ('2-2')", "'live', 'dead' or 'weight'"]),
    "a point alone": ("live = [1, 0]", "at = [1, 0]", ["load no. 1 ('2-2')", "'at'"]),
    "unknown key": ("live =", "liv =", ["load no. 1 ('2-2')", "did you mean 'live'"]),
    "no block": ("live = [1, 0]\n", "", ["load no. 1", "'live'"]),
    "no such block": ('"2-2"', '"2-4"', ["load no. 1", "'2-4'", "did you mean '2-"]),
    "fixed": ('"2-2"', '"base"', ["load no. 1", "'base'", "fixed"]),
    "a weight twice": (
        "live = [1, 0]",
        'weight = 1\n[[load]]\nblock = "2-2"\nweight = 2',
        ["load no. 2", "'2-2'", "'weight'"],
    ),
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


def test_a_load_outside_of_its_block_is_warned_of():
    for at, distance in (((1.0, 2.0), None), ((4.0, 6.0), 5.0)):
        load = mo.Load(block="A", dead=(0, -0.1), at=at)
        scene = block_on_floor().model_copy(update={"loads": [load]})
        found = [one for one in mo.solve(scene, "static").warnings if one.code is Code.ACTS_OUTSIDE]
        assert [(one.values["load"], one.values["blocks"]) for one in found] == (
            [("dead", ["A"])] if distance else []
        )
        if distance:
            assert found[0].values["distance"] == pytest.approx(distance)


def test_other_loads_keep_matrices_and_other_blocks_do_not():
    """Sweeps keep the matrices of a scene while its joint properties and loads alone change."""
    scene = block_on_floor()
    before, other = assemble(scene), scene.model_copy(update={"loads": [mo.Load(block="A", dead=(0, -1))]})
    same, loaded = on_matrices_of(before, scene), on_matrices_of(before, other)
    assert same.problem.dead is before.problem.dead
    assert loaded.problem.matrices is before.problem.matrices
    fresh = assemble(other).problem
    for name in ("dead", "live", "friction", "force_unit"):
        assert np.array_equal(getattr(loaded.problem, name), getattr(fresh, name)), name
    assert on_matrices_of(before, block_on_floor(width=2)) is None

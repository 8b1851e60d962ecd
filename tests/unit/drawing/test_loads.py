"""Where the arrows of loads begin and end, and how they move."""

import numpy as np
import pytest
from drawn import arrows, elements_of, labels, marks
from scenes import CASES, WALLS, block_on_floor, on_a_corner

import masonry_opt as mo
from masonry_opt.drawing.elements import counts
from masonry_opt.problem.assembly import assemble


def test_forces_start_at_the_centroid_and_end_on_a_face_that_they_push():
    scene = block_on_floor(2, 3, live=(1.0, 0.0), dead=(0.0, -2.0), dead_at=(0.5, 3.0))
    (weight,), (live,), (dead,) = (arrows(scene, kind) for kind in ("weight", "live", "dead"))
    # The longest of each kind takes 9 % of the scene's larger side.
    assert weight == pytest.approx(np.array([[1, 1.5], [1, 1.5 - 0.27]]))
    assert live == pytest.approx(np.array([[1, 1.5], [1.27, 1.5]]))
    assert dead == pytest.approx(np.array([[0.5, 3.27], [0.5, 3]]))


def test_every_load_of_a_block_has_an_arrow_where_it_acts():
    """On one block: its own force, and two of loads, one of them at a point inside it."""
    loads = [mo.Load(block="A", live=(2, 0), at=(0.5, 2.5)), mo.Load(block="A", live=(0, -1), dead=(0, -1))]
    scene = block_on_floor(2, 3).model_copy(update={"loads": loads})
    assert arrows(scene, "live") == pytest.approx(
        np.array([[[1, 1.5], [1.135, 1.5]], [[0.5, 2.5], [0.77, 2.5]], [[1, 1.5], [1, 1.365]]])
    )
    assert arrows(scene, "dead") == pytest.approx(np.array([[[1, 1.5], [1, 1.23]]]))


def test_arrows_go_with_their_points_and_keep_their_direction():
    # A block of 1 × 2 overturns about its toe (1, 0) by 6 % of 2 for its fastest corner, (0, 2).
    result = mo.solve(block_on_floor(1, 2, 0.8))
    (tail, tip) = arrows(result, "live")[0]
    turn = 0.12 / np.sqrt(5)
    assert tail == pytest.approx([0.5 + turn * 1, 1 + turn * 0.5])
    assert tip - tail == pytest.approx([0.18, 0])


def test_all_weights_of_many_blocks_have_one_arrow():
    ((tail, tip),) = arrows(WALLS[0], "weight")
    assert (tip - tail)[0] == pytest.approx(0)
    assert (tip - tail)[1] < 0
    assert len(arrows(WALLS[0], "live")) == 33
    assert "direction of all weights" in labels(WALLS[0])


def test_a_tilted_scene_is_pushed_by_its_weights():
    scene = block_on_floor(2, 3, live=(0.0, 0.0)).model_copy(update={"tilt": "left"})
    ((tail, tip),) = arrows(scene, "live")
    assert tip - tail == pytest.approx([-0.27, 0])


def test_water_pushes_more_the_deeper():
    water = mo.EdgeLoad(start=(0, 0), end=(0, 3), pressure=(3.0, 0.0), kind="live")
    scene = block_on_floor(2, 3, live=(0.0, 0.0)).model_copy(update={"edge_loads": [water]})
    rows = arrows(scene, "live")
    tip, length = rows[:, 1], rows[:, 1, 0] - rows[:, 0, 0]
    assert tip[:, 0] == pytest.approx(np.zeros(len(rows)))
    assert length / length.max() == pytest.approx(1 - tip[:, 1] / 3)
    (along,) = marks(scene, "live", shape="line")
    assert np.array(along) == pytest.approx(rows[[0, -1], 0])
    assert "live load, times λ" in labels(scene)


def test_nothing_that_is_drawn_of_loads_leaves_the_frame():
    scene = CASES / "goodman_bray" / "slope.toml"
    elements, kind = elements_of(scene)
    low, high = elements.box(elements.shown(kind), 0.0) + elements.assembly.geometry.origin
    ends = np.concatenate([arrows(scene, name).reshape(-1, 2) for name in ("live", "weight", "dead")])
    assert (ends >= low).all()
    assert (ends <= high).all()


@pytest.mark.parametrize("along_an_edge", [False, True])
def test_a_state_under_dead_load_alone_is_shown_without_the_live_load(along_an_edge):
    """Where a scene falls by itself, and at the ends of a margin; the scene itself is drawn with it."""
    scene = block_on_floor(dead=(0.9, 0.0))
    if along_an_edge:
        push = mo.EdgeLoad(start=(0, 0), end=(0, 2), force=(1, 0), kind="live")
        still = block_on_floor(dead=(0.9, 0.0), live=(0.0, 0.0))
        scene = still.model_copy(update={"edge_loads": [push]})
    falls = mo.solve(scene, "static")
    margin = mo.least(lambda mu: block_on_floor(friction=mu, dead=(0.4, 0.0)), 0.1, 0.9, samples=0)
    for result in (falls, margin.fails.result, margin.holds.result):
        assert not len(marks(result, "live"))
        assert len(arrows(result, "dead")) == 1
        assert "live load, times λ" not in labels(result)
        assert "further dead load" in labels(result)
    assert len(arrows(scene, "live")) > 0
    assert "live load, times λ" in labels(mo.solve(block_on_floor(), "static"))


def block(name, left, right, bottom, top, **keys):
    return mo.Block(
        name=name, vertices=[(left, bottom), (right, bottom), (right, top), (left, top)], weight=1, **keys
    )


def beside(*blocks):
    """More blocks on the floor beside a block of 2 × 3, whose lower left corner is the origin."""
    scene = block_on_floor(2, 3)
    return scene.model_copy(update={"blocks": [*scene.blocks, *blocks]})


#: A gap of 0.001 between faces of height 2.
GAP = beside(block("B", 2.001, 4, 0, 2))
#: C stands on B's corner with its own.
CORNER = beside(block("B", 2, 4, 0, 2), block("C", 4, 5, 2, 3))


def test_joints_found_are_drawn_and_counted():
    assert len(marks(WALLS[0], "joint")) == 83
    assert mo.draw(WALLS[0]).axes[0].get_title().endswith("33 blocks, 1 support, 83 joints")


def test_a_small_gap_is_marked_as_no_joint():
    (gap,) = marks(GAP, "gaps")
    assert np.sort(gap[:, 1]) == pytest.approx([0, 2], abs=0.01)
    assert gap[:, 0] == pytest.approx([2, 2], abs=0.002)
    assert len(marks(GAP, "joint")) == 2
    assert "small gap: no joint" in labels(GAP)
    assert "1 small gap" in counts(assemble(GAP))
    assert "small gap: no joint" not in labels(WALLS[0])


def test_corner_on_corner_is_marked_and_warned_of():
    assert marks(CORNER, "corners") == pytest.approx(np.array([[[4, 2]]]))
    assert "corner on corner: no joint" in labels(CORNER)
    assert any("corner on corner" in text.get_text() for text in mo.draw(CORNER).texts)


def test_a_corner_on_an_edge_is_a_joint_of_its_own_mark():
    assert marks(on_a_corner(), "joint", shape="square") == pytest.approx(np.array([[[1, 0]]]))
    assert len(marks(on_a_corner(), "joint", shape="line")) == 3
    assert {"joint", "joint of a corner on an edge"} <= set(labels(on_a_corner()))


def test_a_block_that_touches_nothing_is_drawn_and_named():
    scene = beside(block("far up", 0, 1, 5, 6))
    with pytest.raises(mo.CaseError):
        mo.solve(scene)
    figure = mo.draw(scene, names=True)
    assert "far up" in {text.get_text() for text in figure.axes[0].texts}
    assert any("'far up' touches no other block" in text.get_text() for text in figure.texts)
    alone = scene.model_copy(update={"blocks": scene.blocks[1:]})
    assert counts(assemble(alone, floating=True)) == "1 block, 1 support, 0 joints"
    mo.draw(alone)

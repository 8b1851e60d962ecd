"""Where the arrows of loads begin and end, and how they move."""

from __future__ import annotations

import numpy as np
import pytest
from drawn import arrows, elements_of, labels, marks
from scenes import CASES, WALLS, block_on_floor

import masonry_opt as mo


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


def test_an_edge_load_of_nothing_is_not_drawn():
    """Such as a sweep from zero on has."""
    none = mo.EdgeLoad(**{"from": (0, 0), "to": (0, 2)}, pressure=0.0)
    scene = block_on_floor(4, 2, 0.5).model_copy(update={"edge_loads": [none]})
    assert len(arrows(scene, "live")) == 1
    assert not len(marks(scene, "dead"))


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

"""Where the arrows of loads begin and end."""

from __future__ import annotations

import numpy as np
import pytest
from drawn import arrows, legend
from scenes import CASES, WALLS, block_on_floor

import masonry_opt as mo
from masonry_opt.report.colours import DEAD, FURTHER_DEAD, LIVE
from masonry_opt.report.page.page import page


def drawn(scene):
    return mo.draw(scene).axes[0]


def test_forces_start_at_the_centroid_and_end_on_a_face_that_they_push():
    scene = block_on_floor(2, 3, live=(1.0, 0.0), dead=(0.0, -2.0), dead_at=(0.5, 3.0))
    axes = drawn(scene)
    (weight,), (live,), (dead,) = (arrows(axes, colour) for colour in (DEAD, LIVE, FURTHER_DEAD))
    # The longest of each kind takes 9 % of the scene's larger side.
    assert weight == pytest.approx(np.array([[1, 1.5], [1, 1.5 - 0.27]]))
    assert live == pytest.approx(np.array([[1, 1.5], [1.27, 1.5]]))
    assert dead == pytest.approx(np.array([[0.5, 3.27], [0.5, 3]]))


def test_every_load_of_a_block_has_an_arrow_where_it_acts():
    """On one block: its own force, and two of loads, one of them at a point inside it."""
    loads = [mo.Load(block="A", live=(2, 0), at=(0.5, 2.5)), mo.Load(block="A", live=(0, -1), dead=(0, -1))]
    scene = block_on_floor(2, 3).model_copy(update={"loads": loads})
    axes = drawn(scene)
    # The longest takes 9 % of the scene's larger side.
    assert arrows(axes, LIVE) == pytest.approx(
        np.array([[[1, 1.5], [1.135, 1.5]], [[0.5, 2.5], [0.77, 2.5]], [[1, 1.5], [1, 1.365]]])
    )
    assert arrows(axes, FURTHER_DEAD) == pytest.approx(np.array([[[1, 1.5], [1, 1.23]]]))
    drawn_live = page(mo.solve(scene, "static")).split('<g class="loads live"')[1].split("</g>")[0]
    assert drawn_live.count("<path") == 3


def test_all_weights_of_many_blocks_have_one_arrow():
    axes = drawn(WALLS[0])
    (weight,) = arrows(axes, DEAD)
    assert (weight[1] - weight[0])[0] == pytest.approx(0)
    assert (weight[1] - weight[0])[1] < 0
    assert len(arrows(axes, LIVE)) == 33


def test_a_tilted_scene_is_pushed_by_its_weights():
    scene = block_on_floor(2, 3, live=(0.0, 0.0)).model_copy(update={"tilt": "left"})
    (live,) = arrows(drawn(scene), LIVE)
    assert live[1] - live[0] == pytest.approx([-0.27, 0])


def test_water_pushes_more_the_deeper():
    water = mo.EdgeLoad(start=(0, 0), end=(0, 3), pressure=(3.0, 0.0), kind="live")
    scene = block_on_floor(2, 3, live=(0.0, 0.0)).model_copy(update={"edge_loads": [water]})
    figure = mo.draw(scene)
    rows = arrows(figure.axes[0], LIVE)
    tip, length = rows[:, 1], rows[:, 1, 0] - rows[:, 0, 0]
    assert tip[:, 0] == pytest.approx(np.zeros(len(rows)))
    assert length / length.max() == pytest.approx(1 - tip[:, 1] / 3)
    assert "live load, times λ" in legend(figure)


def test_nothing_that_is_drawn_of_loads_leaves_the_frame():
    axes = mo.draw(CASES / "goodman_bray" / "slope.toml").axes[0]
    ends = np.concatenate([arrows(axes, colour).reshape(-1, 2) for colour in (LIVE, DEAD, FURTHER_DEAD)])
    (x0, x1), (y0, y1) = axes.get_xlim(), axes.get_ylim()
    assert (ends >= [x0, y0]).all()
    assert (ends <= [x1, y1]).all()


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
        figure = result.plot()
        assert len(arrows(figure.axes[0], LIVE)) == 0
        assert len(arrows(figure.axes[0], FURTHER_DEAD)) == 1
        assert "live load, times λ" not in legend(figure)
        text = page(result)
        assert "live load, times λ" not in text
        assert "further dead load" in text
        assert '<g class="loads live"' not in text
    assert len(arrows(drawn(scene), LIVE)) > 0
    carried = mo.solve(block_on_floor(), "static")
    assert '<g class="loads live"' in page(carried)
    assert "live load, times λ" in page(carried)

"""Resultants where they act, and lines of thrust."""

from __future__ import annotations

import numpy as np
import pytest
from drawn import lines
from matplotlib.backends.backend_agg import FigureCanvasAgg
from scenes import CASES, WALLS, block_on_floor, overhanging

import masonry_opt as mo
from masonry_opt.problem.assembly import assemble
from masonry_opt.report.colours import THRUST
from masonry_opt.report.thrust import chains


def test_a_resultant_is_drawn_through_its_point_of_action_to_scale():
    # By hand: 3 up and 1.5 to the left, at x = 2.5 of the floor (see the unit test of thrust).
    figure = mo.solve(block_on_floor(4, 2, 0.5, weight=3.0, live=(3.0, 0.0))).plot("thrust")
    axes = figure.axes[0]
    ((tail, tip),) = lines(axes, THRUST)
    assert (tail + tip) / 2 == pytest.approx([2.5, 0], abs=1e-5)
    assert (tip - tail)[0] / (tip - tail)[1] == pytest.approx(-0.5, abs=1e-5)
    (bar,) = axes.lines
    (said,) = (text.get_text() for text in axes.texts)
    scale = np.ptp(bar.get_xdata()) / float(said.removeprefix("= "))
    assert np.hypot(*(tip - tail)) / scale == pytest.approx(np.hypot(3, 1.5), rel=1e-5)


def test_the_line_of_thrust_runs_through_an_arch_from_support_to_support():
    figure = mo.solve(CASES / "casapulla_lauro" / "arch.toml").plot("thrust")
    # The two resultants on supports are drawn beside it, from outside the arch.
    polygon = lines(figure.axes[0], THRUST)[:-2]
    assert polygon.shape == (27, 2, 2)
    ends = polygon.reshape(-1, 2)
    points, times = np.unique(ends.round(9), axis=0, return_counts=True)
    assert sorted(times) == [1, 1] + [2] * 26
    # Between intrados and extrados; voussoirs have straight edges.
    radius = np.hypot(*points.T)
    assert (radius > 9.45 - 1e-6).all()
    assert (radius < 10.55 + 1e-6).all()
    assert points[times == 1][:, 1] == pytest.approx([0, 0], abs=1e-9)


def test_a_wall_has_no_chain_and_a_column_has_one():
    wall = assemble(mo.load(WALLS[0]))
    assert len(chains(wall, np.ones(wall.problem.joints, dtype=bool))) == 0
    column = assemble(mo.load(CASES / "closed_forms" / "dam_overturns.toml"))
    # The top lift has one joint; three lifts lie between two.
    assert len(chains(column, np.ones(column.problem.joints, dtype=bool))) == 3
    assert len(chains(column, np.zeros(column.problem.joints, dtype=bool))) == 0


@pytest.mark.parametrize("kind", ["thrust", "utilisation"])
def test_without_forces_the_picture_says_so(kind):
    axes = mo.solve(overhanging()).plot(kind).axes[0]
    assert [text.get_text() for text in axes.texts] == ["no forces were found to draw"]
    assert not len(lines(axes, THRUST))


@pytest.mark.parametrize("height", [1, 4, 12, 20, 28, 60, 200])
def test_the_scale_keeps_its_label_beside_slender_scenes(height):
    """The bar is up to 12 % of the height long: more than a slender column leaves free beside it."""
    blocks = [
        mo.Block(name=str(y), vertices=[(0, y), (0.5, y), (0.5, y + 1), (0, y + 1)], weight=1, live=(1, 0))
        for y in range(height)
    ]
    floor = mo.Block(name="floor", vertices=[(-1, -1), (2, -1), (2, 0), (-1, 0)], fixed=True)
    scene = mo.Scene(joints=mo.JointDefaults(friction=0.6), blocks=[*blocks, floor])
    figure = mo.solve(scene, "static").plot("thrust")
    canvas = FigureCanvasAgg(figure)
    canvas.draw()
    (label,) = figure.axes[0].texts
    assert label._check_xy(canvas.get_renderer())  # matplotlib draws it
    box, axes = label.get_window_extent(), figure.axes[0].bbox
    assert axes.x0 <= box.x0 < box.x1 <= axes.x1

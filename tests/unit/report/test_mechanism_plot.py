"""What the picture of a mechanism shows."""

from __future__ import annotations

import matplotlib as mpl
import pytest
from scenes import WALLS, block_on_floor

import masonry_opt as mo
from masonry_opt.report.mechanism_plot import joint_motion, plot_mechanism


def test_plot_shows_load_factor_and_legend(tmp_path):
    with mpl.rc_context({"svg.fonttype": "none"}):
        plot_mechanism(mo.solve(WALLS[0], "nonassociative"), tmp_path / "wall.svg")
    text = (tmp_path / "wall.svg").read_text()
    for words in ("Ferris &amp; Tin-Loi wall 1", "0.63982", "sliding joint", "hinging joint"):
        assert words in text


def test_titles_may_hold_anything(tmp_path):
    scene = block_on_floor().model_copy(update={"title": "costs $\\frac{$ " + "very " * 40})
    plot_mechanism(mo.solve(scene), tmp_path / "picture.png")


@pytest.mark.parametrize(
    ("width", "friction", "slides", "hinges"), [(1, 0.8, False, True), (4, 0.5, True, False)]
)
def test_marked_joints_are_those_that_move(width, friction, slides, hinges):
    motion = joint_motion(mo.solve(block_on_floor(width, 2, friction)))
    assert (motion.slides[0], motion.hinges[0]) == (slides, hinges)


def test_block_overturns_about_its_far_toe():
    result = mo.solve(block_on_floor(1, 2, 0.8))
    toe = joint_motion(result).hinge[0] + result.assembly.geometry.origin
    assert toe == pytest.approx([1, 0])

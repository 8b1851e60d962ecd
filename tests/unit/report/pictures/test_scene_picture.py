"""Scenes before they are solved: joints, gaps, corners, and what looks unintended."""

from __future__ import annotations

import numpy as np
import pytest
from drawn import legend, lines
from scenes import WALLS, block_on_floor, on_a_corner, overhanging

import masonry_opt as mo
from masonry_opt.problem.assembly import assemble
from masonry_opt.report.colours import HINGES, SLIDES
from masonry_opt.report.pictures.scene_picture import counts, meeting_corners, near_misses


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
    figure = mo.draw(WALLS[0])
    assert len(lines(figure.axes[0], SLIDES)) == 83
    assert figure.axes[0].get_title().endswith("33 blocks, 1 support, 83 joints")


def test_a_small_gap_is_marked_as_no_joint():
    figure = mo.draw(GAP)
    (gap,) = lines(figure.axes[0], HINGES)
    assert np.sort(gap[:, 1]) == pytest.approx([0, 2], abs=0.01)
    assert gap[:, 0] == pytest.approx([2, 2], abs=0.002)
    assert len(lines(figure.axes[0], SLIDES)) == 2
    assert "small gap: no joint" in legend(figure)
    assert "1 small gap" in counts(assemble(GAP))
    assert "small gap: no joint" not in legend(mo.draw(WALLS[0]))
    assert not near_misses(assemble(mo.load(WALLS[0])))


def test_corner_on_corner_is_marked_and_warned_of():
    assembly = assemble(CORNER, floating=True)
    assert meeting_corners(assembly) == pytest.approx(np.array([[4, 2]]))
    figure = mo.draw(CORNER)
    assert "corner on corner: no joint" in legend(figure)
    assert any("corner on corner" in text.get_text() for text in figure.texts)


def test_a_corner_on_an_edge_is_a_joint_of_its_own_mark():
    axes = mo.draw(on_a_corner()).axes[0]
    (mark,) = axes.lines
    assert mark.get_xydata() == pytest.approx(np.array([[1, 0]]))
    assert len(lines(axes, SLIDES)) == 3


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


def test_a_scene_that_falls_can_be_drawn_and_written(tmp_path):
    mo.draw(overhanging(), tmp_path / "falls.pdf")
    assert (tmp_path / "falls.pdf").read_bytes().startswith(b"%PDF-")


def test_what_is_no_scene_or_picture_is_refused(tmp_path):
    with pytest.raises(mo.OptionError, match=r"\.svg"):
        mo.draw(WALLS[0], tmp_path / "wall.gif")
    with pytest.raises(mo.CaseError, match="overlap"):
        mo.draw(beside(block("B", 1, 4, 0, 2)), tmp_path / "wall.png")
    assert not list(tmp_path.iterdir())

"""Scenes before they are solved: joints, gaps, corners, and what looks unintended."""

from __future__ import annotations

import numpy as np
import pytest
from drawn import labels, marks
from scenes import WALLS, block_on_floor, on_a_corner, overhanging

import masonry_opt as mo
from masonry_opt.drawing.elements import counts
from masonry_opt.problem.assembly import assemble


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


def test_a_scene_that_falls_can_be_drawn_and_written(tmp_path):
    mo.draw(overhanging(), tmp_path / "falls.pdf")
    assert (tmp_path / "falls.pdf").read_bytes().startswith(b"%PDF-")


def test_what_is_no_scene_or_picture_is_refused(tmp_path):
    with pytest.raises(mo.OptionError, match=r"\.svg"):
        mo.draw(WALLS[0], tmp_path / "wall.gif")
    with pytest.raises(mo.CaseError, match="overlap"):
        mo.draw(beside(block("B", 1, 4, 0, 2)), tmp_path / "wall.png")
    assert not list(tmp_path.iterdir())

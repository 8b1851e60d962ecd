"""Joints by how they move: what is drawn of each, and only of what occurs."""

from __future__ import annotations

import numpy as np
import pytest
from drawn import legend, lines, marks
from scenes import CASES, block_on_floor, overhanging

import masonry_opt as mo
from masonry_opt.answer.motion import joint_motion
from masonry_opt.report.colours import CRUSHES, HINGES, SEPARATES, SLIDES


def beside_a_wall():
    """A block that is pushed away from a wall: it slides on the floor and leaves the wall."""
    scene = block_on_floor(4, 2, 0.5)
    wall = mo.Block(name="wall", vertices=[(-1, 0), (0, 0), (0, 3), (-1, 3)], fixed=True)
    return scene.model_copy(update={"blocks": [*scene.blocks, wall]})


def test_a_face_that_separates_does_not_slide():
    result = mo.solve(beside_a_wall())
    motion = joint_motion(result.assembly, result.solution)
    on = {second: number for number, second in enumerate(result.joints["second"])}
    assert motion.slides.tolist() == [number == on["floor"] for number in range(2)]
    assert motion.separates.tolist() == [number == on["wall"] for number in range(2)]
    figure = result.plot()
    (face,) = lines(figure.axes[0], SEPARATES)
    (bed,) = lines(figure.axes[0], SLIDES)
    # Midway between the wall, at rest, and the block, moved to the right by 6 % of its width.
    assert face == pytest.approx(np.array([[0.12, 2], [0.12, 0]]))
    assert bed == pytest.approx(np.array([[0.12, 0], [4.12, 0]]))
    assert {"sliding joint", "separating joint"} <= set(legend(figure))
    assert not {"hinging joint", "crushing joint"} & set(legend(figure))


def test_an_arch_has_four_hinges():
    result = mo.solve(CASES / "casapulla_lauro" / "arch.toml")
    figure = result.plot()
    hinges = marks(figure.axes[0], HINGES)
    assert len(hinges) == 4
    # That on the support has not moved: at the arch's extrados, 10.55 from its middle.
    assert hinges[np.argmin(hinges[:, 1])] == pytest.approx([10.55, 0], abs=1e-6)
    assert not len(lines(figure.axes[0], SLIDES))
    assert "sliding joint" not in legend(figure)


def test_a_toe_that_crushes_is_crossed():
    scene = block_on_floor(1, 2, 0.8).model_copy(
        update={"joints": mo.JointDefaults(friction=0.8, strength=4)}
    )
    figure = mo.solve(scene, "static").plot()
    assert len(lines(figure.axes[0], CRUSHES)) == len(marks(figure.axes[0], CRUSHES)) == 1
    assert not len(lines(figure.axes[0], SLIDES))
    assert "crushing joint" in legend(figure)


def test_blocks_that_fall_are_drawn_falling_and_named_so():
    figure = mo.solve(overhanging()).plot()
    assert "no load factor" in figure.axes[0].get_title()
    # About the edge of what bears the block.
    assert marks(figure.axes[0], HINGES) == pytest.approx(np.array([[0.5, 0]]), abs=1e-6)
    assert not len(lines(figure.axes[0], SEPARATES))


def test_titles_may_hold_anything(tmp_path):
    scene = block_on_floor().model_copy(update={"title": "costs $\\frac{$ " + "very " * 40})
    mo.solve(scene).save(tmp_path / "picture.png")

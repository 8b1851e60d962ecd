"""Joints in the colours of their utilisation."""

from __future__ import annotations

import numpy as np
import pytest
from drawn import legend, lines
from matplotlib import colormaps
from scenes import block_on_floor

import masonry_opt as mo
from masonry_opt.report.colours import IDLE


def two_stones():
    """A block that leaves a wall and slides at λ = 0.5, and one of the same weight and half the live load."""
    scene = block_on_floor(4, 2, 0.5)
    wall = mo.Block(name="wall", vertices=[(-1, 0), (0, 0), (0, 2), (-1, 2)], fixed=True)
    other = mo.Block(name="B", vertices=[(-5, 0), (-1.5, 0), (-1.5, 2), (-5, 2)], weight=1, live=(0.5, 0))
    return scene.model_copy(update={"blocks": [*scene.blocks, wall, other]})


def test_colours_say_how_much_of_its_limit_a_joint_carries():
    figure = mo.solve(two_stones()).plot("utilisation")
    axes, bar = figure.axes
    (full,) = lines(axes, colormaps["viridis_r"](1.0))
    assert np.sort(full[:, 0]) == pytest.approx([0, 4])
    # |s| / (μ n) = 0.25 / 0.5, more than |m| / (n L / 2) = 0.25 × 1 / 1.75.
    (half,) = lines(axes, colormaps["viridis_r"](0.5))
    assert np.sort(half[:, 0]) == pytest.approx([-5, -1.5])
    (idle,) = lines(axes, IDLE)
    assert idle[:, 0] == pytest.approx([0, 0])
    assert "idle joint" in legend(figure)
    assert bar.get_xlim() == (0, 1)
    assert "utilisation" in bar.get_xlabel()

"""How joints move in a mechanism."""

from __future__ import annotations

import pytest
from scenes import block_on_floor

import masonry_opt as mo
from masonry_opt.report.motion import joint_motion


@pytest.mark.parametrize(
    ("width", "friction", "slides", "hinges"), [(1, 0.8, False, True), (4, 0.5, True, False)]
)
def test_a_block_slides_or_hinges(width, friction, slides, hinges):
    motion = joint_motion(mo.solve(block_on_floor(width, 2, friction)))
    assert (motion.slides[0], motion.hinges[0]) == (slides, hinges)


def test_block_overturns_about_its_far_toe():
    result = mo.solve(block_on_floor(1, 2, 0.8))
    toe = joint_motion(result).hinge[0] + result.assembly.geometry.origin
    assert toe == pytest.approx([1, 0])

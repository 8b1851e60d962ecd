"""Joints by how they move: what is drawn of each, and only of what occurs."""

import numpy as np
import pytest
from drawn import labels, marks, solved
from scenes import CASES, WALLS, block_on_floor

import masonry_opt as mo
from masonry_opt.answer.motion import fastest, joint_motion
from masonry_opt.drawing.elements import FULL, result_elements
from masonry_opt.drawing.marks import moved, size_of

ARCH = CASES / "casapulla_lauro" / "arch.toml"


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
    (face,), (bed,) = marks(result, "separates"), marks(result, "slides")
    # Midway between the wall, at rest, and the block, moved to the right by 6 % of its width.
    assert face == pytest.approx(np.array([[0.12, 2], [0.12, 0]]))
    assert bed == pytest.approx(np.array([[0.12, 0], [4.12, 0]]))
    assert {"sliding joint", "separating joint"} <= set(labels(result))
    assert not {"hinging joint", "crushing joint"} & set(labels(result))


def test_an_arch_has_four_hinges():
    result = solved(ARCH)
    hinges = marks(result, "hinges")[:, 0]
    assert len(hinges) == 4
    # That on the support has not moved: at the arch's extrados, 10.55 from its middle.
    assert hinges[np.argmin(hinges[:, 1])] == pytest.approx([10.55, 0], abs=1e-6)
    assert not len(marks(result, "slides"))
    assert "sliding joint" not in labels(result)


def test_a_toe_that_crushes_is_crossed():
    scene = block_on_floor(1, 2, 0.8).model_copy(
        update={"joints": mo.JointDefaults(friction=0.8, strength=4)}
    )
    result = mo.solve(scene, "static")
    assert len(marks(result, "crushes")) == len(marks(result, "crosses")) == 1
    assert not len(marks(result, "slides"))
    assert "crushing joint" in labels(result)


def test_the_fastest_corner_moves_by_a_tenth_and_stays_in_the_picture():
    # A block of 1 × 2 overturns about its toe (1, 0): fastest is the corner furthest from it, (0, 2).
    elements = result_elements(mo.solve(block_on_floor(1, 2, 0.8)))
    corners = np.array([[0, 2], [0, 0], [1, 0], [1, 2]]) - elements.assembly.geometry.origin
    after = moved(corners, elements.motion[0])
    assert after[0] - corners[0] == pytest.approx(FULL * 2 * np.array([2, 1]) / np.sqrt(5))
    assert after[2] == pytest.approx(corners[2])
    low, high = elements.box([], 1.0)
    assert ((after > low) & (after < high)).all()


@pytest.mark.parametrize("case", [WALLS[0], ARCH], ids=["wall", "arch"])
def test_joints_open_and_slip_as_the_motions_of_their_blocks_say(case):
    """The motion of the first block against the second, resolved along the joint by hand."""
    result = solved(case)
    motion, joints, frame = result_elements(result).motion, result.assembly.joints, result.joints
    apart = moved(joints.middle, motion[joints.first]) - moved(joints.middle, motion[joints.second])
    full = FULL * size_of(result.assembly) / fastest(result.assembly, result.solution.d)
    along = np.column_stack([joints.normal[:, 1], -joints.normal[:, 0]])
    assert (apart * joints.normal).sum(axis=1) == pytest.approx(full * frame["opening"], abs=1e-9)
    assert (apart * along).sum(axis=1) == pytest.approx(full * frame["slip"], abs=1e-9)

"""The matrices against rigid-body motion worked out by hand."""

from __future__ import annotations

import numpy as np
import pytest
from scenes import block_on_floor, irregular, small_wall, two_blocks

import masonry_opt as mo
from masonry_opt.problem.assembly import assemble


def velocity(d, block, arm):
    vx, vy, omega = d[3 * block : 3 * block + 3]
    return np.array([vx - omega * arm[1], vy + omega * arm[0]])


@pytest.mark.parametrize("scene", [irregular(), two_blocks(), small_wall()], ids=["irregular", "two", "wall"])
def test_joint_velocities_are_differences_of_rigid_body_velocities(scene):
    assembly = assemble(scene)
    problem, joints, shapes = assembly.problem, assembly.joints, assembly.geometry
    d = np.random.default_rng(1).normal(size=3 * problem.blocks)
    u = problem.B.T @ d
    row = {block: number for number, block in enumerate(assembly.movable)}
    for joint in range(problem.joints):
        start, end = np.zeros(2), np.zeros(2)
        for block, sign in ((joints.first[joint], 1), (joints.second[joint], -1)):
            if block in row:
                for motion, at in ((start, joints.start), (end, joints.end)):
                    arm = (at[joint] - shapes.centroid[block]) / problem.length_unit
                    motion += sign * velocity(d, row[block], arm)
        normal = joints.normal[joint]
        tangent = np.array([normal[1], -normal[0]])
        expected = [start @ normal, end @ normal, start @ tangent]
        assert u.reshape(3, -1)[:, joint] == pytest.approx(expected)


def test_compression_pushes_the_first_block_away_from_the_second():
    problem = assemble(block_on_floor()).problem
    first, second, s = np.eye(3)
    # Block A (first) stands on the floor: n lifts it, s pushes it right about its centroid above. At its
    # start, to the left, n turns it clockwise, with half the joint for its arm.
    assert problem.B @ first == pytest.approx([0, 1, -1])
    assert problem.B @ second == pytest.approx([0, 1, 1])
    assert problem.B @ s == pytest.approx([1, 0, 1.0 / problem.length_unit])


def test_loads_act_where_they_are_put():
    scene = block_on_floor(
        2.0, 2.0, live=(3.0, 0.0), live_at=(1.0, 2.0), dead=(0.0, -4.0), dead_at=(1.5, 2.0), weight=6.0
    )
    problem = assemble(scene).problem
    force, moment = problem.force_unit, problem.force_unit * problem.length_unit
    assert problem.dead * [force, force, moment] == pytest.approx([0, -10, -2])
    assert problem.live * [force, force, moment] == pytest.approx([3, 0, -3])


def test_gravity_points_where_the_scene_says():
    scene = block_on_floor().model_copy(update={"gravity": (3.0, -4.0)})
    problem = assemble(scene).problem
    assert problem.dead * problem.force_unit == pytest.approx([0.6, -0.8, 0])


def test_units_cancel():
    small, large = block_on_floor(1, 2, weight=1), block_on_floor(1000, 2000, weight=1, live=(1, 0))
    large = mo.Scene(
        joints=large.joints,
        blocks=[
            large.blocks[0],
            mo.Block(
                name="floor", vertices=[(-5000, -1000), (6000, -1000), (6000, 0), (-5000, 0)], fixed=True
            ),
        ],
    )
    one, other = assemble(small).problem, assemble(large).problem
    np.testing.assert_allclose(one.B.toarray(), other.B.toarray(), atol=1e-12)
    np.testing.assert_allclose(one.matrices.extent, other.matrices.extent)
    np.testing.assert_allclose(one.dead, other.dead)


def test_loads_that_no_number_can_compare_are_refused():
    """A median weight of 1e-300 and a live load of 1e20: their ratio is beyond double precision."""
    scene = block_on_floor(weight=1e-300, live=(1e20, 0.0))
    with pytest.raises(mo.CaseError, match="double precision"):
        assemble(scene)

"""The matrices against rigid-body motion worked out by hand."""

import numpy as np
import pytest
from scenes import WALLS, block_on_floor, declared, irregular, small_wall, two_blocks

import masonry_opt as mo
from masonry_opt.problem.assembly import assemble
from masonry_opt.problem.load_units import in_units_of_load
from masonry_opt.problem.problem import ShearLimits


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


def test_loads_that_no_number_can_compare_are_refused():
    """A median weight of 1e-300 and a live load of 1e20: their ratio is beyond double precision."""
    scene = block_on_floor(weight=1e-300, live=(1e20, 0.0))
    with pytest.raises(mo.CaseError, match="double precision"):
        assemble(scene)


@pytest.mark.parametrize("language", ["cvxpy", "pyomo"])
def test_states_and_shear_limits_are_in_the_problem_s_units(language):
    problem = assemble(mo.load(WALLS[2])).problem
    cohesive = ShearLimits(problem.friction, np.zeros(len(problem.sliding)))
    plain = declared(problem, "static", language, limits=cohesive)
    scaled = declared(problem, "static", language, limits=cohesive, of_load=True)
    assert in_units_of_load(problem).force > 10  # else nothing is tested
    slope = 0.5 * problem.friction
    for limits in (cohesive, ShearLimits(slope, np.full(len(slope), 0.7))):
        for driver in (plain, scaled):
            driver.set_shear_limits(limits)
        expected, found = plain.solve().state, scaled.solve().state
        assert found.load_factor == pytest.approx(expected.load_factor, abs=1e-6)
        balance = problem.B @ found.q + found.load_factor * problem.live + problem.dead
        assert np.abs(balance).max() < 1e-6
        assert problem.live @ found.d == pytest.approx(problem.live_norm, rel=1e-6)
        dissipated = limits.cohesion @ problem.slip(found.p) - problem.dead @ found.d
        assert dissipated == pytest.approx(found.load_factor * problem.live_norm, rel=1e-6)
    assert scaled.effort.lp_solves == plain.effort.lp_solves == 2
    assert scaled.size() == plain.size()

"""Matrices agree with rigid-body motion, yield conditions and the flow rule agree with values by hand, and
laws share tables."""

from dataclasses import replace
from math import cos, pi

import numpy as np
import pytest
import scipy.sparse as sp
from scenes import KINDS_OF_JOINTS, block_on_floor, irregular, small_wall, two_blocks

import masonry_opt as mo
from masonry_opt.problem.assembly import assemble
from masonry_opt.problem.faces import CHORDS, space
from masonry_opt.problem.laws import Law
from masonry_opt.problem.matrices import Matrices
from masonry_opt.problem.problem import Problem

SCENES = KINDS_OF_JOINTS | {"irregular": irregular()}


@pytest.fixture(scope="module", params=SCENES)
def problem(request):
    return assemble(SCENES[request.param]).problem


def slacks_by_hand(problem, q, slope, cohesion, whole):
    """Return the slacks of |s| ≤ c + slope n and |m| ≤ n L / 2 over L / 2, joint by joint.

    If a joint crushes, chords reduce its moment. ``whole`` is the crushing force of each such joint.
    """
    first, second, s = q.reshape(3, -1)
    n, m = first + second, second - first  # m is divided by L / 2
    plus, minus, start, end = [], [], [], []
    for joint in range(problem.joints):
        if joint in problem.sliding:
            at = list(problem.sliding).index(joint)
            limit = cohesion[at] + slope[at] * n[joint]
            plus.append(limit - s[joint])
            minus.append(limit + s[joint])
        start.append(n[joint] - m[joint])
        end.append(n[joint] + m[joint])
    crushing = []
    for sense in (-1, 1):
        for joint, force in zip(problem.crushing, whole, strict=True):
            for lean, constant in zip(*CHORDS, strict=True):
                crushing.append(lean * n[joint] + constant * force + sense * m[joint])
    return np.array([*plus, *minus, *start, *end, *crushing])


def motion_by_hand(problem, p, slope):
    """Return the opening of each joint at its start and end, and its slip.

    Sliding opens a joint by the slope times the slip. Each rate of rocking opens one end, about the other.
    """
    k, c = len(problem.sliding), problem.joints
    plus, minus, start, end, crushing = np.split(p, [k, 2 * k, 2 * k + c, 2 * k + 2 * c])
    opening, turning, slip = start + end, start - end, np.zeros(c)
    of_chords = crushing.reshape(2, len(problem.crushing), len(CHORDS.slope))
    for at, joint in enumerate(problem.crushing):
        opening[joint] += (of_chords[:, at] @ CHORDS.slope).sum()
        turning[joint] += of_chords[0, at].sum() - of_chords[1, at].sum()
    for at, joint in enumerate(problem.sliding):
        slip[joint] = minus[at] - plus[at]
        opening[joint] += slope[at] * (plus[at] + minus[at])
    return np.concatenate([opening + turning, opening - turning, slip])


def test_yield_conditions_are_those_of_each_joint(problem):
    rng = np.random.default_rng(0)
    q = rng.normal(size=3 * problem.joints)
    expected = slacks_by_hand(problem, q, problem.friction, problem.cohesion, problem.crushing_force)
    assert problem.slacks(q).shape == (problem.faces,)
    np.testing.assert_allclose(problem.slacks(q), expected, atol=1e-13)
    slope = rng.normal(size=len(problem.sliding))
    without = slacks_by_hand(problem, q, slope, np.zeros_like(slope), np.zeros(len(problem.crushing)))
    np.testing.assert_allclose(problem.C(slope) @ q, without, atol=1e-13)


def test_the_flow_rule_is_that_of_each_joint(problem):
    rng = np.random.default_rng(1)
    p, slope = rng.uniform(size=problem.faces), rng.normal(size=len(problem.sliding))
    np.testing.assert_allclose(problem.D(slope) @ p, motion_by_hand(problem, p, slope), atol=1e-13)
    np.testing.assert_allclose(
        problem.D(problem.dilatancy) @ p, motion_by_hand(problem, p, problem.dilatancy)
    )


@pytest.mark.parametrize("sense", [0, 1])
def test_rates_give_back_what_moved(sense):
    """A block slides in one sense and rocks about both edges. Its rates follow from its velocities."""
    problem = assemble(block_on_floor()).problem
    p = np.array([0.0, 0.0, 0.25, 0.5])
    p[sense] = 0.75
    slope = np.array([0.2])
    d = np.linalg.solve(problem.B.T.toarray(), problem.D(slope) @ p)
    np.testing.assert_allclose(problem.rates(d, slope), p, atol=1e-12)


def test_rates_of_blocks_that_pass_into_each_other_are_never_negative():
    problem = assemble(irregular()).problem
    rng = np.random.default_rng(3)
    for _ in range(20):
        d = rng.normal(size=3 * problem.blocks)
        p, u = problem.rates(d, problem.friction), problem.B.T @ d
        assert p.min() >= 0
        # The rates reproduce the slip exactly. Only the opening of points may be smaller than required.
        departure = u - problem.D(problem.friction) @ p
        np.testing.assert_allclose(departure[2 * problem.joints + problem.sliding], 0, atol=1e-12)
        assert departure.max() < 1e-12


#: Friction polygon with four sides at a contact point.
SPACE = space(4)

FRICTION = 0.5
COHESION = 0.05

#: Corners of the base of a box of unit weight, half as high as it is wide.
CORNERS = np.array([[x, y, -0.5] for x in (-1.0, 1.0) for y in (-1.0, 1.0)])


def box() -> Problem:
    """Return the problem of the box under its weight and a live load through its centroid."""
    forces = np.eye(3)[[2, 0, 1]]  # n, s, t
    columns = [np.concatenate([force, np.cross(corner, force)]) for force in forces for corner in CORNERS]
    matrices = Matrices(sp.csr_array(np.array(columns).T), np.ones(4), 1.0, SPACE)
    law = Law(
        sliding=np.arange(4),
        friction=np.full(4, FRICTION),
        cohesion=np.full(4, COHESION),
        dilatancy=np.full(4, 0.1),
        dilatancy_force=np.full((4, 2), np.inf),
        crushing=np.array([], dtype=int),
        crushing_force=np.array([]),
    )
    dead, live = np.array([[0, 0, -1.0, 0, 0, 0], [0.6, 0.8, 0, 0, 0, 0]])
    return Problem(matrices, law, dead, live, force_unit=1.0)


def test_yield_conditions_are_those_of_each_point():
    """The yield conditions are the four sides of a square inside the cone, and n ≥ 0."""
    problem, q = box(), np.random.default_rng(5).normal(size=12)
    n, s, t = problem.by_kind(q)
    # The corners of the square are on the axes: |s| + |t| ≤ c + μ n.
    limit = COHESION + FRICTION * n
    sides = [limit - s - t, limit + s - t, limit + s + t, limit - s + t]
    expected = np.concatenate([*(cos(pi / 4) * side for side in sides), n])
    np.testing.assert_allclose(problem.slacks(q), expected, atol=1e-14)
    C, D = problem.C(problem.friction), problem.D(problem.friction)
    np.testing.assert_array_equal(C.toarray(), D.T.toarray())


def test_rates_of_points_give_back_what_moved():
    """Each point slips in one sense along each axis, and opens at least by the dilatancy times its slip."""
    problem, rng = box(), np.random.default_rng(5)
    for _ in range(10):
        lifted = np.array([0, 0, 5.0, 0, 0, 0]) + 0.3 * rng.normal(size=6)
        p = problem.rates(lifted, problem.dilatancy)
        assert p.min() >= 0
        np.testing.assert_allclose(problem.departure(lifted, p, problem.dilatancy), 0, atol=1e-14)
        speeds = problem.table.slip_speed(p)
        np.testing.assert_allclose(speeds, problem.slip_speed(lifted), atol=1e-14)


@pytest.mark.parametrize("name", KINDS_OF_JOINTS)
def test_laws_share_what_does_not_depend_on_them(name):
    """With another friction, the table and the program stay the same. With another live load, only the table
    does."""
    problem = assemble(KINDS_OF_JOINTS[name]).problem
    other = replace(problem, law=replace(problem.law, friction=2 * problem.friction))
    assert other.table is problem.table
    assert other.same_program(problem)
    louder = replace(problem, live=2 * problem.live)
    assert louder.table is problem.table
    assert not louder.same_program(problem)


def test_a_table_is_of_the_joints_that_slide_and_crush():
    problem = assemble(small_wall(strength=8.0)).problem
    fewer = {name: getattr(problem.law, name)[1:] for name in ("crushing", "crushing_force")}
    other = replace(problem, law=replace(problem.law, **fewer))
    assert not other.same_program(problem)
    assert other.faces < problem.faces
    of_old = {name: getattr(problem.law, name).copy() for name in fewer}
    again = replace(other, law=replace(other.law, **of_old))
    assert again.table is problem.table
    assert again.same_program(problem)
    weaker = replace(problem, law=replace(problem.law, crushing_force=problem.crushing_force / 2))
    assert not weaker.same_program(problem)


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
                    x, y = (at[joint] - shapes.centroid[block]) / problem.length_unit
                    vx, vy, omega = d.reshape(-1, 3)[row[block]]
                    motion += sign * np.array([vx - omega * y, vy + omega * x])
        normal = joints.normal[joint]
        tangent = np.array([normal[1], -normal[0]])
        expected = [start @ normal, end @ normal, start @ tangent]
        assert u.reshape(3, -1)[:, joint] == pytest.approx(expected)


def test_loads_that_no_number_can_compare_are_refused():
    """The median weight is 1e-300 and the live load is 1e20, so their ratio exceeds double precision."""
    scene = block_on_floor(weight=1e-300, live=(1e20, 0.0))
    with pytest.raises(mo.CaseError, match="double precision"):
        assemble(scene)

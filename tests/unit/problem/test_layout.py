"""A problem whose numbers differ from the plane's, and laws that share what does not depend on them."""

from dataclasses import replace
from math import cos, pi

import numpy as np
import pytest
import scipy.sparse as sp
from scenes import KINDS_OF_JOINTS, small_wall

from masonry_opt.problem.assembly import assemble
from masonry_opt.problem.faces import space
from masonry_opt.problem.laws import Law
from masonry_opt.problem.matrices import Matrices
from masonry_opt.problem.problem import Problem

#: Four senses of sliding at a contact point.
SPACE = space(4)

FRICTION, COHESION, PUSH = 0.5, 0.05, np.array([0.6, 0.8, 0.0])

#: A box of unit weight, half as high as it is wide, on the four corners of its base.
CORNERS = np.array([[x, y, -0.5] for x in (-1.0, 1.0) for y in (-1.0, 1.0)])


def box(push: np.ndarray = PUSH) -> Problem:
    """The box under its weight and a live load through its centroid."""
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
    dead, live = np.array([0, 0, -1.0, 0, 0, 0]), np.append(push, np.zeros(3))
    return Problem(matrices, law, dead, live, force_unit=1.0)


@pytest.fixture
def rng() -> np.random.Generator:
    return np.random.default_rng(5)


def test_yield_conditions_are_those_of_each_point(rng):
    """Four sides of a square inside the cone, and n ≥ 0."""
    problem, q = box(), rng.normal(size=12)
    n, s, t = problem.by_kind(q)
    # The square stands on its corner: |s| + |t| ≤ c + μ n.
    limit = COHESION + FRICTION * n
    sides = [limit - s - t, limit + s - t, limit + s + t, limit - s + t]
    expected = np.concatenate([*(cos(pi / 4) * side for side in sides), n])
    np.testing.assert_allclose(problem.slacks(q), expected, atol=1e-14)
    C, D = problem.C(problem.friction), problem.D(problem.friction)
    np.testing.assert_array_equal(C.toarray(), D.T.toarray())


def test_rates_give_back_what_moved(rng):
    """Points that slip in one sense along each axis, and open by what dilatancy asks or more."""
    problem = box()
    for _ in range(10):
        lifted = np.array([0, 0, 5.0, 0, 0, 0]) + 0.3 * rng.normal(size=6)
        p = problem.rates(lifted, problem.dilatancy)
        assert p.min() >= 0
        np.testing.assert_allclose(problem.departure(lifted, p, problem.dilatancy), 0, atol=1e-14)
        speeds = problem.table.slip_speed(p)
        np.testing.assert_allclose(speeds, problem.slip_speed(lifted), atol=1e-14)


@pytest.mark.parametrize("name", KINDS_OF_JOINTS)
def test_laws_share_what_does_not_depend_on_them(name):
    """Another friction, or other loads: the same matrices and table. Other joints that slide: another."""
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

"""The return mapping of the contact law is compared with values by hand, and its tangent with finite
differences."""

from dataclasses import replace

import numpy as np
import pytest
from scenes import block_on_floor, on_floor
from scenes_in_space import box_on_floor

import masonry_opt as mo
from masonry_opt.methods.incremental.contact_law import ContactLaw, StrengthPolygon
from masonry_opt.problem.assembly import assemble
from masonry_opt.problem.faces import CHORDS
from masonry_opt.problem.problem import Problem
from masonry_opt.scene.blocks import rectangle


def law_of(problem: Problem, **values: float) -> ContactLaw:
    """Return the law of a problem with one joint of unit stiffness. The keyword arguments replace its
    parameters."""
    law = replace(problem.law, **{name: np.array([value]) for name, value in values.items()})
    return ContactLaw(replace(problem, law=law), np.ones(problem.B.shape[1]))


@pytest.fixture(scope="module")
def joint() -> Problem:
    return assemble(block_on_floor()).problem


@pytest.fixture(scope="module")
def point() -> Problem:
    return assemble(box_on_floor()).problem


def column(*values: float) -> np.ndarray:
    return np.array(values, dtype=float)[:, None]


def test_a_joint_that_presses_and_sticks_is_elastic(joint):
    response = law_of(joint, friction=0.5).respond(column(2, 1, 1.4))
    np.testing.assert_array_equal(response.forces, column(2, 1, 1.4))
    np.testing.assert_array_equal(response.tangent[:, :, 0], np.eye(3))
    assert not response.sliding.any()
    assert not response.open.any()


def test_shear_returns_to_cohesion_and_friction_in_the_plane(joint):
    """The limit is L = 0.2 + 0.5 · 3 = 1.7. A trial shear of -5 returns to -1.7, which is remembered."""
    response = law_of(joint, friction=0.5, cohesion=0.2).respond(column(2, 1, -5))
    np.testing.assert_allclose(response.forces, column(2, 1, -1.7), atol=1e-15)
    np.testing.assert_allclose(response.remembered, column(2, 1, -1.7), atol=1e-15)
    np.testing.assert_allclose(response.tangent[2, :, 0], [-0.5, -0.5, 0], atol=1e-15)
    assert response.sliding.all()


def test_an_open_end_bears_nothing_and_remembers_its_gap(joint):
    """An open end carries no force. Its gap is remembered as a negative trial force, -3."""
    response = law_of(joint, friction=0.5).respond(column(-3, 1, 2))
    np.testing.assert_allclose(response.forces, column(0, 1, 0.5))
    np.testing.assert_allclose(response.remembered, column(-3, 1, 0.5))
    assert not response.open.any()


def test_a_joint_that_is_open_at_both_ends_loses_its_shear(joint):
    response = law_of(joint, friction=0.5).respond(column(-3, -1, 2))
    assert not response.forces.any()
    assert not response.tangent.any()
    assert response.open.all()


def test_sliding_opens_a_joint_that_dilates(joint):
    """The slip P = 3 solves 5 - P = 0.2 + 0.5 (3 + 2 · 0.1 P). Both ends gain 0.3, and |s| = 2."""
    law = law_of(joint, friction=0.5, cohesion=0.2, dilatancy=0.1)
    response = law.respond(column(2, 1, 5))
    np.testing.assert_allclose(response.forces, column(2.3, 1.3, 2), atol=1e-14)
    np.testing.assert_allclose(response.remembered, column(2.3, 1.3, 2), atol=1e-14)


def test_dilation_closes_an_open_end(joint):
    """The end at -0.1 closes after a slip of P = 1. For a larger slip, 5 - P = 0.5 (0.9 + 0.2 P)."""
    response = law_of(joint, friction=0.5, dilatancy=0.1).respond(column(-0.1, 1, 5))
    slip = (5 - 0.45) / 1.1
    np.testing.assert_allclose(
        response.forces[:, 0], [0.1 * slip - 0.1, 1 + 0.1 * slip, 5 - slip], rtol=1e-14
    )


def test_shear_returns_along_its_direction_in_space(point):
    """The limit is L = 0.5 · 2 = 1, so the trial shear (3, 4), of size 5, returns to (0.6, 0.8)."""
    trial = np.tile(column(2, 3, 4), point.joints)
    law = replace(point.law, friction=np.full(point.joints, 0.5))
    response = ContactLaw(replace(point, law=law), np.ones(point.B.shape[1])).respond(trial)
    expected = np.tile(column(2, 0.6, 0.8), point.joints)
    np.testing.assert_allclose(response.forces, expected, atol=1e-15)
    np.testing.assert_allclose(response.remembered, expected, atol=1e-15)


def test_slip_is_remembered(joint):
    """After sliding, a motion back is elastic up to the limit in the opposite sense."""
    law = law_of(joint, friction=0.5)
    slid = law.respond(column(2, 1, 5)).remembered
    np.testing.assert_allclose(law.respond(slid - column(0, 0, 1)).forces, column(2, 1, 0.5))
    np.testing.assert_allclose(law.respond(slid - column(0, 0, 4)).forces, column(2, 1, -1.5))


def test_crushing_returns_to_the_nearest_point_of_the_strength():
    """Under central compression beyond f_c L = 4, both ends carry 2, and the tangent is zero."""
    problem = assemble(block_on_floor(weight=1.0)).problem
    law = ContactLaw(
        replace(problem, law=replace(problem.law, crushing=np.array([0]), crushing_force=np.array([4.0]))),
        np.ones(3),
    )
    response = law.respond(column(3, 3, 0))
    np.testing.assert_allclose(response.forces, column(2, 2, 0))
    assert not response.tangent[:2, :2].any()
    inside = law.respond(column(0.4, 0.5, 0))
    np.testing.assert_allclose(inside.forces, column(0.4, 0.5, 0))


def test_crushing_forces_stay_within_the_strength_of_the_problem(joint):
    rng = np.random.default_rng(1_400_000)
    changed = replace(joint.law, crushing=np.array([0]), crushing_force=np.array([4.0]))
    problem = replace(joint, law=changed)
    law = ContactLaw(problem, np.ones(3))
    for trial in rng.normal(2.0, 4.0, (50, 3, 1)):
        response = law.respond(trial)
        assert problem.slacks(law.of_problem(response.forces)).min() >= -1e-12


def test_ties_remember_yield_and_forget_slack():
    """A rod of strength 0.4 is stretched beyond yield. When the rod shortens again, its force vanishes before
    it is back at its first length."""
    tie = mo.Tie(between=("A", "ground"), at=((0.5, 1), (-4, 1)), strength=0.4)
    block = mo.Block(name="A", vertices=rectangle(0, 1, 0, 2), weight=1, live=(1, 0))
    problem = assemble(on_floor(block, ties=[tie])).problem
    law = ContactLaw(problem, np.ones(problem.B.shape[1]))

    def stretched(trial: np.ndarray, by: float) -> np.ndarray:
        return trial + np.array([[0, 0], [0, 0], [0, by]])

    response = law.respond(stretched(np.zeros((3, 2)), 1.0))
    assert response.forces[2, 1] == pytest.approx(0.4)
    back = law.respond(stretched(response.remembered, -0.3))
    assert back.forces[2, 1] == pytest.approx(0.1)
    slack = law.respond(stretched(back.remembered, -0.5))
    assert slack.forces[2, 1] == 0
    assert slack.remembered[2, 1] == pytest.approx(-0.4)


@pytest.mark.parametrize("dilatancy", [0.0, 0.2])
@pytest.mark.parametrize(("dimension", "crushing_force"), [(2, None), (2, 4.0), (3, None)])
def test_tangent_is_the_derivative(joint, point, dimension, dilatancy, crushing_force):
    """The reference is central differences of step 1e-6. Their error on a piecewise smooth law is about
    1e-9."""
    problem = joint if dimension == 2 else point
    count = problem.joints
    changes = {"dilatancy": np.full(count, dilatancy), "cohesion": np.full(count, 0.1)}
    if crushing_force is not None:
        changes |= {"crushing": np.array([0]), "crushing_force": np.array([crushing_force])}
    law = ContactLaw(replace(problem, law=replace(problem.law, **changes)), np.ones(problem.B.shape[1]))
    rng = np.random.default_rng(1_400_000)
    for trial in rng.normal(0.5, 1.5, (40, 3, count)):
        tangent = law.respond(trial).tangent
        for kind in range(3):
            change = np.zeros((3, count))
            change[kind] = 1e-6
            difference = law.respond(trial + change).forces - law.respond(trial - change).forces
            np.testing.assert_allclose(tangent[:, kind], difference / 2e-6, atol=1e-7)


def test_crushing_forces_are_the_projection_of_the_trial_forces():
    """For the nearest point f of a convex set to a trial point t, (t - f)·(g - f) ≤ 0 for every g of the set.

    The points g lie on the chords, which are 28 secants of the parabola m = x (1 - x) / 2 with x = n₁ + n₂.
    """
    rng = np.random.default_rng(1)
    crushing_force = rng.uniform(0.5, 2.0, 200)
    trial = rng.normal(0.2, 1.0, (2, 200)) * crushing_force
    forces, _ = StrengthPolygon(np.arange(200), crushing_force).project(trial)
    inner = (CHORDS.constant[1:] - CHORDS.constant[:-1]) / (CHORDS.slope[:-1] - CHORDS.slope[1:])
    x = np.array([0.0, *inner, 1.0])
    moment = np.minimum.reduce(CHORDS.slope[:, None] * x + CHORDS.constant[:, None])
    corners = np.concatenate([np.stack([x + m, x - m]) / 2 for m in (moment, -moment)], axis=1)
    towards = corners[:, :, None] * crushing_force - forces[:, None]
    assert np.einsum("il,ikl->kl", trial - forces, towards).max() <= 1e-12
    half, total = np.abs(forces[0] - forces[1]) / crushing_force, forces.sum(axis=0) / crushing_force
    assert (half[:, None] <= total[:, None] * CHORDS.slope + CHORDS.constant + 1e-12).all()


def test_slip_under_dilatancy_takes_few_iterations(joint):
    """Both ends press, so the excess of the shear is linear in the slip, and one Newton step suffices.

    A slip that is small compared with the shear must not prolong the iterations because of rounding errors.
    """
    law = law_of(joint, friction=0.6, dilatancy=0.4)
    calls = 0
    press = law._press

    def counted_press(trial: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        nonlocal calls
        calls += 1
        return press(trial)

    law._press = counted_press
    rng = np.random.default_rng(0)
    for _ in range(200):
        normal = rng.uniform(100, 1000, 2)
        excess = 10 ** rng.uniform(-12, -1)
        calls = 0
        law.respond(column(*normal, 0.6 * normal.sum() * (1 + excess)))
        # One evaluation for the trial, one for the step, one that finds no excess, and one for the forces.
        assert calls == 4

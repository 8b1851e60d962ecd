"""The load that grows until blocks do not come to rest: against closed forms and contact dynamics."""

from functools import cache

import numpy as np
import pytest
from atlas.large_scenes import rubble
from atlas.random_scenes import random_scene
from residuals import residuals
from scenes import block_on_floor
from scenes_in_space import corner_wall

import masonry_opt as mo
from masonry_opt.answer.acceptance import LIMITS, Kind
from masonry_opt.answer.reasons import Code
from masonry_opt.methods.push.compliant import _solution
from masonry_opt.methods.push.growth import grown, sharp_steps
from masonry_opt.methods.push.push import Elastic, Ended, Pushed
from masonry_opt.models.pyomo_mcp import PyomoMcp
from masonry_opt.problem.assembly import assemble
from masonry_opt.problem.problem import State

WALL = rubble(60, 341002)


def load_grown(scene):
    """The scene's contacts, their growth, and the load factors that it tells."""
    elastic = Elastic(assemble(scene).problem)
    told = []
    growth = grown(elastic.curve.rounded_by(0.03), lambda u, load: told.append(load))
    return elastic, growth, np.array(told) / elastic.problem.live_norm


@cache
def grown_rubble():
    """The same of a wall of 60 stones."""
    return load_grown(WALL)


@pytest.mark.parametrize(("friction", "expected"), [(0.3, 0.3), (0.7, 0.5)])
def test_a_block_slides_or_rocks(friction, expected):
    """A block of weight 1 and twice as high as wide, pushed at its centroid: at μ, or at b/h."""
    _, growth, told = load_grown(block_on_floor(1.0, 2.0, friction))
    assert growth.beyond is None
    assert np.diff(told).min() > -1e-6 * expected
    assert told[-1] == pytest.approx(expected, rel=1e-3)


@pytest.mark.parametrize(
    ("scene", "brought_down", "within"),
    [
        (corner_wall(3, 2, 4, 0.6), 0.35125, 0.005),
        (WALL, 0.365, 0.02),
        (rubble(60, 341004), 0.385, 0.04),
        pytest.param(rubble(200, 750003), 0.34566, 0.03, marks=pytest.mark.slow),
    ],
    ids=["corner 20", "60, 2", "60, 4", "200, 3"],
)
def test_the_load_comes_as_far_as_in_contact_dynamics(scene, brought_down, within):
    """Stored loads at which ``contact_dynamics`` brought the scenes down, those of 200 stones where it waits
    for 10⁶ steps, with a damping of .998."""
    elastic, growth, _ = grown_rubble() if scene is WALL else load_grown(scene)
    assert growth.carried / elastic.problem.live_norm == pytest.approx(brought_down, rel=within)


@pytest.mark.parametrize(
    ("scene", "rests"),
    [
        (random_scene("tessellation", 751001), True),
        (random_scene("tessellation", 751066), False),
        (random_scene("tessellation", 751087), False),
        (rubble(600, 751000), True),
    ],
    ids=["rests", "falls", "falls slowly", "600 stones"],
)
def test_what_rests_under_its_dead_load_in_contact_dynamics_settles(scene, rests):
    """Of 19 tessellations from seed 751000 on of which a dead load that grows along a path tells of none,
    dynamics bring this one to rest; and walls of 600 stones."""
    elastic = Elastic(assemble(scene).problem)
    assert (elastic.settled is not None) == rests
    if rests:
        left = np.abs(elastic.problem.unbalanced(0.0, elastic.settled)).max()
        assert left < 1e-8 * np.abs(elastic.problem.dead).max()


def rougher(kind, seed, friction, **keys):
    scene = random_scene(kind, seed)
    return scene.replace(joints=scene.joints.replace(friction=friction, **keys))


def test_a_load_that_grows_for_ever_is_no_load_factor():
    """It is proven that no load factor exists."""
    elastic = Elastic(assemble(rougher("wall", 1007, 1.5)).problem)
    assert grown(elastic.curve.rounded_by(0.03), lambda *_: None) is None
    result = mo.solve(rougher("tessellation", 3103, 1.5, cohesion=0), "compliant")
    assert (result.load_factor, result.status) == (None, mo.Status.UNLIMITED)


def test_a_growth_that_is_not_done_is_no_load_to_expect():
    """In contact dynamics 5.5 is carried, and ``refined`` finds an exact state at 5.87245."""
    result = mo.solve(rougher("tessellation", 3070, 1.0, cohesion=0), "compliant", expected=False)
    assert result.load_factor == pytest.approx(5.87245, rel=1e-5)


def test_the_last_state_is_one_of_contacts_that_give_from_those_before():
    """By the declared equations with E (q - q₀), which it leaves nothing of."""
    elastic, growth, _ = grown_rubble()
    state = elastic.carried(growth)
    assert state.answer.load_factor == pytest.approx(growth.carried / elastic.problem.live_norm, rel=3e-3)
    assert not LIMITS[Kind.COMPLIANT].failing(state.answer.residuals)
    solution = _solution(elastic, Pushed(Ended.STOPPED, growth=growth), None)
    assert (solution.status, solution.load_factor) == (mo.Status.CONVERGED, state.answer.load_factor)
    assert solution.values_of(Code.GROWN)["beyond"] == growth.beyond / elastic.problem.live_norm
    problem, found = state.problem, state.answer
    p = problem.rates(found.d, problem.dilatancy, found.q)
    left = residuals(PyomoMcp(elastic.problem), State(found.load_factor, found.q, found.d, p)).compatibility
    gives = problem.compliance * (found.q - problem.settled)
    np.testing.assert_allclose(left, -gives, atol=1e-8 * np.abs(found.d).max())


def test_contacts_made_sharp_carry_what_round_ones_do_but_for_a_little():
    """Where a state of round contacts has no like among sharp ones, a step of these counts."""
    _, growth, _ = grown_rubble()
    curve, at = next(sharp_steps(growth))
    assert curve.rounding == pytest.approx(growth.before.rounding / 100)
    assert 0.99 * growth.carried <= at[-1] < growth.carried
    assert curve.unbalanced(at) < 1e-9
    assert curve.u(at) > 0


def test_slip_that_is_past_changes_no_force():
    """But by what is left of rounded corners; and what did not slip is as it was."""
    elastic, growth, _ = grown_rubble()
    law = elastic.curve.rounded_by(0.01).law
    trial = growth.before.rest * np.exp(np.random.default_rng(0).normal(size=growth.before.rest.shape))
    held = law.without_slip(trial)
    assert (np.abs(held) <= np.abs(trial)).all()
    changed = np.abs(held - trial).max(axis=0) > 0
    assert 0 < changed.sum() < len(changed)
    forces, after = (law.forces(of)[0] for of in (trial, held))
    np.testing.assert_allclose(after, forces, atol=0.2 * law.rounding)
    np.testing.assert_array_equal(after[:, ~changed], forces[:, ~changed])

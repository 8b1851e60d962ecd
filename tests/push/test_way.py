"""The way of a push: from rest to where λ stays, and what yields along it."""

from itertools import pairwise

import numpy as np
import pytest
from drawn import solved
from scenes import CASES, WALLS, two_blocks
from scenes_in_space import corner_wall

import masonry_opt as mo
from masonry_opt.answer.motion import joint_motion, yielded_on
from masonry_opt.answer.thresholds import PLATEAU
from masonry_opt.methods.push.compliant import KEYFRAMES, keyframes


@pytest.fixture(scope="module", params=["wall 1", "corner"])
def pushed(request):
    """A result by the default method, and the way that it keeps."""
    result = solved(WALLS[0]) if request.param == "wall 1" else mo.solve(corner_wall(2, 2, 3))
    return result, result.solution.at_expected.way()


def test_it_begins_at_rest_and_ends_at_the_load_of_the_ray(pushed):
    result, way = pushed
    problem = result.assembly.problem
    assert way.d.shape == (KEYFRAMES, problem.dead.size)
    assert not way.d[0].any()
    assert (way.displacement[0], way.load_factor[0]) == (0, 0)
    assert way.load_factor[-1] == pytest.approx(result.end, rel=PLATEAU)
    assert way.displacement == pytest.approx(way.d @ problem.live / problem.live_norm)
    left = problem.unbalanced(way.load_factor[-1], way.q[-1])
    assert np.abs(left).max() <= 1e-2 * np.abs(problem.dead).max()


def test_at_its_end_blocks_move_by_the_mechanism_of_the_ray(pushed):
    result, way = pushed
    step, ray = way.d[-1] - way.d[-2], result.at_expected.solution.d
    assert step @ ray >= (1 - 1e-4) * np.linalg.norm(step) * np.linalg.norm(ray)


def test_joints_yield_one_after_the_other_up_to_those_of_the_mechanism(pushed):
    result, way = pushed
    moves, at_ray = yielded_on(result.assembly, way), result.at_expected
    slid, opened = moves[-1]
    mechanism = joint_motion(at_ray.assembly, at_ray.solution)
    assert mechanism.slides.any()
    assert slid[mechanism.slides].all()
    assert opened[mechanism.hinges | mechanism.separates].all()
    assert not moves[0].any()
    begun = np.maximum.accumulate(moves).sum(axis=(1, 2))
    assert len(np.unique(begun)) >= 10


def test_a_block_slides_at_the_load_at_which_it_does():
    """Of the two blocks' joints one slips from 0.157 on, as its contacts give, by 0.05 from 0.163 on; the
    other from the end on."""
    result = solved(CASES / "gilbert" / "two_blocks.toml")
    way = result.solution.at_expected.way()
    slides = yielded_on(result.assembly, way)[:, 0]
    first, last = sorted(way.load_factor[slides[:, joint].argmax()] for joint in np.flatnonzero(slides[-1]))
    assert first == pytest.approx(0.163, rel=0.1)
    assert last == pytest.approx(result.end, rel=0.01)


def test_scenes_that_no_push_was_followed_of_have_none():
    result = mo.solve(two_blocks(), expected=False)
    assert result.solution.at_expected is None
    assert mo.solve(two_blocks(), "compliant").solution.way().displacement[-1] > 0


def test_keyframes_keep_folds_and_leave_most_of_a_ray_out():
    """λ falls and u goes back, then a ray of a hundred times the way before."""
    u = np.array([0.0, 1.0, 2.0, 1.5, 3.0, 4.0, 400.0])
    load = np.array([0.0, 0.9, 1.0, 0.7, 0.8, 0.8, 0.8])
    at = keyframes(u, load)
    assert len(at) == KEYFRAMES
    assert at[0] == 0
    assert all(before < after for before, after in pairwise(at))
    assert {1.0, 2.0, 3.0, 4.0} <= set(at.tolist())
    assert np.interp(at[-1], np.arange(7), u) == pytest.approx(9.0)

"""Keyframes of a load history from rest to collapse, and the joints that slide and open in them."""

import numpy as np
import pytest
from drawn import solved
from scenes import CASES, WALLS, two_blocks
from scenes_in_space import corner_wall

import masonry_opt as mo
from masonry_opt.drawing.keyframes import COLLAPSE_FRAMES, KEYFRAMES, keyframes_of
from masonry_opt.solution.motion import joint_motion


@pytest.fixture(scope="module", params=["wall 1", "corner"])
def loaded(request):
    """Return a result with a load history, and its keyframes.

    The default's further starts on the corner in space would not change its load history.
    """
    corner = corner_wall(2, 2, 3)
    result = solved(WALLS[0]) if request.param == "wall 1" else mo.solve(corner, "incremental")
    return result, keyframes_of(result)


@pytest.mark.slow
def test_they_begin_at_rest_and_end_under_the_load_of_collapse(loaded):
    result, frames = loaded
    problem = result.assembly.problem
    assert frames.d.shape == (KEYFRAMES + COLLAPSE_FRAMES, problem.dead.size)
    assert not frames.d[0].any()
    assert (frames.displacement[0], frames.load_factor[0]) == (0, 0)
    assert (np.diff(frames.load_factor[:KEYFRAMES]) > 0).all()
    assert frames.load_factor[-1] == result.end
    work = frames.d @ problem.live * problem.live_displacement / problem.live_norm
    assert frames.displacement == pytest.approx(work)


@pytest.mark.slow
def test_at_the_end_blocks_move_by_the_mechanism_of_the_collapse(loaded):
    result, frames = loaded
    step, mechanism = frames.d[-1] - frames.d[-2], result.at_incremental.solution.d
    assert step @ mechanism == pytest.approx(np.linalg.norm(step) * np.linalg.norm(mechanism))


def test_joints_move_one_after_the_other_up_to_those_of_the_mechanism(loaded):
    result, frames = loaded
    at_collapse = result.at_incremental
    mechanism = joint_motion(at_collapse.assembly, at_collapse.solution)
    assert mechanism.slides.any()
    assert frames.has_slid[-1][mechanism.slides].all()
    assert frames.is_open[-1][mechanism.hinges | mechanism.separates].all()
    assert (np.diff(frames.has_slid.sum(axis=1)) >= 0).all()
    assert len(np.unique(frames.is_open.sum(axis=1))) >= 5


def test_the_first_joint_slides_under_the_load_by_hand():
    """In the two blocks, one joint slides below the collapse load, and the last joint slides at collapse."""
    result = solved(CASES / "gilbert" / "two_blocks.toml")
    frames = keyframes_of(result)
    slides = np.flatnonzero(frames.has_slid[-1])
    first, last = sorted(frames.load_factor[frames.has_slid[:, joint].argmax()] for joint in slides)
    assert first < result.end
    assert last == pytest.approx(result.end, rel=1e-3)


def test_a_scene_without_a_load_history_has_none():
    assert keyframes_of(mo.solve(two_blocks(), incremental=False)) is None
    assert keyframes_of(mo.solve(two_blocks(), "incremental")).displacement[-1] > 0

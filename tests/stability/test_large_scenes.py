"""Large random scenes have the stones they are asked for, come by their seed, stand, and have an answer."""

from __future__ import annotations

from collections import Counter
from itertools import pairwise

import numpy as np
import pytest
from atlas.large_scenes import LARGE, large_scene

import masonry_opt as mo
from masonry_opt.answer.acceptance import LIMITS, Kind
from masonry_opt.answer.reasons import Code
from masonry_opt.effort import Effort
from masonry_opt.problem.assembly import assemble
from masonry_opt.solvers.registry import find_solver
from masonry_opt.standing.diagnosis import falling_mechanism

#: Joints of a stone, over all sizes: nearly three in large scenes, fewer in small ones.
JOINTS = {"rubble": (2, 3), "openings": (1.5, 3), "piers": (1.3, 3)}


def is_as_asked_and_stands(family: str, stones: int, seed: int) -> None:
    assembly = assemble(large_scene(family, stones, seed))
    built = len(assembly.movable)
    assert abs(built / stones - 1) <= 0.1
    fewest, most = JOINTS[family]
    assert fewest < len(assembly.joints.first) / built < most
    assert not assembly.joints.gaps
    assert falling_mechanism(assembly.problem, find_solver("cvxpy", None), Effort()) is None


@pytest.mark.parametrize("family", LARGE)
@pytest.mark.parametrize("stones", [20, 60, 200])
def test_large_scenes_stand(family, stones):
    for seed in range(2):
        is_as_asked_and_stands(family, stones, seed)


@pytest.mark.slow
@pytest.mark.parametrize("family", LARGE)
@pytest.mark.parametrize(("stones", "seeds"), [(20, 20), (60, 15), (200, 10), (600, 3), (2000, 1)])
def test_many_large_scenes_stand(family, stones, seeds):
    for seed in range(100, 100 + seeds):
        is_as_asked_and_stands(family, stones, seed)


def has_an_answer(family: str, stones: int, seed: int) -> bool:
    """Whether there is one; then a state that meets every condition, at or below the associative λ, which is
    solved to 1e-9."""
    scene = large_scene(family, stones, seed)
    result = mo.solve(scene, "mcp", expected=False)
    if result.status is mo.Status.SOLVER_FAILED:
        assert [reason.code for reason in result.reasons] == [Code.PUSH_STOPPED, Code.AT_MOST]
        return False
    assert result.status is mo.Status.CONVERGED
    left = result.certificate
    assert max(left.equilibrium, left.yield_, left.flow) <= 1e-8
    assert left.complementarity <= LIMITS[Kind.ONE_PASS].complementarity * result.load_factor
    assert 0 < result.load_factor <= mo.solve(scene, "static").load_factor * (1 + 1e-7)
    return True


@pytest.mark.parametrize("family", LARGE)
@pytest.mark.parametrize("seed", range(2))
def test_the_default_solves_scenes_of_60_stones(family, seed):
    assert has_an_answer(family, 60, seed)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("family", "seeds", "most_left"), [("rubble", 8, 0), ("openings", 4, 0), ("piers", 4, 0)]
)
def test_the_default_solves_most_scenes_of_200_stones(family, seeds, most_left):
    ended = [has_an_answer(family, 200, seed) for seed in range(seeds)]
    assert ended.count(False) <= most_left


@pytest.mark.parametrize("family", LARGE)
def test_a_scene_comes_by_its_number_of_stones_and_its_seed(family):
    scene = large_scene(family, 60, 1)
    assert scene.title == f"{family} 60 1"
    assert scene == large_scene(family, 60, 1)
    assert scene.blocks != large_scene(family, 60, 2).blocks
    assert scene.blocks != large_scene(family, 61, 1).blocks


@pytest.mark.parametrize("family", LARGE)
def test_the_live_load_is_the_weight_sideways(family):
    problem = assemble(large_scene(family, 60, 0)).problem
    dead, live = problem.dead.reshape(-1, 3), problem.live.reshape(-1, 3)
    assert live[:, 0] == pytest.approx(-dead[:, 1])
    assert not live[:, 1:].any()
    assert 0.01 < mo.solve(large_scene(family, 60, 0), "static").required() < 1


def test_stones_of_rubble_fill_the_wall_and_meet_at_the_same_corners():
    assembly = assemble(large_scene("rubble", 200, 0))
    stones = [block for block in assembly.scene.blocks if not block.fixed]
    assert assembly.geometry.size[assembly.movable].sum() == pytest.approx(200)
    edges = Counter(
        frozenset(edge) for block in stones for edge in pairwise([*block.vertices, block.vertices[0]])
    )
    inner = sum(times == 2 for times in edges.values())
    on_base = sum(all(y == 0 for _, y in edge) for edge in edges)
    assert set(edges.values()) == {1, 2}
    assert inner + on_base == len(assembly.joints.first)


def test_walls_have_openings_and_a_lintel_over_each():
    for seed in range(5):
        scene = large_scene("openings", 60, seed)
        stones = [block.corners() for block in scene.blocks if not block.fixed]
        lengths = np.array([np.ptp(stone[:, 0]) for stone in stones])
        height = max(stone[:, 1].max() for stone in stones)
        span = max(stone[:, 0].max() for stone in stones)
        area = sum(np.ptp(stone[:, 0]) * np.ptp(stone[:, 1]) for stone in stones)
        assert area < 0.97 * height * span
        assert lengths.max() > 1.9 * np.median(lengths)


def test_arches_on_piers_are_symmetric():
    for seed in range(5):
        geometry = assemble(large_scene("piers", 60, seed)).geometry
        assert geometry.size @ geometry.centroid[:, 0] == pytest.approx(0, abs=1e-6)


def test_too_few_stones_are_refused():
    with pytest.raises(mo.OptionError, match="20"):
        large_scene("openings", 19, 0)

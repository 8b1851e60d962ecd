"""Tests of large random scenes: number of stones, seed, stability under dead load, and an answer."""

import pytest
from atlas.large_scenes import LARGE, large_scene
from speeds import slow

import masonry_opt as mo
from masonry_opt.effort import Effort
from masonry_opt.problem.assembly import assemble
from masonry_opt.solution.acceptance import LIMITS, Kind
from masonry_opt.solvers.registry import find_solver
from masonry_opt.stability.diagnosis import falling_mechanism

#: Fewest and most joints per stone, over all sizes: nearly three in large scenes, fewer in small ones.
JOINTS = {"rubble": (2, 3), "openings": (1.5, 3), "piers": (1.3, 3)}


@pytest.mark.parametrize("family", LARGE)
@pytest.mark.parametrize(
    ("stones", "seed"),
    [(20, 0), (60, 0), *(pytest.param(*of, marks=pytest.mark.slow) for of in ((200, 100), (600, 100)))],
)
def test_large_scenes_are_as_asked_and_stand(family, stones, seed):
    assembly = assemble(large_scene(family, stones, seed))
    built = len(assembly.movable)
    assert abs(built / stones - 1) <= 0.1
    fewest, most = JOINTS[family]
    assert fewest < len(assembly.joints.first) / built < most
    assert not assembly.joints.gaps
    assert falling_mechanism(assembly.problem, find_solver("cvxpy", None), Effort()) is None


@pytest.mark.parametrize(
    ("family", "stones", "seed"),
    [
        *(("rubble", 30, 0), ("openings", 30, 3), ("piers", 30, 3)),
        *slow(("openings", 200, 1), ("piers", 200, 1)),
    ],
)
def test_the_default_solves_scenes(family, stones, seed):
    """The state meets all conditions, and its λ is at most the associative λ, which is solved to 1e-9."""
    scene = large_scene(family, stones, seed)
    result = mo.solve(scene, "coulomb", incremental=False)
    assert result.status is mo.Status.CONVERGED
    left = result.certificate
    assert max(left.equilibrium, left.yield_, left.flow) <= 1e-8
    assert left.complementarity <= LIMITS[Kind.NEARLY_COMPLEMENTARY].complementarity * result.load_factor
    assert 0 < result.load_factor <= mo.solve(scene, "static").load_factor * (1 + 1e-7)


@pytest.mark.slow
def test_the_loop_answers_where_no_exact_state_is_found(short_motions):
    """The loop answers if the load history ends too early to lead to a nearby exact state.

    The damped motions of the load history are short here.
    """
    result = mo.solve(large_scene("rubble", 200, 751014), "coulomb", incremental=False)
    assert (result.status, result.solution.kind) == (mo.Status.CONVERGED, Kind.LOOP)
    assert result.certificate.complementarity < 1e-4 * result.load_factor < 1e-4 * result.associative


@pytest.mark.parametrize("family", LARGE)
def test_a_scene_comes_by_its_number_of_stones_and_its_seed(family):
    scene = large_scene(family, 60, 1)
    assert scene.title == f"{family} 60 1"
    assert scene == large_scene(family, 60, 1)
    assert scene.blocks != large_scene(family, 60, 2).blocks
    assert scene.blocks != large_scene(family, 61, 1).blocks

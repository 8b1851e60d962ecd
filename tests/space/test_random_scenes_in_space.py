"""Random scenes in space, from the seeds in the tests' names: the default ends certified, or it is proven
that there is no load factor; associative load factors are those of a second program."""

import numpy as np
import pytest
from atlas.random_scenes_in_space import KINDS, random_scene_in_space
from scenes import solved
from scenes_in_space import pushed_box
from space import boxes
from space.cone_program import by_cones

import masonry_opt as mo
from masonry_opt.answer.acceptance import Kind
from masonry_opt.answer.answer import certified
from masonry_opt.answer.reasons import Status
from masonry_opt.answer.solution import Solution
from masonry_opt.effort import Effort
from masonry_opt.methods.exact.refiner import Refiner
from masonry_opt.methods.push.push import Elastic
from masonry_opt.problem.assembly import assemble
from masonry_opt.problem.laws import Cone, Sides

SCENES = [
    *((kind, 0) for kind in KINDS),
    *(pytest.param(kind, seed, marks=pytest.mark.slow) for kind in KINDS for seed in (101,)),
]
#: Programs solved to 1e-9, twice, of scenes with loads of very different sizes.
RANDOM = 1e-6


@pytest.mark.parametrize("kind", KINDS)
def test_a_seed_gives_its_scene_and_most_are_worth_solving(kind):
    assert random_scene_in_space(kind, 3) == random_scene_in_space(kind, 3)
    sizes = [len(random_scene_in_space(kind, seed).blocks) for seed in range(40)]
    assert max(sizes) <= 60 + 4  # supports beside them
    assert len(set(sizes)) > 3


@pytest.mark.parametrize(("kind", "seed"), SCENES)
def test_associative_load_factor_is_that_of_a_second_program(kind, seed):
    """Of equilibrium rows put together by another, from the same contact points, for Clarabel."""
    result = solved(random_scene_in_space(kind, seed), "static")
    if result.load_factor is not None:
        wall, scene = _for_the_second(result), result.assembly.scene
        # Cohesion counts by area of the point, which is by joint there as here.
        other = by_cones(wall, scene.joints.friction, scene.joints.cohesion)
        assert result.load_factor == pytest.approx(other, rel=RANDOM)


def _for_the_second(result: mo.Result) -> boxes.Pushed:
    assembly = result.assembly
    joints, shapes, problem = assembly.joints, assembly.geometry, assembly.problem
    joint = joints.joint
    normal, tangent = joints.normal[joint], joints.tangent[joint]
    touching = boxes.Contacts(
        first=joints.second[joint],
        second=joints.first[joint],
        at=joints.point,
        frame=np.stack([normal, tangent, np.cross(normal, tangent)], axis=1),
        area=(joints.extent / np.bincount(joint))[joint],
    )
    fixed = np.array([block.fixed for block in assembly.scene.blocks])
    load = np.zeros((2, len(fixed), 6))
    for index, block in enumerate(assembly.scene.blocks):
        if not fixed[index]:
            weight = block.unit_weight * shapes.size[index]
            load[0, index, 2] = -weight
            load[1, index, :3] = np.add(block.live, weight * np.array(block.live_per_weight))
            load[1, index, 3:] = block.live_moment
    assert problem.joints == len(joint)
    return boxes.pushed(touching, shapes.centroid, fixed, load[0], load[1])


@pytest.mark.parametrize(("kind", "seed"), SCENES)
def test_the_default_is_certified_and_below_associative(kind, seed):
    scene = random_scene_in_space(kind, seed)
    associative, result = solved(scene, "static"), solved(scene)
    if result.load_factor is None:
        # Of what jams from rest other states may exist.
        assert result.solution.proven_none or result.status in (Status.UNSTABLE, Status.JAMMED)
        assert associative.load_factor is None
        return
    assert associative.status is not Status.UNSTABLE
    answer = result.solution.answer
    assert answer.forms.friction is Cone
    assert not answer.failing(Kind.ONE_PASS)
    if associative.load_factor is not None:
        assert result.load_factor <= associative.load_factor * (1 + RANDOM) + RANDOM


def test_two_piers_and_what_they_bear_are_exact_by_the_cone():
    """Linear programs and cones in turn leave 3e-5 of λ there; the push from rest leaves nothing."""
    result = solved(random_scene_in_space("piers", 30028))
    assert result.friction_law == "cone"
    assert (result.exact, result.kind) == (True, Kind.EXACT)
    assert not result.solution.answer.failing(Kind.EXACT)
    assert result.load_factor < result.associative


def test_a_state_by_sides_that_the_cone_allows_is_exact():
    """A box that overturns, and one that slides along an axis of its contact; at 7.5° to one it is not."""
    for scene, exact in (
        (pushed_box((0.5, 2, 2), 0.6, 0.0), True),
        (pushed_box((2, 2, 1), 0.5, 0.0), True),
        (pushed_box((2, 2, 1), 0.5, 7.5), False),
    ):
        problem = assemble(scene).problem
        state = Elastic(problem).pushed().answer
        assert state.forms.friction is Cone
        if not exact:
            state = Refiner(problem, Effort()).state_near(state.q)
        by_sides = certified(problem, state.load_factor, state.q, state.d)
        assert by_sides.forms.friction is Sides
        assert not by_sides.failing(Kind.EXACT)
        solution = Solution(Status.CONVERGED, Kind.EXACT, found=by_sides)
        assert solution.is_exact(problem) == exact

"""On random scenes in space, the default ends with a certified state or without a load factor.

The associative load factors of random scenes are tested in `stability/test_verdicts.py`.
"""

import pytest
from atlas.random_scenes_in_space import KINDS, random_scene_in_space
from scenes import solved
from scenes_in_space import pushed_box

from masonry_opt.effort import Effort
from masonry_opt.methods.exact.refiner import Refiner
from masonry_opt.methods.incremental.analysis import IncrementalAnalysis
from masonry_opt.problem.assembly import assemble
from masonry_opt.problem.laws import Cone, Sides
from masonry_opt.solution.acceptance import Kind
from masonry_opt.solution.answer import certified
from masonry_opt.solution.reasons import Status
from masonry_opt.solution.solution import Solution

#: Kinds and seeds of small scenes, of each kind at least one. The Coulomb load factor of ("corner", 0) is
#: 11 % lower than its associative load factor. For ("wedges", 9), it is 6 % lower.
SCENES = [("boxes", 18), ("wedges", 9), ("corner", 0), ("piers", 0), ("piers", 3)]
#: Difference allowed between two programs solved to 1e-9, for scenes with loads of very different sizes.
RANDOM = 1e-6


@pytest.mark.parametrize("kind", KINDS)
def test_a_seed_gives_its_scene_and_most_are_worth_solving(kind):
    assert random_scene_in_space(kind, 3) == random_scene_in_space(kind, 3)
    sizes = [len(random_scene_in_space(kind, seed).blocks) for seed in range(40)]
    assert max(sizes) <= 60 + 4  # 60 movable blocks and 4 supports
    assert len(set(sizes)) > 3


@pytest.mark.slow
@pytest.mark.parametrize(("kind", "seed"), SCENES)
def test_the_default_is_certified_and_below_associative(kind, seed):
    scene = random_scene_in_space(kind, seed)
    associative, result = solved(scene, "static"), solved(scene)
    if result.load_factor is None:
        # If a scene jams from rest, other states may exist.
        assert result.solution.proven_none or result.status in (Status.UNSTABLE, Status.JAMMED)
        assert associative.load_factor is None
        return
    assert associative.status is not Status.UNSTABLE
    answer = result.solution.answer
    assert answer.forms.friction is Cone
    assert not answer.failing(Kind.NEARLY_COMPLEMENTARY)
    if associative.load_factor is not None:
        assert result.load_factor <= associative.load_factor * (1 + RANDOM) + RANDOM


@pytest.mark.slow
def test_two_piers_and_what_they_bear_have_an_exact_state():
    """Two piers with a lintel have an exact state, to which the forces of the last load step lead.

    The forces of a rough equilibrium lead to a state with a residual of 3e-5 of λ.
    """
    result = solved(random_scene_in_space("piers", 30028))
    assert result.friction_law == "cone"
    assert result.kind is Kind.EXACT
    assert not result.solution.answer.failing(Kind.EXACT)
    assert result.lowest == result.load_factor < result.associative


def test_a_state_by_sides_that_the_cone_allows_is_exact():
    """A state by polygons is exact if it satisfies the cone too.

    This applies to a box that overturns, and to a box that slides along an axis of its contact, but not to a
    box that slides at 7.5° to this axis.
    """
    for scene, exact in (
        (pushed_box((0.5, 2, 2), 0.6, 0.0), True),
        (pushed_box((2, 2, 1), 0.5, 0.0), True),
        (pushed_box((2, 2, 1), 0.5, 7.5), False),
    ):
        problem = assemble(scene).problem
        state = IncrementalAnalysis(problem).run().state
        assert state.forms.friction is Cone
        if not exact:
            state = Refiner(problem, Effort()).state_near(state.q)
        by_sides = certified(problem, state.load_factor, state.q, state.d)
        assert by_sides.forms.friction is Sides
        assert not by_sides.failing(Kind.EXACT)
        solution = Solution(Status.CONVERGED, Kind.EXACT, state=by_sides)
        assert solution.is_exact(problem) == exact

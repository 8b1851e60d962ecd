"""Tests on random scenes of notched stones, of corners on edges, and of joints that crush.

Seeds 0 to 299 were all solved once: 254 ended in an exact state, and 37 are unstable under their dead load.
Seven are proven to have no load factor, and two remained undecided.
"""

import pytest
from atlas.odd_stones import odd_scene

import masonry_opt as mo
from masonry_opt.problem.assembly import assemble
from masonry_opt.solution.acceptance import LIMITS, Kind
from masonry_opt.solution.reasons import Status

#: Relative tolerance of two programs solved to 1e-9; thin cells cost digits.
RANDOM = 1e-6

SEEDS = [0, *(pytest.param(seed, marks=pytest.mark.slow) for seed in (1, 2, 300, 303, 306))]


def test_scenes_have_what_they_are_for():
    scenes = [odd_scene(seed) for seed in range(12)]
    assemblies = [assemble(scene) for scene in scenes]
    assert sum((assembly.joints.extent == 0).any() for assembly in assemblies) >= 9
    assert sum((~assembly.geometry.convex).any() for assembly in assemblies) >= 9
    assert 5 <= sum(len(assembly.problem.crushing) > 0 for assembly in assemblies) < 12


@pytest.mark.slow
@pytest.mark.parametrize("seed", SEEDS)
def test_the_default_is_exact_or_says_why_there_is_none(seed):
    result = mo.solve(odd_scene(seed))
    if result.load_factor is None:
        proven = result.infeasibility is not None and result.infeasibility.proven
        assert result.status is Status.UNSTABLE or proven
        return
    assert not LIMITS[Kind.EXACT if result.exact else Kind.LOOP].failing(result.certificate.as_dict())
    if result.associative is not None:  # Dilatancy locks some scenes.
        assert result.load_factor <= result.associative * (1 + 1e-7)


@pytest.mark.parametrize("seed", SEEDS)
def test_parabola_and_chords_hold_each_other(seed):
    """The load factor with chords is at most that with the parabola; without a strength, both are equal.

    Chords lie inside the parabola, and miss 0.65 % of a moment at most.
    """
    scene = odd_scene(seed)
    by_chords, whole = mo.solve(scene, "static", solver="highs"), mo.solve(scene, "static")
    if by_chords.load_factor is None:
        assert whole.load_factor is None or scene.joints.strength is not None
        return
    assert whole.load_factor >= by_chords.load_factor * (1 - RANDOM)
    if scene.joints.strength is None:
        assert whole.load_factor == pytest.approx(by_chords.load_factor, rel=RANDOM)

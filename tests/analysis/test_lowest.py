"""The default's lowest state on scenes where the load history does not lead to the lowest state.

Expected values come from proofs or longer searches of this package, as each case names. The tolerance of
1e-6 is that of the linear programs (1e-10) times the conditioning of random scenes.
"""

import itertools
import time
from pathlib import Path

import numpy as np
import pytest
from atlas.held_scenes import held
from atlas.random_scenes import random_scene
from mappings import mapped, mirrored
from scenes import solved, values_of
from scenes_in_space import corner_wall

import masonry_opt as mo
from masonry_opt.solution.reasons import Code

FOLDER = Path(__file__).parent / "low_states"
TOLERANCE = 1e-6

#: Scenes and their least load factors. The comment in each file says how the value is known.
LEAST_KNOWN = {"wall_13_joints": 16.4710309, "stones_14_joints": 2.3410936}

#: Seeds of random walls and their lowest load factors from searches by this package, not proven least. The
#: first two seeds were not used to choose the settings of the search; the last seed was.
SEARCHED = {1_211_000: 3.63859270, 1_211_004: 0.62443956, 1_210_024: 0.56704015}


def with_turned_outlines(scene: mo.Scene) -> mo.Scene:
    """Return the scene with each outline begun at its next vertex, which renumbers the joints."""
    blocks = [block.replace(vertices=[*block.vertices[1:], block.vertices[0]]) for block in scene.blocks]
    return scene.model_copy(update={"blocks": blocks})


def in_order(scene: mo.Scene, seed: int) -> mo.Scene:
    """Return the scene with its blocks in a random order."""
    return mapped(scene, order=np.random.default_rng(seed).permutation(len(scene.blocks)))


def assert_lowest(scene: mo.Scene, least: float) -> None:
    """Assert that the default finds an exact state at the least load factor."""
    result = solved(scene)
    assert result.exact
    assert result.load_factor == pytest.approx(least, rel=TOLERANCE)


@pytest.mark.parametrize(
    "order", [pytest.param(order, marks=pytest.mark.slow if order else ()) for order in range(4)]
)
@pytest.mark.parametrize("name", LEAST_KNOWN)
def test_any_order_of_the_blocks_leads_to_the_least_state(name, order):
    assert_lowest(in_order(mo.load(FOLDER / f"{name}.toml"), order), LEAST_KNOWN[name])


@pytest.mark.slow
@pytest.mark.parametrize("name", LEAST_KNOWN)
def test_the_mirror_image_leads_to_the_least_state(name):
    scene = mo.load(FOLDER / f"{name}.toml")
    assert_lowest(mapped(scene, mirrored, mirrored), LEAST_KNOWN[name])


@pytest.mark.slow
@pytest.mark.parametrize("name", LEAST_KNOWN)
def test_renumbered_joints_lead_to_the_least_state(name):
    assert_lowest(with_turned_outlines(mo.load(FOLDER / f"{name}.toml")), LEAST_KNOWN[name])


@pytest.mark.slow
@pytest.mark.parametrize("seed", SEARCHED)
def test_a_random_wall_leads_to_the_state_that_searches_find(seed):
    assert_lowest(random_scene("wall", seed), SEARCHED[seed])


@pytest.mark.slow
@pytest.mark.parametrize("seed", SEARCHED)
def test_a_random_wall_leads_there_in_other_orders_and_mirrored(seed):
    scene = random_scene("wall", seed)
    assert_lowest(mapped(scene, mirrored, mirrored), SEARCHED[seed])
    for order in range(3):
        assert_lowest(in_order(scene, order), SEARCHED[seed])


@pytest.mark.slow
def test_a_rod_that_does_not_yield_leads_to_a_lower_state():
    """The default finds a state in which a strong rod carries less than its strength, at 0.3000 or lower.

    An independent program recomputed the state at 0.3000. Later searches by this package found exact states
    at 0.2500 and 0.1256, with residuals of 2e-11.
    """
    result = solved(mo.load(FOLDER / "wall_with_a_rod.toml"))
    assert result.exact
    assert result.load_factor <= 0.3000 * (1 + TOLERANCE)
    assert result.load_factor < 0.65 * result.associative


@pytest.mark.slow
def test_the_number_of_starts_in_space_depends_on_the_scene_alone(monkeypatch):
    """A clock that jumps by an hour at each reading must change neither the starts nor the answer."""
    scene = corner_wall(2, 2, 2)
    first = mo.solve(scene)
    hours = itertools.count(step=3600.0)
    monkeypatch.setattr(time, "perf_counter", lambda: next(hours))
    second = mo.solve(scene)
    assert second.solution.starts == first.solution.starts
    assert second.load_factor == first.load_factor


@pytest.mark.slow
def test_the_forces_of_the_lowest_state_lead_lower():
    """The default ends at 1.3244646 or lower, the result of a 10 s search by an earlier version.

    The default of that version ended at 3.026.
    """
    result = solved(held("corner", 1_230_022, space=True))
    assert result.exact
    assert result.load_factor <= 1.3244646


def test_agreement_after_one_start_is_reported():
    """Without descent, the only state is near the incremental load factor, far above the least one.

    The three load factors agree, and the summary says that only one start was made.
    """
    result = mo.solve(mo.load(FOLDER / "wall_13_joints.toml"), descent=False)
    assert result.load_factor == pytest.approx(result.associative, rel=TOLERANCE)
    assert values_of(result, Code.FEW_STARTS) == {"candidates": 1}
    words = " ".join(str(result).split())
    assert "the analysis made only 1 start; a collapse state with a lower load factor may exist" in words


def test_no_agreement_is_reported_where_the_lowest_is_below_the_associative():
    result = mo.solve(mo.load(FOLDER / "wall_13_joints.toml"))
    assert result.load_factor < 0.52 * result.associative
    assert Code.FEW_STARTS not in [reason.code for reason in result.reasons]


def test_no_agreement_is_reported_where_equilibrium_fixes_the_forces():
    """A block on one bed joint has three forces and three equations, so no message on few starts appears."""
    block = mo.Block(name="block", vertices=[(0, 0), (1, 0), (1, 4), (0, 4)], weight=1, live=(1, 0))
    base = mo.Block(name="base", vertices=[(-1, -1), (2, -1), (2, 0), (-1, 0)], fixed=True)
    scene = mo.Scene(joints=mo.JointDefaults(friction=0.7), blocks=[block, base])
    result = mo.solve(scene, descent=False)
    assert result.load_factor == pytest.approx(0.5 / 2, rel=TOLERANCE)  # toppling about a corner
    assert Code.FEW_STARTS not in [reason.code for reason in result.reasons]

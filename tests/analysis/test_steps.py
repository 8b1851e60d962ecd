"""The default method as a list of steps: the steps that run, their order, and their log."""

from pathlib import Path

import numpy as np
import pytest
from atlas.random_scenes import random_scene
from scenes import block_on_floor, overhanging, pressed_down, small_wall, solved, two_blocks

import masonry_opt as mo
from masonry_opt.methods.bounds.settings import ProofBudget
from masonry_opt.methods.coulomb import method
from masonry_opt.methods.coulomb.steps import ExactFrom, FurtherStarts, Incremental, LeastProven, Loop
from masonry_opt.methods.exact.settings import SearchSettings
from masonry_opt.methods.incremental.settings import IncrementalSettings

LOW_STATES = Path(__file__).parent / "low_states"
LOAD_HISTORY = "incremental analysis"
FROM_HISTORY = "exact state from the incremental forces"
FROM_ASSOCIATIVE = "exact state from the associative forces"
FURTHER = "further starts"
PROOF = "proof of the least"
LOOP = "loop of linear programs"


def steps_of(result: mo.Result) -> list[str]:
    return [entry.step for entry in result.solution.log]


@pytest.mark.parametrize(
    ("scene", "options", "steps"),
    [
        (two_blocks(), {}, [LOAD_HISTORY, FROM_HISTORY, PROOF, FURTHER]),
        (two_blocks(), {"descent": False}, [LOAD_HISTORY, FROM_HISTORY]),
        (small_wall(2, 1, dilatancy=0.2, dilatancy_stress=(0.1, 1.0)), {}, [LOOP]),
        (pressed_down(), {}, [LOAD_HISTORY, FROM_ASSOCIATIVE]),
        (block_on_floor(), {}, [LOAD_HISTORY, FROM_HISTORY]),
        (two_blocks().replace(joints={"dilatancy": 0.1}), {}, [LOAD_HISTORY, FROM_HISTORY]),
        (random_scene("wall", 2830002), {}, [LOAD_HISTORY, FROM_HISTORY, FURTHER]),
    ],
    ids=[
        "small",
        "without descent",
        "dilatancy falls",
        "no mechanism",
        "fixed forces",
        "associative",
        "22 joints",
    ],
)
def test_steps_that_apply(scene, options, steps):
    assert steps_of(mo.solve(scene, **options)) == steps


def test_a_scene_that_falls_needs_no_step():
    assert steps_of(mo.solve(overhanging())) == []


def test_the_log_follows_the_load_factor():
    """The log of the two blocks begins at 0.188 of the load history and ends at the least λ, 0.15.

    The least value is that of Gilbert et al. (2006).
    """
    log = solved(two_blocks()).solution.log
    np.testing.assert_allclose(
        [entry.load_factor for entry in log], [0.18843976, 0.15, 0.15, 0.15], rtol=1e-6
    )
    assert [entry.exact_states for entry in log] == [0, 1, 1, 1]
    assert all(entry.seconds > 0 for entry in log)


def test_the_log_has_the_time_of_a_load_history_computed_before():
    result = mo.solve(two_blocks())
    assert result.solution.log[0].seconds >= result.seconds["incremental"] > 0


def test_the_technical_summary_lists_the_steps():
    details = solved(two_blocks()).details
    assert f"{LOAD_HISTORY}: λ = 0.18844 (" in details
    assert f"{FROM_HISTORY}: λ = 0.15, 1 exact state (" in details
    assert f"{PROOF}: λ = 0.15, 1 exact state, proven by " in details


@pytest.mark.parametrize(
    ("steps", "load_factor"),
    [((Incremental(), ExactFrom("incremental")), 0.5), ((Loop(),), 0.5)],
    ids=["load history alone", "loop alone"],
)
def test_the_list_decides_what_is_done(monkeypatch, steps, load_factor):
    """Only the listed steps run; a block of width 1 and height 2 tips at λ = 0.5 with each list."""
    monkeypatch.setattr(method, "STEPS", steps)
    result = mo.solve(block_on_floor(), incremental=False)
    assert result.load_factor == pytest.approx(load_factor, rel=1e-4)
    assert len(result.solution.log) == len(steps)


def test_the_steps_are_in_the_order_of_the_guide():
    kinds = [Incremental, ExactFrom, ExactFrom, LeastProven, FurtherStarts, Loop]
    assert [type(step) for step in method.STEPS] == kinds


def test_settings_of_the_search_can_be_passed():
    """With six starts in vain instead of one, a search without a proof takes at least five starts more."""
    path, no_proof = LOW_STATES / "stones_14_joints.toml", ProofBudget(most_joints=0)
    counts = []
    for number in (1, 6):
        settings = SearchSettings(starts_in_vain=number)
        result = mo.solve(path, incremental=False, settings=settings, budget=no_proof)
        assert steps_of(result)[-1] == FURTHER
        counts.append(result.solution.starts)
    assert counts[1] >= counts[0] + 5


def test_settings_of_another_class_are_refused():
    with pytest.raises(mo.OptionError, match="settings"):
        mo.solve(two_blocks(), settings=IncrementalSettings())

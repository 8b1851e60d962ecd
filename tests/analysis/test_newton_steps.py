"""The steps of passes: recorded one by one, told as they are made, the same in every run."""

from __future__ import annotations

import numpy as np
import pytest
from scenes import WALLS, solved, two_blocks

import masonry_opt as mo

SCENES = {"wall_2": WALLS[1], "wall_6": WALLS[5], "two blocks": two_blocks()}


def test_history_has_a_row_for_every_step():
    steps = solved(WALLS[5]).history
    columns = (
        "iteration load_factor gap statics yielding motion blend centring forces velocities error seconds"
    )
    assert {*columns.split(), "full", "attempt"} <= set(steps.columns)
    assert steps["iteration"].to_list() == list(range(1, len(steps) + 1))
    giving = solved(WALLS[5], "compliant", give=1e-2).load_factor
    assert steps["load_factor"].iloc[-1] == pytest.approx(giving, rel=2e-3)
    lengths = steps[["forces", "velocities"]].to_numpy()[:-1]
    assert ((lengths > 0) & (lengths <= 1)).all()
    assert steps["centring"].isna().to_list() == [False] * (len(steps) - 1) + [True]
    assert (steps["seconds"] >= 0).all()


@pytest.mark.parametrize("path", WALLS, ids=lambda path: path.stem)
def test_the_gap_falls(path):
    """Steps may raise the gap; half of them (all but a few on walls) do not, and it ends below 1e-8."""
    history = solved(path).history
    gap = history["gap"].to_numpy()
    assert gap[-1] < 1e-8 < 1 < gap[0]
    assert np.mean(np.diff(gap) < 0) > 0.5
    assert history[["statics", "yielding"]].iloc[-1].max() < 1e-8


def test_progress_is_called_with_every_step():
    """Those of the load to expect are the first."""
    seen = []
    result = mo.solve(WALLS[0], progress=seen.append)
    assert [step.load_factor for step in seen] == result.history["load_factor"].to_list()
    assert [step.iteration for step in seen] == result.history["iteration"].to_list()


@pytest.mark.parametrize("method", ["mcp", "refined"])
def test_an_interrupt_goes_through(method):
    """Of a refinement too, where no search is asked for."""
    seen = []

    def interrupt(step):
        seen.append(step)
        if len(seen) == 3:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        mo.solve(WALLS[0], method, progress=interrupt, expected=False)
    assert len(seen) == 3


@pytest.mark.parametrize("name", SCENES)
def test_two_runs_are_the_same_to_the_bit(name):
    one, other = solved(SCENES[name]), mo.solve(SCENES[name], expected=False)
    assert one.load_factor == other.load_factor
    np.testing.assert_array_equal(one.solution.q, other.solution.q)
    np.testing.assert_array_equal(one.solution.d, other.solution.d)
    steps, others = (result.history.drop(columns="seconds") for result in (one, other))
    assert steps.equals(others)

"""What a result says of joints and blocks, in the units of the case."""

from __future__ import annotations

import json

import numpy as np
import pytest
from scenes import block_on_floor, small_wall, two_blocks

import masonry_opt as mo


@pytest.mark.parametrize(
    ("live", "friction", "expected"),
    [((0.5, 0.0), 0.5, 0.5), ((1.0, 0.0), 0.5, 0.5)],
)
def test_utilisation_is_force_over_limit(live, friction, expected):
    """At collapse a sliding block uses all its friction; held by twice the need, half of it."""
    result = mo.solve(block_on_floor(4, 2, friction, live=live), "static")
    assert result.joints["utilisation"][0] == pytest.approx(1.0)
    held = block_on_floor(1, 2, 1.0)  # overturns at 0.5, sliding needs 1.0
    joint = mo.solve(held, "static").joints.iloc[0]
    assert abs(joint["s"]) / (1.0 * joint["n"]) == pytest.approx(expected)
    assert joint["utilisation"] == pytest.approx(1.0)  # by rocking
    assert abs(joint["m"]) / (joint["n"] * joint["length"] / 2) == pytest.approx(1.0)


def test_idle_joints_have_no_utilisation_and_others_none_above_one():
    frame = mo.solve(small_wall(6, 4), "static").joints
    idle = frame["utilisation"].isna()
    largest = frame["n"].max()
    assert (frame.loc[idle, ["n", "s"]].abs() <= 1e-6 * largest).all(axis=None)
    assert (frame.loc[~idle, "utilisation"] <= 1 + 1e-3).all()


def test_sliding_block_moves_as_it_should():
    """Associative: it slides to the right and opens by μ per unit slip; live load moves at rate 1."""
    result = mo.solve(block_on_floor(4, 2, 0.5), "static")
    block, joint = result.blocks.iloc[0], result.joints.iloc[0]
    assert block[["vx", "vy", "omega"]].to_numpy(float) == pytest.approx([1, 0.5, 0], abs=1e-6)
    assert joint[["slip", "opening", "rotation"]].to_numpy(float) == pytest.approx([1, 0.5, 0], abs=1e-6)
    assert joint[["n", "s"]].to_numpy(float) == pytest.approx([1, -0.5], abs=1e-6)


def test_overturning_block_turns_about_its_toe():
    result = mo.solve(block_on_floor(1, 2, 0.8), "static")
    block = result.blocks.iloc[0]
    # The centroid stands 1 above and 0.5 left of the toe: turning by -1 moves it (1, 0.5).
    assert block[["vx", "vy", "omega"]].to_numpy(float) == pytest.approx([1, 0.5, -1], abs=1e-6)


def test_json_is_plain_and_without_nan():
    text = mo.solve(two_blocks()).to_json()
    assert "NaN" not in text
    assert "Infinity" not in text
    answer = json.loads(text)
    assert answer["history"][0]["alpha"] is None
    assert np.isclose(answer["load_factor"], 0.15, rtol=1e-3)


def test_repr_is_short():
    assert len(repr(mo.solve(two_blocks()))) < 2000


@pytest.mark.parametrize("tolerance", [0, -1.0, 1.0, "1e-9", float("nan")])
def test_tolerance_must_be_one(tolerance):
    with pytest.raises(mo.OptionError, match="tolerance"):
        mo.solve(two_blocks(), tolerance=tolerance)

"""What failed moves nothing: not in words, frames, pages or pictures."""

from __future__ import annotations

import json

import pytest
from atlas.small_scenes import pebble
from drawn import labels
from scenes import CASES

import masonry_opt as mo
from masonry_opt.drawing.elements import has_mechanism
from masonry_opt.drawing.page import page
from masonry_opt.words.summary import facts


@pytest.fixture(scope="module")
def failed():
    """A state that its certificate does not bear out: a pebble on a boulder of 10⁸ times its weight."""
    result = mo.solve(
        pebble(1e4, push_both=False)(CASES), "nonassociative", start="cohesive", remedies="slope"
    )
    assert result.status is mo.Status.SOLVER_FAILED
    assert result.history["load_factor"].notna().any()
    return result


def test_nothing_moves_in_words_and_numbers(failed):
    assert "moves" not in facts(failed)
    assert "moves" not in failed.details
    assert failed.blocks[["vx", "vy", "omega"]].isna().all(axis=None)
    assert failed.joints[["n", "s", "m", "slip", "opening", "utilisation"]].isna().all(axis=None)
    told = json.loads(failed.to_json())
    assert {row["vx"] for row in told["block_results"]} == {None}


def test_nothing_moves_in_pictures_and_pages(failed):
    assert not has_mechanism(failed)
    assert not any("joint" in label for label in labels(failed))
    assert "tried" not in failed.plot().axes[0].get_title()
    (slider,) = [line for line in page(failed).splitlines() if 'id="moved"' in line]
    assert " disabled" in slider

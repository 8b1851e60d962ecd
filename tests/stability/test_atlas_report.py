"""What the atlas's page says of a run that is not as expected."""

from __future__ import annotations

from dataclasses import replace

import pytest
from scenes import CASES

import masonry_opt as mo
from masonry_opt.studies.atlas.entries import ATLAS
from masonry_opt.studies.atlas.entry import Expectation, carry_out
from masonry_opt.studies.paper.stability import atlas_row, difference_line

ENTRY = next(entry for entry in ATLAS if entry.name == "joint 10⁻⁶ of a block long")
RIGHT = Expectation(mo.Status.OPTIMAL, "static", load_factor=0.5, source="μ")


@pytest.mark.parametrize("wrong", [{"expected": mo.Status.UNSTABLE}, {"load_factor": 0.6}])
def test_a_run_that_is_not_as_expected_is_shown_as_such(wrong):
    assert atlas_row(carry_out(ENTRY, RIGHT, CASES))["as expected"] == "yes"
    observed = carry_out(ENTRY, replace(RIGHT, **wrong), CASES)
    assert atlas_row(observed)["as expected"] == "no"
    assert difference_line(observed).startswith("joint 10⁻⁶ of a block long, static: ")

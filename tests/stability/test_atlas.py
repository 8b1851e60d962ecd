"""Tests that every run of the failure atlas has the answer that its entry states."""

import dataclasses

import pytest
from atlas.entries import ATLAS
from atlas.entry import Expectation, difference
from scenes import CASES

import masonry_opt as mo
from masonry_opt.solution.reasons import Code, reason

#: Methods of which the first run of an entry is fast. All other runs, and all walls of Table 1, are slow.
FAST = ("static", "nonassociative", "coulomb")
#: Entries on which the default takes about half a second; these runs are slow.
SLOW_BY_DEFAULT = (
    *("cycling between near-equal load paths", "c₀ = 0: stuck at the associative answer"),
    *("c₀ = 0: uncontrolled penetration", "interior point without crossover"),
    *("coordinates 1e+06 from the origin", "coordinates 1e+12 from the origin"),
)


def _runs():
    for entry in ATLAS:
        left = set() if "wall" in entry.name else {*FAST}
        if entry.name in SLOW_BY_DEFAULT:
            left.remove("coulomb")
        for run in entry.runs:
            is_fast = run.method in left and "search" not in run.options
            marks = [] if is_fast else [pytest.mark.slow]
            if is_fast:
                left.discard(run.method)
            yield pytest.param(entry, run, id=f"{entry.name}: {run.name}", marks=marks)


@pytest.mark.parametrize(("entry", "run"), list(_runs()))
def test_run_is_as_expected(entry, run):
    assert difference(entry, run, CASES) == ""


def test_names_are_unique():
    assert {*SLOW_BY_DEFAULT} <= {entry.name for entry in ATLAS}
    names = [(entry.name, run.name) for entry in ATLAS for run in entry.runs]
    assert len(set(names)) == len(names)


ENTRY = next(entry for entry in ATLAS if entry.name == "joint 10⁻⁶ of a block long")
RIGHT = Expectation("static", 0.5, "μ", mo.Status.OPTIMAL)


@pytest.mark.parametrize(
    ("wrong", "said"),
    [
        ({"expected": mo.Status.UNSTABLE}, "optimal (), expected: unstable under dead load"),
        ({"expected": mo.CaseError}, "optimal (), expected: CaseError"),
        ({"load_factor": 0.5001}, "expected 0.5000995 to 0.5001005 (μ)"),
        ({"load_factor": (0.1, 0.49)}, "expected 0.1 to 0.49 (μ)"),
        ({"why": reason(Code.REPEATS)}, "not given as a reason: {'code': 'repeats'}"),
    ],
)
def test_what_is_not_as_expected_is_said(wrong, said):
    """The comparison detects a wrong status, error, load factor and reason."""
    assert difference(ENTRY, RIGHT, CASES) == ""
    assert said in difference(ENTRY, dataclasses.replace(RIGHT, **wrong), CASES)

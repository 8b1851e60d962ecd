"""Every run of the failure atlas answers as its entry says."""

import dataclasses

import pytest
from atlas.entries import ATLAS
from atlas.entry import Expectation, carry_out
from scenes import CASES

import masonry_opt as mo
from masonry_opt.answer.reasons import Code, reason

#: Runs of many attempts each, beside others of their entry that stay: the loop's remedies in vain before a
#: method that begins with it, walls of large friction by vertices, and what `test_remedies.py` holds too.
SLOW = {
    "cycling on wall 6": {
        "nonassociative",
        "nonassociative beta=1.0",
        "nonassociative beta=1.0 alpha=0.0 alpha_min=0.0",
        "nonassociative beta=1.0 alpha=0.0 alpha_min=0.0 preset=paper remedies=none",
    },
    "the end hangs on the vertex: wall 6": {
        "nonassociative pyomo highs",
        "nonassociative pyomo highs preset=paper remedies=none",
    },
    "sizes 1 : 10⁴, the small one pushed": {"refined", "mpec", "global", "nonassociative start=cohesive"},
    "μ large: wall 3": {"nonassociative highs", "nonassociative highs-ipm", "nonassociative start=cohesive"},
    "μ very large: wall 1": {"mcp", "nonassociative highs", "nonassociative highs-ipm"},
    "c₀ = 0: uncontrolled penetration": {"nonassociative highs c0=0.0", "mpec"},
    "a vertex locks joints: wall 3": {"nonassociative highs-ipm"},
    "a vertex locks joints: wall 6": {"nonassociative highs"},
    "a vertex from a cohesive start: wall 1": {"nonassociative highs start=cohesive"},
}


def _runs():
    for entry in ATLAS:
        for run in entry.runs:
            slow = run.slow or run.name in SLOW.get(entry.name, ())
            marks = [pytest.mark.slow] if slow else []
            yield pytest.param(entry, run, id=f"{entry.name}: {run.name}", marks=marks)


def test_slow_runs_are_runs():
    """A name that is none would leave a slow run among the others."""
    for entry, names in SLOW.items():
        (runs,) = (known.runs for known in ATLAS if known.name == entry)
        assert names <= {run.name for run in runs}


@pytest.mark.parametrize(("entry", "run"), list(_runs()))
def test_run_is_as_expected(entry, run):
    assert carry_out(entry, run, CASES).difference == ""


def test_names_are_unique():
    names = [(entry.name, run.name) for entry in ATLAS for run in entry.runs]
    assert len(set(names)) == len(names)


ENTRY = next(entry for entry in ATLAS if entry.name == "joint 10⁻⁶ of a block long")
RIGHT = Expectation(mo.Status.OPTIMAL, "static", load_factor=0.5, source="μ")


@pytest.mark.parametrize(
    ("wrong", "difference"),
    [
        ({"expected": mo.Status.UNSTABLE}, "optimal (), expected: unstable under dead load"),
        ({"expected": mo.CaseError}, "optimal (), expected: CaseError"),
        ({"load_factor": 0.5001}, "expected 0.5000995 to 0.5001005 (μ)"),
        ({"load_factor": (0.1, 0.49)}, "expected 0.1 to 0.49 (μ)"),
        ({"why": reason(Code.REPEATS)}, "not given as a reason: {'code': 'repeats'}"),
    ],
)
def test_what_is_not_as_expected_is_said(wrong, difference):
    """The judge can fail: on the status, the error, λ and the message."""
    assert carry_out(ENTRY, RIGHT, CASES).difference == ""
    observed = carry_out(ENTRY, dataclasses.replace(RIGHT, **wrong), CASES)
    assert difference in observed.difference

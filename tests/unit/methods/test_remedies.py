"""What the loop tries after each way to fail: order, limits and names."""

from __future__ import annotations

from dataclasses import replace

import pytest

from masonry_opt.answer.reasons import Status
from masonry_opt.methods.loop.nonassociative import REMEDIES, Shortfall
from masonry_opt.methods.loop.options import Attempt, LoopOptions
from masonry_opt.solvers.registry import find_solver

CLARABEL = find_solver("cvxpy", None)
FIRST = Attempt(LoopOptions().parameters(1, CLARABEL), CLARABEL)
ROUGH = Attempt(LoopOptions(sub_problems="rough").parameters(1, CLARABEL), CLARABEL)


def series(failure, attempt):
    """The names of the remedies for a failure, each taken on the one before."""
    names = []
    for remedy in REMEDIES[failure]:
        following = remedy(attempt)
        if following is not None:
            attempt = following
            names.append(attempt.remedy)
    return names


#: By failure of the first run.
ORDER = {
    Status.NO_STATE: ["alpha=0.1", "alpha=0.033", "alpha=0.011", "alpha=0.0037", "alpha=0.0012"],
    Status.CYCLING: ["beta=0.3", "beta=0.15", "solver=highs-ipm"],
    Status.ITERATION_LIMIT: [],
    Status.SOLVER_FAILED: ["solver=highs-ipm"],
    Status.LOCKED: ["start=cohesive"],
    Shortfall.INEXACT: ["solver=highs-ipm"],
    Shortfall.ROUGH: [],
}


@pytest.mark.parametrize("failure", REMEDIES)
def test_order_of_the_remedies(failure):
    assert series(failure, FIRST) == ORDER[failure]


@pytest.mark.parametrize(
    "failure", [Status.CYCLING, Status.SOLVER_FAILED, Shortfall.ROUGH, Shortfall.INEXACT]
)
def test_rough_sub_problems_are_first_solved_accurately(failure):
    """What a rough run could not do proves little; and no rough answer ends early."""
    assert series(failure, ROUGH)[0] == "sub_problems=accurate"
    accurate = REMEDIES[failure][0](ROUGH)
    assert accurate.parameters == replace(ROUGH.parameters, tolerance=None, early=False)
    assert REMEDIES[failure][0](FIRST) is None


@pytest.mark.parametrize("failure", REMEDIES)
def test_remedies_are_named_like_options(failure):
    """Each as NAME=VALUE, as the command takes it, of an option of the loop or of ``solve``."""
    for name in series(failure, FIRST):
        for part in name.split(", "):
            option, _, value = part.partition("=")
            assert option in {*LoopOptions.model_fields, "solver", "tolerance"}
            assert value


def test_another_solver_is_another():
    of_highs = replace(FIRST, solver=find_solver("cvxpy", "highs-ipm"))
    assert series(Status.SOLVER_FAILED, of_highs) == ["solver=clarabel"]

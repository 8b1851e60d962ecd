"""Rows of a study: the same from one process and from several, whatever becomes of the workers."""

from functools import partial

import hogs
import pytest
from scenes import block_on_floor

from masonry_opt.methods.registry import HowToSolve
from masonry_opt.studies.many.runs import COLUMNS, row, run_solver
from masonry_opt.studies.runner import Workers

STUDY = HowToSolve("static")
VALUES = [{"joints.friction": 0.1 + 0.05 * number} for number in range(12)]
RUNS = [block_on_floor(friction=values["joints.friction"]) for values in VALUES]


def rows(ends):
    return {number: row(VALUES[number], end) | {"seconds": None} for number, end in ends}


@pytest.fixture(scope="module")
def alone():
    solve = run_solver(STUDY)
    without = dict.fromkeys(COLUMNS)
    return {number: VALUES[number] | without | solve(run) for number, run in enumerate(RUNS)}


def test_a_row_says_what_was_found(alone):
    row = alone[3]
    assert list(row) == ["joints.friction", *COLUMNS]
    assert (row["load_factor"], row["status"]) == (pytest.approx(0.25, abs=1e-8), "optimal")
    assert (row["mechanism"], row["slides"], row["hinges"]) == ("sliding", 1, 0)
    assert (alone[11]["mechanism"], alone[11]["slides"], alone[11]["hinges"]) == ("hinging", 0, 1)
    assert max(row[name] for name in ("equilibrium", "yield", "flow", "complementarity")) < 1e-6


def test_a_lost_worker_costs_nothing_but_time(alone, tmp_path):
    with Workers(partial(hogs.Mortal, partial(run_solver, STUDY), tmp_path), 2) as workers:
        assert rows(workers.map(RUNS)) == alone
    assert len(list(tmp_path.iterdir())) >= 3  # two may die at once

"""Runs in processes of their own: ended by time, by memory, by a crash; and what a good one returns."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time

import hogs
import pytest
from scenes import CASES, two_blocks

import masonry_opt as mo
from masonry_opt.studies.compare.measure import (
    FINISHED,
    MEMORY_LIMIT,
    TIME_LIMIT,
    run_limited,
)
from masonry_opt.studies.compare.plan import Pair
from masonry_opt.studies.compare.worker import run_pair
from masonry_opt.studies.endings import CRASHED, DIED, REFUSED


def test_a_run_over_its_time_is_killed():
    ended = run_limited(hogs.sleep, (30.0,), 0.3, 4000)
    assert (ended.how, ended.reason, ended.value) == (TIME_LIMIT, "over 0.3 s", None)
    assert ended.seconds < 10  # of 30


def test_a_run_over_its_memory_is_killed():
    ended = run_limited(hogs.hoard, (3000,), 30, 700)
    assert (ended.how, ended.reason) == (MEMORY_LIMIT, "over 700 MB")
    assert 700 < ended.peak < 3000


def test_crashes_are_results():
    died = run_limited(hogs.die, (), 10, 4000)
    assert died.how == DIED
    assert "exit code 7" in died.reason
    failed = run_limited(hogs.fail, (), 10, 4000)
    assert (failed.how, failed.reason) == (CRASHED, "ZeroDivisionError: by zero")


def test_a_run_returns_the_answer_and_its_cost():
    """2.5 μ by hand: Fig. 6 of the paper."""
    case = CASES / "gilbert" / "two_blocks.toml"
    ended = run_limited(run_pair, (case, Pair("static", "cvxpy", "clarabel", 1e-9), 30.0), 30, 4000)
    assert ended.how == FINISHED
    assert ended.value["load_factor"] == pytest.approx(0.25, rel=1e-7)
    assert 0 < ended.value["seconds"]["solve"] < ended.value["wall"] < ended.seconds
    assert ended.peak > 50  # the libraries alone


def test_time_is_split_once_between_solves_of_one_model():
    """HiGHS's clock runs on in a model that stays loaded: the parts must not exceed the whole."""
    case = CASES / "ferris_tinloi" / "wall_1.toml"
    value = run_limited(
        run_pair, (case, Pair("nonassociative", "pyomo", "highs-ipm", 1e-8), 60.0), 60, 4000
    ).value
    assert value["lp_solves"] > 3
    assert sum(value["seconds"].values()) <= value["wall"]


def test_a_wrong_case_is_refused():
    ended = run_limited(run_pair, ("missing.toml", Pair("static", "cvxpy", "clarabel", 1e-9), 30.0), 30, 4000)
    assert ended.how == REFUSED
    assert "missing.toml" in ended.reason


def test_a_comparison_that_is_killed_takes_its_run_along(tmp_path):
    """It is ended like Ctrl-C within a run of a minute, and no process is left."""
    case = tmp_path / "two_blocks.toml"
    mo.save(two_blocks(), case)
    program = "import hogs; from masonry_opt.studies.compare import comparison as c; "
    program += "c.run_pair = hogs.start_and_sleep; from masonry_opt.cli import main; main()"
    arguments = ["compare", str(case), "--methods", "static", "--out", str(tmp_path)]
    comparison = subprocess.Popen(
        [sys.executable, "-c", program, *arguments],
        env=os.environ | {"PYTHONPATH": os.pathsep.join(sys.path)},
        stderr=subprocess.PIPE,
        text=True,
        start_new_session=True,
    )
    deadline = time.monotonic() + 60
    while not case.with_suffix(".started").exists():
        assert time.monotonic() < deadline
        assert comparison.poll() is None
        time.sleep(0.05)
    comparison.send_signal(signal.SIGTERM)
    _, said = comparison.communicate(timeout=30)
    assert comparison.returncode == 130, said
    assert "continues where it stopped" in said
    deadline = time.monotonic() + 10
    while time.monotonic() < deadline:
        try:
            os.killpg(comparison.pid, 0)
        except ProcessLookupError:
            return
        time.sleep(0.1)
    pytest.fail("a process is left")

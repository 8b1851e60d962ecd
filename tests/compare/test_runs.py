"""Runs of a comparison in processes of their own: what one returns, and that none is left behind."""

import os
import signal
import subprocess
import sys
import time
from functools import partial

import pytest
from scenes import CASES, two_blocks

import masonry_opt as mo
from masonry_opt.studies.compare.runs import Pair, run_pair
from masonry_opt.studies.runner import FINISHED, REFUSED, run_alone


def test_a_run_returns_the_answer_and_its_cost():
    """2.5 μ by hand: Fig. 6 of the paper."""
    case = CASES / "gilbert" / "two_blocks.toml"
    end = run_alone(partial(run_pair, case, Pair("static", "cvxpy", "clarabel", 1e-9), 30.0), 30, 4000)
    assert end.how == FINISHED
    assert end.value["load_factor"] == pytest.approx(0.25, rel=1e-7)
    assert 0 < end.value["solve_seconds"] < end.value["wall"] < end.seconds
    assert end.peak > 50  # the libraries alone


def test_time_is_split_once_between_solves_of_one_model():
    """HiGHS's clock runs on in a model that stays loaded: the parts must not exceed the whole."""
    case = CASES / "ferris_tinloi" / "wall_1.toml"
    pair = Pair("nonassociative", "pyomo", "highs-ipm", 1e-8)
    value = run_alone(partial(run_pair, case, pair, 60.0), 60, 4000).value
    assert value["lp_solves"] > 3
    assert sum(value[name] for name in value if name.endswith("_seconds")) <= value["wall"]


def test_a_wrong_case_is_refused():
    pair = Pair("static", "cvxpy", "clarabel", 1e-9)
    end = run_alone(partial(run_pair, "missing.toml", pair, 30.0), 30, 4000)
    assert end.how == REFUSED
    assert "missing.toml" in end.reason


@pytest.mark.slow
def test_a_comparison_that_is_killed_takes_its_run_along(tmp_path):
    """It is ended like Ctrl-C within a run of a minute, and no process is left."""
    case = tmp_path / "two_blocks.toml"
    mo.save(two_blocks(), case)
    # Without charts: the report of what there is takes less time.
    program = "import hogs, sys; sys.modules['altair'] = None; "
    program += "from masonry_opt.studies.compare import comparison as c; "
    program += "c.runs.run_pair = hogs.start_and_sleep; from masonry_opt.cli import main; main()"
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

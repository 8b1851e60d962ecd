"""Tests of long sweeps: Ctrl-C in the middle, and memory that does not grow."""

import os
import signal
import subprocess
import sys
from pathlib import Path

import pandas as pd
import pytest
from hogs import environment, is_gone, wait_until
from scenes import block_on_floor

import masonry_opt as mo
from masonry_opt.studies.writing import JOURNAL

RUNS = 40

#: The command. A process that is started in the background inherits that Ctrl-C is ignored.
COMMAND = """
import signal
signal.signal(signal.SIGINT, signal.default_int_handler)
from masonry_opt.cli import main
main()
"""

#: Prints the resident memory of one process in bytes, after a number of runs and after four times as many. If
#: a number of bytes is given, as many runs again keep this number of bytes each, and the memory is printed.
MEMORY = """
import gc, os, pickle, sys
from scenes import block_on_floor
from masonry_opt.methods.registry import HowToSolve
from masonry_opt.studies.many.runs import run_scene

runs, keeps, kept = int(sys.argv[1]), int(sys.argv[2]), []
how = pickle.dumps(HowToSolve(sys.argv[3]))

def run(first, last, keeps=0):
    for number in range(first, last):
        row = run_scene(how, block_on_floor(friction=0.1 + 1e-4 * number))
        assert row["exact"] or row["status"] == "optimal", row
        kept.append(b"x" * keeps)
        if number % 10 == 9:
            gc.collect()  # what is only not collected yet is not kept
    with open("/proc/self/statm") as pages:
        print(int(pages.read().split()[1]) * os.sysconf("SC_PAGE_SIZE"))

run(0, runs)
run(runs, 4 * runs)
if keeps:
    run(4 * runs, 7 * runs, keeps)
"""


@pytest.mark.slow
def test_ctrl_c_keeps_every_finished_run_and_the_same_command_makes_the_rest(tmp_path):
    case, out = tmp_path / "block.toml", tmp_path / "out"
    mo.save(block_on_floor(), case)
    arguments = ["sweep", case, "--vary", f"joints.friction=0.1:0.9:{RUNS}", "--method", "static"]
    command = [sys.executable, "-c", COMMAND, *arguments, "--workers", "2", "--out", out]
    keys = {"env": environment(), "stderr": subprocess.PIPE, "text": True, "cwd": tmp_path}
    interrupted = subprocess.Popen(command, start_new_session=True, **keys)
    kept = out / JOURNAL

    def lines():
        return kept.read_bytes().splitlines(keepends=True) if kept.exists() else []

    wait_until(lambda: len(lines()) > 5, interrupted)
    os.killpg(interrupted.pid, signal.SIGINT)  # A terminal signals the workers too.
    _, said = interrupted.communicate(timeout=60)
    assert interrupted.returncode == 130, said
    assert "Traceback" not in said
    assert is_gone(interrupted.pid)
    before = lines()
    assert 1 + 5 <= len(before) < 1 + RUNS
    assert all(line.endswith(b"\n") for line in before)
    # The last run may have been recorded just as the command was stopped.
    count = int(said.split("interrupted: ")[1].split()[0])
    assert count in (len(before) - 1, len(before) - 2)
    assert not (out / "runs.csv").exists()

    again = subprocess.run(command, stdout=subprocess.PIPE, timeout=120, check=False, **keys)
    assert again.returncode == 0, again.stderr
    assert lines()[: len(before)] == before
    assert len(lines()) == 1 + RUNS  # No run was recorded twice.
    through = tmp_path / "through"
    frictions = pd.read_csv(out / "runs.csv")["joints.friction"].tolist()
    mo.sweep(case, {"joints.friction": frictions}, method="static", workers=1, out=through)
    one, other = (pd.read_csv(at / "runs.csv", dtype=str).drop(columns="seconds") for at in (out, through))
    pd.testing.assert_frame_equal(one, other)


@pytest.mark.slow
@pytest.mark.skipif(not Path("/proc/self/statm").exists(), reason="needs /proc")
@pytest.mark.parametrize(("method", "keeps"), [("static", 20_000), ("coulomb", 0)])
def test_memory_does_not_grow_with_runs(method, keeps):
    """Memory grows by less than 10 kB a run. A run that kept 20 kB would be noticed."""
    runs = 25
    ended = subprocess.run(
        [sys.executable, "-c", MEMORY, str(runs), str(keeps), method],
        env=environment(),
        capture_output=True,
        text=True,
        timeout=200,
        check=True,
    )
    first, last, *with_kept = map(int, ended.stdout.split())
    assert last - first <= 10_000 * 3 * runs
    if keeps:
        assert with_kept[0] - last > 10_000 * 3 * runs


@pytest.mark.slow
def test_a_worker_whose_study_ends_before_it_runs_says_nothing(tmp_path):
    """A worker that starts after its arguments are gone writes no error; the study itself still writes
    errors."""
    program = """
import gc, sys, time
from masonry_opt.studies.runner import Context
context = Context()
first = context.Process(target=time.sleep, args=(0,))
first.start()
first.join()
given = [context.Semaphore(1) for _ in range(3)]
late = context.Process(target=print, args=tuple(given))
late.start()
del given
gc.collect()
print("still here", file=sys.stderr)
late.join()
"""
    ran = subprocess.run(
        [sys.executable, "-c", program], env=environment(), cwd=tmp_path, capture_output=True, text=True
    )
    assert ran.returncode == 0
    assert ran.stderr == "still here\n"

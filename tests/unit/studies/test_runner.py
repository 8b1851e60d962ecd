"""Tasks in worker processes: their values, the ways in which they end, and their independence."""

import multiprocessing
import os
import subprocess
import sys
import time
from functools import partial

import hogs
import pytest

import masonry_opt as mo
from masonry_opt.studies import runner
from masonry_opt.studies.runner import Workers, run_alone


def test_tasks_run_beside_each_other_and_are_taken_as_workers_become_free():
    """The first task starts first and ends last, and only a few tasks are created in advance. The third task
    takes long enough for the end of the second to be seen first."""
    made, seconds = [], {0: 0.5, 2: 0.3}

    def tasks():
        for number in range(40):
            made.append(number)
            yield partial(time.sleep, seconds.get(number, 0.0))

    with Workers(count=2) as workers:
        ends = [(number, len(made)) for number, _ in workers.map(enumerate(tasks()))]
    assert ends[0][0] == 1
    assert sorted(number for number, _ in ends) == list(range(40))
    assert ends[0][1] < 10


def test_an_error_in_making_a_task_is_raised_after_those_before_it():
    def tasks():
        yield from [os.getpid] * 2
        raise LookupError

    ends = []
    with Workers(count=1) as workers, pytest.raises(LookupError):
        ends.extend(workers.map(enumerate(tasks())))
    assert [end.how for _, end in ends] == [runner.FINISHED] * 2


#: Program that makes a lock in a worker process, as Pyomo does when it is imported.
MAKES_A_LOCK = """
from functools import partial
from masonry_opt.studies.runner import Workers

task = partial(exec, "import multiprocessing as all; all.kept = all.Lock()", {})
with Workers(count=1) as workers:
    [(_, end)] = workers.map([(0, task)])
print(end.how)
"""


@pytest.mark.slow
def test_locks_of_workers_are_not_left_behind():
    ended = subprocess.run([sys.executable, "-c", MAKES_A_LOCK], capture_output=True, text=True)
    assert (ended.stdout.strip(), ended.stderr) == (runner.FINISHED, "")


def test_an_analysis_without_a_result_at_its_time_limit_is_not_refused():
    """A run that ends at its time limit is undecided. It must not count as refused, because refused runs are
    left out of statistics."""
    end = runner._run(partial(hogs.end_at_the_time_limit, "over"))
    assert (end.how, end.reason, end.value) == (runner.TIME_LIMIT, "over", None)


def test_an_error_ends_its_task_alone_and_is_raised_where_the_value_is_asked_for():
    tasks = {
        "fails": hogs.fail,
        "refuses": partial(hogs.refuse, "nowhere"),
        "dies": hogs.die,
        "ends": os.getpid,
    }
    with Workers(count=2) as workers:
        ends = dict(workers.map(tasks.items()))
    for name, why in (("refuses", "nowhere"), ("dies", "exit code 7")):
        with pytest.raises(mo.MasonryError, match=why):
            _ = ends[name].result
    with pytest.raises(RuntimeError, match="ZeroDivisionError"):
        _ = ends["fails"].result
    assert ends["ends"].result != os.getpid()
    assert multiprocessing.active_children() == []


def test_a_task_that_kills_its_workers_is_given_up_alone(tmp_path):
    tasks = [partial(hogs.leave_mark_and_die, tmp_path), *[os.getpid] * 8]
    with Workers(count=1) as workers:
        ends = dict(workers.map(enumerate(tasks)))
        # After the loss of all processes, the workers continue with new ones.
        again = dict(workers.map([(0, os.getpid)]))
    assert ends.pop(0).how == runner.DIED
    assert len(list(tmp_path.iterdir())) == runner.MOST_DEATHS
    assert [end.how for end in (*ends.values(), *again.values())] == [runner.FINISHED] * 9


def test_nothing_goes_on_when_the_caller_is_interrupted():
    began = time.perf_counter()
    with pytest.raises(KeyboardInterrupt), Workers(count=2) as workers:  # noqa: PT012
        for _ in workers.map((seconds, partial(time.sleep, seconds)) for seconds in (0.0, 60.0)):
            raise KeyboardInterrupt
    assert time.perf_counter() - began < 30
    assert multiprocessing.active_children() == []


def test_workers_have_one_thread_and_the_environment_of_the_caller_is_left_alone(monkeypatch):
    monkeypatch.setenv("OMP_NUM_THREADS", "3")
    monkeypatch.delenv("MKL_NUM_THREADS", raising=False)
    assert run_alone(partial(os.getenv, "OMP_NUM_THREADS"), 30.0, 4000).result == "1"
    assert os.environ["OMP_NUM_THREADS"] == "3"
    assert "MKL_NUM_THREADS" not in os.environ


def test_a_process_does_not_import_the_main_program(tmp_path):
    """If a process imported a script without a main guard, the script would start its study again."""
    (script := tmp_path / "script.py").write_text(
        "from functools import partial\n"
        "from masonry_opt.studies.runner import run_alone\n"
        "print(run_alone(partial(divmod, 7, 3), 30.0, 4000).result)"
    )
    printed = subprocess.run([sys.executable, script], capture_output=True, text=True, check=True)
    assert (printed.stdout, printed.stderr) == ("(2, 1)\n", "")


def test_a_process_over_its_limits_is_killed():
    slow = run_alone(partial(time.sleep, 30.0), 0.3, 4000)
    assert (slow.how, slow.reason, slow.value) == (runner.TIME_LIMIT, "over 0.3 s", None)
    assert 0.3 < slow.seconds < 10  # the task takes 30 s
    large = run_alone(partial(hogs.hoard, 3000), 30, 400)
    assert (large.how, large.reason) == (runner.MEMORY_LIMIT, "over 400 MB")
    assert 400 < large.peak < 3000


@pytest.mark.parametrize(
    ("task", "how", "reason"),
    [
        (hogs.die, runner.DIED, "exit code 7"),
        (hogs.fail, runner.CRASHED, "ZeroDivisionError: by zero"),
        (hogs.fail_unreadably, runner.CRASHED, "UnreadableError: no at there"),
        (partial(hogs.refuse, "nowhere"), runner.REFUSED, "nowhere"),
        (hogs.wait_for, runner.CRASHED, "TypeError"),
    ],
)
def test_other_ends_are_told(task, how, reason):
    end = run_alone(task, 30, 4000)
    assert end.how == how
    assert reason in end.reason


@pytest.mark.parametrize("count", [0, -1, 1.5, True, "two"])
def test_a_wrong_number_of_workers_is_refused(count):
    with pytest.raises(mo.OptionError, match="workers"):
        Workers(count=count)


def test_a_scheduler_that_is_not_there_is_told():
    pytest.importorskip("distributed")
    with pytest.raises(mo.OptionError, match="scheduler"):
        Workers(dask="nowhere://x")
    with pytest.raises(mo.OptionError, match="not both"):
        Workers(count=2, dask="tcp://127.0.0.1:1")

"""Runs by processes: every task once, whatever becomes of the workers."""

from __future__ import annotations

import os
import signal

import pytest
from scenes import block_on_floor

import masonry_opt as mo
from masonry_opt.studies.endings import DIED, REFUSED
from masonry_opt.studies.many import processes
from masonry_opt.studies.many.engine import MOST_DEATHS, engine
from masonry_opt.studies.many.parameters import Parameters
from masonry_opt.studies.many.runs import COLUMNS, Runner, Study, Task

STUDY = Study(block_on_floor(), "static")
TASKS = [Task({"joints.friction": 0.1 + 0.05 * number}) for number in range(12)]


def without_seconds(rows):
    return {number: row | {"seconds": None} for number, row in rows.items()}


@pytest.fixture(scope="module")
def alone():
    runner = Runner(STUDY)
    return without_seconds({number: runner.run(task) for number, task in enumerate(TASKS)})


def test_a_row_says_what_was_found(alone):
    row = alone[3]
    assert list(row) == ["joints.friction", *COLUMNS]
    assert (row["load_factor"], row["status"]) == (pytest.approx(0.25, abs=1e-8), "optimal")
    assert (row["mechanism"], row["slides"], row["hinges"]) == ("sliding", 1, 0)
    assert (alone[11]["mechanism"], alone[11]["slides"], alone[11]["hinges"]) == ("hinging", 0, 1)
    assert max(row[name] for name in ("equilibrium", "yield", "flow", "complementarity")) < 1e-6


@pytest.mark.parametrize("workers", [1, 2])
def test_rows_are_those_of_one_process(alone, workers):
    with engine(STUDY, workers) as made:
        rows = dict(made.map(iter(TASKS)))
    assert without_seconds(rows) == alone


def test_a_lost_worker_costs_nothing_but_time(alone):
    rows = {}
    with engine(STUDY, 2) as made:
        for number, row in made.map(TASKS):
            assert number not in rows
            rows[number] = row
            if len(rows) in (2, 5):
                os.kill(made._workers[0]._process.pid, signal.SIGKILL)
    assert without_seconds(rows) == alone


def test_a_task_that_kills_its_workers_is_given_up(monkeypatch, alone):
    give, killed = processes._Worker.give, []

    def deadly(self, numbered):
        if numbered[0] == 4:
            killed.append(numbered[0])
            self._process.kill()
            self._process.join()
        give(self, numbered)

    monkeypatch.setattr(processes._Worker, "give", deadly)
    # Tasks with scenes of their own are given one by one: the one under way is the one to blame.
    parameters = Parameters(block_on_floor())
    tasks = [Task(task.values, parameters.at(task.values)) for task in TASKS]
    with engine(Study(None, "static"), 1) as made:
        rows = dict(made.map(tasks))
    assert rows.pop(4)["status"] == DIED
    assert len(killed) == MOST_DEATHS
    assert without_seconds(rows) == {number: row for number, row in alone.items() if number != 4}


def test_what_cannot_be_a_scene_is_a_row():
    row = Runner(STUDY).run(Task({"joints.friction": -1.0}))
    assert (row["status"], row["load_factor"]) == (REFUSED, None)
    assert "joints.friction = -1" in row["message"]
    row = Runner(Study(None, "static")).run(Task({"x": 1.0}, block_on_floor(live=(0.0, 0.0))))
    assert row["status"] == REFUSED


@pytest.mark.parametrize("workers", [0, -1, 1.5, True, "two"])
def test_a_wrong_number_of_workers_is_refused(workers):
    with pytest.raises(mo.OptionError, match="workers"):
        engine(STUDY, workers)


def test_a_scheduler_that_is_not_there_is_told():
    pytest.importorskip("distributed")
    with pytest.raises(mo.OptionError, match="scheduler"):
        engine(STUDY, dask="nowhere://x")
    with pytest.raises(mo.OptionError, match="not both"):
        engine(STUDY, 2, "tcp://127.0.0.1:1")

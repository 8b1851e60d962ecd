"""Tests of runs on a Dask cluster: the table is the same, also if a worker is lost during a run."""

import subprocess
import sys
import time

import pytest
from many.tables import same
from scenes import block_on_floor, small_wall

import masonry_opt as mo

QUIET = {"dashboard_address": None, "silence_logs": "ERROR"}
VARY = {"joints.friction": [0.1 + 0.02 * number for number in range(30)], "block.A.live.x": [1.0, 2.0]}


@pytest.fixture
def distributed():
    """Return the library, which is imported here rather than in every process that collects the tests."""
    return pytest.importorskip("distributed")


@pytest.fixture
def cluster(distributed):
    """Return the address of a scheduler with two workers of one thread, and the processes of the workers."""
    with distributed.LocalCluster(n_workers=0, processes=True, **QUIET) as scheduler:
        command = [sys.executable, "-m", "distributed.cli.dask_worker", scheduler.scheduler_address]
        options = ["--nthreads", "1", "--no-dashboard", "--no-nanny"]
        workers = [
            subprocess.Popen([*command, *options], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
            for _ in range(2)
        ]
        try:
            with distributed.Client(scheduler.scheduler_address, set_as_default=False) as client:
                client.wait_for_workers(2, timeout=120)
            yield scheduler.scheduler_address, workers
        finally:
            for worker in workers:
                worker.kill()
                worker.wait()


@pytest.mark.slow
def test_a_cluster_that_loses_a_worker_ends_in_the_same_table(cluster):
    address, workers = cluster
    expected = mo.sweep(block_on_floor(), VARY, method="static", workers=1)
    seen = []

    def kill_one(done, of):
        seen.append(done)
        if done == 7:
            workers[0].kill()
            workers[0].wait()
            time.sleep(0.5)

    frame = mo.sweep(block_on_floor(), VARY, method="static", dask=address, progress=kill_one)
    assert seen[-1] == len(frame) == 60
    same(frame, expected)


@pytest.mark.slow
def test_threads_of_one_worker_share_no_session(distributed):
    """Each thread has its own session: otherwise one thread would change programs while another solves
    them."""
    wall = small_wall(2, 2)
    vary = {"joints.friction": [0.2 + 0.06 * number for number in range(8)]}
    with distributed.LocalCluster(n_workers=1, threads_per_worker=4, processes=False, **QUIET) as scheduler:
        frame = mo.sweep(wall, vary, dask=scheduler.scheduler_address)
    expected = mo.sweep(wall, vary, workers=1)
    same(frame, expected)


def test_a_scheduler_without_workers_is_told(distributed, monkeypatch):
    monkeypatch.setattr("masonry_opt.studies.runner.SCHEDULER_TIMEOUT", 1)
    with (
        distributed.LocalCluster(n_workers=0, processes=False, **QUIET) as scheduler,
        pytest.raises(mo.OptionError, match="no worker"),
    ):
        mo.sweep(block_on_floor(), VARY, method="static", dask=scheduler.scheduler_address)

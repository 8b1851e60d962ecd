"""Parts of a study in processes: what they return, in whatever order, and how they end."""

from __future__ import annotations

import multiprocessing
import os
import time

import hogs
import pytest

from masonry_opt.errors import CaseError, MasonryError
from masonry_opt.studies import parts
from masonry_opt.studies.parts import in_processes


@pytest.fixture(params=[1, 2], ids=["one core", "two cores"])
def cores(request, monkeypatch):
    monkeypatch.setattr(parts, "cores", lambda: request.param)
    return request.param


@pytest.fixture
def two_cores(monkeypatch):
    monkeypatch.setattr(parts, "cores", lambda: 2)


def test_every_part_is_done_once_and_known_by_its_number(cores):
    found = dict(in_processes(divmod, [(number, 3) for number in range(7)]))
    assert found == {number: divmod(number, 3) for number in range(7)}


def test_parts_run_beside_each_other_and_not_here(two_cores):
    pids = {pid for _, pid in in_processes(os.getpid, [(), (), ()])}
    assert len(pids) == 3
    assert os.getpid() not in pids
    # The first part is begun first and ends last.
    assert [number for number, _ in in_processes(time.sleep, [(0.5,), (0.0,)])] == [1, 0]


def test_an_error_is_the_caller_s_and_ends_the_others(cores):
    with pytest.raises(ZeroDivisionError):
        list(in_processes(divmod, [(1, 0), (1, 0)]))
    with pytest.raises(CaseError, match="nowhere"):
        list(in_processes(hogs.refuse, [("nowhere",), ("nowhere",)]))
    assert multiprocessing.active_children() == []


def test_a_process_that_dies_is_told(two_cores):
    with pytest.raises(MasonryError, match="exit code 7"):
        list(in_processes(hogs.die, [(), ()]))


def test_nothing_goes_on_when_the_caller_is_interrupted(two_cores):
    began = time.perf_counter()
    with pytest.raises(KeyboardInterrupt):  # noqa: PT012
        for _ in in_processes(time.sleep, [(0.0,), (60.0,)]):
            raise KeyboardInterrupt
    assert time.perf_counter() - began < 30
    assert multiprocessing.active_children() == []


def test_the_environment_of_the_caller_is_left_alone(two_cores, monkeypatch):
    monkeypatch.setenv("OMP_NUM_THREADS", "3")
    monkeypatch.delenv("MKL_NUM_THREADS", raising=False)
    assert dict(in_processes(os.getenv, [("OMP_NUM_THREADS",)] * 2)) == {0: "1", 1: "1"}
    assert os.environ["OMP_NUM_THREADS"] == "3"
    assert "MKL_NUM_THREADS" not in os.environ

"""Functions for processes that must be stopped."""

import itertools
import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any, NoReturn

from masonry_opt.errors import CaseError, TimeLimitError


def wait_for(seconds: float, value: object) -> object:
    time.sleep(seconds)
    return value


def hoard(megabytes: int) -> int:
    """Take memory, ten MB at a time, each touched."""
    kept = [b"x" * 10_000_000 for _ in range(megabytes // 10) if not time.sleep(0.005)]
    time.sleep(2)
    return len(kept)


def die() -> NoReturn:
    os._exit(7)


def leave_mark_and_die(folder: Path) -> NoReturn:
    """Die, and be counted."""
    (folder / str(os.getpid())).touch()
    os._exit(7)


_calls = itertools.count(1)  #: Of the function below, in one process.


def die_thrice(folder: Path, task: Callable[[], Any]) -> Any:
    """Make a task, in a process that dies in the midst of its second, until three have died."""
    if next(_calls) == 2 and len(list(folder.iterdir())) < 3:
        (folder / str(os.getpid())).touch()
        os.kill(os.getpid(), signal.SIGKILL)
    return task()


def fail() -> NoReturn:
    raise ZeroDivisionError("by zero")


class UnreadableError(Exception):
    """An error that pickle writes and cannot read again."""

    def __init__(self, what: str, where: str) -> None:
        super().__init__(f"{what} at {where}")


def fail_unreadably() -> NoReturn:
    """Raise what cannot be sent."""
    raise UnreadableError("no", "there")


def refuse(where: str) -> NoReturn:
    raise CaseError(where)


def end_at_the_time_limit(message: str) -> NoReturn:
    raise TimeLimitError(message)


def start_and_sleep(case: Path, *_: object) -> None:
    """A run that says when it starts, and takes a minute."""
    case.with_suffix(".started").touch()
    time.sleep(60)


def environment() -> dict[str, str]:
    """That of a process that imports what tests do."""
    return os.environ | {"PYTHONPATH": os.pathsep.join(sys.path)}


def wait_until(what: Callable[[], bool], process: subprocess.Popen, seconds: float = 120.0) -> None:
    deadline = time.monotonic() + seconds
    while not what():
        assert time.monotonic() < deadline
        assert process.poll() is None, process.stderr.read()
        time.sleep(0.002)


def is_gone(group: int) -> bool:
    """Whether no process of a group is left, in ten seconds."""
    deadline = time.monotonic() + 10
    while time.monotonic() < deadline:
        try:
            os.killpg(group, 0)
        except ProcessLookupError:
            return True
        time.sleep(0.05)
    return False

"""Functions that tests run in processes: they wait, take memory, die or raise errors."""

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
    """Allocate and write memory in steps of ten MB."""
    kept = [b"x" * 10_000_000 for _ in range(megabytes // 10) if not time.sleep(0.005)]
    time.sleep(2)
    return len(kept)


def die() -> NoReturn:
    os._exit(7)


def leave_mark_and_die(folder: Path) -> NoReturn:
    """Create a file named by the process id, and end the process with code 7."""
    (folder / str(os.getpid())).touch()
    os._exit(7)


_calls = itertools.count(1)  #: Number of the next call of ``die_thrice`` in this process.


def die_thrice(folder: Path, task: Callable[[], Any]) -> Any:
    """Run a task, but kill the process at its second task, until three processes have died."""
    if next(_calls) == 2 and len(list(folder.iterdir())) < 3:
        (folder / str(os.getpid())).touch()
        os.kill(os.getpid(), signal.SIGKILL)
    return task()


def fail() -> NoReturn:
    raise ZeroDivisionError("by zero")


class UnreadableError(Exception):
    """An error that pickle can write but not read."""

    def __init__(self, what: str, where: str) -> None:
        super().__init__(f"{what} at {where}")


def fail_unreadably() -> NoReturn:
    """Raise an error that cannot be sent to another process."""
    raise UnreadableError("no", "there")


def refuse(where: str) -> NoReturn:
    raise CaseError(where)


def end_at_the_time_limit(message: str) -> NoReturn:
    raise TimeLimitError(message)


def start_and_sleep(case: Path, *_: object) -> None:
    """Create a file with the suffix ``.started``, and sleep for a minute."""
    case.with_suffix(".started").touch()
    time.sleep(60)


def environment() -> dict[str, str]:
    """Return the environment of a process that can import the same modules as the tests."""
    return os.environ | {"PYTHONPATH": os.pathsep.join(sys.path)}


def wait_until(what: Callable[[], bool], process: subprocess.Popen, seconds: float = 120.0) -> None:
    deadline = time.monotonic() + seconds
    while not what():
        assert time.monotonic() < deadline
        assert process.poll() is None, process.stderr.read()
        time.sleep(0.002)


def is_gone(group: int) -> bool:
    """Return True if all processes of a group have ended within ten seconds."""
    deadline = time.monotonic() + 10
    while time.monotonic() < deadline:
        try:
            os.killpg(group, 0)
        except ProcessLookupError:
            return True
        time.sleep(0.05)
    return False

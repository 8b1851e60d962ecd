"""Runs a function in a process of its own, within limits of time and memory, on one thread.

Not by the engine of :mod:`~masonry_opt.studies.many.engine`, whose workers make many runs, several at once,
and keep programs between them: seconds and memory would not be the run's own, no limit would end one run
alone, and what a solver leaves behind would meet the next.
"""

from __future__ import annotations

import os
import time
from collections.abc import Callable
from dataclasses import dataclass
from multiprocessing.connection import Connection
from pathlib import Path
from typing import Any

from masonry_opt.errors import MasonryError
from masonry_opt.studies.endings import CRASHED, DIED, REFUSED
from masonry_opt.studies.process import CONTEXT, settle_in, started

#: How a process can end beside :mod:`~masonry_opt.studies.endings`.
FINISHED, TIME_LIMIT, MEMORY_LIMIT = "finished", "time limit", "memory limit"

#: Seconds between two looks at a process's memory.
_LOOK = 0.02


@dataclass(frozen=True)
class Ended:
    """How a process ended.

    Attributes
    ----------
    how: one of FINISHED, TIME_LIMIT, MEMORY_LIMIT, REFUSED (a MasonryError), CRASHED (any other
        error), DIED (without a word).
    reason: in words; "" if it finished.
    value: what the function returned; None unless it finished.
    seconds: from start to end of the process.
    peak: largest memory seen, in MB (10⁶ bytes), the libraries' own included.
    """

    how: str
    reason: str
    value: Any
    seconds: float
    peak: float


def run_limited(
    function: Callable[..., Any], arguments: tuple[Any, ...], time_limit: float, memory_limit: float
) -> Ended:
    """Call an importable function in its own process.

    Parameters
    ----------
    time_limit: seconds after which the process is killed.
    memory_limit: MB of resident memory above which it is killed (where the system has /proc).
    """
    receiver, sender = CONTEXT.Pipe(duplex=False)
    process = started(_call, (sender, function, arguments))
    sender.close()
    start, peak = time.perf_counter(), 0.0
    try:
        while True:
            try:
                if receiver.poll(_LOOK):
                    how, reason, value, own_peak = receiver.recv()
                    return Ended(how, reason, value, time.perf_counter() - start, max(peak, own_peak))
            except EOFError:
                process.join()
                word = f"without a word (exit code {process.exitcode})"
                return Ended(DIED, word, None, time.perf_counter() - start, peak)
            peak, seconds = max(peak, _resident(process.pid)), time.perf_counter() - start
            if seconds > time_limit:
                return Ended(TIME_LIMIT, f"over {time_limit:g} s", None, seconds, peak)
            if peak > memory_limit:
                return Ended(MEMORY_LIMIT, f"over {memory_limit:g} MB", None, seconds, peak)
    finally:
        process.kill()
        process.join()
        receiver.close()


def _call(sender: Connection, function: Callable[..., Any], arguments: tuple[Any, ...]) -> None:
    """In the process: one core, no output, every end reported."""
    settle_in()
    if hasattr(os, "sched_setaffinity"):
        os.sched_setaffinity(0, {max(os.sched_getaffinity(0))})
    how, reason, value = FINISHED, "", None
    try:
        value = function(*arguments)
    except MasonryError as error:
        how, reason = REFUSED, str(error)
    except MemoryError:
        how, reason = MEMORY_LIMIT, "no memory left"
    except BaseException as error:  # whatever it is, it is the run's result
        how, reason = CRASHED, f"{type(error).__name__}: {error}"
    sender.send((how, reason, value, _peak()))


def _resident(pid: int | None) -> float:
    """Resident memory of a process in MB; 0 where the system does not tell."""
    try:
        pages = int(Path(f"/proc/{pid}/statm").read_text().split()[1])
    except (OSError, IndexError, ValueError):
        return 0.0
    return pages * os.sysconf("SC_PAGE_SIZE") / 1e6


def _peak() -> float:
    """Largest resident memory of this process in MB; 0 where the system does not tell."""
    # Not ru_maxrss: a forked process inherits its parent's.
    try:
        status = Path("/proc/self/status").read_text()
    except OSError:
        return 0.0
    return next((float(line.split()[1]) for line in status.splitlines() if "VmHWM" in line), 0.0) * 1.024e-3

"""Processes that studies run in: forked from a server that has imported the package and done nothing else
(the standard library's "forkserver"), where starting one takes milliseconds; a new interpreter takes seconds.
"""

from __future__ import annotations

import contextlib
import multiprocessing
import os
import signal
import sys
import threading
from collections.abc import Callable, Iterator
from multiprocessing.context import BaseContext
from multiprocessing.process import BaseProcess
from types import ModuleType
from typing import Any

#: Set before the server starts: libraries read them when they are imported.
_ONE_THREAD = dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"), "1")

#: What the server imports: ``solve``, and with its methods the modelling languages, which it imports late.
_PRELOADED = (
    "masonry_opt.session",
    "masonry_opt.methods.bracket.bracket",
    "masonry_opt.methods.mpec",
    "masonry_opt.studies.compare.worker",
)

#: Windows has no such server.
_HOW = "forkserver" if "forkserver" in multiprocessing.get_all_start_methods() else "spawn"

#: Where pipes come from.
CONTEXT: BaseContext = multiprocessing.get_context(_HOW)


def started(function: Callable[..., None], arguments: tuple[Any, ...]) -> BaseProcess:
    """A process that calls an importable function, its libraries on one thread each."""
    CONTEXT.set_forkserver_preload(list(_PRELOADED))
    process: BaseProcess = CONTEXT.Process(target=function, args=arguments, daemon=True)  # type: ignore[attr-defined]
    with _main_hidden(), _one_thread():
        _start_server()
        process.start()
    return process


@contextlib.contextmanager
def _one_thread() -> Iterator[None]:
    """Within it processes that begin have libraries on one thread; this one's environment is its user's."""
    before = {name: os.environ.get(name) for name in _ONE_THREAD}
    os.environ.update(_ONE_THREAD)
    try:
        yield
    finally:
        for name, value in before.items():
            if value is None:
                del os.environ[name]
            else:
                os.environ[name] = value


def _start_server() -> None:
    """Start the server, out of the reach of Ctrl-C, which would end it in a traceback."""
    if _HOW != "forkserver":
        return
    from multiprocessing import forkserver

    if threading.current_thread() is not threading.main_thread():
        forkserver.ensure_running()
        return
    before = signal.signal(signal.SIGINT, signal.SIG_IGN)
    try:
        forkserver.ensure_running()
    finally:
        signal.signal(signal.SIGINT, before)


def settle_in() -> None:
    """To be called first in a process: it writes nothing, and its parent decides when it ends."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    silence = os.open(os.devnull, os.O_WRONLY)
    for stream in (1, 2):
        os.dup2(silence, stream)


def cores() -> int:
    """How many cores this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


@contextlib.contextmanager
def ended_by_kill() -> Iterator[None]:
    """Within it `kill` and `timeout` do what Ctrl-C does: else runs under way would go on alone."""
    before = signal.signal(signal.SIGTERM, signal.default_int_handler)
    try:
        yield
    finally:
        signal.signal(signal.SIGTERM, before)


@contextlib.contextmanager
def _main_hidden() -> Iterator[None]:
    """Within it a new process imports nothing of the main program: a script without a main guard would
    start its study again there."""
    main = sys.modules["__main__"]
    sys.modules["__main__"] = ModuleType("__main__")
    try:
        yield
    finally:
        sys.modules["__main__"] = main

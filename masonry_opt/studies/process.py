"""Start of worker processes: forked from a server that has imported the package (the standard library's
"forkserver"), which takes milliseconds; a new interpreter takes seconds.
"""

import contextlib
import multiprocessing
import os
import signal
import sys
import threading
from collections.abc import Iterator, Mapping, MutableMapping
from types import ModuleType
from typing import Any

#: Set before the server starts: libraries read them when they are imported.
_ONE_THREAD = dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"), "1")

#: Modules that the server imports: ``solve``, and methods, whose modelling languages are imported late.
_PRELOADED = (
    "masonry_opt.analysis",
    "masonry_opt.methods.bracket.bracket",
    "masonry_opt.methods.mpec",
    "masonry_opt.studies.compare.runs",
    "masonry_opt.studies.runner",
)

#: Windows has no such server.
_HOW = "forkserver" if "forkserver" in multiprocessing.get_all_start_methods() else "spawn"
_STANDARD: Any = multiprocessing.get_context(_HOW)

_STARTING = threading.Lock()  #: Processes may be started by several threads.


class _Process(_STANDARD.Process):  # type: ignore[misc]  # which class it is depends on the system
    def start(self) -> None:
        # The file of the main program, which a new process would import, is hidden; its names stay visible.
        hidden = ModuleType("__main__")
        with _STARTING:
            vars(hidden).update(vars(sys.modules["__main__"]) | {"__spec__": None, "__file__": None})
            with _replaced(sys.modules, {"__main__": hidden}), _replaced(os.environ, _ONE_THREAD):
                _start_server()
                super().start()


class Context(type(_STANDARD)):  # type: ignore[misc]
    """A context of multiprocessing whose processes (all made so far) run libraries on one thread, and do not
    import the main program: a script without a main guard would start its study again there."""

    def __init__(self) -> None:
        super().__init__()
        self.processes: list[Any] = []

    def Process(self, **keys: Any) -> _Process:
        """A process, not started yet."""
        self.processes.append(_Process(**keys))
        return self.processes[-1]


@contextlib.contextmanager
def _replaced(values: MutableMapping[str, Any], others: Mapping[str, Any]) -> Iterator[None]:
    """Others in place of some values, which are restored."""
    before = {name: values[name] for name in others if name in values}
    values.update(others)
    try:
        yield
    finally:
        for name in others.keys() - before.keys():
            del values[name]
        values.update(before)


def _start_server() -> None:
    """Start the server if it does not run. Ctrl-C must not reach it, which only the main thread can say; nor
    may its processes write errors: one whose study is interrupted before it runs would show a traceback."""
    if _HOW != "forkserver":
        return
    from multiprocessing import forkserver

    _STANDARD.set_forkserver_preload(list(_PRELOADED))
    with contextlib.ExitStack() as before:
        if threading.current_thread() is threading.main_thread():
            before.callback(signal.signal, signal.SIGINT, signal.signal(signal.SIGINT, signal.SIG_IGN))
        before.callback(os.close, kept := os.dup(2))
        before.callback(os.dup2, kept, 2)
        _silence(2)
        forkserver.ensure_running()


def prepare_process() -> None:
    """Prepare a new process: it ignores Ctrl-C, ends at SIGTERM, and writes nothing."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    signal.signal(signal.SIGTERM, signal.SIG_DFL)
    _silence(1, 2)


def _silence(*streams: int) -> None:
    nowhere = os.open(os.devnull, os.O_WRONLY)
    for stream in streams:
        os.dup2(nowhere, stream)
    os.close(nowhere)


def cores() -> int:
    """Number of cores that this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


@contextlib.contextmanager
def ended_by_kill() -> Iterator[None]:
    """Within it `kill` and `timeout` act as Ctrl-C does: else runs under way would go on alone."""
    before = signal.signal(signal.SIGTERM, signal.default_int_handler)
    try:
        yield
    finally:
        signal.signal(signal.SIGTERM, before)

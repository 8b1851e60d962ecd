"""Work in processes of its own: each forked from a server that has imported the package, on one thread.

Starting one takes milliseconds, where a new interpreter takes seconds (the standard library's "forkserver").
"""

from __future__ import annotations

import contextlib
import multiprocessing
import os
import signal
import sys
import traceback
from collections import deque
from collections.abc import Callable, Iterator, Sequence
from multiprocessing.connection import Connection, wait
from multiprocessing.process import BaseProcess
from types import ModuleType
from typing import Any

from masonry_opt.errors import MasonryError

#: Set before the server starts: libraries read them when they are imported.
_ONE_THREAD = dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"), "1")

#: What the server imports: ``solve``, and with its methods the modelling languages, which it imports late.
_PRELOADED = ["masonry_opt.analysis", "masonry_opt.methods.bracket.method", "masonry_opt.methods.mpec"]

_CONTEXT = multiprocessing.get_context("forkserver")


def start(
    function: Callable[..., None], arguments: tuple[Any, ...], preload: Sequence[str] = ()
) -> tuple[BaseProcess, Connection]:
    """Start an importable function in a process, with the end of a pipe to send on before its arguments.

    Parameters
    ----------
    preload: modules that the server imports beside the methods, if it has not started.

    Returns
    -------
    The process, and the other end of the pipe.
    """
    os.environ.update(_ONE_THREAD)
    _CONTEXT.set_forkserver_preload([*_PRELOADED, *preload])
    receiver, sender = _CONTEXT.Pipe(duplex=False)
    process = _CONTEXT.Process(target=function, args=(sender, *arguments), daemon=True)
    with _main_hidden():
        process.start()
    sender.close()
    return process, receiver


def in_processes(function: Callable[..., Any], parts: Sequence[tuple[Any, ...]]) -> Iterator[tuple[int, Any]]:
    """Call an importable function on each part's arguments, as many at once as there are cores to use; with
    one core in this process, one after another.

    Yields the number of each part and what the function returned, as they come. What is left is killed when
    the caller stops asking, by Ctrl-C too.

    Raises
    ------
    MasonryError
        If a process died without a word; else whatever the function raised.
    """
    cores = _cores()
    if cores == 1 or len(parts) == 1:
        for number, arguments in enumerate(parts):
            yield number, function(*arguments)
        return
    waiting = deque(enumerate(parts))
    running: dict[Any, tuple[int, BaseProcess]] = {}
    try:
        while waiting or running:
            while waiting and len(running) < cores:
                number, arguments = waiting.popleft()
                process, receiver = start(_send, (function, arguments), [function.__module__])
                running[receiver] = number, process
            for ready in wait(list(running)):
                yield _received(ready, *running[ready])
                del running[ready]
    finally:
        for _, process in running.values():
            process.kill()
            process.join()


def _received(receiver: Any, number: int, process: BaseProcess) -> tuple[int, Any]:
    try:
        error, value = receiver.recv()
    except EOFError:
        process.join()
        raise MasonryError(
            f"a process ended without a word (exit code {process.exitcode}): is there enough memory?"
        ) from None
    process.join()
    if error is not None:
        raise error
    return number, value


def _send(sender: Connection, function: Callable[..., Any], arguments: tuple[Any, ...]) -> None:
    """In the process: what the function returned, or the error that it raised."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # the parent decides
    error: Exception | None = None
    value = None
    try:
        value = function(*arguments)
    except Exception as raised:
        error = raised
        if not isinstance(raised, MasonryError):
            error.add_note(traceback.format_exc())
    sender.send((error, value))


def _cores() -> int:
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


@contextlib.contextmanager
def _main_hidden() -> Iterator[None]:
    """Within it a new process imports nothing of the main program: a script without a main guard would
    start its work again there."""
    main = sys.modules["__main__"]
    sys.modules["__main__"] = ModuleType("__main__")
    try:
        yield
    finally:
        sys.modules["__main__"] = main

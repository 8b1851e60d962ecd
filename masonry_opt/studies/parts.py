"""Parts of one study, each in a process of its own.

Not by the engine of :mod:`~masonry_opt.studies.many.engine`, which makes rows of scenes alone: a part is any
function, and an error that it raises is its caller's.
"""

from __future__ import annotations

import signal
import traceback
from collections import deque
from collections.abc import Callable, Iterator, Sequence
from multiprocessing.connection import Connection, wait
from multiprocessing.process import BaseProcess
from typing import Any

from masonry_opt.errors import MasonryError
from masonry_opt.studies.process import CONTEXT, cores, started


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
    most = cores()
    if most == 1 or len(parts) == 1:
        for number, arguments in enumerate(parts):
            yield number, function(*arguments)
        return
    waiting = deque(enumerate(parts))
    running: dict[Any, tuple[int, BaseProcess]] = {}
    try:
        while waiting or running:
            while waiting and len(running) < most:
                number, arguments = waiting.popleft()
                receiver, sender = CONTEXT.Pipe(duplex=False)
                process = started(_send, (sender, function, arguments))
                sender.close()
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

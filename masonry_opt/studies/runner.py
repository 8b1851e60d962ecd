"""Tasks in processes of this machine or on a Dask cluster. A task that dies, or exceeds its limits of time or
memory, ends alone. Processes are forked from a server that has imported the package (the standard library's
"forkserver"), which takes milliseconds; a new interpreter takes seconds."""

import contextlib
import multiprocessing
import os
import signal
import sys
import threading
import time
from collections.abc import Callable, Iterable, Iterator, Mapping, MutableMapping
from concurrent.futures import FIRST_COMPLETED, Future, wait
from dataclasses import dataclass, replace
from functools import partial
from numbers import Integral
from pathlib import Path
from types import ModuleType
from typing import Any

import psutil
from pebble import ProcessPool

from masonry_opt.errors import MasonryError, OptionError

#: Ends of a task: a value; a MasonryError; any other error; the death of its process; a limit.
FINISHED, REFUSED, CRASHED, DIED = "finished", "refused", "crashed", "died"
TIME_LIMIT, MEMORY_LIMIT = "time limit", "memory limit"
#: Ends without a value: nothing is known of what the task was to solve.
UNSOLVED = (REFUSED, CRASHED, DIED, TIME_LIMIT, MEMORY_LIMIT)
MOST_DEATHS = 3  #: Workers that a task may kill before it is given up.
_LOOK = 0.02  #: Seconds between two looks at a process's memory.
_AHEAD = 3  #: Tasks handed out for each worker: none waits, and memory does not grow with their number.
PATIENCE = 10  #: Seconds in which a Dask scheduler must answer.
#: Set before the server starts: libraries read them when they are imported.
_ONE_THREAD = dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"), "1")
#: Modules that the server imports: runs, and methods, whose modelling languages are imported late.
_PRELOADED = ("studies.compare.runs", "methods.bracket.bracket", "methods.mpec")
#: Windows has no such server.
_HOW = "forkserver" if "forkserver" in multiprocessing.get_all_start_methods() else "spawn"
_STANDARD: Any = multiprocessing.get_context(_HOW)
_STARTING = threading.Lock()  #: Processes may be started by several threads.


@dataclass(frozen=True)
class TaskEnd:
    """How a task ended (FINISHED, ...), and why in words; its value if it finished; and the largest memory of
    its process so far, in MB (10⁶ bytes), libraries included."""

    how: str
    reason: str = ""
    value: Any = None
    seconds: float = 0.0
    peak: float = 0.0

    @property
    def found(self) -> Any:
        """Its value. Raises MasonryError, or RuntimeError if it crashed, if it has none."""
        if self.how != FINISHED:
            kind = RuntimeError if self.how == CRASHED else MasonryError
            raise kind(f"{self.how}: {self.reason}")
        return self.value


Task = Callable[[], Any]  #: A function of a module, such as functools.partial makes one without arguments.


class Workers(contextlib.AbstractContextManager["Workers"]):
    """Workers that make tasks: ``count`` processes, by default as many as the cores that this process may
    use, or those of the Dask scheduler at this address; they end on leaving. Raises OptionError if ``count``
    is wrong, both are given, or the scheduler cannot be reached."""

    def __init__(self, count: int | None = None, dask: str | None = None) -> None:
        if dask is not None and count is not None:
            raise OptionError("give 'workers' or 'dask', not both: the cluster has workers of its own")
        count = _cores() if count is None else whole("workers", count, 1)
        self._engine = Processes(count) if dask is None else _Cluster(dask)

    def __exit__(self, *_: object) -> None:
        self._engine.close()

    def map(self, tasks: Iterable[tuple[Any, Task]]) -> Iterator[tuple[Any, TaskEnd]]:
        """Names of the tasks, such as numbers, and their ends, as they come. Tasks are taken from the
        iterable as workers become free; an error that it raises is raised here when the tasks before have
        ended. A task whose worker died is made again, up to ``MOST_DEATHS`` times."""
        coming, failed = iter(tasks), None
        under_way: dict[Future[TaskEnd], tuple[Any, Task, int]] = {}
        while True:
            room = self._engine.room
            while len(under_way) < room:
                try:
                    name, task = next(coming)
                except StopIteration:
                    break
                except Exception as error:
                    failed = error
                    break
                under_way[self._engine.submit(task)] = name, task, 1
            if not under_way:
                break
            for future in wait(under_way, return_when=FIRST_COMPLETED).done:
                name, task, tried = under_way.pop(future)
                end = _end_of(future)
                if end.how == DIED and tried < MOST_DEATHS:
                    under_way[self._engine.submit(task)] = name, task, tried + 1
                else:
                    yield name, end
        if failed:
            raise failed


def whole(name: str, value: Any, least: int) -> int:
    """A whole number that is given by a name. Raises OptionError if it is none, or less."""
    if not isinstance(value, Integral) or isinstance(value, bool) or value < least:
        raise OptionError(f"{name} must be a whole number, {least} or more (found {value!r})")
    return int(value)


def run_alone(task: Task, time_limit: float, memory_limit: float) -> TaskEnd:
    """Make a task in a new process, on one core, which is killed after so many seconds, or above so many MB
    of resident memory."""
    start, peak = time.perf_counter(), 0.0
    with contextlib.closing(Processes(1)) as workers:
        future = workers.submit(task, time_limit)
        while peak <= memory_limit and not wait([future], _LOOK).done:
            for process in workers.context.processes:
                with contextlib.suppress(psutil.Error):  # it has ended
                    peak = max(peak, psutil.Process(process.pid).memory_info().rss / 1e6)
        large = TaskEnd(MEMORY_LIMIT, f"over {memory_limit:g} MB")
        end = large if peak > memory_limit else _end_of(future)
        return replace(end, seconds=end.seconds or time.perf_counter() - start, peak=max(peak, end.peak))


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

    _STANDARD.set_forkserver_preload([f"masonry_opt.{name}" for name in _PRELOADED])
    with contextlib.ExitStack() as before:
        if threading.current_thread() is threading.main_thread():
            before.callback(signal.signal, signal.SIGINT, signal.signal(signal.SIGINT, signal.SIG_IGN))
        before.callback(os.close, kept := os.dup(2))
        before.callback(os.dup2, kept, 2)
        _silence(2)
        forkserver.ensure_running()


def _prepare_process() -> None:
    """Prepare a new process, in which Pebble ignores Ctrl-C: it ends at SIGTERM, and writes nothing."""
    signal.signal(signal.SIGTERM, signal.SIG_DFL)
    _silence(1, 2)


def _silence(*streams: int) -> None:
    nowhere = os.open(os.devnull, os.O_WRONLY)
    for stream in streams:
        os.dup2(nowhere, stream)
    os.close(nowhere)


def _cores() -> int:
    """Number of cores that this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


class Processes:
    """Processes of this machine, in one pool of Pebble's."""

    def __init__(self, count: int) -> None:
        self.context, self.room = Context(), _AHEAD * count
        self._open = partial(ProcessPool, count, initializer=_prepare_process, context=self.context)
        self._pool: Any = self._open()

    def submit(self, task: Task, time_limit: float | None = None) -> Future[TaskEnd]:
        if not self._pool.active:  # a process that dies idle breaks the pool
            self.close()
            self._pool = self._open()
        return self._pool.schedule(_made, (task,), timeout=time_limit)

    def close(self) -> None:
        self._pool.stop()
        self._pool.join()


class _Cluster:
    """The workers of a Dask scheduler."""

    def __init__(self, address: str) -> None:
        try:
            import distributed
        except ImportError:
            raise OptionError("--dask needs: pip install '.[dask]'") from None
        try:
            self._client = distributed.Client(address, timeout=PATIENCE, set_as_default=False)
        except (OSError, ValueError) as error:
            raise OptionError(f"no Dask scheduler answers at '{address}': {error}") from None
        self._address, self._executor = address, self._client.get_executor(pure=False)

    def submit(self, task: Task) -> Future[TaskEnd]:
        try:
            self._client.wait_for_workers(1, timeout=PATIENCE)
        except TimeoutError:
            at = self._address
            none = f"the Dask scheduler at '{at}' has no worker: start one with 'dask worker {at}'"
            raise OptionError(f"{none}; runs already made are kept where 'out' is given") from None
        return self._executor.submit(_made, task)

    @property
    def room(self) -> int:
        return _AHEAD * max(1, sum(self._client.nthreads().values()))

    def close(self) -> None:
        self._client.close()


def _end_of(future: Future[TaskEnd]) -> TaskEnd:
    """The end that a worker sent, or why it sent none."""
    if future.cancelled():
        return TaskEnd(DIED, "its workers are gone")
    error = future.exception()
    if error is None:
        return future.result()
    if isinstance(error, TimeoutError):
        return TaskEnd(TIME_LIMIT, f"over {error.args[-1]:g} s")
    code = getattr(error, "exitcode", None)
    how = repr(error) if code is None else f"its process ended (exit code {code})"
    return TaskEnd(DIED, f"{how}; is there enough memory?")


def _made(task: Task) -> TaskEnd:
    """In a worker: make a task, and return its end."""
    began = time.perf_counter()
    try:
        end = TaskEnd(FINISHED, value=task())
    except MasonryError as error:
        end = TaskEnd(REFUSED, str(error))
    except MemoryError:
        end = TaskEnd(MEMORY_LIMIT, "no memory left")
    except Exception as error:  # it ends this task alone
        end = TaskEnd(CRASHED, f"{type(error).__name__}: {error}")
    return replace(end, seconds=time.perf_counter() - began, peak=_peak())


def _peak() -> float:
    """Largest resident memory of this process in MB; 0 where the system does not tell."""
    # Not ru_maxrss: a forked process inherits its parent's.
    with contextlib.suppress(OSError):
        status = Path("/proc/self/status").read_text().splitlines()
        return next((float(line.split()[1]) for line in status if "VmHWM" in line), 0.0) * 1.024e-3
    return 0.0

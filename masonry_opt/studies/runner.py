"""Run tasks in worker processes of this machine or on a Dask cluster.

A task that crashes its process, or exceeds its limit of time or memory, does not affect other tasks. On
this machine processes are forked from a server that has imported the package (the start method "forkserver"
of the standard library). A fork takes milliseconds, a new interpreter takes seconds.
"""

import contextlib
import multiprocessing
import os
import signal
import sys
import threading
import time
from collections.abc import Callable, Iterable, Iterator, Mapping, MutableMapping, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, wait
from dataclasses import dataclass, replace
from functools import partial
from numbers import Integral
from pathlib import Path
from types import ModuleType
from typing import Any

import psutil
from pebble import ProcessPool

from masonry_opt.errors import MasonryError, OptionError, TimeLimitError
from masonry_opt.threads import ONE_THREAD

FINISHED = "finished"  #: Outcome of a task that returned a value.
REFUSED = "refused"  #: Outcome of a task that raised a MasonryError.
CRASHED = "crashed"  #: Outcome of a task that raised an error other than a MasonryError.
DIED = "died"  #: Outcome of a task whose process ended without a result.
TIME_LIMIT = "time limit"  #: Outcome of a task that exceeded its time limit.
MEMORY_LIMIT = "memory limit"  #: Outcome of a task whose process used too much memory.
#: Outcomes of a task that has no value.
UNSOLVED = (REFUSED, CRASHED, DIED, TIME_LIMIT, MEMORY_LIMIT)
MOST_DEATHS = 3  #: Largest number of attempts to run a task whose worker process dies.
_MEMORY_INTERVAL = 0.02  #: Seconds between two measurements of the memory of a process.
#: Largest number of unfinished tasks per worker that are submitted at one time. With fewer tasks, workers may
#: be idle. With more tasks, more memory is used.
_TASKS_PER_WORKER = 3
#: Time in seconds within which a Dask scheduler must answer and must have a worker. After this time, an
#: OptionError is raised.
SCHEDULER_TIMEOUT = 10
#: Modules that the fork server imports for ``Workers``, so that the worker processes need not import them.
_MODULES_OF_WORKERS = ("studies.many.runs", "methods.coulomb.method")
#: Modules that the fork server imports in advance for ``run_alone``. They import Pyomo and CVXPY, which would
#: take a second in each process.
_MODULES_OF_RUN_ALONE = ("studies.compare.runs", "methods.bracket.bracket", "methods.mpec")
#: Start method of processes. Windows has no fork server, so processes are spawned on Windows.
_START_METHOD = "forkserver" if "forkserver" in multiprocessing.get_all_start_methods() else "spawn"
_PROCESS_CONTEXT: Any = multiprocessing.get_context(_START_METHOD)
#: Lock for starting processes: only one thread at a time may start a process, because each start temporarily
#: changes sys.modules and os.environ.
_START_LOCK = threading.Lock()


@dataclass(frozen=True)
class TaskEnd:
    """Outcome of a task: how it ended, and its value if it finished."""

    how: str  #: kind of outcome: FINISHED, REFUSED, CRASHED, DIED, TIME_LIMIT or MEMORY_LIMIT
    reason: str = ""  #: reason why the task has no value, as text
    value: Any = None  #: value that the task returned
    seconds: float = 0.0  #: duration of the task
    peak: float = 0.0  #: largest resident memory of the task's process so far, in MB (10⁶ bytes)

    @property
    def result(self) -> Any:
        """Value that the task returned.

        Raises RuntimeError if the task raised an error other than a MasonryError. Raises MasonryError if the
        task has no value for another reason: see ``how``.
        """
        if self.how != FINISHED:
            kind = RuntimeError if self.how == CRASHED else MasonryError
            raise kind(f"{self.how}: {self.reason}")
        return self.value


Task = Callable[[], Any]  #: Picklable function without arguments, such as a functools.partial.


class Workers(contextlib.AbstractContextManager["Workers"]):
    """Context manager that runs tasks in worker processes, which end when the ``with`` block ends.

    Raises OptionError if ``count`` is wrong, if both parameters are given, or if the Dask scheduler cannot be
    reached.

    Parameters
    ----------
    count: Number of processes; by default the number of cores that this process may use.
    dask: Address of a Dask scheduler. Its workers run the tasks instead of new processes on this machine, and
        continue to run after the ``with`` block.
    """

    def __init__(self, count: int | None = None, dask: str | None = None) -> None:
        if dask is not None and count is not None:
            raise OptionError("use 'workers' or 'dask', not both: a Dask cluster has its own workers")
        count = _cores() if count is None else whole("workers", count, 1)
        self._engine = Processes(count, _MODULES_OF_WORKERS) if dask is None else _Cluster(dask)

    def __exit__(self, *_: object) -> None:
        self._engine.close()

    def map(self, tasks: Iterable[tuple[Any, Task]]) -> Iterator[tuple[Any, TaskEnd]]:
        """Run named tasks, and return the name and the outcome of each task as soon as it ends.

        Tasks are taken from the iterable as workers become free. An error that the iterable raises is raised
        here after all earlier tasks have ended. A task whose worker died is repeated, and runs at most
        ``MOST_DEATHS`` times.
        """
        remaining, failure = iter(tasks), None
        running: dict[Future[TaskEnd], tuple[Any, Task, int]] = {}
        while True:
            capacity = self._engine.room
            while len(running) < capacity:
                try:
                    name, task = next(remaining)
                except StopIteration:
                    break
                except Exception as error:
                    failure = error
                    break
                running[self._engine.submit(task)] = name, task, 1
            if not running:
                break
            for future in wait(running, return_when=FIRST_COMPLETED).done:
                name, task, attempts = running.pop(future)
                end = _end_of(future)
                if end.how == DIED and attempts < MOST_DEATHS:
                    running[self._engine.submit(task)] = name, task, attempts + 1
                else:
                    yield name, end
        if failure:
            raise failure


def whole(name: str, value: Any, least: int) -> int:
    """Return a value as an int, or raise OptionError if it is not a whole number ≥ ``least``."""
    if not isinstance(value, Integral) or isinstance(value, bool) or value < least:
        raise OptionError(f"{name} must be a whole number, {least} or more (found {value!r})")
    return int(value)


def run_alone(task: Task, time_limit: float, memory_limit: float) -> TaskEnd:
    """Run a task in a new process with one thread, and return the outcome of the task.

    The process is killed if it takes longer than ``time_limit`` seconds, or if its resident memory exceeds
    ``memory_limit`` MB.
    """
    start, peak = time.perf_counter(), 0.0
    with contextlib.closing(Processes(1, _MODULES_OF_RUN_ALONE)) as workers:
        future = workers.submit(task, time_limit)
        while peak <= memory_limit and not wait([future], _MEMORY_INTERVAL).done:
            for process in workers.context.processes:
                with contextlib.suppress(psutil.Error):  # the process has ended
                    peak = max(peak, psutil.Process(process.pid).memory_info().rss / 1e6)
        too_large = TaskEnd(MEMORY_LIMIT, f"over {memory_limit:g} MB")
        end = too_large if peak > memory_limit else _end_of(future)
        return replace(end, seconds=end.seconds or time.perf_counter() - start, peak=max(peak, end.peak))


class _Process(_PROCESS_CONTEXT.Process):  # type: ignore[misc]  # the base class depends on the operating system
    """Worker process that does not import the main script. Its numerical libraries use one thread."""

    def start(self) -> None:
        """Start the process. The file of the main script is hidden, so the process does not import it."""
        hidden = ModuleType("__main__")
        with _START_LOCK:
            vars(hidden).update(vars(sys.modules["__main__"]) | {"__spec__": None, "__file__": None})
            with _replaced(sys.modules, {"__main__": hidden}), _replaced(os.environ, ONE_THREAD):
                _start_server()
                super().start()


class Context(type(_PROCESS_CONTEXT)):  # type: ignore[misc]
    """Multiprocessing context whose processes do not import the main script.

    A script without a main guard would start its study again in every process that imports it.
    """

    def __init__(self) -> None:
        super().__init__()
        self.processes: list[Any] = []  #: all processes made so far

    def Process(self, **keys: Any) -> _Process:
        """Return a new process without starting it."""
        self.processes.append(_Process(**keys))
        return self.processes[-1]


@contextlib.contextmanager
def _replaced(values: MutableMapping[str, Any], replacements: Mapping[str, Any]) -> Iterator[None]:
    """Replace some values of a mapping within a ``with`` block, and restore them afterwards."""
    before = {name: values[name] for name in replacements if name in values}
    values.update(replacements)
    try:
        yield
    finally:
        for name in replacements.keys() - before.keys():
            del values[name]
        values.update(before)


def _start_server() -> None:
    """Start the fork server if it does not run yet.

    Two settings of this process are changed while the server starts, because the server inherits them, and
    are restored afterwards. Ctrl-C is ignored, which only the main thread can set. Standard error is
    discarded, because a process whose study is interrupted before it begins would write a traceback.
    """
    if _START_METHOD != "forkserver":
        return
    from multiprocessing import forkserver

    with contextlib.ExitStack() as restore:
        if threading.current_thread() is threading.main_thread():
            handler = signal.signal(signal.SIGINT, signal.SIG_IGN)
            restore.callback(signal.signal, signal.SIGINT, handler)
        standard_error = os.dup(2)
        restore.callback(os.close, standard_error)
        restore.callback(os.dup2, standard_error, 2)
        _silence(2)
        forkserver.ensure_running()


def _prepare_process() -> None:
    """Prepare a new process: it ends at the signal SIGTERM, and its output is discarded.

    Pebble lets the process ignore Ctrl-C.
    """
    signal.signal(signal.SIGTERM, signal.SIG_DFL)
    if _START_METHOD == "forkserver":
        # Set the default start method to "fork", because Pyomo creates a lock when it is imported. With
        # another start method, this lock would remain when the process is terminated, and Python would print
        # a warning.
        multiprocessing.set_start_method("fork", force=True)
    _silence(1, 2)


def _silence(*streams: int) -> None:
    """Discard everything that is written to the given file descriptors."""
    null = os.open(os.devnull, os.O_WRONLY)
    for stream in streams:
        os.dup2(null, stream)
    os.close(null)


def _cores() -> int:
    """Return the number of cores that this process may use."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


class Processes:
    """Pool of worker processes on this machine, managed by the library Pebble.

    Parameters
    ----------
    count: Number of processes.
    modules: Modules of the package that the fork server imports when it starts. A server that already runs
        imports no further modules, so its processes import the missing modules themselves.
    """

    def __init__(self, count: int, modules: Sequence[str] = ()) -> None:
        if _START_METHOD == "forkserver":
            _PROCESS_CONTEXT.set_forkserver_preload([f"masonry_opt.{name}" for name in modules])
        self.context, self.room = Context(), _TASKS_PER_WORKER * count
        self._open = partial(ProcessPool, count, initializer=_prepare_process, context=self.context)
        self._pool: Any = self._open()

    def submit(self, task: Task, time_limit: float | None = None) -> Future[TaskEnd]:
        """Submit a task to the pool. A task that runs longer than ``time_limit`` seconds is killed."""
        if not self._pool.active:  # the pool becomes inactive if one of its idle processes dies
            self.close()
            self._pool = self._open()
        return self._pool.schedule(_run, (task,), timeout=time_limit)

    def close(self) -> None:
        """End all processes."""
        self._pool.stop()
        self._pool.join()


class _Cluster:
    """Workers of a Dask scheduler."""

    def __init__(self, address: str) -> None:
        try:
            import distributed
        except ImportError:
            raise OptionError("--dask needs 'distributed': install it with pip install '.[dask]'") from None
        try:
            self._client = distributed.Client(address, timeout=SCHEDULER_TIMEOUT, set_as_default=False)
        except (OSError, ValueError) as error:
            raise OptionError(f"no Dask scheduler answers at '{address}': {error}") from None
        self._address, self._executor = address, self._client.get_executor(pure=False)

    def submit(self, task: Task) -> Future[TaskEnd]:
        """Submit a task to the cluster.

        Raises OptionError if no worker is available within ``SCHEDULER_TIMEOUT``.
        """
        try:
            self._client.wait_for_workers(1, timeout=SCHEDULER_TIMEOUT)
        except TimeoutError:
            raise OptionError(
                f"the Dask scheduler at '{self._address}' has no worker: start one with 'dask worker "
                f"{self._address}'; finished runs are kept if 'out' is set"
            ) from None
        return self._executor.submit(_run, task)

    @property
    def room(self) -> int:
        """Largest number of submitted tasks that may be unfinished at one time."""
        return _TASKS_PER_WORKER * max(1, sum(self._client.nthreads().values()))

    def close(self) -> None:
        """Disconnect from the scheduler."""
        self._client.close()


def _end_of(future: Future[TaskEnd]) -> TaskEnd:
    """Return the outcome that a worker sent, or an outcome with the reason why the worker sent nothing."""
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


def _run(task: Task) -> TaskEnd:
    """Run a task in a worker process, and return its outcome."""
    began = time.perf_counter()
    try:
        end = TaskEnd(FINISHED, value=task())
    except TimeLimitError as error:
        end = TaskEnd(TIME_LIMIT, str(error))
    except MasonryError as error:
        end = TaskEnd(REFUSED, str(error))
    except MemoryError:
        end = TaskEnd(MEMORY_LIMIT, "no memory left")
    except Exception as error:  # an error in one task must not stop the other tasks
        end = TaskEnd(CRASHED, f"{type(error).__name__}: {error}")
    return replace(end, seconds=time.perf_counter() - began, peak=_peak())


def _peak() -> float:
    """Return the largest resident memory of this process in MB, or 0 if the system does not report it."""
    # Read the largest memory from /proc. The value ru_maxrss is not used, because a forked process inherits
    # it from its parent.
    with contextlib.suppress(OSError):
        status = Path("/proc/self/status").read_text().splitlines()
        return next((float(line.split()[1]) for line in status if "VmHWM" in line), 0.0) * 1.024e-3
    return 0.0

"""Runs by the workers of a Dask cluster, the scene scattered to them once."""

from __future__ import annotations

import threading
from collections.abc import Iterable, Iterator
from typing import Any, Self

from masonry_opt.errors import OptionError
from masonry_opt.studies.many.engine import MOST_DEATHS
from masonry_opt.studies.many.runs import Runner, Study, Task, died

#: Tasks that lie ready, for each thread of the cluster: no worker waits, and memory does not grow with tasks.
_AHEAD = 3

#: Seconds in which a scheduler must answer.
_PATIENCE = 10

#: One runner a thread, for the last study that it saw.
_kept = threading.local()


class Cluster:
    """An :class:`~.engine.Engine` on the workers of a scheduler, which stay as they are when it ends.

    Raises OptionError if Dask is not installed or the scheduler cannot be reached.
    """

    def __init__(self, study: Study, address: str) -> None:
        try:
            import distributed
        except ImportError:
            raise OptionError("--dask needs: pip install '.[dask]'") from None
        try:
            self._client = distributed.Client(address, timeout=_PATIENCE, set_as_default=False)
        except (OSError, ValueError) as error:
            raise OptionError(f"no Dask scheduler answers at '{address}': {error}") from None
        self._distributed, self._study, self._address = distributed, study, address
        self._scattered: Any = None

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self._client.close()

    def map(self, tasks: Iterable[Task]) -> Iterator[tuple[int, dict[str, Any]]]:
        """See :meth:`.engine.Engine.map`."""
        coming = enumerate(tasks)
        under_way: dict[Any, tuple[int, Task]] = {}
        deaths: dict[int, int] = {}
        ended = self._distributed.as_completed(loop=self._client.loop)

        def submit(numbered: tuple[int, Task]) -> None:
            future = self._client.submit(_run, self._study_there(), numbered[1], pure=False)
            under_way[future] = numbered
            ended.add(future)

        def feed() -> None:
            while len(under_way) < _AHEAD * max(1, sum(self._client.nthreads().values())):
                numbered = next(coming, None)
                if numbered is None:
                    return
                submit(numbered)

        feed()
        for future in ended:
            number, task = under_way.pop(future)
            if future.status == "finished":
                row = future.result()
                future.release()
                feed()
                yield number, row
                continue
            # Its workers are gone, or those that held the scene.
            deaths[number] = deaths.get(number, 0) + 1
            if deaths[number] < MOST_DEATHS:
                submit((number, task))
                continue
            feed()
            yield number, died(task, f"the cluster lost it {MOST_DEATHS} times: {future.exception()!r}")

    def _study_there(self) -> Any:
        """The study, scattered; again if all the workers that held it are gone."""
        if self._scattered is None or self._scattered.status != "finished":
            try:
                self._client.wait_for_workers(1, timeout=_PATIENCE)
                (self._scattered,) = self._client.scatter([self._study], broadcast=True, hash=False)
            except TimeoutError:
                raise OptionError(
                    f"the Dask scheduler at '{self._address}' has no worker: start one with 'dask worker "
                    f"{self._address}'; runs already made are kept where 'out' is given"
                ) from None
        return self._scattered


def _run(study: Study, task: Task) -> dict[str, Any]:
    """On a worker: the row of a task."""
    if getattr(_kept, "study", None) is not study:
        _kept.study, _kept.runner = study, Runner(study)
    row: dict[str, Any] = _kept.runner.run(task)
    return row

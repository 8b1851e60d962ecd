"""Where many runs are made: processes on this machine, or the workers of a cluster."""

from __future__ import annotations

import os
from collections.abc import Iterable, Iterator
from typing import Any, Protocol, Self

from masonry_opt.errors import OptionError
from masonry_opt.studies.many.runs import Study, Task

#: A run that kills its worker so often is given up.
MOST_DEATHS = 3


class Engine(Protocol):
    """Makes the runs of one study; as a context, ends its workers at last, whatever happens."""

    def map(self, tasks: Iterable[Task]) -> Iterator[tuple[int, dict[str, Any]]]:
        """Numbers of the tasks, from 0, and rows (see :class:`~.runs.Runner`), as they come.

        Tasks are taken as workers become free: they may be made as they are asked for. A run whose worker is
        lost is made again; one that kills three comes as a row whose status is "died".
        """
        ...

    def __enter__(self) -> Self: ...

    def __exit__(self, *_: object) -> None: ...


def engine(study: Study, workers: int | None = None, dask: str | None = None) -> Engine:
    """The engine of a study.

    Parameters
    ----------
    workers: processes; by default as many as this process may use cores.
    dask: address of a scheduler, in place of processes of its own.

    Raises
    ------
    OptionError
        If the number is wrong, both are given, or the scheduler cannot be reached.
    """
    if dask is not None:
        if workers is not None:
            raise OptionError("give 'workers' or 'dask', not both: the cluster has workers of its own")
        from masonry_opt.studies.many.cluster import Cluster

        return Cluster(study, dask)
    if workers is not None and (not isinstance(workers, int) or isinstance(workers, bool) or workers < 1):
        raise OptionError(f"workers must be a whole number, 1 or more (found {workers!r})")
    from masonry_opt.studies.many.processes import Processes

    return Processes(study, workers or _cores())


def _cores() -> int:
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1

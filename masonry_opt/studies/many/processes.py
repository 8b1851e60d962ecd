"""Runs by processes of this machine, one run at a time in each, the scene sent to each once."""

from __future__ import annotations

import contextlib
from collections import deque
from collections.abc import Iterable, Iterator
from multiprocessing.connection import Connection, wait
from typing import Any, Self

from masonry_opt.studies.many.engine import MOST_DEATHS
from masonry_opt.studies.many.runs import Runner, Study, Task, died
from masonry_opt.studies.process import CONTEXT, settle_in, started

_Numbered = tuple[int, Task]


class Processes:
    """An :class:`~.engine.Engine` of so many processes, started as there is something to do."""

    def __init__(self, study: Study, workers: int) -> None:
        self._study, self._most = study, workers
        # A second task lies ready while the first is made; one with a scene of its own might fill the pipe.
        self._ahead = 2 if study.scene is not None else 1
        self._workers: list[_Worker] = []

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        for worker in self._workers:
            worker.end()
        self._workers.clear()

    def map(self, tasks: Iterable[Task]) -> Iterator[tuple[int, dict[str, Any]]]:
        """See :meth:`.engine.Engine.map`."""
        coming, again = enumerate(tasks), deque[_Numbered]()
        deaths: dict[int, int] = {}

        def following() -> _Numbered | None:
            return again.popleft() if again else next(coming, None)

        while True:
            self._feed(following)
            busy = {worker.connection: worker for worker in self._workers if worker.given}
            if not busy:
                return
            for ready in wait(list(busy)):
                worker = busy[ready]  # type: ignore[index]
                row = worker.answer()
                if row is not None:
                    number, _ = worker.given.popleft()
                    deaths.pop(number, None)
                    yield number, row
                    continue
                self._workers.remove(worker)
                code = worker.end()
                (number, task), *waiting = worker.given
                deaths[number] = deaths.get(number, 0) + 1
                again.extendleft(reversed(waiting))
                if deaths[number] < MOST_DEATHS:
                    again.appendleft((number, task))
                else:
                    yield number, died(task, f"its process ended {MOST_DEATHS} times (exit code {code})")

    def _feed(self, following: Any) -> None:
        """Give tasks to the workers, one to each before a second to any."""
        for ahead in range(1, self._ahead + 1):
            for place in range(self._most):
                if place < len(self._workers) and len(self._workers[place].given) >= ahead:
                    continue
                numbered = following()
                if numbered is None:
                    return
                if place >= len(self._workers):
                    self._workers.append(_Worker(self._study))
                    place = len(self._workers) - 1
                self._workers[place].give(numbered)


class _Worker:
    """A process, and the tasks it was given and has not answered, the first under way."""

    def __init__(self, study: Study) -> None:
        self.connection, other = CONTEXT.Pipe()
        self._process = started(_serve, (other, study))
        other.close()
        self.given: deque[_Numbered] = deque()

    def give(self, numbered: _Numbered) -> None:
        self.given.append(numbered)
        with contextlib.suppress(OSError):  # of one that is gone: seen when its answer is read
            self.connection.send(numbered[1])

    def answer(self) -> dict[str, Any] | None:
        """The row of the task under way; None if the process is gone."""
        try:
            row: dict[str, Any] = self.connection.recv()
        except (EOFError, OSError):
            return None
        return row

    def end(self) -> int | None:
        """End the process, whatever it does."""
        self._process.kill()
        self._process.join()
        self.connection.close()
        return self._process.exitcode


def _serve(connection: Connection, study: Study) -> None:
    """In the process: rows for tasks, until the parent is gone."""
    settle_in()
    runner = Runner(study)
    while True:
        try:
            task = connection.recv()
        except EOFError:
            return
        connection.send(runner.run(task))

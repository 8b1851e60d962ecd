"""The table of all runs of a study: finished ones are read from its folder, the others are made."""

from __future__ import annotations

import csv
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import pandas as pd

from masonry_opt.answer.frames import unsigned
from masonry_opt.errors import CaseError, OptionError, counted
from masonry_opt.scene.scene import Scene
from masonry_opt.studies.journal import NAME, Journal
from masonry_opt.studies.many.parameters import is_of_joints
from masonry_opt.studies.many.runs import COLUMNS, RunSolver, Study, StudyRun, row
from masonry_opt.studies.runner import FINISHED, REFUSED, TaskEnd, Workers
from masonry_opt.studies.writing import csv_text, write_files

#: Called with how many runs are done, and of how many.
RunProgress = Callable[[int, int], None]

#: The table's name in a study's folder, and what to do where it must not be replaced.
_TABLE = "runs.csv"
_INSTEAD = "choose another folder, or replace the table with --force (in Python: force=True)"

#: Makes a scene from values.
Maker = Callable[[Mapping[str, float]], Scene]


@dataclass(frozen=True)
class RunsFolder:
    """The folder of ``runs.csv`` and of the journal of finished runs, which are not made again; without a
    path nothing is kept. ``parquet``, ``force``: as of :func:`~.sweep.sweep`."""

    path: Path | None = None
    parquet: bool = False
    force: bool = False

    def journal(self, study: Study, points: Sequence[Mapping[str, float]]) -> Journal | None:
        """That of these runs. Raises OptionError if the folder holds others."""
        if self.parquet and find_spec("pyarrow") is None:
            raise OptionError("--parquet needs: pip install '.[parquet]'")
        if self.path is None:
            return None
        # A journal of other runs is refused first; none is begun beside a table that stays.
        journal = Journal(self.path, study.identity()) if (self.path / NAME).exists() else None
        if not self.force:
            _refuse_losing(self.path / _TABLE, points)
        return journal or Journal(self.path, study.identity())

    def write(self, frame: pd.DataFrame) -> None:
        if self.path is not None:
            contents: dict[str, str | bytes] = {_TABLE: csv_text(frame)}
            if self.parquet:
                contents["runs.parquet"] = frame.to_parquet(None, index=False)
            write_files(self.path, contents)


@dataclass(frozen=True)
class ManyRuns:
    """A study's runs at points, which are values by name, and what makes the scene of a point where the study
    has none, in this process."""

    study: Study
    points: Sequence[Mapping[str, float]]
    make: Maker | None = None

    def table(
        self,
        folder: RunsFolder,
        workers: int | None = None,
        dask: str | None = None,
        progress: RunProgress = lambda done, of: None,
    ) -> pd.DataFrame:
        """One row a point, in the order of the points: see :func:`~.sweep.sweep`, errors too."""
        points, make = self.points, self.make
        self.study.how.refuse_functions()
        journal = folder.journal(self.study, points)
        rows: dict[int, dict[str, Any]] = {}
        under_way: list[tuple[int, StudyRun]] = []

        def missing() -> Iterator[StudyRun]:
            for index in _neighbours_together(points):
                values = points[index]
                try:
                    run = StudyRun(values, make(values) if make else None)
                except CaseError as error:
                    rows[index] = row(StudyRun(values), TaskEnd(REFUSED, str(error)))
                    continue
                found = journal.find(run.key) if journal else None
                if found is None:
                    under_way.append((index, run))
                    yield run
                else:
                    rows[index] = found

        with Workers(partial(RunSolver, self.study), workers, dask) as made:
            for number, end in made.map(missing()):
                index, run = under_way[number]
                under_way[number] = (index, StudyRun({}))  # scenes are not kept
                rows[index] = row(run, end)
                # A run that crashed or died is made again by the same command: memory may have been short.
                if journal and end.how in (FINISHED, REFUSED):
                    journal.add(run.key, rows[index])
                progress(len(rows), len(points))
        progress(len(rows), len(points))
        frame = framed([rows[index] for index in range(len(points))], list(points[0]))
        folder.write(frame)
        return frame


def framed(rows: Sequence[Mapping[str, Any]], names: Sequence[str]) -> pd.DataFrame:
    """Rows of runs as a frame: numbers of the scene by these names, then COLUMNS. No zero has a sign."""
    types = dict.fromkeys(names, "float64") | COLUMNS
    return unsigned(pd.DataFrame(rows, columns=[*types]).astype(types))


def _refuse_losing(path: Path, points: Sequence[Mapping[str, float]]) -> None:
    """Raise OptionError if a file is no table of these points or of some of them."""
    if not path.exists():
        return
    names = list(points[0])
    try:
        with path.open(encoding="utf-8", newline="") as stream:
            header, *rows = csv.reader(stream)
        varied = header.index(next(iter(COLUMNS)))
        runs = [tuple(map(float, row[:varied])) for row in rows]
    except (OSError, ValueError, csv.Error):
        raise OptionError(f"{path}: is there already, and no table of runs: {_INSTEAD}") from None
    wanted = {tuple(point.values()) for point in points}
    lost = sum(run not in wanted for run in runs) if header[:varied] == names else len(runs)
    if lost:
        raise OptionError(f"{path}: {lost} of its {counted(len(runs), 'run')} would be lost: {_INSTEAD}")


def _neighbours_together(points: Sequence[Mapping[str, float]]) -> list[int]:
    """Order in which points that differ in joint properties alone follow one another: a worker builds its
    programs once for all of them."""
    seen: dict[tuple[float, ...], list[int]] = {}
    for index, values in enumerate(points):
        others = tuple(value for name, value in values.items() if not is_of_joints(name))
        seen.setdefault(others, []).append(index)
    return [index for alike in seen.values() for index in alike]

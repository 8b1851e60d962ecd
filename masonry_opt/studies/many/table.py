"""The table of all runs of a study: finished ones are read from its folder, the others are made."""

from __future__ import annotations

import csv
from collections.abc import Callable, Iterator, Mapping, Sequence
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
from masonry_opt.studies.many.runs import COLUMNS, Run, Solves, Study, row
from masonry_opt.studies.runner import FINISHED, REFUSED, End, Workers
from masonry_opt.studies.writing import csv_text, write_files

#: Called with how many runs are done, and of how many.
Progress = Callable[[int, int], None]

#: The table's name in a study's folder, and what to do where it must not be replaced.
_TABLE = "runs.csv"
_INSTEAD = "choose another folder, or replace the table with --force (in Python: force=True)"

#: Makes a scene from values.
Maker = Callable[[Mapping[str, float]], Scene]


def table(
    study: Study,
    points: Sequence[Mapping[str, float]],
    *,
    make: Maker | None = None,
    folder: Path | None = None,
    parquet: bool = False,
    force: bool = False,
    workers: int | None = None,
    dask: str | None = None,
    progress: Progress = lambda done, of: None,
) -> pd.DataFrame:
    """One row a point, in the order of the points: see :func:`~.sweep.sweep`.

    Parameters
    ----------
    points: values by name.
    make: the scene of a point, where the study has none; called in this process.
    folder: of ``runs.csv`` and of the journal of finished runs, which are not made again.
    parquet, force, workers, dask, progress: as of :func:`~.sweep.sweep`; errors too.
    """
    study.how.refuse_functions()
    if parquet and find_spec("pyarrow") is None:
        raise OptionError("--parquet needs: pip install '.[parquet]'")
    journal = None
    if folder is not None:
        # A journal of other runs is refused first; none is begun beside a table that stays.
        journal = Journal(folder, study.identity()) if (folder / NAME).exists() else None
        if not force:
            _refuse_losing(folder / _TABLE, points)
        journal = journal or Journal(folder, study.identity())
    rows: dict[int, dict[str, Any]] = {}
    under_way: list[tuple[int, Run]] = []

    def missing() -> Iterator[Run]:
        for index in _neighbours_together(points):
            values = points[index]
            try:
                run = Run(values, make(values) if make else None)
            except CaseError as error:
                rows[index] = row(Run(values), End(REFUSED, str(error)))
                continue
            found = journal.find(run.key) if journal else None
            if found is None:
                under_way.append((index, run))
                yield run
            else:
                rows[index] = found

    with Workers(partial(Solves, study), workers, dask) as made:
        for number, end in made.map(missing()):
            index, run = under_way[number]
            under_way[number] = (index, Run({}))  # scenes are not kept
            rows[index] = row(run, end)
            # A run that crashed or died is made again by the same command: memory may have been short.
            if journal and end.how in (FINISHED, REFUSED):
                journal.add(run.key, rows[index])
            progress(len(rows), len(points))
    progress(len(rows), len(points))
    frame = framed([rows[index] for index in range(len(points))], list(points[0]))
    if folder is not None:
        contents: dict[str, str | bytes] = {_TABLE: csv_text(frame)}
        if parquet:
            contents["runs.parquet"] = frame.to_parquet(None, index=False)
        write_files(folder, contents)
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

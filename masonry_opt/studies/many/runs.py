"""Runs of a scene with different values of its parameters, which are solved in parallel and recorded."""

import contextlib
import pickle
import re
import threading
from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pandas as pd
from numpy.typing import ArrayLike

from masonry_opt.analysis import Session
from masonry_opt.effort import ignore_progress
from masonry_opt.errors import CaseError, NoRunSolvedError, OptionError, counted
from masonry_opt.files import refuse_outputs, write_folder
from masonry_opt.methods.registry import HowToSolve
from masonry_opt.problem.load_factor_scale import EQUALITY_TOLERANCE, LoadFactorScale
from masonry_opt.reporting.load_factors import LOWEST
from masonry_opt.scene.scene import Scene
from masonry_opt.solution.acceptance import Kind
from masonry_opt.solution.reasons import Status
from masonry_opt.solution.solution import Solution
from masonry_opt.solvers.driver import ProgramCache
from masonry_opt.studies.many.parameters import is_of_joints
from masonry_opt.studies.many.run_warnings import (
    Row,
    differing_values,
    recorded_warnings,
    warnings_of_falls,
    warnings_of_rows,
)
from masonry_opt.studies.many.scene_answer import solve_or_cross
from masonry_opt.studies.many.shared_states import SharedAnswer, recorded_state, shared_answers
from masonry_opt.studies.run_columns import CROSSING_COLUMNS, RUN_COLUMNS, framed, mechanism
from masonry_opt.studies.runner import FINISHED, REFUSED, UNSOLVED, Task, TaskEnd, Workers
from masonry_opt.studies.writing import JOURNAL, Journal, csv_text, digest, versions

#: Prefix of the names of columns that refer to the incremental load factor, in the tables of a sample.
INCREMENTAL_COLUMN = "incremental_"
#: Least length of an axis of λ in a chart, relative to the largest λ. A shorter axis would magnify rounding
#: errors.
_LEAST_AXIS = 0.02
#: Type of a progress function, which is called with the number of finished runs and the number of all runs.
RunProgress = Callable[[int, int], None]
_RUNS_FILE = "runs.csv"  #: Name of the table of runs in the folder of a study.
#: Advice in the error message about a table of runs that would be replaced.
_REPLACEMENT_ADVICE = "choose another folder, or replace the table with --force (in Python: force=True)"

_LINE_CHART = "load_factor"  #: Name of the chart of λ against a parameter; several charts are numbered.
HEAT_MAP = "heat_map"  #: Name of the chart of λ over two parameters.
#: Pattern of the names of the files that a sweep or a sample writes in addition to its table.
_STUDY_FILES = re.compile(
    rf"({_LINE_CHART}(_\d+)?|{HEAT_MAP}|fragility|sensitivity)\.(png|svg)"
    r"|(quantiles|fragility|sensitivity)\.csv|charts\.html"
)

#: Cache of each worker thread. The attribute ``how`` contains the pickled settings of the last study, and the
#: attribute ``session`` contains the session with these settings.
_thread_cache = threading.local()


class Study(NamedTuple):
    """Settings that are equal in all runs of a study."""

    how: HowToSolve
    #: Function that returns the scene of a run from a mapping of parameter names to values.
    make: Callable[[Mapping[str, float]], Scene]
    #: Scene whose parameters vary; None if a function of the user makes the scenes.
    scene: Scene | None = None


class StudyOutput(NamedTuple):
    """Output folder of a study, and the files that the study writes into the folder."""

    folder: Path
    extra_files: Sequence[str]  #: names of the files that are written in addition to the table of runs
    force: bool  #: True to replace files of other programs, and a table even if runs are lost

    def write(self, frame: pd.DataFrame, extra_contents: Mapping[str, str | bytes]) -> None:
        """Write the table of runs and the additional files, and remove other files of an earlier study.

        Raises OutputError if a file cannot be written or removed.
        """
        write_folder(self.folder, {_RUNS_FILE: csv_text(frame), **extra_contents}, self.force, _is_study_file)


def _is_study_file(name: str) -> bool:
    """Return True if a sweep or a sample may write a file with this name in addition to its table."""
    return _STUDY_FILES.fullmatch(name) is not None


def chart_names(names: Sequence[str]) -> list[str]:
    """Return the names of a sweep's charts: λ against each parameter and, for two parameters, a heat map."""
    if len(names) > 2:
        return [f"{_LINE_CHART}_{number}" for number in range(1, len(names) + 1)]
    return [_LINE_CHART, HEAT_MAP][: len(names)]


def charts_if_installed(title: str, drawings: Callable[[], list[Any]]) -> dict[str, str | bytes]:
    """Return the files of a study's charts by name; no files if the extra "studies" is not installed."""
    with contextlib.suppress(OptionError):
        from masonry_opt.studies.charts import chart_contents

        return chart_contents(title, drawings())
    return {}


def run_scene(how: bytes, scene: Scene) -> dict[str, Any]:
    """Solve a scene, or move axles over the scene, and return the row of the run as a dict.

    ``how`` contains the pickled settings. Each thread reuses its last session. In addition to RUN_COLUMNS the
    row has the entries that :mod:`.shared_states` and :mod:`.run_warnings` read.
    """
    if getattr(_thread_cache, "how", None) != how:
        _thread_cache.how = how
        _thread_cache.session = Session(pickle.loads(how), ProgramCache(keeps=True))
    session: Session = _thread_cache.session
    answer = solve_or_cross(session, scene)
    entries = answer.columns() | recorded_warnings(answer.warning_records)
    if answer.time_limit_reached:
        entries |= {"time_limit_reached": True, "time_limit": session.how.time_limit}
    # A state of a crossing is not shared with other runs, because another position may govern in another run.
    if session.method.seeks_lowest and answer.crossing is None:
        entries |= recorded_state(answer.result.assembly.problem, answer.result.solution)
    return entries


def run_many(
    study: Study,
    points: Sequence[Mapping[str, float]],
    *,
    output: StudyOutput | None = None,
    by: tuple[int | None, str | None] = (None, None),
    progress: RunProgress = ignore_progress,
) -> pd.DataFrame:
    """Solve a scene for each dictionary of values, and return a table with one row per dictionary.

    ``points`` are the dictionaries of values by name, in the order of the rows. Scenes are made in this
    process, and solved by worker processes or by the workers of a Dask scheduler. A journal in the folder of
    the output records finished runs, which are not made again. When all runs have ended, they share their
    exact states (:mod:`.shared_states`).

    The frame has three attributes: ``attrs["warnings"]`` is a list of sentences, ``attrs["warning_records"]``
    has their codes too, and ``attrs["method"]`` is the name of the method. The caller writes the output. If
    no run was solved, the folder remains unchanged, and NoRunSolvedError is raised.

    See :func:`~.sweep.sweep` for the other parameters and the errors.
    """
    study.how.refuse_functions()
    journal = None if output is None else _journal(output, study, points)
    rows = _rows_of_runs(study, points, journal, by, progress)
    for shared in shared_answers(rows, lambda index: study.make(points[index])):
        differing = differing_values(points[shared.run], points[shared.found_in])
        rows[shared.run] = rows[shared.run] | _columns_of_state(shared, differing)
    crossed = any("position" in row for row in rows)
    frame = framed(rows, list(points[0]), RUN_COLUMNS | (CROSSING_COLUMNS if crossed else {}))
    records = [*journal.warnings] if journal else []
    records += warnings_of_rows(rows, points)
    if study.how.chosen.seeks_lowest:
        records += warnings_of_falls(frame, list(points[0]), study.how.method)
    frame.attrs["warning_records"] = records
    frame.attrs["warnings"] = [record["sentence"] for record in records]
    frame.attrs["method"] = study.how.method
    if frame["status"].isin(UNSOLVED).all():
        raise _nothing_solved(frame)
    return frame


def _rows_of_runs(
    study: Study,
    points: Sequence[Mapping[str, float]],
    journal: Journal | None,
    by: tuple[int | None, str | None],
    progress: RunProgress,
) -> list[dict[str, Any]]:
    """Return the rows of all runs, read from the journal or solved by workers, in the order of ``points``."""
    how = pickle.dumps(study.how)
    rows: dict[int, dict[str, Any]] = {}

    def missing() -> Iterator[tuple[tuple[int, str], Task]]:
        """Generate index, journal key and task of each run without a valid row in the journal."""
        for index in _neighbours_together(points):
            values = {name: float(value) for name, value in points[index].items()}
            try:
                # In a study of one scene, the values of the parameters identify a run, so the scenes of
                # recorded runs need not be built.
                scene = None if study.scene else study.make(points[index])
                key = digest((values, scene and _scene_hash(scene))) if journal else ""
                recorded = journal.find(key) if journal else None
                if recorded and not is_outdated(recorded, study.how.time_limit):
                    rows[index] = recorded
                    continue
                scene = scene or study.make(points[index])
                yield (index, key), partial(run_scene, how, scene)
            except CaseError as error:
                rows[index] = row(points[index], TaskEnd(REFUSED, str(error)))

    with _discarded_if_nothing_is_solved(journal, rows), Workers(*by) as workers:
        for (index, key), end in workers.map(missing()):
            rows[index] = row(points[index], end)
            # A run that crashed, or whose process died, is not recorded. The run is therefore repeated if the
            # study is started again.
            if journal and end.how in (FINISHED, REFUSED):
                journal.add(key, rows[index])
            progress(len(rows), len(points))
    progress(len(rows), len(points))
    return [rows[index] for index in range(len(points))]


def is_outdated(recorded: Row, time_limit: float | None) -> bool:
    """Return True if a record is outdated: the run ended at a time limit, and the present limit is longer.

    A limit of None in the row is the method's own limit. Any other limit counts as longer.
    """
    if not recorded.get("time_limit_reached", False):
        return False
    before = recorded.get("time_limit")
    return time_limit != before and (before is None or time_limit is None or time_limit > before)


@contextlib.contextmanager
def _discarded_if_nothing_is_solved(journal: Journal | None, rows: Mapping[int, Row]) -> Iterator[None]:
    """Return a context manager that removes the added rows from the journal on exit if no run was solved."""
    try:
        yield
    finally:
        if journal and all(row["status"] in UNSOLVED for row in rows.values()):
            journal.discard()


def _nothing_solved(frame: pd.DataFrame) -> NoRunSolvedError:
    """Return the error for a study in which no run was solved.

    The message names the most frequent status, the number of runs with this status, and their most frequent
    reason. The reasons of several runs differ if they contain the values of a run.
    """
    ((how, count),) = Counter(frame["status"]).most_common(1)
    reasons = Counter(frame.loc[frame["status"] == how, "message"])
    ((why, alike),) = reasons.most_common(1)
    named = why if alike == count else f"for example {why}"
    return NoRunSolvedError(
        f"no run was solved: status '{how}' in {count} of {len(frame)} runs: {named}", frame.attrs["warnings"]
    )


def _columns_of_state(shared: SharedAnswer, found_at: str) -> dict[str, Any]:
    """Return the table columns of a run that takes its collapse state from another run.

    ``found_at`` is a text that describes the other run, such as "tie.strength = 40".
    """
    solution = Solution(Status.CONVERGED, Kind.EXACT, state=shared.answer)
    entries = {"load_factor": shared.answer.load_factor, "status": str(solution.status), "reason": ""}
    entries |= {"any_load": False, "exact": True, "which": LOWEST, "state_from": f"state found at {found_at}"}
    entries["message"] = f"another run found this state ({found_at}); it is certified for the present run"
    certificate = shared.answer.certificate.as_dict()
    return entries | certificate | mechanism(shared.assembly, solution)


def _journal(output: StudyOutput, study: Study, points: Sequence[Mapping[str, float]]) -> Journal:
    """Open or create the journal of a study in its folder, and return the journal.

    Raises OptionError if the folder has runs of another study, files of other programs, or a table whose
    replacement would lose runs.
    """
    how, folder = study.how, output.folder
    head = {
        "scene": "" if study.scene is None else _scene_hash(study.scene),
        "method": digest((how.method, how.model, how.solver, how.tolerance, how.incremental)),
        "options": digest(sorted(how.options.items())),
        "versions": digest(versions()),
        "columns": digest(sorted(RUN_COLUMNS)),
    }
    # Open an existing journal first: this raises an error if the journal has runs of another study.
    journal = Journal(folder, head) if (folder / JOURNAL).exists() else None
    if not output.force:
        _refuse_losing(folder / _RUNS_FILE, points)
    refuse_outputs(folder, (_RUNS_FILE, *output.extra_files), output.force)
    # Create a new journal only after all checks: if a check raises an error, no new journal remains.
    return journal or Journal(folder, head)


def _refuse_losing(path: Path, points: Sequence[Mapping[str, float]]) -> None:
    """Raise OptionError if a file is not a table of runs, or if its replacement would lose runs."""
    if not path.exists():
        return
    try:
        table = pd.read_csv(path, dtype=str)
        values = table.iloc[:, : table.columns.get_loc("load_factor")].astype(float)
    except (OSError, ValueError, KeyError):
        raise OptionError(
            f"{path}: the file exists and is not a table of runs: {_REPLACEMENT_ADVICE}"
        ) from None
    names = list(points[0])
    if set(values) == set(names):
        planned = {tuple(point.values()) for point in points}
        lost = sum(run not in planned for run in values[names].itertuples(index=False, name=None))
    else:
        lost = len(table)
    if lost:
        runs = counted(len(table), "run")
        raise OptionError(
            f"{path}: the new table would delete {lost} of the {runs} in this file: {_REPLACEMENT_ADVICE}"
        )


def _neighbours_together(points: Sequence[Mapping[str, float]]) -> list[int]:
    """Return indices of runs in an order in which runs that differ only in joint properties are neighbours.

    For successive runs that differ only in joint properties, a worker builds its programs only once.
    """
    first: dict[tuple[float, ...], int] = {}
    not_of_joints = [
        tuple(value for name, value in point.items() if not is_of_joints(name)) for point in points
    ]
    return sorted(range(len(points)), key=lambda index: first.setdefault(not_of_joints[index], index))


def row(values: Mapping[str, float], end: TaskEnd) -> dict[str, Any]:
    """Return the row of a run in the table of runs: the values of the run, then RUN_COLUMNS.

    If the run did not finish, the columns "status", "reason" and "message" state why.
    """
    unfinished = {"status": end.how, "reason": end.how, "message": end.reason}
    entries = end.value if end.how == FINISHED else unfinished
    empty = dict.fromkeys(RUN_COLUMNS) | {"state_from": "", "warnings": ""}
    return dict(values) | empty | entries | {"seconds": end.seconds}


def _scene_hash(scene: Scene) -> str:
    """Return a hash of a scene and of its case file.

    The case file is included, because two generators that build equal blocks may build different blocks
    after a number is varied.
    """
    records = scene, scene.case, scene.load_case
    return digest([None if record is None else record.model_dump_json() for record in records])


def ends(load_factors: ArrayLike) -> tuple[float, float]:
    """Return the ends of an axis that contains all finite load factors; 0 and 1 if none is finite."""
    values = np.asarray(load_factors, dtype=float)
    finite = values[np.isfinite(values)]
    least, greatest = (float(finite.min()), float(finite.max())) if len(finite) else (0.0, 1.0)
    least_length = _LEAST_AXIS * max(abs(least), abs(greatest)) or 0.1
    margin = max(0.0, least_length - (greatest - least)) / 2
    return least - margin, greatest + margin


def at_least(frame: pd.DataFrame) -> pd.Series:
    """Return a mask of the runs whose λ equals the least λ within ``EQUALITY_TOLERANCE``, shape (runs,)."""
    values = frame["load_factor"]
    least = values.min()
    return values <= least + EQUALITY_TOLERANCE * LoadFactorScale().divisor(least)

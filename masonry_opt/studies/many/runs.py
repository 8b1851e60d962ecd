"""Many certified runs of a scene with other values, each a row of a table of plain numbers and words."""

import contextlib
import pickle
import re
import threading
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pandas as pd
from numpy.typing import ArrayLike

from masonry_opt.analysis import Session
from masonry_opt.answer.acceptance import SMALLEST, Kind
from masonry_opt.answer.frames import unsigned
from masonry_opt.answer.motion import joint_motion
from masonry_opt.answer.reasons import Code, Status
from masonry_opt.answer.solution import Solution
from masonry_opt.answer.thresholds import SAME
from masonry_opt.errors import CaseError, NoRunSolvedError, OptionError, counted
from masonry_opt.files import refuse_outputs, write_folder
from masonry_opt.methods.registry import HowToSolve
from masonry_opt.problem.assembly import Assembly
from masonry_opt.result import Result
from masonry_opt.scene.scene import Scene
from masonry_opt.solvers.driver import Kept
from masonry_opt.studies.many.parameters import is_of_joints
from masonry_opt.studies.many.run_warnings import (
    Row,
    differing_values,
    recorded_warnings,
    warnings_of_falls,
    warnings_of_rows,
)
from masonry_opt.studies.many.shared_states import SharedAnswer, recorded_state, shared_answers
from masonry_opt.studies.runner import FINISHED, REFUSED, UNSOLVED, Task, TaskEnd, Workers
from masonry_opt.studies.writing import JOURNAL, Journal, csv_text, digest, versions
from masonry_opt.words.load_factors import LOWEST, own_name

#: Columns of a row beside the values, in order, and their types in a table. ``seconds`` alone depends on
#: machine and time.
COLUMNS = {
    "load_factor": "float64",
    **dict.fromkeys(("which", "status", "reason"), "object"),
    **dict.fromkeys(("any_load", "exact"), "boolean"),
    "states": "Int64",
    **dict.fromkeys(("incremental", "spread_lower", "spread_upper", "associative"), "float64"),
    **dict.fromkeys(("equilibrium", "yield", "flow", "complementarity"), "float64"),
    "mechanism": "object",
    **dict.fromkeys(("slides", "hinges", "separates", "crushes", "blocks", "joints"), "Int64"),
    "message": "object",
    "seconds": "float64",
}

#: Columns of a study of many runs: those of each run, where its answer was found if in another run, and what
#: looks unintended in its scene.
RUN_COLUMNS = COLUMNS | {"state_from": "object", "warnings": "object"}

INCREMENTAL_COLUMN = (
    "incremental_"  #: Begins names of a sample's columns that tell of the incremental load factor.
)
#: Names of mechanisms by the one thing that joints do in them, beside coming apart.
_NAMES = {"slides": "sliding", "hinges": "hinging", "crushes": "crushing"}
_LEAST = 0.02  #: Least length of an axis, over the largest load factor: less would magnify rounding.
RunProgress = Callable[[int, int], None]  #: Called with how many runs are done, and of how many.
_TABLE = "runs.csv"  #: The table's name in a study's folder, and what to do where it must not be replaced.
_INSTEAD = "choose another folder, or replace the table with --force (in Python: force=True)"

_AGAINST = "load_factor"  #: Name of the chart of λ against a number; of several numbers the first part of it.
HEAT_MAP = "heat_map"  #: Name of the chart of λ over two numbers.

_kept = threading.local()  #: Of a worker's thread: how the scenes of its study are solved, and its session.


class Study(NamedTuple):
    """What all runs share: how they are solved, and what makes a scene of values, from one or by itself."""

    how: HowToSolve
    make: Callable[[Mapping[str, float]], Scene]
    scene: Scene | None = None


class StudyOutput(NamedTuple):
    """The folder of a study, the names of its files beside the table, and whether to replace foreign ones."""

    folder: Path
    beside: Sequence[str]
    force: bool

    def write(self, frame: pd.DataFrame, beside: Mapping[str, str | bytes]) -> None:
        """Write the table of the runs and the files beside it; remove those of an earlier table.

        Raises OutputError if a file cannot be written or removed.
        """
        write_folder(self.folder, {_TABLE: csv_text(frame), **beside}, self.force, _is_of_a_study)


#: Names of the files that a sweep or a sample writes beside its table.
_OF_A_STUDY = re.compile(
    rf"({_AGAINST}(_\d+)?|{HEAT_MAP}|fragility|sensitivity)\.(png|svg)"
    r"|(quantiles|fragility|sensitivity)\.csv|charts\.html"
)


def _is_of_a_study(name: str) -> bool:
    """Return True if a sweep or a sample writes a file of this name beside its table."""
    return _OF_A_STUDY.fullmatch(name) is not None


def chart_names(names: Sequence[str]) -> list[str]:
    """Return the names of a sweep's charts: λ against each number, or of two numbers a map beside it."""
    if len(names) > 2:
        return [f"{_AGAINST}_{number}" for number in range(1, len(names) + 1)]
    return [_AGAINST, HEAT_MAP][: len(names)]


def charts_if_installed(title: str, drawings: Callable[[], list[Any]]) -> dict[str, str | bytes]:
    """Return the files of a study's charts by name; none if the extra "studies" is not installed."""
    with contextlib.suppress(OptionError):
        from masonry_opt.studies.charts import chart_contents

        return chart_contents(title, drawings())
    return {}


def run_scene(how: bytes, scene: Scene) -> dict[str, Any]:
    """Return the row of a scene, solved as a pickled HowToSolve says. Each thread keeps its last session.

    Beside RUN_COLUMNS the row has what :mod:`.shared_states` and :mod:`.run_warnings` read.
    """
    if getattr(_kept, "how", None) != how:
        _kept.how, _kept.session = how, Session(pickle.loads(how), Kept(keeps=True))
    session: Session = _kept.session
    result = session.solve(scene)
    found = columns(result) | recorded_warnings(result.warnings)
    if session.method.seeks_lowest:
        found |= recorded_state(result.assembly.problem, result.solution)
    return found


def run_many(
    study: Study,
    points: Sequence[Mapping[str, float]],
    *,
    output: StudyOutput | None = None,
    by: tuple[int | None, str | None] = (None, None),
    progress: RunProgress = lambda done, of: None,
) -> pd.DataFrame:
    """Return one row a point, in the order of the points, which are values by name.

    Scenes are made in this process, and solved by worker processes or by those of a Dask scheduler. Finished
    runs are kept in a journal in the folder of the output, and not made again. When all runs have ended, they
    share their exact states (:mod:`.shared_states`). ``attrs["warnings"]`` of the frame is a list of
    sentences; ``attrs["warning_records"]`` has their codes too, and ``attrs["seeks_lowest"]`` tells whether
    the method looks for the lowest state. The caller writes the output. If no run was solved,
    NoRunSolvedError is raised, and the folder is as it was before.

    Other parameters and errors are those of :func:`~.sweep.sweep`.
    """
    study.how.refuse_functions()
    how = pickle.dumps(study.how)
    journal = None if output is None else _journal(output, study, points)
    rows: dict[int, dict[str, Any]] = {}

    def missing() -> Iterator[tuple[tuple[int, str], Task]]:
        for index in _neighbours_together(points):
            values = {name: float(value) for name, value in points[index].items()}
            try:
                # Of one scene values tell runs apart: none is made for a run that is known.
                scene = None if study.scene else study.make(points[index])
                key = digest((values, scene and _of_scene(scene))) if journal else ""
                if journal and (known := journal.find(key)):
                    rows[index] = known
                    continue
                scene = scene or study.make(points[index])
                yield (index, key), partial(run_scene, how, scene)
            except CaseError as error:
                rows[index] = row(points[index], TaskEnd(REFUSED, str(error)))

    with _discarded_if_nothing_is_solved(journal, rows), Workers(*by) as workers:
        for (index, key), end in workers.map(missing()):
            rows[index] = row(points[index], end)
            # A run that crashed or died is made again by the same command: memory may have been short.
            if journal and end.how in (FINISHED, REFUSED):
                journal.add(key, rows[index])
            progress(len(rows), len(points))
    progress(len(rows), len(points))
    found = [rows[index] for index in range(len(points))]
    for shared in shared_answers(found, lambda index: study.make(points[index])):
        differing = differing_values(points[shared.run], points[shared.found_in])
        found[shared.run] = found[shared.run] | _columns_of_state(shared, differing)
    frame = framed(found, list(points[0]), RUN_COLUMNS)
    damaged = journal.warnings if journal else []
    falls = warnings_of_falls(frame, list(points[0])) if study.how.chosen.seeks_lowest else ()
    frame.attrs["warning_records"] = [*damaged, *warnings_of_rows(found, points), *falls]
    frame.attrs["warnings"] = [record["sentence"] for record in frame.attrs["warning_records"]]
    frame.attrs["seeks_lowest"] = study.how.chosen.seeks_lowest
    if frame["status"].isin(UNSOLVED).all():
        raise _nothing_solved(frame)
    return frame


@contextlib.contextmanager
def _discarded_if_nothing_is_solved(journal: Journal | None, rows: Mapping[int, Row]) -> Iterator[None]:
    """Discard what is added to the journal inside if no run of the rows was solved."""
    try:
        yield
    finally:
        if journal and all(row["status"] in UNSOLVED for row in rows.values()):
            journal.discard()


def _nothing_solved(frame: pd.DataFrame) -> NoRunSolvedError:
    """Return the error for runs that were all refused, crashed, died or exceeded a limit."""
    ends = Counter(zip(frame["status"], frame["message"], strict=True))
    (((how, why), count),) = ends.most_common(1)
    return NoRunSolvedError(f"no run was solved: {count} of {len(frame)} {how}: {why}")


def _columns_of_state(shared: SharedAnswer, found_at: str) -> dict[str, Any]:
    """Return the columns that change where a state of another run replaces an answer."""
    solution = Solution(Status.CONVERGED, Kind.EXACT, found=shared.answer)
    changed = {"load_factor": shared.answer.load_factor, "status": str(solution.status), "reason": ""}
    changed |= {"any_load": False, "exact": True, "which": LOWEST, "state_from": f"state found at {found_at}"}
    changed["message"] = f"the lowest state was found by the run at {found_at}, and is certified for this run"
    certificate = shared.answer.certificate.as_dict()
    return changed | certificate | mechanism(shared.assembly, solution)


def _journal(output: StudyOutput, study: Study, points: Sequence[Mapping[str, float]]) -> Journal:
    """Return the journal of these runs.

    Raises OptionError if the folder holds other runs, a table that would lose some, or files that were not
    written here.
    """
    how, folder = study.how, output.folder
    head = {
        "scene": "" if study.scene is None else _of_scene(study.scene),
        "method": digest((how.method, how.model, how.solver, how.tolerance, how.incremental)),
        "options": digest(sorted(how.options.items())),
        "versions": digest(versions()),
        "columns": digest(sorted(RUN_COLUMNS)),
    }
    # A journal of other runs is refused first; none is begun beside a table that stays.
    journal = Journal(folder, head) if (folder / JOURNAL).exists() else None
    if not output.force:
        _refuse_losing(folder / _TABLE, points)
    refuse_outputs(folder, (_TABLE, *output.beside), output.force)
    return journal or Journal(folder, head)


def framed(
    rows: Sequence[Mapping[str, Any]],
    before: Iterable[str] | Mapping[str, str],
    of_runs: Mapping[str, str] = COLUMNS,
) -> pd.DataFrame:
    """Return rows of runs as a frame: columns of these names, numbers if no types are given, then those of
    runs."""
    types = dict(before) if isinstance(before, Mapping) else dict.fromkeys(before, "float64")
    types |= of_runs
    return unsigned(pd.DataFrame(rows, columns=[*types]).astype(types))


def _refuse_losing(path: Path, points: Sequence[Mapping[str, float]]) -> None:
    """Raise OptionError if a file is no table of these points or of some of them."""
    if not path.exists():
        return
    try:
        table = pd.read_csv(path, dtype=str)
        values = table.iloc[:, : table.columns.get_loc("load_factor")].astype(float)
    except (OSError, ValueError, KeyError):
        raise OptionError(f"{path}: is there already, and no table of runs: {_INSTEAD}") from None
    wanted = {tuple(point.values()) for point in points}
    same = [*values] == [*points[0]]
    lost = sum(not same or run not in wanted for run in values.itertuples(index=False, name=None))
    if lost:
        raise OptionError(f"{path}: {lost} of its {counted(len(table), 'run')} would be lost: {_INSTEAD}")


def _neighbours_together(points: Sequence[Mapping[str, float]]) -> list[int]:
    """Order in which points that differ in joint properties alone follow: their programs are built once."""
    first: dict[tuple[float, ...], int] = {}
    others = [tuple(value for name, value in point.items() if not is_of_joints(name)) for point in points]
    return sorted(range(len(points)), key=lambda index: first.setdefault(others[index], index))


def row(values: Mapping[str, float], end: TaskEnd) -> dict[str, Any]:
    """Return the row of a run: its values, then RUN_COLUMNS; of a run that did not finish, the reason."""
    without = {"status": end.how, "reason": end.how, "message": end.reason}
    found = end.value if end.how == FINISHED else without
    empty = dict.fromkeys(RUN_COLUMNS) | {"state_from": "", "warnings": ""}
    return dict(values) | empty | found | {"seconds": end.seconds}


def columns(result: Result) -> dict[str, Any]:
    """Return the columns of the row of a result."""
    assembly, solution = result.assembly, result.solution
    spread = [said.values for said in solution.reasons if said.code is Code.SPREAD]
    ends = [end for of in spread for kind in ("stiffness", "stress") for end in of[kind] or ()]
    certificate = solution.answer.certificate.as_dict() if solution.answer else {}
    own: dict[str, Any] = {
        "load_factor": solution.load_factor,
        "which": "" if solution.load_factor is None else own_name(result),
        "status": str(solution.status),
        "reason": str(solution.reasons[0].code) if solution.reasons else "",
        "any_load": solution.carries_any_load,
        "exact": result.exact,
        "states": solution.exact_states,
        "incremental": solution.incremental_value,
        "spread_lower": min(ends, default=None),
        "spread_upper": max(ends, default=None),
        "associative": solution.associative_value,
        "blocks": assembly.problem.blocks,
        "joints": len(assembly.joints.first),
        "message": result.message,
    }
    return own | certificate | mechanism(assembly, solution)


def mechanism(assembly: Assembly, solution: Solution) -> dict[str, Any]:
    """Name of the mechanism, and how many joints slide, hinge, come apart and crush; empty without one."""
    if solution.d is None:
        return {}
    motion = joint_motion(assembly, solution)
    counts = {kind: int(getattr(motion, kind).sum()) for kind in (*_NAMES, "separates")}
    names = [name for kind, name in _NAMES.items() if counts[kind]]
    if not names:
        names = ["separating" if counts["separates"] else "none"]
    return {"mechanism": names[0] if len(names) == 1 else "mixed", **counts}


def _of_scene(scene: Scene) -> str:
    # Of generators too: two files may say the same blocks, and vary otherwise.
    records = scene, scene.case, scene.load_case
    return digest([None if one is None else one.model_dump_json() for one in records])


def ends(load_factors: ArrayLike) -> tuple[float, float]:
    """Ends of an axis that holds all finite load factors; 0 and 1 without any."""
    values = np.asarray(load_factors, dtype=float)
    finite = values[np.isfinite(values)]
    least, greatest = (float(finite.min()), float(finite.max())) if len(finite) else (0.0, 1.0)
    missing = (_LEAST * max(abs(least), abs(greatest)) or 0.1) - (greatest - least)
    aside = max(0.0, missing) / 2
    return least - aside, greatest + aside


def at_least(frame: pd.DataFrame) -> pd.Series:
    """Whether each run has the least load factor, within SAME, shape (runs,)."""
    values = frame["load_factor"]
    least = values.min()
    return values <= least + SAME * max(abs(least), SMALLEST)

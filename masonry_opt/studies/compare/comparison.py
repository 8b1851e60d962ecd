"""Function ``compare``: a benchmark of methods and solvers on scenes.

It makes the runs that are missing in its journal, judges all runs, and writes tables, charts and a page.
"""

import contextlib
from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import astuple, dataclass, replace
from functools import partial
from itertools import product
from pathlib import Path
from typing import Any

import pandas as pd

from masonry_opt.effort import ignore_progress
from masonry_opt.errors import NoRunSolvedError, OptionError
from masonry_opt.files import refuse_outputs, write_folder
from masonry_opt.scene.case_file import case_folder
from masonry_opt.scene.mistakes import suggests_arguments
from masonry_opt.scene.scene import Scene
from masonry_opt.solvers.registry import LANGUAGES
from masonry_opt.studies.compare import judge, runs
from masonry_opt.studies.compare.accuracy import CertifiedBounds
from masonry_opt.studies.compare.runs import CaseScene, Pair, RunLimits, RunPlan, checked, find_scenes, plan
from masonry_opt.studies.runner import CRASHED, DIED, FINISHED, MEMORY_LIMIT, TIME_LIMIT, run_alone, whole
from masonry_opt.studies.writing import Journal, chart_files, csv_text, digest, machine, versions

#: Time limit for computing the certified bounds of a scene, in seconds. If the time limit of the runs is
#: longer, the limit of the runs is used instead.
_BOUNDS_TIME = 120.0
#: Default methods, each of which solves a wall of the paper's Table 1 in seconds.
DEFAULT_METHODS = ("static", "kinematic", "nonassociative", "coulomb", "mpec")
DEFAULT_SOLVERS = ("clarabel", "highs", "highs-ipm")  #: Default solvers, which the package installs.
#: Tolerances with which a comparison runs each solver by default: a coarse tolerance, and the default
#: tolerance of the package.
TOLERANCES = (1e-6, 1e-9)
DEFAULT_FOLDER = Path("results/compare")  #: Default folder of the results.
_PAGE_FILE = "report.html"  #: Name of the HTML file with all charts of a comparison.
_CHARTS = [judge.chart_name(question) for question in (judge.ASSOCIATIVE, judge.COULOMB)]
#: Files that a comparison may write.
_FILES = (
    "results.csv",
    "summary.csv",
    _PAGE_FILE,
    *chart_files(_CHARTS),
)


@suggests_arguments
def compare(  # noqa: PLR0913 - options of the public API are keywords
    scenes: str | Path | Sequence[str | Path] = (),
    *,
    methods: str | Sequence[str] = DEFAULT_METHODS,
    models: str | Sequence[str] = LANGUAGES,
    solvers: str | Sequence[str] = DEFAULT_SOLVERS,
    tolerances: Sequence[float] = TOLERANCES,
    repeats: int = RunLimits.repeats,
    time_limit: float = RunLimits.time,
    memory_limit: float = RunLimits.memory,
    out: str | Path = DEFAULT_FOLDER,
    force: bool = False,
    cases: str | Path | None = None,
    progress: Callable[[str], None] = ignore_progress,
) -> judge.Comparison:
    """Measure the times of methods and solvers on scenes, judge their answers, and write the results.

    The written files are tables (CSV), charts and a report (HTML).

    Runs that ``out`` contains are not made again. An interrupted comparison (Ctrl-C) reports the runs made so
    far, and continues when it is called again.

    Parameters
    ----------
    scenes: paths of case files, or names of case files in the folder ``cases``.
    methods, models, solvers: names of methods, modelling languages and solvers, one or a list.
    cases: folder of the case files. Default: ``./cases`` if it has the cases of the paper; otherwise the
        folder in the package.
    tolerances: tolerances for the solvers that accept one.
    repeats: number of runs of each combination; times are medians.
    time_limit: Largest time of a run in seconds.
    memory_limit: Largest memory of a run in MB (10⁶ bytes), including libraries.
    out: folder of results and report.
    force: True to replace files of other programs.
    progress: function called with a line of text before each run.

    Returns
    -------
    Comparison
        All runs, their verdicts and summary.

    Raises
    ------
    CaseError
        If a case file is missing or wrong.
    OptionError
        If an argument is wrong, if no combination exists, or if ``out`` has other runs, or files with the
        same names from other programs.
    OutputError
        If ``out`` cannot be written.
    NoRunSolvedError
        If every run crashed or died. The report is written nevertheless.
    """
    limits = RunLimits(time_limit, memory_limit, whole("repeats", repeats, 1))
    named = _listed("scenes", scenes)
    methods, models = _listed("methods", methods), _listed("models", models)
    solvers = _listed("solvers", solvers)
    planned = plan(methods, models, solvers, tolerances)
    folder, out = case_folder(None if cases is None else Path(cases)), Path(out)
    if not named:
        raise OptionError("nothing to compare: name case files")
    case_scenes = [checked(scene) for scene in find_scenes(named, folder)]
    refuse_outputs(out, _FILES, force)
    best = judge.best_known(case_scenes, folder)
    comparison = run_plan(case_scenes, planned, limits, out, progress, best)
    progress("report")
    comparison = replace(comparison, files=tuple(write_report(comparison, out, force)))
    ended = comparison.results["ended"]
    if len(ended) and ended.isin((CRASHED, DIED)).all() and not comparison.interrupted:
        ends = Counter(zip(ended, comparison.results["message"], strict=True))
        (((how, why), count),) = ends.most_common(1)
        most = f"{count} of {len(ended)} {how}: {why}"
        raise NoRunSolvedError(f"no run ended: {most}; see {out / 'summary.csv'}")
    return comparison


def _listed(argument: str, names: str | Path | Scene | Sequence[Any]) -> Sequence[Any]:
    """Return a name, a scene or a list as a list. Raise OptionError if the argument has another type."""
    if isinstance(names, str | Path | Scene):
        return [names]
    if not isinstance(names, Sequence):
        raise OptionError(f"{argument} must be a list of names (found {names!r})")
    return names


def write_report(comparison: judge.Comparison, folder: Path, force: bool = False) -> list[Path]:
    """Write the files of a comparison, and return their paths.

    The files are results.csv and summary.csv. With the extra "studies" there are also charts (PNG and SVG)
    and report.html. Raises OutputError if the folder cannot be written. Raises OptionError if the folder has
    files with these names from other programs, unless ``force`` is True.
    """
    tables = {"results.csv": comparison.results, "summary.csv": comparison.summary}
    files: dict[str, str | bytes] = {name: csv_text(frame) for name, frame in tables.items()}
    with contextlib.suppress(OptionError):  # without the extra "studies", only tables are written
        # The modules of charts and pages are imported here, because they are slow to import and not always
        # needed.
        from masonry_opt.studies.charts import pictures
        from masonry_opt.studies.compare.page import charts, page

        named_charts = charts(comparison.summary)
        files |= pictures(named_charts) | {_PAGE_FILE: page(comparison, named_charts)}
    return write_folder(folder, files, force, is_own=_FILES.__contains__)


def run_plan(
    scenes: Sequence[CaseScene],
    planned: RunPlan,
    limits: RunLimits,
    folder: Path,
    progress: Callable[[str], None],
    known: Mapping[str, judge.BestKnown] | None = None,
) -> judge.Comparison:
    """Make the planned runs that the journal in a folder does not contain yet, and judge all runs.

    ``known`` has exact Coulomb states by scene name, which are used in addition to the states of the runs.
    """
    notes: list[str] = []
    journal = Journal(folder, {"columns": digest(runs.COMPARISON_COLUMNS)})
    scene_warnings = [f"{scene.name}: {sentence}" for scene in scenes for sentence in scene.warnings]
    warnings = (*(warning["sentence"] for warning in journal.warnings), *scene_warnings)
    journal_runs = _JournalRuns(journal, limits, progress, notes)
    bounds: dict[str, CertifiedBounds] = {}
    rows: list[dict[str, Any]] = []
    interrupted = False
    try:
        for scene in scenes:
            certified = journal_runs.bounds(scene)
            if certified:
                bounds[scene.name] = CertifiedBounds(**certified)
        for row in journal_runs.runs(scenes, planned.pairs):
            rows.append(row)  # an interrupt keeps the rows so far
    except KeyboardInterrupt:
        interrupted = True
        notes.append("the comparison was interrupted: run the same command again to continue it")
    results, best = pd.DataFrame(rows, columns=runs.COMPARISON_COLUMNS), judge.lowest_exact(rows, known or {})
    by_parabola = sorted({*results["scene"][results["crushing"] == "parabola"]})
    if by_parabola:
        notes.append(
            f"{', '.join(by_parabola)}: no errors are given for conic solvers with methods 'static' and "
            "'kinematic', because conic solvers use the crushing parabola, and the certified bounds use "
            "chords inside the parabola"
        )
    summary = judge.summary(rows, bounds, best)
    coulomb = summary[(summary["question"] == judge.COULOMB) & summary["load_factor"].notna()]
    without_best = sorted({*coulomb["scene"]} - {*best})
    if without_best:
        notes.append(
            f"the gap to the best exact state is unknown for {', '.join(without_best)}, because no run "
            "that searches for exact states has found one: add 'coulomb' or 'mpec' to the methods"
        )
    return judge.Comparison(
        tuple(scenes), planned, limits, bounds, best, results, summary, tuple(notes), interrupted, warnings
    )


@dataclass(frozen=True)
class _JournalRuns:
    """Runs of a comparison: recorded runs are read from a journal, and new runs are added to the journal."""

    journal: Journal
    limits: RunLimits
    progress: Callable[[str], None]
    notes: list[str]  #: list to which notes on missing values are added

    def runs(self, scenes: Sequence[CaseScene], pairs: Sequence[Pair]) -> Iterator[dict[str, Any]]:
        """Generate a row of results for each run. A run that takes long or fails is not repeated."""
        # Times are comparable only for equal versions and processors, so both are part of the key of a run.
        made_by, limits = digest((versions(), machine()["processor"]))[:8], self.limits
        not_repeated: set[tuple[str, Pair]] = set()
        # Every run is made once before any run is repeated, so that an interrupted comparison lacks only
        # repeats.
        planned = [*product(range(1, limits.repeats + 1), scenes, pairs)]
        for number, (repeat, scene, pair) in enumerate(planned, start=1):
            if (scene.name, pair) in not_repeated:
                continue
            identity = (scene.name, scene.content, made_by, *astuple(pair), repeat)
            key = " · ".join(map(str, identity))
            row = self.journal.find(key)
            if row is None or self._has_lower_limit(row):
                *names, tolerance = astuple(pair)
                names += [] if tolerance is None else [f"{tolerance:.0e}"]
                self.progress(f"{number}/{len(planned)} {' · '.join([scene.name, *names])}")
                run = partial(runs.run_pair, scene.path, pair, limits.time)
                end = run_alone(run, limits.time, limits.memory)
                row = runs.row_of(dict(zip(runs.KEY, identity, strict=True)), end, limits)
                # Do not record a run whose process died, because the system may have killed the process for
                # lack of memory.
                if end.how != DIED:
                    self.journal.add(key, row)
            if row["wall"] > judge.REPEATED_BELOW or row["ended"] != FINISHED:
                not_repeated.add((scene.name, pair))
            yield row

    def _has_lower_limit(self, row: Mapping[str, Any]) -> bool:
        """Return True if a run exceeded a time or memory limit that was lower than the present limit."""
        by_time = row["ended"] == TIME_LIMIT and row["time_limit"] < self.limits.time
        by_memory = row["ended"] == MEMORY_LIMIT and row["memory_limit"] < self.limits.memory
        return bool(by_time or by_memory)

    def bounds(self, scene: CaseScene) -> dict[str, float] | None:
        """Return the certified bounds of a scene. If the computation fails, add a note and return None."""
        key, limits = f"certified bounds · {scene.content}", self.limits
        recorded = self.journal.find(key)
        if recorded is not None:
            return recorded
        self.progress(f"certified bounds of {scene.name}")
        task = partial(runs.bound_scene, scene.path)
        end = run_alone(task, max(limits.time, _BOUNDS_TIME), limits.memory)
        if end.how != FINISHED:
            self.notes.append(f"{scene.name} has no certified bounds: {end.how}: {end.reason}")
            return None
        self.journal.add(key, end.value)
        return end.value

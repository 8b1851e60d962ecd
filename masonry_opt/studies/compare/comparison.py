"""``compare``: makes the runs that are missing, keeps each, judges all, writes tables, charts and a page."""

import contextlib
from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import astuple, dataclass, replace
from functools import partial
from itertools import product
from pathlib import Path
from typing import Any

import pandas as pd

from masonry_opt.errors import NoRunSolvedError, OptionError
from masonry_opt.files import refuse_outputs, write_folder
from masonry_opt.scene.case_file import case_folder
from masonry_opt.solvers.registry import LANGUAGES
from masonry_opt.studies.compare import judge, runs
from masonry_opt.studies.compare.accuracy import CertifiedBounds
from masonry_opt.studies.compare.runs import CaseScene, Pair, RunLimits, RunPlan, checked, find_scenes, plan
from masonry_opt.studies.runner import CRASHED, DIED, FINISHED, MEMORY_LIMIT, TIME_LIMIT, run_alone, whole
from masonry_opt.studies.writing import Journal, chart_files, csv_text, digest, machine, versions

_SCENE_TIME = 120.0  #: Seconds that the bounds of a scene may take at least.
#: Defaults: the methods that take seconds on a wall of Table 1, the solvers of the package, a loose tolerance
#: and the package's own.
METHODS = ("static", "kinematic", "nonassociative", "coulomb", "mpec")
SOLVERS = ("clarabel", "highs", "highs-ipm")
TOLERANCES = (1e-6, 1e-9)
OUT = Path("results/compare")  #: Folder of results and report.
_PAGE = "report.html"  #: Page of a comparison, which has its charts too.
_CHARTS = [judge.chart_name(question) for question in (judge.ASSOCIATIVE, judge.COULOMB)]
_FILES = ("results.csv", "summary.csv", _PAGE, *chart_files(_CHARTS))  #: Files that a comparison may write.


def compare(
    scenes: str | Path | Sequence[str | Path] = (),
    *,
    methods: str | Sequence[str] = METHODS,
    models: str | Sequence[str] = LANGUAGES,
    solvers: str | Sequence[str] = SOLVERS,
    tolerances: Sequence[float] = TOLERANCES,
    repeats: int = RunLimits.repeats,
    time_limit: float = RunLimits.time,
    memory_limit: float = RunLimits.memory,
    out: str | Path = OUT,
    force: bool = False,
    cases: str | Path | None = None,
    progress: Callable[[str], None] = lambda _: None,
) -> judge.Comparison:
    """Time methods and solvers on scenes, judge their answers, write tables, charts and a page.

    Runs that ``out`` holds already are not made again: an interrupted comparison (Ctrl-C) is reported with
    what it has, and continues when it is called again.

    Raises CaseError if a case file is missing or wrong; OptionError if an argument is wrong, nothing is left
    to compare, or ``out`` holds other runs or files of these names that were not written here; OutputError if
    ``out`` cannot be written; NoRunSolvedError if every run crashed or died (the report is written
    nevertheless).

    Parameters
    ----------
    scenes: case files, or names of those in the folder ``cases``.
    cases: folder of the case files; see :func:`~masonry_opt.scene.case_file.case_folder`.
    tolerances: asked of the solvers that take one.
    repeats: runs of each; times are medians.
    time_limit, memory_limit: seconds and MB (10⁶ bytes, libraries included) that a run may take.
    out: folder of results and report.
    force: replace files there that were not written here.
    progress: called with a line before each run.
    """
    limits = RunLimits(time_limit, memory_limit, whole("repeats", repeats, 1))
    given = {"scenes": scenes, "methods": methods, "models": models, "solvers": solvers}
    named, methods, models, solvers = (_listed(what, names) for what, names in given.items())
    planned = plan(methods, models, solvers, tolerances)
    folder, out = case_folder(None if cases is None else Path(cases)), Path(out)
    if not named:
        raise OptionError("nothing to compare: name case files")
    found = [checked(scene) for scene in find_scenes(named, folder)]
    refuse_outputs(out, _FILES, force)
    comparison = run_plan(found, planned, limits, out, progress, judge.best_known(found, folder))
    progress("report")
    comparison = replace(comparison, files=tuple(write_report(comparison, out, force)))
    ended = comparison.results["ended"]
    if len(ended) and ended.isin((CRASHED, DIED)).all() and not comparison.interrupted:
        ends = Counter(zip(ended, comparison.results["message"], strict=True))
        (((how, why), count),) = ends.most_common(1)
        said = f"{count} of {len(ended)} {how}: {why}"
        raise NoRunSolvedError(f"no run ended: {said}; see {out / 'summary.csv'}")
    return comparison


def _listed(what: str, names: str | Path | Sequence[Any]) -> Sequence[Any]:
    """Names; a name by itself is a list of one."""
    if isinstance(names, str | Path):
        return [names]
    if not isinstance(names, Sequence):
        raise OptionError(f"{what} must be a list of names (found {names!r})")
    return names


def write_report(comparison: judge.Comparison, folder: Path, force: bool = False) -> list[Path]:
    """Write the files of a comparison; returns their paths.

    These are results.csv, summary.csv and, where the extra "studies" is installed, charts (PNG and SVG) and
    report.html. Raises OutputError if the folder cannot be written; OptionError if, without ``force``, it
    holds files of these names that were not written here.
    """
    tables = {"results.csv": comparison.results, "summary.csv": comparison.summary}
    files: dict[str, str | bytes] = {name: csv_text(of) for name, of in tables.items()}
    with contextlib.suppress(OptionError):  # the tables need no extra
        # Charts and pages are slow to import: only when they are needed.
        from masonry_opt.studies.charts import pictures
        from masonry_opt.studies.compare.page import charts, page

        drawn = charts(comparison.summary)
        files |= pictures(drawn) | {_PAGE: page(comparison, drawn)}
    return write_folder(folder, files, force, is_own=_FILES.__contains__)


def run_plan(
    scenes: Sequence[CaseScene],
    planned: RunPlan,
    limits: RunLimits,
    folder: Path,
    progress: Callable[[str], None],
    known: Mapping[str, judge.BestKnown] | None = None,
) -> judge.Comparison:
    """Make the runs that ``folder`` does not hold yet, and judge all (see :func:`compare`). ``known``: exact
    Coulomb states by scene name, beside those of the runs."""
    notes: list[str] = []
    journal = Journal(folder, {"columns": digest(runs.COLUMNS)})
    of_scenes = [f"{scene.name}: {sentence}" for scene in scenes for sentence in scene.warnings]
    warnings = (*(warning["sentence"] for warning in journal.warnings), *of_scenes)
    made = _JournalRuns(journal, limits, progress, notes)
    bounds, rows, interrupted = dict[str, CertifiedBounds](), list[dict[str, Any]](), False
    try:
        for scene in scenes:
            if found := made.bounds(scene):
                bounds[scene.name] = CertifiedBounds(**found)
        for row in made.runs(scenes, planned.pairs):
            rows.append(row)  # those before an interrupt stay
    except KeyboardInterrupt:
        interrupted = True
        notes.append("interrupted: the same command continues where it stopped")
    results, best = pd.DataFrame(rows, columns=runs.COLUMNS), judge.lowest_exact(rows, known or {})
    if bent := sorted({*results["scene"][results["crushing"] == "parabola"]}):
        parabola = "static and kinematic with a conic solver crush joints by the parabola"
        chords = "all other runs and the certified bounds by chords inside it"
        notes.append(f"{parabola}, {chords}: no error is given for the former on {', '.join(bent)}")
    summary = judge.summary(rows, bounds, best)
    coulomb = summary[(summary["question"] == judge.COULOMB) & summary["load_factor"].notna()]
    if bare := sorted({*coulomb["scene"]} - {*best}):
        why = "none is known, and no run searches for one; have 'coulomb' or 'mpec' among the methods"
        notes.append(f"no gap to a low exact state is given on {', '.join(bare)}: {why}")
    return judge.Comparison(
        tuple(scenes), planned, limits, bounds, best, results, summary, tuple(notes), interrupted, warnings
    )


@dataclass(frozen=True)
class _JournalRuns:
    """Runs read from a journal, or made and kept there; notes of what could not be made."""

    journal: Journal
    limits: RunLimits
    progress: Callable[[str], None]
    notes: list[str]

    def runs(self, scenes: Sequence[CaseScene], pairs: Sequence[Pair]) -> Iterator[dict[str, Any]]:
        # Only measurements by the same versions and processor may be compared.
        made_by, limits = digest((versions(), machine()["processor"]))[:8], self.limits
        long: set[tuple[str, Pair]] = set()
        # Repeats come last: an interrupted comparison has made everything once.
        asked = [*product(range(1, limits.repeats + 1), scenes, pairs)]
        for number, (repeat, scene, pair) in enumerate(asked, start=1):
            if (scene.name, pair) in long:
                continue
            which = (scene.name, scene.content, made_by, *astuple(pair), repeat)
            key = " · ".join(map(str, which))
            row = self.journal.find(key)
            # What was killed at a limit that is higher now is made again.
            if (
                row is None
                or (row["ended"] == TIME_LIMIT and row["time_limit"] < limits.time)
                or (row["ended"] == MEMORY_LIMIT and row["memory_limit"] < limits.memory)
            ):
                *names, tolerance = astuple(pair)
                names += [] if tolerance is None else [f"{tolerance:.0e}"]
                self.progress(f"{number}/{len(asked)} {' · '.join([scene.name, *names])}")
                run = partial(runs.run_pair, scene.path, pair, limits.time)
                end = run_alone(run, limits.time, limits.memory)
                row = runs.row_of(dict(zip(runs.KEY, which, strict=True)), end, limits)
                if end.how != DIED:  # the system may have killed it
                    self.journal.add(key, row)
            if row["wall"] > judge.REPEATED_BELOW or row["ended"] != FINISHED:
                long.add((scene.name, pair))
            yield row

    def bounds(self, scene: CaseScene) -> dict[str, float] | None:
        """Certified bounds, read or computed; None, and a note, where that failed."""
        key, limits = f"certified bounds · {scene.content}", self.limits
        found = self.journal.find(key)
        if found is None:
            self.progress(f"certified bounds of {scene.name}")
            task = partial(runs.bound_scene, scene.path)
            end = run_alone(task, max(limits.time, _SCENE_TIME), limits.memory)
            if end.how != FINISHED:
                self.notes.append(f"{scene.name}: no certified bounds: {end.how}: {end.reason}")
                return None
            self.journal.add(key, found := end.value)
        return found
